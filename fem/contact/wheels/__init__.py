"""Compliance, contact and damage of toothed wheels: what the finite-element models are made from."""
