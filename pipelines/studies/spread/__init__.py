"""Spread: features over a population of machines, and which property of the machines makes their variance."""
