"""Limits and bands of casing frequencies against another element: `python -m benchmarks.casing_limits`."""
