"""Places of the parts of a document along and across the common direction of its shafts.

A component gives its origin and its u and w axes in the frame of another one, and finally of the gear unit. The scene
has y along u (of the first shaft, or against it if the input turns backwards), z along w, x along w x u.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipelines.rexs.document import Document, RexsComponent

PARALLEL = 1e-6  # rad
Vector = np.ndarray


@dataclass(frozen=True)
class Frame:
    """Origin (mm) and axes u, v, w (columns) in the frame of the gear unit."""

    origin: Vector
    axes: np.ndarray


def frame(document: Document, component: RexsComponent, seen: tuple[int, ...] = ()) -> Frame | None:
    """Frame of a component, None if the file gives none; `seen` are the components that refer to it.

    Raises
    ------
    RexsError : axes without length or not perpendicular, places that refer to one another in a circle
    """
    place = component.vector("support_vector")
    u, w = component.vector("u_axis_vector"), component.vector("w_axis_vector")
    if place is None or u is None or w is None:
        return None
    own = Frame(np.array(place), _axes(component, np.array(u), np.array(w)))
    reference = component.optional("reference_component_for_position")
    number = component.number_in_file if reference is None else int(reference)
    other = document.components.get(number)
    if other is None:
        raise component.error(f"its position refers to component {number}, which the file does not have. Correct it.")
    if number == component.number_in_file or other.kind == "gear_unit":
        return own
    if number in seen:
        raise component.error("its position refers in a circle to itself. Correct reference_component_for_position.")
    below = frame(document, other, (*seen, component.number_in_file))
    if below is None:
        raise component.error(f"its position refers to {other.label}, which has none. Give its support_vector.")
    return Frame(below.origin + below.axes @ own.origin, below.axes @ own.axes)


def _axes(component: RexsComponent, u: Vector, w: Vector) -> np.ndarray:
    lengths = np.linalg.norm(u), np.linalg.norm(w)
    if min(lengths) < 1e-9 or abs(u @ w) > PARALLEL * lengths[0] * lengths[1]:
        raise component.error("its u and w axes are not perpendicular. Correct u_axis_vector and w_axis_vector.")
    u, w = u / lengths[0], w / lengths[1]
    return np.column_stack([u, np.cross(w, u), w])


@dataclass(frozen=True)
class Directions:
    """Axes of the scene in the frame of the gear unit."""

    x: Vector
    y: Vector
    z: Vector

    def reversed(self) -> Directions:
        """Directions after half a turn about z, so that a rotation about -y becomes one about +y."""
        return Directions(-self.x, -self.y, self.z)

    def across(self, place: Frame) -> tuple[float, float]:
        """x and z of an origin."""
        return float(self.x @ place.origin), float(self.z @ place.origin)

    def along(self, place: Frame, u: float = 0.0) -> float:
        """y of the point at coordinate u on an axis."""
        return float(self.y @ (place.origin + u * place.axes[:, 0]))

    def sense(self, shaft: RexsComponent, place: Frame) -> int:
        """+1 if the u axis of a shaft points along +y, -1 against it; RexsError if it is not parallel."""
        cosine = float(self.y @ place.axes[:, 0])
        if math.hypot(*np.cross(self.y, place.axes[:, 0])) > PARALLEL:
            raise shaft.error("its axis is not parallel to that of the first shaft. Only parallel shafts are read.")
        return 1 if cosine > 0 else -1


def directions(place: Frame) -> Directions:
    """The axes of the scene along a first shaft."""
    u, v, w = place.axes.T
    return Directions(x=-v, y=u, z=w)
