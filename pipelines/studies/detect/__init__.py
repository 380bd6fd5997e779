"""Detectability: how probably damage is found, over its size, load, noise and place of the sensor."""
