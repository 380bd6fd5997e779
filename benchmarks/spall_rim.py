"""Compliance of the rim of a spall in plane deformation: python -m benchmarks.spall_rim

A block with a slot of the depth 1 and the width 10 is loaded on its flank next to the slot, over 0 < t < c, by the
singular pressure sqrt((c - t) / t). The table holds what the slot adds to the mean displacement under this load, and
the number WALL of `fem.contact.faults.spalled_tooth` that gives the same.
"""

from __future__ import annotations

import math

import numpy as np

from benchmarks.markdown import markdown

WIDTH, FAR, POISSON = 10.0, 60.0, 0.3  # of the slot, radius of the block, both in depths
LOADED = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 4.0)
RATE = 4 * math.pi / (math.pi**2 - 4) - 2 / math.pi  # of a quarter-plane beyond a half-plane


def compliance(loaded: float, *, slotted: bool) -> float:
    """Mean displacement under a unit load, for E / (1 - nu^2) = 1, held at the radius FAR."""
    import gmsh
    import skfem
    from skfem.models.elasticity import lame_parameters, linear_elasticity

    slot = [(0.0, -1.0), (-WIDTH, -1.0), (-WIDTH, 0.0)] if slotted else [(-WIDTH, 0.0)]
    corners = [(FAR, 0.0), (loaded, 0.0), (0.0, 0.0), *slot, (-FAR, 0.0), (0.0, -FAR)]
    sizes = [6.0, 0.04 * loaded, 0.02 * loaded, *[0.1] * len(slot), 6.0, 6.0]
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        shape = gmsh.model.geo
        points = [shape.addPoint(*place, 0, size) for place, size in zip(corners, sizes, strict=True)]
        lines = [shape.addLine(a, b) for a, b in zip(points[:-2], points[1:-1], strict=True)]
        for a, b in ((points[-2], points[-1]), (points[-1], points[0])):
            lines.append(shape.addCircleArc(a, points[2], b))
        shape.addPlaneSurface([shape.addCurveLoop(lines)])
        shape.synchronize()
        gmsh.model.mesh.generate(2)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        triangles = gmsh.model.mesh.getElementsByType(2)[1].reshape(-1, 3)
    finally:
        gmsh.finalize()
    used, cells = np.unique(triangles, return_inverse=True)
    places = coordinates.reshape(-1, 3)[np.argsort(tags)][np.searchsorted(np.sort(tags), used), :2]
    mesh = skfem.MeshTri(np.ascontiguousarray(places.T), np.ascontiguousarray(cells.reshape(-1, 3).T))
    element = skfem.ElementVector(skfem.ElementTriP2())
    basis = skfem.Basis(mesh, element)
    matrix = linear_elasticity(*lame_parameters(1 - POISSON**2, POISSON)).assemble(basis)
    flank = mesh.facets_satisfying(lambda x: (abs(x[1]) < 1e-9) & (x[0] > 0) & (x[0] < loaded), boundaries_only=True)
    facets = skfem.FacetBasis(mesh, element, facets=flank, intorder=12)
    place = np.asarray(facets.global_coordinates())[0]
    pressure = np.sqrt(np.maximum(loaded - place, 0.0) / place)
    pressure /= (pressure * facets.dx).sum()
    load = skfem.LinearForm(lambda v, w: -w.pressure * v[1]).assemble(facets, pressure=pressure)
    held = basis.get_dofs(mesh.facets_satisfying(lambda x: np.hypot(*x) > 0.98 * FAR, boundaries_only=True)).all()
    return float(load @ skfem.solve(*skfem.condense(matrix, load, D=held)))


def main() -> None:
    """Print the table."""
    rows = []
    for loaded in LOADED:
        added = compliance(loaded, slotted=True) - compliance(loaded, slotted=False)
        rows.append([f"{loaded:g}", f"{added:.4f}", f"{(math.exp(added / RATE) - 1) * loaded:.2f}"])
    print(markdown(("c / d", "added, 1 / E'", "WALL"), rows))


if __name__ == "__main__":
    main()
