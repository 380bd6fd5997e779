"""Contents of pictures (gear pairs, casings, loaded teeth), and the results: a picture, or the reason why it is
omitted.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from fem.gears.geometry import GearPair
from pipelines.report.figures.damaged_tooth import DrawnTooth
from pipelines.report.figures.gear_frame import scene_frame


@dataclass(frozen=True, eq=False, kw_only=True)
class GearPairView:
    """Two gears at a whole mesh cycle, with a tooth pair in contact at the pitch point; the wheel's axis is at x = a.

    The pinion turns counter-clockwise and drives; in the picture pinion tooth i follows tooth i - 1 clockwise and
    wheel tooth j follows tooth j - 1 counter-clockwise, so that pair (i, i) follows pair (i - 1, i - 1). The tooth
    `marked` ("pinion" or "wheel", and its number) is shown as the `tooth` with its damage, or translucent and red.
    """

    pair: GearPair
    marked: tuple[str, int] | None = None
    cycle: int = 0  # mesh cycle
    tooth: DrawnTooth | None = None
    frame: np.ndarray = field(
        default_factory=lambda: scene_frame((0.0, 0.0), (1.0, 0.0), 0.0, 1)
    )  # (4, 4), to the scene
    sense: int = 1  # +1 if the face coordinate runs along the global y, else -1
    seen_from: int = -1  # the end of the shafts, along the global y

    def centre(self, gear: str) -> float:
        """Place of the centre of "pinion" or "wheel", m."""
        return 0.0 if gear == "pinion" else self.pair.axis_distance

    def zero_angle(self, gear: str) -> float:
        """Polar angle of the middle of a tooth, rad; the upper (pinion) or lower (wheel) flank touches."""
        half = getattr(self.pair, gear).half_thickness_angle(self.pair.working_radii[gear == "wheel"])
        return -half if gear == "pinion" else math.pi - half

    @property
    def marked_angle(self) -> float:
        """Polar angle of the middle of the marked tooth about its centre, rad."""
        assert self.marked is not None, "a view with a damaged tooth"
        gear, number = self.marked
        turn = 2 * math.pi * (self.cycle - number) / getattr(self.pair, gear).teeth
        return self.zero_angle(gear) + (turn if gear == "pinion" else -turn)

    @property
    def missing(self) -> bool:
        """The marked tooth is missing."""
        return self.tooth is None or self.tooth.missing


@dataclass(frozen=True, eq=False, kw_only=True)
class PairStates:
    """A pair under load, healthy and, if given, `damaged`; `marked` names the damaged tooth, "" without one."""

    title: str
    gears: GearPairView
    damaged: GearPairView | None
    marked: str
    model: str
    force: float  # N

    def of_state(self, number: int) -> GearPairView:
        """Gears of a state of the teeth, 0 the healthy one."""
        return self.gears if number == 0 or self.damaged is None else self.damaged


@dataclass(frozen=True, eq=False, kw_only=True)
class Teeth:
    """Loaded teeth of both gears in the frame of `tooth_mesh_frames`, in one mesh; nodes of neighbours coincide."""

    points: np.ndarray  # (node, 3), m
    cells: np.ndarray  # (cell, 8), hexahedra in the order of VTK
    gear: np.ndarray  # (cell,), 1 pinion, 2 wheel
    tooth_pair: np.ndarray  # (cell,), number of the tooth pair
    displacement: np.ndarray  # (node, 3), m
    von_mises: np.ndarray  # (node,), Pa
    root: np.ndarray  # (place,), nodes on the fillets of the loaded sides
    root_gear: np.ndarray  # (place,), as `gear`
    root_pair: np.ndarray  # (place,), number of the tooth pair
    line_points: np.ndarray  # (pair, slice, 3), m
    line_load: np.ndarray  # (pair, slice), N/m, nan without contact


@dataclass(frozen=True, eq=False, kw_only=True)
class Picture:
    """A rendered picture: image (rows, columns, 3) in 0..255, and the pixel (column, row) of every named place."""

    image: np.ndarray
    places: Mapping[str, tuple[float, float]]


class NotRendered(Exception):
    """A picture cannot be rendered: the cause and the remedy."""


@dataclass(frozen=True, kw_only=True)
class LeftOut:
    """Omitted picture: the cause and the remedy, as the report keeps them."""

    reason: str
