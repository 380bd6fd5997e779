"""The reduced casing as a free body that finite-element programs read: nodes, equations, matrices; SI.

The reduced coordinates q are relative to the ground. With the ground as a node g of six motions at the centre of
gravity the casing is a free body again:

    u = T q + R g,    q_absolute = q + B g

B are the motions of the interface by g; modal coordinates stay relative. All feet move with the node g; springs under
the feet are part of the stiffness. The body is held where g is held.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fem.casing.reduced.reduced_body import ReducedBody
from pipelines.io.user_files import whole_file, write_whole

_AXES = ("ux", "uy", "uz", "rx", "ry", "rz")


@dataclass(frozen=True, eq=False, kw_only=True)
class Superelement:
    """Stiffness, mass and damping of a free body, the meaning of its equations, and the rows of its sensors."""

    stiffness: np.ndarray  # (n, n)
    mass: np.ndarray  # (n, n)
    damping: np.ndarray  # (n, n)
    equations: np.ndarray  # int (n, 2), node and axis 1 to 6; axis 0: modal coordinate, whose node is a scalar point
    node_names: tuple[str, ...]
    nodes: np.ndarray  # (k, 4), number and place in m; sensors are nodes without equations
    row_names: tuple[str, ...]
    rows: np.ndarray  # (row, n), absolute x, y, z of the sensors without equations, by node; then axes of forced ones

    def files(self) -> Mapping[str, np.ndarray]:
        """Matrices by the names that Nastran gives them."""
        return {"KAA": self.stiffness, "MAA": self.mass, "BAA": self.damping}

    def sensor_rows(self, name: str) -> dict[str, np.ndarray]:
        """The rows by a name; empty without sensors."""
        return {name: self.rows} if len(self.rows) else {}


def superelement(
    body: ReducedBody, participation: np.ndarray, mass: float, centre: np.ndarray, inertia: np.ndarray
) -> Superelement:
    """The free body of a reduced casing.

    Parameters
    ----------
    body : in its ground
    participation : T^T M R (coordinate, 6), R the rigid motions about the centre of gravity
    mass, centre, inertia : kg, (3,) m, (3, 3) kg m2 about the centre
    """
    size, interface = len(body.mass), [name for name in body.coordinate_names if ":" in name]
    places = dict(zip(body.point_names, body.point_positions, strict=True))
    points = list(dict.fromkeys(name.split(":")[0] for name in interface))
    others = [name for name in body.row_names if name not in interface]
    sensors = [name for name in dict.fromkeys(name.split(":")[0] for name in others) if name not in points]
    by_ground = np.zeros((size, 6))
    numbers = np.zeros((size + 6, 2), int)
    for place, name in enumerate(interface):
        point, axis = name.split(":")
        by_ground[place] = _rigid(places[point] - centre)[_AXES.index(axis)]
        numbers[place] = points.index(point) + 1, _AXES.index(axis) + 1
    ground = len(points) + len(sensors) + 1
    numbers[len(interface) : size, 0] = ground + 1 + np.arange(size - len(interface))
    numbers[size:] = np.column_stack([np.full(6, ground), np.arange(1, 7)])
    relative = np.hstack([np.eye(size), -by_ground])  # q from (q_absolute, g)
    both = np.vstack([relative, np.hstack([np.zeros((6, size)), np.eye(6)])])
    whole = np.zeros((6, 6))
    whole[:3, :3], whole[3:, 3:] = mass * np.eye(3), inertia
    inertial = np.block([[body.mass, participation], [participation.T, whole]])
    row_names = [f"{name}:{axis}" for name in sensors for axis in _AXES[:3]]
    row_names += [name for name in others if name not in row_names]
    rows = np.zeros((len(row_names), size + 6))
    for row, name in zip(rows, row_names, strict=True):
        shift = body.row_shifts[body.row_names.index(name)]
        row[:] = body.row(name) @ relative
        row[size:] += shift @ _rigid(places[name.split(":")[0]] - centre)[:3]
    for first in range(0, 3 * len(sensors), 3):  # from the axes of a sensor to those of the scene
        own = slice(first, first + 3)
        rows[own] = body.row_shifts[[body.row_names.index(name) for name in row_names[own]]].T @ rows[own]
    located = np.array([*(places[point] for point in (*points, *sensors)), centre])
    return Superelement(
        stiffness=_symmetric(relative.T @ body.stiffness @ relative),
        mass=_symmetric(both.T @ inertial @ both),
        damping=_symmetric(relative.T @ body.damping @ relative),
        equations=numbers,
        node_names=(*points, *sensors, "ground"),
        nodes=np.column_stack([np.arange(1, ground + 1), located]),
        row_names=tuple(row_names),
        rows=rows,
    )


def housing_table(found: Superelement, written: Sequence[Path], band: float) -> str:
    """The table [casing.housing] that imports an export, of modes for a band (Hz), from its files."""
    names = [f"{path.stem.removeprefix(f'{written[0].stem}-')}_file" for path in written[1:]]
    files = {"file": written[0], **dict(zip(names, written[1:], strict=True))}
    bearings = ", ".join(
        f'{{ name = "{name}", nodes = [{number}] }}'
        for number, name in enumerate(found.node_names, 1)
        if name.startswith("bearing_")
    )
    lines = [f'{key} = "{path.name}"' for key, path in files.items() if key != "damping_file"]
    return "\n".join(
        [
            f'# with casing.ground = "fixed" and casing.band_Hz of at most {band:g}, for which the file has modes',
            "[casing.housing]",
            'model = "matrices"',
            *lines,
            'units = "kg-m-s"',
            "origin_mm = [0.0, 0.0, 0.0]",
            f"bearings = [{bearings}]",
            f"grounds = [{{ nodes = [{len(found.nodes)}] }}]",
        ]
    )


def _rigid(arm: np.ndarray) -> np.ndarray:
    """Motion (6, 6) of a point at `arm` (3,) from the node that moves."""
    x, y, z = arm
    found = np.eye(6)
    found[:3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    return found


def _symmetric(matrix: np.ndarray) -> np.ndarray:
    return np.asarray(0.5 * (matrix + matrix.T))


def write_npz(found: Superelement, path: Path, target: Path) -> None:
    """All in one file of NumPy."""
    with path.open("wb") as file:
        np.savez_compressed(
            file,
            stiffness=found.stiffness,
            mass=found.mass,
            damping=found.damping,
            equations=found.equations,
            nodes=found.nodes,
            node_names=np.array(found.node_names),
            rows=found.rows,
            row_names=np.array(found.row_names),
        )


def write_matrix_market(found: Superelement, path: Path, target: Path) -> list[Path]:
    """The stiffness; mass, damping, rows, nodes and equations in files of their names next to it."""
    from scipy.io import mmwrite

    def written(matrix: np.ndarray, file: Path) -> None:
        with file.open("wb") as stream:
            mmwrite(stream, matrix, precision=17)

    written(found.stiffness, path)
    others = {"mass": found.mass, "damping": found.damping} | found.sensor_rows("rows")
    further = [target.with_name(f"{target.stem}-{name}.mtx") for name in others]
    for file, matrix in zip(further, others.values(), strict=True):
        with whole_file(file) as partial:
            written(matrix, partial)
    return [*further, *_write_map(found, target)]


def write_output4(found: Superelement, path: Path, target: Path) -> list[Path]:
    """KAA, MAA, BAA and ROWS in binary; nodes and equations in files next to it."""
    from pyyeti.nastran import op4

    op4.write(str(path), {**found.files(), **found.sensor_rows("ROWS")})
    return _write_map(found, target)


def write_punch(found: Superelement, path: Path, target: Path) -> None:
    """GRID and SPOINT cards, then KAAX, MAAX, BAAX and the motion ROWSX of the sensors as DMIG."""
    import pandas as pd
    from pyyeti.nastran import bulk

    names = ["id", "dof"]
    index = pd.MultiIndex.from_arrays(found.equations.T, names=names)
    sensors = sorted({*found.nodes[:, 0].astype(int)} - {*found.equations[:, 0]})
    matrices = {f"{name}X": pd.DataFrame(A, index=index, columns=index) for name, A in found.files().items()}
    if sensors:
        rows = pd.MultiIndex.from_product([sensors, (1, 2, 3)], names=names)
        matrices["ROWSX"] = pd.DataFrame(found.rows[: len(rows)], index=rows, columns=index)
    with path.open("w", encoding="ascii") as file:
        for name, (number, x, y, z) in zip(found.node_names, found.nodes, strict=True):
            file.write(f"$ {name}\nGRID*   {int(number):16d}{0:16d}{x:16.9E}{y:16.9E}*\n*       {z:16.9E}{0:16d}\n")
        for number in found.equations[found.equations[:, 1] == 0, 0]:
            file.write(f"SPOINT  {int(number):8d}\n")
        bulk.wtdmig(file, matrices)


def _write_map(found: Superelement, target: Path) -> list[Path]:
    """Write nodes and equations as comma-separated rows."""
    nodes, equations = (target.with_name(f"{target.stem}-{what}.csv") for what in ("nodes", "equations"))
    places = (
        f"# {name}: number, x, y, z in m\n{int(number)},{x:.17g},{y:.17g},{z:.17g}\n"
        for name, (number, x, y, z) in zip(found.node_names, found.nodes, strict=True)
    )
    write_whole(nodes, "".join(places))
    lines = (f"{node},{axis}\n" for node, axis in found.equations)
    write_whole(equations, "# node, axis (0: modal)\n" + "".join(lines))
    return [nodes, equations]
