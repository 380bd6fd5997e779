"""
Speed against accuracy of the mesh models
=========================================

Four models give the stiffness of a gear pair, from a closed formula to finite elements in space. The dearer ones know
more of the gears: here is what each takes, and how far it is from the finest.
"""

import matplotlib.pyplot as plt

import gearcase

scene = gearcase.Scene.from_file("minimal")
choices = {
    "iso": {"model": "iso"},
    "energy": {"model": "energy"},
    "plane": {"model": "plane"},
    "solid, coarse": {"model": "solid", "refinement": 0.6},
    "solid": {"model": "solid"},
}
stiffness, seconds = {}, dict.fromkeys(choices, 0.0)
for name, mesh in choices.items():

    def add(step, name=name):
        seconds[name] += step.seconds

    pair = gearcase.laws(scene.changed({"stages.1.mesh": mesh}), progress=add)[0]
    stiffness[name] = float(pair.curve().secant.mean())

# %%
# The time is that of the machine that makes this page; a law from the cache tells what it took when it was built.

errors = {name: abs(value / stiffness["solid"] - 1) for name, value in stiffness.items() if name != "solid"}
figure, axes = plt.subplots(figsize=(6, 3.5), layout="constrained")
for name, error in errors.items():
    axes.loglog(seconds[name], 100 * error, "o", color="C0")
    axes.annotate(name, (seconds[name], 100 * error), xytext=(6, 4), textcoords="offset points")
axes.set(xlabel="seconds", ylabel="error of the mean stiffness, %", ylim=(0.1, 100))
axes.margins(x=0.3)

# %%

print({name: f"{100 * error:.1f} %" for name, error in errors.items()})
