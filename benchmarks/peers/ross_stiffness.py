"""Mesh stiffness of a spur pair by ROSS (GearElementTVMS) and by gearcase: python -m benchmarks.peers.ross_stiffness

z 62/62, m 2 mm, b 20 mm, bores 35 mm: the pair of the documentation of ROSS. Both give 1000 values over one mesh cycle.
ROSS is asked once more with a helix angle of 20 degrees, to which its stiffness does not respond.
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.clock import conditions, timed
from benchmarks.peers import environment, output

RESULTS = Path(__file__).resolve().parent.parent / "results" / "ross_stiffness.json"
POINTS = 1000
FORCE = 1000.0  # N, at which model plane is evaluated


def theirs(helix_deg: float = 0.0) -> dict[str, float]:
    """Largest and smallest stiffness (N/m) by ROSS; runs where it is installed."""
    from ross.gear_element import GearElementTVMS, Mesh
    from ross.materials import steel

    helix = {"helix_angle": math.radians(helix_deg)} if helix_deg else {}
    taken, mesh = timed(
        lambda: Mesh(
            *(
                GearElementTVMS(n=n, material=steel, width=0.02, bore_diameter=0.035, module=0.002, n_teeth=62,
                                pr_angle=math.radians(20.0), **helix)
                for n in (0, 2)
            )
        ),
        repeats=1,
    )  # fmt: skip
    found = np.asarray(mesh.stiffness_range)
    return {"largest": float(found.max()), "smallest": float(found.min()), "mean": float(found.mean()), **taken}


def ours() -> dict[str, dict[str, float]]:
    """The same by the models energy and plane, with the steel of ROSS."""
    from fem.contact.evaluation.stiffness_curve import stiffness_curve
    from fem.contact.models.energy import Energy
    from fem.contact.models.plane import Plane
    from fem.elements.materials import Material
    from fem.gears.gear import Gear
    from fem.gears.geometry import GearPair

    steel = Material(name="steel of ROSS", elastic_modulus=211e9, poisson_ratio=211.0 / 162.4 - 1.0, density=7810.0)
    gear = Gear(teeth=62, normal_module=0.002, face_width=0.02, bore_radius=0.0175)
    pair = GearPair(pinion=gear, wheel=gear, pinion_material=steel, wheel_material=steel)
    cycle = np.arange(POINTS) / POINTS
    rows = {}
    for name, model in (("energy", Energy(slices=1)), ("plane", Plane(slices=1))):
        stiffness_curve(model.laws(pair)[0], FORCE, cycle)  # compiled code is loaded beforehand
        taken, curve = timed(lambda r=model: stiffness_curve(r.laws(pair)[0], FORCE, cycle))
        found = curve.secant
        rows[name] = {
            "largest": float(found.max()), "smallest": float(found.min()), "mean": float(found.mean()), **taken,
        }  # fmt: skip
    return rows


def main() -> int:
    """Measure and write."""
    if "--here" in sys.argv:
        import ross

        print(json.dumps({"version": ross.__version__, "spur": theirs(), "helical": theirs(20.0)}))
        return 0
    try:
        peer = environment.answer("ross", "benchmarks.peers.ross_stiffness")
    except environment.NotInstalledError as error:
        print(f"skipped: {error}")
        return 1
    rows: dict[str, Any] = {"ross": peer["spur"], "ross, helix 20 deg": peer["helical"], **ours()}
    found = {"conditions": conditions(), "program": f"ROSS {peer['version']}", "rows": rows}
    output.report(found, RESULTS)
    return 0


if __name__ == "__main__":
    sys.exit(main())
