"""Recordings side by side: same channels, same rate, same orders; features with their differences, and curves."""
