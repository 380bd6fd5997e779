"""Speeds at which gear bodies burst: the motion may be computed, but no machine makes it.

The largest stress of a solid disc that turns with the rim speed v is (3 + nu)/8 rho v^2, tangential and at its centre;
a bore doubles it, which is left out here (Timoshenko & Goodier, Theory of Elasticity, section 32).
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from fem.elements.materials import STEEL
from pipelines.io.errors import Problem
from pipelines.machine.checks.strength import YIELD_STRENGTH
from pipelines.machine.facts import motor_speed
from pipelines.machine.layout import Layout
from pipelines.scene.scene import Scene
from pipelines.scene.tables.motion import SpeedDrive

RIM_SPEED = math.sqrt(8 * YIELD_STRENGTH / ((3 + STEEL.poisson_ratio) * STEEL.density))


def bursting(scene: Scene, layout: Layout) -> Iterator[Problem]:
    """The first stage with a gear whose tips run faster than a solid disc of the strongest steel bears."""
    speed = motor_speed(layout)
    for number, (pair, shafts) in enumerate(zip(layout.pairs, layout.pair_shafts, strict=True), 1):
        for name, gear, shaft in zip(("pinion", "wheel"), (pair.pinion, pair.wheel), shafts, strict=True):
            ratio = abs(layout.shaft_ratios[shaft])
            tips = speed * ratio * gear.tip_radius
            if not tips <= RIM_SPEED:
                limit = RIM_SPEED / gear.tip_radius / ratio * 30 / math.pi
                yield Problem(
                    "drive.speeds_rpm" if isinstance(scene.drive, SpeedDrive) else "drive",
                    f"the tips of the stage {number} {name} would move at {tips:.4g} m/s, and a disc of the strongest "
                    f"steel bursts at {RIM_SPEED:.0f} m/s",
                    f"Set at most {limit:.4g} rpm.",
                    f"{60 * layout.turns:.4g}",
                )
                return
