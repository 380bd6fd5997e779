"""The load of a scene, in SI: a torque, or a container on the ropes of drums."""

from __future__ import annotations

from mbd.forces.hanging_loads import HangingLoad
from mbd.forces.torque_source import TorqueSource
from mbd.parts.load import Load
from pipelines.scene.tables.drive_and_load import LoadBase, LoadModel, TorqueLoad
from pipelines.scene.tables.shafts import ShaftTable


def load_places(table: LoadModel, shaft: ShaftTable) -> tuple[float, ...]:
    """y (m) where the load acts on its shaft: the drums, or the position of a torque, by default the +y end."""
    if isinstance(table, LoadBase):
        return table.si.drum_positions or shaft.ends
    return (shaft.ends[1] if table.position_mm is None else table.si.position,)


def load_torque(table: LoadModel, shaft: int) -> float:
    """Torque (N m) of greatest magnitude with which the load resists the rotation of its shaft (number from 0)."""
    hanging = suspended_load(table)
    return -_source(table, shaft, 0.0).largest if hanging is None else hanging.torque


def suspended_load(table: LoadModel) -> HangingLoad | None:
    """The suspended load on the ropes of the drums; None for a torque."""
    return table.made() if isinstance(table, LoadBase) else None


def hanging_load(table: LoadModel, shaft: int, places: tuple[float, ...]) -> Load | None:
    """The load on drums at ``places`` (y, m) of a shaft (number from 0); None for a torque."""
    hanging = suspended_load(table)
    return None if hanging is None else hanging.load(f"shaft_{shaft + 1}", places)


def torque_load(table: LoadModel, shaft: int, places: tuple[float, ...]) -> tuple[TorqueSource, ...]:
    """The load that is a torque; empty for a load on drums. Arguments as for `hanging_load`."""
    return (_source(table, shaft, places[0]),) if isinstance(table, TorqueLoad) else ()


def _source(table: TorqueLoad, shaft: int, y: float) -> TorqueSource:
    return table.curve({"name": "load", "shaft": f"shaft_{shaft + 1}", "y": y}, -1.0, "load")
