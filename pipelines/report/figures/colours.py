"""Colours of all figures and pictures, shared by the renderer and the legends.

The maps are perceptually uniform: equal steps of a value look equally large, in grey too.
"""

PINION, WHEEL, GONE = "#8fa9bf", "#c9b28a", "#d62718"
DAMAGED, CRACK = "#f2e6d0", "#7a0010"  # the undamaged surface of a damaged tooth; where a crack comes to the surface
HEALTHY, FAULTY = "#2a6f97", "#c23b22"
PAIR_COLOURS = ("#2a6f97", "#e08e0b", "#3a7d44", "#7b4ea3", "#b5651d", "#6b6b6b", "#c2578f", "#1f9e9e")
LOAD_COLOURS, STRESS_COLOURS, WEAR_COLOURS = "viridis", "plasma", "magma_r"
CONTACT = "#111111"  # contact lines where colour shows something else, and their rim
POINTS = {"ground": "#f2c200", "bearing": "#c8281e", "sensor": "#2e9e44"}
