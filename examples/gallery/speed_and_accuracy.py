"""
Cost and accuracy of the mesh models
====================================

Four models compute the stiffness of a gear pair: `iso` is a formula, `energy` a beam model of the teeth, `plane` and
`solid` are finite elements in two and three dimensions. The figure compares their stiffness curves, computing times,
and deviations from `solid`.
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
curves, seconds = {}, dict.fromkeys(choices, 0.0)
for name, mesh in choices.items():

    def add(step, name=name):
        seconds[name] += step.seconds

    pair = gearcase.laws(scene.changed({"stages.1.mesh": mesh}), progress=add)[0]
    curves[name] = pair.curve().secant

# %%
# Times are those of the computer that built this page. The program warns that the gear-body formula of `energy` is
# not valid for this pinion.

mean = {name: float(curve.mean()) for name, curve in curves.items()}
errors = {name: abs(value / mean["solid"] - 1) for name, value in mean.items() if name != "solid"}
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
for name, curve in curves.items():
    left.plot(curve.cycle, curve.squeeze() / 1e6, label=name)
    if name in errors:
        right.loglog(seconds[name], 100 * errors[name], "o", label=name)
left.set(xlabel="mesh cycles", ylabel="secant stiffness, N/um", ylim=(0, None))
left.legend()
right.set(xlabel="computing time, s", ylabel="deviation of the mean stiffness from solid, %", ylim=(0.1, 100))
right.legend()

# %%
# Deviation of the mean stiffness of each model from that of `solid`:

print({name: f"{100 * error:.1f} %" for name, error in errors.items()})
