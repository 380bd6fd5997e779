"""Faults of shafts in a scene, and the scene without them.

Unbalance, a bent shaft and a misaligned coupling are faults, which increase the low orders of a shaft (Randall 2011,
Vibration-based Condition Monitoring, 2.2.1). Forces on shafts and casing and accelerations of the ground are external.
The torque ripple of a motor belongs to its design (Jahns & Soong 1996, IEEE Trans. Ind. Electron. 43(2), 321-330): a
healthy motor has it, so the control does, too. A coupling with two stiffness axes and a universal joint are also
designs; their fault is an offset or a tilt between the axes of their shafts.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pipelines.scene.scene import Scene
from pipelines.scene.tables.derived import DerivedTable
from pipelines.scene.tables.shafts import CouplingTable, DiskTable

_FAULTY_MODELS = frozenset(("unbalance", "bent-shaft"))
_FAULTY_KEYS = {"disks": ("eccentricity_um", "eccentricity_angle_deg"), "couplings": ("offset_um", "tilt_mrad")}


@dataclass(frozen=True, kw_only=True)
class ShaftFault:
    """A fault of a shaft (from 0): its place in words, and as `severity` keys of the scene with their values."""

    kind: str
    shaft: int
    place: str
    severity: tuple[tuple[str, Any], ...]

    @property
    def name(self) -> str:
        """The fault in words: "unbalance of shaft 1 at y = 20 mm"."""
        return f"{self.kind.replace('-', ' ')} {self.place}"

    @property
    def label(self) -> dict[str, Any]:
        """Label of the fault in data sets and results: kind, number of the shaft and severity."""
        return {"kind": self.kind, "shaft": self.shaft + 1, **dict(self.severity)}


def shaft_faults(scene: Scene) -> tuple[ShaftFault, ...]:
    """All faults of shafts, of the forces, disks and couplings of a scene, in this order."""
    return (
        *(_force_fault(table) for table in scene.forces if table.model in _FAULTY_MODELS),
        *(_eccentric(number, table) for number, table in enumerate(scene.disks, 1) if table.eccentricity_um),
        *(
            _misaligned(number, table)
            for number, table in enumerate(scene.couplings, 1)
            if any((*table.offset_um, *table.tilt_mrad))
        ),
    )


def without_shaft_faults(tree: Mapping[str, Any], scene: Scene) -> dict[str, Any]:
    """A tree of settings without the faults of shafts.

    Parameters
    ----------
    tree : of a whole scene, or of settings that change single items (tables by number, as in ``forces.2``)
    scene : in which these items have their numbers
    """
    found = dict(tree)
    if "forces" in found:
        faulty = {str(n) for n, table in enumerate(scene.forces, 1) if table.model in _FAULTY_MODELS}
        found["forces"] = _kept_forces(found["forces"], faulty)
    for table, keys in _FAULTY_KEYS.items():
        if table in found:
            found[table] = _without_keys(found[table], keys)
    return {key: value for key, value in found.items() if value != {} or tree[key] == {}}


def _force_fault(table: DerivedTable) -> ShaftFault:
    return ShaftFault(
        kind=table.model,
        shaft=table.shaft - 1,
        place=f"of shaft {table.shaft} at y = {table.position_mm:g} mm",
        severity=tuple(table.model_dump(exclude={"model", "shaft"}).items()),
    )


def _eccentric(number: int, table: DiskTable) -> ShaftFault:
    """The unbalance of an eccentric disk."""
    return ShaftFault(
        kind="unbalance",
        shaft=table.shaft - 1,
        place=f"of shaft {table.shaft} by disk {number} at y = {table.position_mm:g} mm",
        severity=(
            ("disk", number),
            ("position_mm", table.position_mm),
            ("unbalance_g_mm", table.mass_kg * table.eccentricity_um),
            ("angle_deg", table.eccentricity_angle_deg),
        ),
    )


def _misaligned(number: int, table: CouplingTable) -> ShaftFault:
    first, second = table.shafts
    return ShaftFault(
        kind="misaligned-coupling",
        shaft=first - 1,
        place=f"{number} of shafts {first} and {second}",
        severity=(
            ("coupling", number),
            ("shafts", table.shafts),
            ("positions_mm", table.positions_mm),
            ("offset_um", table.offset_um),
            ("tilt_mrad", table.tilt_mrad),
        ),
    )


def _kept_forces(forces: Any, faulty: set[str]) -> Any:
    if isinstance(forces, dict):
        return type(forces)({number: value for number, value in forces.items() if number not in faulty})
    return [table for table in forces if table["model"] not in _FAULTY_MODELS]


def _without_keys(tables: Any, keys: tuple[str, ...]) -> Any:
    def stripped(table: Any) -> Any:
        return type(table)({key: value for key, value in table.items() if key not in keys})

    if isinstance(tables, dict):
        return type(tables)({number: kept for number, table in tables.items() if (kept := stripped(table))})
    return [stripped(table) for table in tables]
