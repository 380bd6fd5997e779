"""Damage of measured rolling bearings, named by a rule that was made from simulated machines only.

`rule.json` contains the rule. It was fitted to the population of population.toml and is committed with its SHA-256, so
that a result on further recordings is blind. docs/zero-shot.md gives the commands and the result on public recordings.
"""
