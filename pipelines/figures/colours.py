"""Colours of three-dimensional pictures, shared by the renderer and the legends."""

PINION, WHEEL, GONE = "#8fa9bf", "#c9b28a", "#d62718"
STATES = "#2a6f97", "#c23b22"  # healthy, faulty
PAIR_COLOURS = ("#2a6f97", "#e08e0b", "#3a7d44", "#7b4ea3", "#b5651d", "#6b6b6b", "#c2578f", "#1f9e9e")
LOAD_COLOURS, STRESS_COLOURS = "turbo", "Spectral_r"
CONTACT = "#111111"  # contact lines where colour shows something else
POINTS = {"ground": "#f2c200", "bearing": "#c8281e", "sensor": "#2e9e44"}
