"""Gear units in the exchange format REXS, read into scenes."""
