"""Diagnosis of any recording against healthy ones: baselines, p-values, a blind ranking of what the machine has."""
