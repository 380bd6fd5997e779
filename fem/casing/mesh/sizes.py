"""Element sizes of a casing: from the required frequency band, and finer near bores and feet.

Free bending waves of a plate of thickness t (Kirchhoff) have the wavelength

    lambda_b = 2 pi / k = sqrt(2 pi) (D / (rho t))^(1/4) / sqrt(f),   D = E t^3 / (12 (1 - nu^2))

Thick or perforated walls bend more easily, so the true wavelength is a little shorter.

Reference: Cremer, Heckl & Petersson, Structure-Borne Sound, 3rd ed. (2005), section 3.3.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fem.elements.materials import Material
from fem.elements.solid_elements import solid_element

MM = 1000.0
AROUND_A_BORE = 12  # least number of elements around a bearing seat
AROUND_A_BOLT = 12  # least number around a bolt hole or a round pad
AROUND_A_FILLET = 6  # least number around a full circle of any radius: fewer would fold elements
LEAST = 0.25  # of the element size: lower limit for elements at small radii
_HOLE = 0.6


@dataclass(frozen=True, kw_only=True)
class Sizes:
    """Target edge lengths (m): general, at the bearing seats and at the ground faces (None: the general one).

    The least numbers of elements around bores, bolt holes and pads are divided by `fewer`.
    """

    element: float = 0.022
    bore: float | None = None
    foot: float | None = None
    fewer: float = 1.0

    def times(self, factor: float) -> Sizes:
        """All edge lengths multiplied by a factor."""
        bore, foot = (None if size is None else factor * size for size in (self.bore, self.foot))
        return Sizes(element=factor * self.element, bore=bore, foot=foot, fewer=factor * self.fewer)

    @property
    def smaller(self) -> str:
        """The remedy for bad elements, in terms of the scene, whose size a coarser mesh exceeds by `fewer`."""
        most = MM * self.element / self.fewer
        return f"Set casing.element_size_mm below {most:.4g} (with --set it overrides a --preset)"

    def at_bore(self, diameter: float) -> float:
        """Edge length (m) at a bearing seat: as given, but short enough for the least number of elements around it."""
        return min(self.element, self.bore or self.element, self.fewer * math.pi * diameter / AROUND_A_BORE)

    def at_foot(self, diameter: float) -> float:
        """Edge length (m) at a ground face; keeps the least number around its hole or pad (if diameter > 0)."""
        around = self.fewer * math.pi * diameter / AROUND_A_BOLT if diameter else self.element
        return min(self.element, self.foot or self.element, around)


@dataclass(frozen=True)
class Refinement:
    """`size` up to the distance `near` from the surfaces and edges, growing to the general size at `far` (m)."""

    surfaces: Sequence[int]
    size: float
    near: float
    far: float
    edges: Sequence[int] = ()


def bending_wavelength(material: Material, thickness: float, frequency: float) -> float:
    """Length (m) of a free bending wave in a plate of `thickness` (m) at `frequency` (Hz); both positive."""
    D = material.elastic_modulus * thickness**3 / (12.0 * (1.0 - material.poisson_ratio**2))
    return math.sqrt(2.0 * math.pi / frequency) * (D / (material.density * thickness)) ** 0.25


def set_sizes(gmsh: Any, element: float, refinements: Sequence[Refinement]) -> None:
    """Set the size field of an open gmsh model: the least of all refinements, `element` elsewhere."""
    field, made = gmsh.model.mesh.field, []
    for one in refinements:
        distance = field.add("Distance")
        field.setNumbers(distance, "SurfacesList", list(one.surfaces))
        field.setNumbers(distance, "CurvesList", list(one.edges))
        field.setNumber(distance, "Sampling", 20)
        threshold = field.add("Threshold")
        for key, value in {
            "InField": distance,
            "SizeMin": MM * one.size,
            "SizeMax": MM * element,
            "DistMin": MM * one.near,
            "DistMax": MM * one.far,
        }.items():
            field.setNumber(threshold, key, value)
        made.append(threshold)
    if not made:
        gmsh.option.setNumber("Mesh.MeshSizeMax", MM * element)
        return
    least = field.add("Min")
    field.setNumbers(least, "FieldsList", made)
    field.setAsBackgroundMesh(least)


def follow_fillets(gmsh: Any, element: float, refinements: Sequence[Refinement]) -> None:
    """Set elements small enough for curved surfaces and edges, but not below `LEAST`.

    A body with a hole smaller than `_HOLE` of that is left as it is: gmsh fails or does not terminate (holes of 0.2 to
    1 mm with elements of 8 mm, least 2 mm; it meshes a hole of 2 mm).
    """
    least = MM * min([LEAST * element, *(one.size for one in refinements)])
    boxes = [gmsh.model.getBoundingBox(1, tag) for _, tag in gmsh.model.getEntities(1) if _whole_circle(gmsh, tag)]
    if any(np.ptp(np.reshape(box, (2, 3)), axis=0).max() < _HOLE * least for box in boxes):
        return
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", AROUND_A_FILLET)
    gmsh.option.setNumber("Mesh.MeshSizeMin", least)


def _whole_circle(gmsh: Any, curve: int) -> bool:
    """Whether a curve is a full circle."""
    return gmsh.model.getType(1, curve) == "Circle" and not gmsh.model.getBoundary([(1, curve)], combined=True)


def mean_edge(nodes: np.ndarray, elements: np.ndarray) -> float:
    """Mean edge length (m) of the elements: the element size of an imported mesh."""
    first, second = np.transpose(solid_element(elements).library.refdom.edges)
    return float(np.linalg.norm(nodes[elements[:, first]] - nodes[elements[:, second]], axis=2).mean())
