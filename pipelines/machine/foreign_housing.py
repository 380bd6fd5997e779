"""The housing of a scene whose matrices another program made, in SI."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from fem.casing.geometry.dimensions import HousingError, Sensor
from fem.casing.imported.body import ForeignError
from fem.casing.imported.casing import ForeignHousing, file_digests
from fem.casing.imported.files import MatrixFiles
from fem.casing.mesh.locate import Point
from pipelines.io.errors import InputError, Problem, SceneError
from pipelines.machine.housing import seat_problems
from pipelines.scene.shipped_files import find_file
from pipelines.scene.tables.housing import MatricesHousingTable


def foreign_housing(
    table: MatricesHousingTable, sensors: tuple[Sensor, ...], points: Sequence[Point], source: str
) -> ForeignHousing:
    """The housing with the sensors on it.

    Parameters
    ----------
    table : of the housing
    sensors : on it
    points : (x, y, z) of the bearings that it carries, m
    source : of the scene, for messages

    Raises
    ------
    SceneError : a file that is not there, bearings that are not located or belong to no shaft
    """
    if problems := list(seat_problems([seat.name for seat in table.bearings], len(points))):
        raise SceneError(source, problems)
    nodes = {seat.name: seat.nodes for seat in table.bearings}
    try:
        found = [
            None if name is None else str(find_file(name))
            for name in (table.file, table.mass_file, table.nodes_file, table.equations_file)
        ]
        files = MatrixFiles(
            stiffness=str(found[0]), mass=found[1], nodes=found[2], equations=found[3], system=table.units
        )
        return ForeignHousing(
            files=replace(files, digests=file_digests(files)),
            seats=tuple((f"bearing_{n}", nodes[f"bearing_{n}"], point) for n, point in enumerate(points, 1)),
            grounds=tuple(ground.nodes for ground in table.grounds),
            origin=table.si.origin,
            sensors=sensors,
        )
    except (ForeignError, HousingError, InputError) as error:
        raise SceneError(source, [Problem("casing.housing", str(error))]) from error
