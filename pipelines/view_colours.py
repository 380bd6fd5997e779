"""Colours of three-dimensional pictures, shared by the renderer and the legends."""

PINION, WHEEL, GONE = "#8fa9bf", "#c9b28a", "#d62718"
LOAD_COLOURS = "turbo"
POINTS = {"ground": "#f2c200", "bearing": "#c8281e", "sensor": "#2e9e44"}
