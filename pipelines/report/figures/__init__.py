"""Plots and three-dimensional pictures."""
