"""The reduced casing in files that other programs read, chosen by the ending of the name.

.h5    in its ground: everything, as `fem.casing.reduced.reduced_body.ReducedBody` writes it (HDF5)
.mat   in its ground: matrices, rows and names for MATLAB
.npz, .mtx, .op4, .pch   as a free body with a node for the ground, see `pipelines.studies.housings.superelement`; the
       model `matrices` of a housing reads them again
.uff   universal file of modal testing: key points (2411), their modes (55), accelerances bearing -> sensor (58)
.vtu   the mesh with every natural mode as a field on its nodes (in its elements)
.step  the solid of a parametric housing
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pipelines.io.errors import InputError
from pipelines.io.user_files import whole_file
from pipelines.studies.housings.responses import accelerances
from pipelines.studies.housings.superelement import (
    Superelement,
    superelement,
    write_matrix_market,
    write_npz,
    write_output4,
    write_punch,
)

if TYPE_CHECKING:
    from fem.casing.mesh.mesh import CasingMesh
    from fem.casing.reduced.casing_modes import CasingModes, NaturalModes
    from fem.casing.reduced.reduced_body import ReducedBody
    from pipelines.runs.single_results import Casing

_LINES = 1000  # frequencies of an accelerance


def write_casing(casing: Casing, title: str, target: Path) -> list[Path]:
    """Write a casing in the format that the ending of `target` names; every file is whole or not there.

    Returns
    -------
    The files: `target` first, then those with nodes, equations or further matrices next to it

    Raises
    ------
    InputError : a file cannot be written, a package is not installed, or the casing has no elastic modes
    """
    check_package(target)
    form = FORMATS[target.suffix.lower()]
    if form.elastic and casing.modes is None:
        raise InputError(
            f"--export {target.name}: a {casing.body.model} casing has no elastic modes. Set casing.model to "
            "craig-bampton or static, or export .h5 or .mat."
        )
    try:
        with whole_file(target) as path:
            further = form.write(casing, title, path, target)
    except OSError as error:
        raise InputError(f"{target}: cannot be written ({error.strerror}). Choose another --export.") from error
    return [target, *(further or ())]


def check_package(target: Path) -> None:
    """InputError if the package that writes a file is not installed."""
    package, extra = FORMATS[target.suffix.lower()].needs
    if package and find_spec(package) is None:
        raise InputError(f"--export {target.name} needs the package {package}: pip install 'gearcase[{extra}]'")


def free_body(casing: Casing) -> Superelement:
    """The casing as a free body with a node for the ground; of an elastic casing."""
    modes, participation = casing.modes, casing.participation
    if modes is None or participation is None:
        raise ValueError("a casing without elastic modes is no superelement")
    return superelement(casing.body, participation, modes.total_mass, modes.centre, modes.inertia)


def write_mat(body: ReducedBody, path: Path) -> None:
    """Mass, stiffness, damping, rows, names of coordinates and rows, key points; SI."""
    from scipy.io import savemat

    content = {
        "model": body.model,
        "mass": body.mass,
        "stiffness": body.stiffness,
        "damping": body.damping,
        "rows": body.rows,
        "coordinate_names": np.array(body.coordinate_names, dtype=object),
        "row_names": np.array(body.row_names, dtype=object),
        "point_names": np.array(body.point_names, dtype=object),
        "point_positions": body.point_positions,
    }
    savemat(path, content, do_compression=True, long_field_names=True)


def write_uff(body: ReducedBody, path: Path, *, title: str, band: float) -> None:
    """Key points as nodes 1, 2, ..., undamped modes and accelerances; SI, ASCII.

    Directions of a sensor are its own axes. A point without a row in a direction does not move along it.

    Parameters
    ----------
    body : the reduced casing
    path : file, replaced if it is there
    title : text of every set
    band : Hz, up to which modes and accelerances are written
    """
    import pyuff

    nodes = np.arange(1, len(body.point_names) + 1)
    motions = np.zeros((len(nodes), 3, len(body.mass)))
    for number, name in enumerate(body.point_names):
        for axis, word in enumerate(("ux", "uy", "uz")):
            if f"{name}:{word}" in body.row_names:
                motions[number, axis] = body.row(f"{name}:{word}")
    x, y, z = body.point_positions.T
    zero = np.zeros(len(nodes), int)
    units = {"units_code": 1, "units_description": "SI", "temp_mode": 1}
    scale = {"length": 1.0, "force": 1.0, "temp": 1.0, "temp_offset": 273.15}
    sets = [
        pyuff.prepare_164(**units, **scale),
        pyuff.prepare_2411(node_nums=nodes, def_cs=zero, disp_cs=zero, color=zero, x=x, y=y, z=z),
        *_modes(pyuff, body, motions, nodes, title, band),
        *_accelerances(pyuff, body, motions, nodes, title, band),
    ]
    path.unlink(missing_ok=True)
    pyuff.UFF(str(path)).write_sets(sets, mode="add")


def _modes(
    pyuff: Any, body: ReducedBody, motions: np.ndarray, nodes: np.ndarray, title: str, band: float
) -> list[dict[str, Any]]:
    import scipy.linalg as la

    square, phi = la.eigh(body.stiffness, body.mass)
    omega = np.sqrt(np.maximum(square, 0.0))
    zeta = np.einsum("im,ij,jm->m", phi, body.damping, phi, optimize=True) / (2.0 * omega)
    points = ", ".join(f"{n} {name}" for n, name in zip(nodes, body.point_names, strict=True))
    return [
        pyuff.prepare_55(
            id1=title[:80],
            id2="natural modes, unit modal mass",
            id3=points[:80],
            id4="NONE",
            id5="NONE",
            model_type=1,
            analysis_type=2,
            data_ch=2,
            spec_data_type=8,
            data_type=2,
            n_data_per_node=3,
            r1=motions[:, 0] @ phi[:, mode],
            r2=motions[:, 1] @ phi[:, mode],
            r3=motions[:, 2] @ phi[:, mode],
            load_case=1,
            mode_n=int(mode) + 1,
            freq=float(omega[mode] / (2.0 * math.pi)),
            modal_m=1.0,
            modal_damp_vis=float(zeta[mode]),
            modal_damp_his=0.0,
            node_nums=nodes,
        )
        for mode in np.flatnonzero(omega <= 2.0 * math.pi * band)
    ]


def _accelerances(
    pyuff: Any, body: ReducedBody, motions: np.ndarray, nodes: np.ndarray, title: str, band: float
) -> list[dict[str, Any]]:
    """Acceleration of every sensor per force at every bearing, all directions that have rows."""
    frequencies = np.linspace(0.0, band, _LINES + 1)[1:]
    numbers = range(len(body.point_names))
    bearings = [n for n in numbers if body.point_names[n].startswith("bearing_")]
    sensors = [n for n in numbers if not body.point_names[n].startswith(("bearing_", "ground_"))]
    inputs, outputs = ([(n, a) for n in some for a in range(3)] for some in (bearings, sensors))
    inputs = [(n, a) for n, a in inputs if motions[n, a].any()]
    if not (inputs and outputs):
        return []
    loads, readings = (np.array([motions[n, a] for n, a in some]) for some in (inputs, outputs))
    response = accelerances(body, readings, loads, frequencies)
    step = float(frequencies[0])
    return [
        pyuff.prepare_58(
            binary=0,
            id1=f"{body.point_names[out]} {'xyz'[a]} per {body.point_names[into]} {'xyz'[b]}",
            id2=title[:80],
            func_type=4,  # frequency response
            rsp_ent_name=body.point_names[out][:10],
            rsp_node=int(nodes[out]),
            rsp_dir=a + 1,
            ref_ent_name=body.point_names[into][:10],
            ref_node=int(nodes[into]),
            ref_dir=b + 1,
            ord_data_type=6,  # complex, double
            num_pts=len(frequencies),
            abscissa_spacing=1,
            abscissa_min=step,
            abscissa_inc=step,
            abscissa_spec_data_type=18,  # frequency
            ordinate_spec_data_type=12,  # acceleration
            ordinate_axis_units_lab="m/s2",
            orddenom_spec_data_type=13,  # excitation force
            orddenom_axis_units_lab="N",
            abscissa_axis_units_lab="Hz",
            data=response[:, i, j],
            x=frequencies,
        )
        for i, (out, a) in enumerate(outputs)
        for j, (into, b) in enumerate(inputs)
    ]


def write_vtu(mesh: CasingMesh, modes: CasingModes, natural: NaturalModes, path: Path, *, band: float) -> None:
    """The mesh with the modes as fields, each scaled to a largest displacement of 1.

    Parameters
    ----------
    mesh, modes, natural : the mesh, the modes of its reduction, and the natural modes in their coordinates
    path : file
    band : Hz, up to which modes are written
    """
    from fem.casing.mesh.mesh_file import write_fields
    from pipelines.runs.single_results import mode_shapes

    in_band = np.flatnonzero(natural.frequencies <= band)
    data = {
        f"mode {mode + 1:03d}: {natural.frequencies[mode]:.2f} Hz": shape
        for mode, shape in zip(in_band, mode_shapes(modes, natural, in_band.tolist()), strict=True)
    }
    write_fields(mesh, data, path)


@dataclass(frozen=True, kw_only=True)
class CasingFormat:
    """A format of an export: `write(casing, title, path, target)` returns the files next to the target, if any."""

    write: Callable[[Casing, str, Path, Path], list[Path] | None]
    elastic: bool = False  # needs modes of finite elements
    needs: tuple[str, str] = ("", "")  # package that writes it, and the extra of gearcase that installs the package


def _vtu(casing: Casing, title: str, path: Path, target: Path) -> None:
    if casing.mesh is None or casing.modes is None or casing.natural is None:
        raise InputError(f"--export {target.name}: the casing has no mesh. Export .h5, .mat or .npz instead.")
    write_vtu(casing.mesh, casing.modes, casing.natural, path, band=casing.band)


def _step(casing: Casing, title: str, path: Path, target: Path) -> None:
    from fem.casing.geometry.housing import Housing
    from fem.casing.mesh.gmsh_mesh import write_step

    if not isinstance(casing.housing, Housing):
        raise InputError(
            f'--export {target.name}: needs casing.housing.model = "parametric". Export .vtu, or copy the file of the '
            "housing."
        )
    write_step(casing.housing, path)


def _free(
    write: Callable[[Superelement, Path, Path], list[Path] | None], needs: tuple[str, str] = ("", "")
) -> CasingFormat:
    return CasingFormat(
        write=lambda casing, title, path, target: write(free_body(casing), path, target), elastic=True, needs=needs
    )


FREE_BODIES: Mapping[str, CasingFormat] = {
    ".npz": _free(write_npz),
    ".mtx": _free(write_matrix_market),
    ".op4": _free(write_output4, ("pyyeti", "nastran")),
    ".pch": _free(write_punch, ("pyyeti", "nastran")),
}
FORMATS: Mapping[str, CasingFormat] = {
    ".h5": CasingFormat(write=lambda casing, title, path, target: casing.body.save(path)),
    ".mat": CasingFormat(write=lambda casing, title, path, target: write_mat(casing.body, path)),
    **FREE_BODIES,
    ".uff": CasingFormat(
        write=lambda casing, title, path, target: write_uff(casing.body, path, title=title, band=casing.band),
        needs=("pyuff", "uff"),
    ),
    ".vtu": CasingFormat(write=_vtu, elastic=True),
    ".step": CasingFormat(write=_step),
}
