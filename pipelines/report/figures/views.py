"""Contents of pictures (gear pairs, casings, loaded teeth), and the results: a picture, or the reason why it is
omitted.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from pipelines.report.figures.damaged_tooth import DrawnTooth
from pipelines.report.figures.gear_frame import scene_frame


@dataclass(frozen=True, eq=False, kw_only=True)
class GearView:
    """A gear in the transverse section at mid face, about its centre, turned to its position in mesh."""

    outline: np.ndarray  # (n, 2), m, counter-clockwise, with all teeth
    teeth: int
    bore: float  # radius, m
    twist: float  # rad per m of face width
    web: tuple[float, float, float] | None = None  # inner radius of the rim, end, end along the face, m


@dataclass(frozen=True, eq=False, kw_only=True)
class GearPairView:
    """Two gears; the wheel's centre is at (centre_distance, 0) from the pinion's.

    `marked_gear` "pinion" | "wheel" | "" and `marked_angle` (rad, polar angle of the middle of the tooth about its
    centre) show one tooth in red, translucent if it is `missing`, or as the `tooth` with its damage. `frame` (4, 4)
    moves points to the scene, `sense` is +1 if the face coordinate runs along the global y.
    """

    pinion: GearView
    wheel: GearView
    face_width: float
    centre_distance: float
    marked_gear: str = ""
    marked_angle: float = 0.0
    missing: bool = True
    tooth: DrawnTooth | None = None
    frame: np.ndarray = field(default_factory=lambda: scene_frame((0.0, 0.0), (1.0, 0.0), 0.0, 1))
    sense: int = 1
    seen_from: int = -1  # the end of the shafts, along the global y

    def centre(self, gear: str) -> float:
        """Place of the centre of "pinion" or "wheel", m."""
        return 0.0 if gear == "pinion" else self.centre_distance


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
