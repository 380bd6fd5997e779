"""Limits and bands of casing frequencies against references of another element: `python -m benchmarks.casing_limits`."""
