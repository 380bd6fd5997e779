"""Damage of measured rolling bearings, named by a rule that was made from simulated machines only.

`rule.json` contains the rule. It was fitted to the population of population.toml and committed with its SHA-256
before it was applied to a recording. docs/zero-shot.md gives the commands and the result.
"""
