"""Finished runs under ./runs: found, compared, removed."""
