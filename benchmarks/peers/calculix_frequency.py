"""Natural frequencies of the casing on one mesh by CalculiX: python -m benchmarks.peers.calculix_frequency

Ten-node tetrahedra of the shipped housing with straight edges, every node of the feet held, bearings free, all modes to
7.5 kHz. Both do all from the mesh to the modes: assembly, factorisation, eigensolution; CalculiX also reads its deck.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.clock import conditions, timed
from benchmarks.peers import ccx, output
from benchmarks.rig import casing_parts, read
from fem.casing.mesh.choose_mesher import mesh_geometry
from fem.casing.mesh.mesh import CasingMesh
from fem.casing.mesh.sizes import Sizes
from fem.casing.models.elastic_casing import ElasticCasing
from fem.casing.reduced.grounded import assembled_casing
from fem.casing.reduced.halves import reduced_and_counted
from fem.casing.reduced.reduction import Reduction
from fem.elements.materials import Material
from fem.elements.solid_elements import straight_places

RESULTS = Path(__file__).resolve().parent.parent / "results" / "calculix_frequency.json"
HIGHEST = 7500.0  # Hz


def deck(mesh: CasingMesh, material: Material, count: int) -> str:
    """The input of CalculiX for `count` modes; N, m, kg. C3D10 numbers its nodes as the library does."""
    held = np.unique(np.concatenate([mesh.patch(name).ravel() for name in mesh.patches("ground_")]))
    lines = ["*NODE, NSET=ALL"]
    lines += [f"{i},{x:.10g},{y:.10g},{z:.10g}" for i, (x, y, z) in enumerate(mesh.nodes, 1)]
    lines += ["*ELEMENT, TYPE=C3D10, ELSET=CASING"]
    lines += [f"{i}," + ",".join(map(str, nodes)) for i, nodes in enumerate(mesh.elements + 1, 1)]
    lines += ["*MATERIAL, NAME=IRON", "*ELASTIC", f"{material.elastic_modulus:.12g},{material.poisson_ratio:.12g}"]
    lines += ["*DENSITY", f"{material.density:.12g}", "*SOLID SECTION, ELSET=CASING, MATERIAL=IRON"]
    lines += ["*BOUNDARY", *(f"{node + 1},1,3" for node in held)]
    lines += ["*STEP", "*FREQUENCY, STORAGE=NO", f"{count}", "*END STEP"]
    return "\n".join(lines) + "\n"


def straightened(mesh: CasingMesh) -> CasingMesh:
    """The mesh with its mid-side nodes in the middle of their edges: CalculiX refuses some of the curved elements."""
    nodes = mesh.nodes.copy()
    nodes[mesh.elements] = straight_places(nodes, mesh.elements)
    return replace(mesh, nodes=nodes, curved=0)


def ours(mesh: CasingMesh, material: Material) -> Reduction:
    """All modes to HIGHEST with the feet held."""
    casing = assembled_casing(mesh, material, interfaces=(), divided=True)
    return reduced_and_counted(casing.subspaces, casing.loads, highest=HIGHEST)[0]


def measure(element_size: float | None = None) -> dict[str, Any]:
    """Frequencies and seconds of both."""
    machine = read()
    box, iron = casing_parts(machine)
    assert isinstance(machine.casing, ElasticCasing)
    mesh = straightened(mesh_geometry(box, Sizes(element=element_size or machine.casing.element_size)))
    taken, reduction = timed(lambda: ours(mesh, iron), repeats=1)
    with tempfile.TemporaryDirectory(prefix="gearcase-calculix-") as folder:
        path = Path(folder) / "casing.inp"
        path.write_text(deck(mesh, iron, reduction.n_fixed), encoding="utf-8")
        wall, processor = ccx.run(path)
        theirs = frequencies(path.with_suffix(".dat"))
    deviation = reduction.frequencies[: theirs.size] / theirs - 1.0
    return {
        "program": f"CalculiX {ccx.version()}, SPOOLES, ARPACK",
        "conditions": conditions(),
        "unknowns": 3 * len(mesh.nodes),
        "modes": int(theirs.size),
        "gearcase": taken,
        "calculix": {"seconds": wall, "cpu_seconds": processor},
        "ratio": processor / taken["cpu_seconds"],
        "largest_deviation": float(np.abs(deviation).max()),
        "first_Hz": float(theirs[0]),
        "last_Hz": float(theirs[-1]),
    }


def frequencies(result: Path) -> np.ndarray:
    """Hz, from the table of eigenvalues in a .dat file: mode, eigenvalue, rad/s, Hz, imaginary part."""
    rows = []
    for line in result.read_text(encoding="utf-8").partition("P A R T I C I P A T I O N")[0].splitlines():
        words = line.split()
        if len(words) == 5 and words[0].isdigit():
            rows.append(float(words[3]))
    if not rows:
        raise ccx.PeerFailed("CalculiX wrote no table of eigenvalues")
    return np.array(rows)


def main(arguments: list[str] | None = None) -> int:
    """Measure and write."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.peers.calculix_frequency")
    parser.add_argument("--element-size-mm", type=float, help="another element size than that of the scene")
    chosen = parser.parse_args(arguments).element_size_mm
    try:
        found = measure(None if chosen is None else chosen / 1000.0)
    except ccx.PeerMissing as error:
        print(f"skipped: {error}")
        return 1
    if chosen is None:
        output.keep(found, RESULTS)
    output.show(found)
    return 0


if __name__ == "__main__":
    sys.exit(main())
