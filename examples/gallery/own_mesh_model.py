"""
A user-defined mesh model
=========================

A mesh model is a frozen dataclass. Its method `laws` returns the mesh laws of drive and coast flank. This example
takes the stiffness of a tooth pair from a measured curve. docs/extending.md shows how to add a model to scene files.
"""

from dataclasses import dataclass, replace

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import trapezoid

import gearcase
from fem.contact.models.iso import Iso
from fem.contact.models.mesh_model import MeshModel


@dataclass(frozen=True, kw_only=True)
class Measured(MeshModel):
    """`stiffness` of a tooth pair (N/m per metre of face) at `places` from 0 to 1 on its path of contact."""

    places: tuple[float, ...]
    stiffness: tuple[float, ...]

    def laws(self, pair):
        """The laws of drive and coast flank: those of `iso`, with the compliance of the curve."""

        def own(law):
            xi = law.position_start + law.position_step * np.arange(law.compliance.size)
            place = (xi - pair.xi_start) / (pair.xi_end - pair.xi_start)
            return law.replaced(model="measured", compliance=1 / np.interp(place, self.places, self.stiffness))

        drive, coast = Iso(slices=self.slices).laws(pair)
        return own(drive), own(coast)


# %%
# The curves compare the new model with the model `iso` of the scene. The stiffness is the tangent stiffness:

found = gearcase.laws(gearcase.Scene.from_file("minimal"))[0]
model = Measured(places=(0.0, 0.25, 0.5, 0.75, 1.0), stiffness=(8e9, 12e9, 14e9, 12e9, 8e9))
drive, coast = model.laws(found.pair)
measured = replace(found, healthy=drive, drive=drive, coast=coast)

figure, axes = plt.subplots(figsize=(7, 3.5), layout="constrained")
for name, one in (("iso", found), ("measured", measured)):
    curve = one.curve(np.linspace(0, 2, 401)).sel(state="healthy")
    axes.plot(curve.cycle, curve.tangent / 1e6, label=name)
axes.set(xlabel="mesh cycles", ylabel="tangent stiffness, N/um", ylim=(0, None))
axes.legend()

# %%
# The mean mesh stiffness must equal the area under the measured curve (length in base pitches) times the face width:

area = trapezoid(model.stiffness, model.places) * found.pair.transverse_contact_ratio * found.pair.face_width
ratio = float(measured.curve().tangent.mean()) / area
print(f"{area / 1e6:.1f} N/um, ratio {ratio:.4f}")
