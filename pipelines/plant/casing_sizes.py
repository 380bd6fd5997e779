"""Element sizes of the casing of a scene."""

from __future__ import annotations

from fem.casing.geometry.housing import Housing
from fem.casing.meshing.sizes import Sizes, bending_wavelength
from fem.casing.meshing.source import Geometry
from fem.elements.materials import Material
from pipelines.border.errors import Problem, SceneError
from pipelines.scene.tables.casing import CraigBamptonCasingTable, FlexibleBase


def element_sizes(table: FlexibleBase, box: Geometry, iron: Material, source: str) -> Sizes:
    """Element sizes of a casing; at most a share of the bending wavelength of its thinnest wall where that is asked."""
    size = table.element_size_mm / 1000
    if isinstance(table, CraigBamptonCasingTable) and table.elements_per_wavelength is not None:
        if isinstance(box, Housing):
            wall = box.thinnest_wall
        elif table.housing.wall_thickness_mm is not None:
            wall = table.housing.wall_thickness_mm / 1000
        else:
            problem = "is needed for casing.elements_per_wavelength of a housing from a file"
            raise SceneError(source, [Problem("casing.housing.wall_thickness_mm", problem, "Give its thinnest wall.")])
        size = min(size, bending_wavelength(iron, wall, table.band_Hz) / table.elements_per_wavelength)
    bore, foot = table.bore_element_size_mm, table.foot_element_size_mm
    return Sizes(element=size, bore=None if bore is None else bore / 1000, foot=None if foot is None else foot / 1000)
