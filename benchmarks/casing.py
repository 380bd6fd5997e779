"""Parts `casing` and `static`: seconds and memory of the casing stages at the shipped size."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import scipy.sparse as sp
from scipy.sparse.linalg import splu

from benchmarks.clock import timed
from benchmarks.rig import casing_parts, keep, kept, read
from fem.casing.enrichment.added_unknowns import added_functions
from fem.casing.mesh.mesh import CasingMesh
from fem.casing.models.casing_model import Structure
from fem.casing.models.craig_bampton import CraigBamptonCasing
from fem.casing.models.elastic_casing import ElasticCasing
from fem.casing.models.static_casing import StaticCasing
from fem.casing.reduced.casing_modes import casing_modes
from fem.casing.reduced.checkup import check_up
from fem.casing.reduced.grounded import assembled_casing
from fem.casing.reduced.halves import reduced_and_counted
from fem.casing.reduced.reduced_body import MODES_OVER_BAND
from fem.elements.materials import Material
from fem.numerics.elimination import plan_elimination
from fem.numerics.linear_solver import factorize
from fem.numerics.multifrontal import Cholesky

SHIFT = 4e7  # 1/s2: K + SHIFT M of the free body is definite and has the pattern of K


def mesh(folder: Path) -> list[dict[str, Any]]:
    """Geometry and elements, as the scene has them."""
    machine = read()
    assert isinstance(machine.casing, ElasticCasing)
    meshing = machine.casing.meshed(machine.structure).stage
    seconds, found = timed(meshing.build)
    keep(folder, "mesh", found)
    size = f"{len(found.nodes)} nodes, {len(found.elements)} elements {machine.casing.element}"
    return [{"step": "mesh", "size": size, "solver": "", **seconds}]


def free_matrices(mesh: CasingMesh, iron: Material) -> tuple[sp.csr_matrix, sp.csr_matrix]:
    """Stiffness and mass of the free body, with the functions that its elements are given beyond their nodes."""
    return added_functions(mesh, iron, held=mesh.patches("ground_")).matrices()


def super_lu(K: sp.csr_matrix) -> Any:
    """SciPy's factor without pivoting, with the rows and columns in the order of the multifrontal one."""
    order = plan_elimination(K, 3).order
    return splu(
        K[order][:, order].tocsc(), permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )


def factors(folder: Path) -> list[dict[str, Any]]:
    """Assembly of K and M, and their factorisation, also by SciPy's SuperLU for comparison."""
    machine = read()
    found, (_, iron) = kept(folder, "mesh"), casing_parts(machine)
    seconds, (stiffness, mass) = timed(lambda: free_matrices(found, iron))
    rows = [{"step": "assembly of K and M", "size": f"{stiffness.shape[0]} unknowns", "solver": "", **seconds}]
    shifted = (stiffness + SHIFT * mass).tocsr()
    for name, solver in ((Cholesky.name, factorize), ("SuperLU (SciPy) with METIS ordering", super_lu)):
        seconds, factor = timed(lambda solver=solver: solver(shifted))
        rows.append({"step": "factorisation", "size": f"{stiffness.shape[0]} unknowns", "solver": name, **seconds})
        right = mass[:, :24].toarray()
        seconds, _ = timed(lambda f=factor, r=right: f.solve(r))
        rows.append({"step": "24 right-hand sides at once", "size": "", "solver": name, **seconds})
    return rows


def modes(folder: Path) -> list[dict[str, Any]]:
    """Craig-Bampton reduction at the shipped band, and its check-up; keeps the body."""
    machine = read()
    found, (box, iron) = kept(folder, "mesh"), casing_parts(machine)
    model = machine.casing
    assert isinstance(model, CraigBamptonCasing)
    grounding, casing = timed(lambda: assembled_casing(found, iron), repeats=1)
    limit = MODES_OVER_BAND * model.band
    reducing, (reduction, counted) = timed(
        lambda: reduced_and_counted(casing.subspaces, casing.loads, highest=limit), repeats=1
    )
    checking, checked = timed(lambda: check_up(casing, reduction), repeats=1)
    result = casing_modes(casing, reduction, model="craig-bampton", band_limit=limit)
    recovery = model.recovery(machine.structure)
    recovering, body = timed(lambda: recovery.build(modes=(result, checked)))
    keep(folder, "craig-bampton", body)
    size = f"{counted} modes to {limit:.0f} Hz, {len(result.mass)} coordinates"
    return [
        {"step": "assembly, clamping", "solver": result.solver, **grounding},
        {
            "step": "factorisation, constraint and fixed-interface modes, their count, inertia correction",
            "size": size,
            "solver": "",
            **reducing,
        },
        {"step": "checks of the reduced body", "size": f"{len(checked.failures)} of 14 fail", "solver": "", **checking},
        {"step": "damping, sensors", "size": f"{len(box.sensors)} sensors", "solver": "", **recovering},
    ]


def static(folder: Path) -> list[dict[str, Any]]:
    """Static condensation, check-up included; keeps the body."""
    machine = read(casing__model="static")
    found, (box, iron) = kept(folder, "mesh"), casing_parts(machine)
    model = machine.casing
    assert isinstance(model, StaticCasing)
    structure = Structure(housing=box, material=iron)
    reduction, recovery = model.reduction(structure), model.recovery(structure)
    seconds, body = timed(lambda: recovery.build(modes=reduction.build(mesh=found)), repeats=1)
    keep(folder, "static", body)
    size = f"{len(body.coordinate_names)} coordinates"
    return [{"step": "model `static`, all but the mesh", "size": size, "solver": "", **seconds}]
