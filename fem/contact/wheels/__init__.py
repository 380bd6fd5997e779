"""Compliance, contact and damage of toothed wheels, used by the finite-element models."""
