"""Read and write mesh files through meshio or gmsh: solid elements and named groups, as in the file.

Groups are named as in the file: physical groups of Gmsh (or the number of an unnamed one), node and element sets of
Abaqus, property numbers of Nastran shells, groups of universal files and of MED, and the point or cell arrays of VTK,
where entries other than 0 mark the members. A group is stored by its facets, or by its nodes if it has no facets. Nodes
are in the order of `fem.elements.solid_elements`; files that swap the mid-side nodes 13 and 23 of tetrahedra are
recognised by the positions of these nodes.
"""

from __future__ import annotations

import contextlib
import io
import logging
import re
import tempfile
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fem.casing.mesh.finished_mesh import RawMesh
from fem.casing.mesh.mesh import CasingMesh, MeshError
from fem.elements.division import cut_quadrilaterals, described, divided, ordered
from fem.elements.solid_elements import SOLIDS, ElementError, solid_element
from fem.processes.own_process import DAMAGED, READER, bounded, call_in_own_process

_log = logging.getLogger(__name__)
SUFFIXES = (".msh", ".inp", ".bdf", ".nas", ".vtu", ".vtk", ".unv", ".med", ".mesh", ".xdmf", ".cgns", ".e")
_COMPILED = (".unv", ".mesh", ".med", ".xdmf", ".cgns", ".e")  # read by gmsh, HDF5 or NetCDF, which may crash
_IDENTIFIERS = ("gmsh:physical", "nastran:ref")
_SOLID = ("tetra", "pyramid", "wedge", "hexahedron")
KINDS = {  # of meshio, by the number of nodes
    "tetra": 4,
    "tetra10": 10,
    "pyramid": 5,
    "pyramid13": 13,
    "pyramid14": 14,
    "wedge": 6,
    "wedge15": 15,
    "wedge18": 18,
    "hexahedron": 8,
    "hexahedron20": 20,
    "hexahedron27": 27,
}


def read_mesh_file(path: Path, scale: float) -> RawMesh:
    """The solid elements of a file, nodes in its unit; mixed elements, wedges and pyramids are divided into tetrahedra.

    Parameters
    ----------
    path : the file
    scale : mm per unit of the file, for positions in messages

    Raises
    ------
    MeshError : unknown kind, unreadable, no solid elements, incompatible kinds, nodes in an unknown order
    """
    if path.suffix.lower() not in SUFFIXES:
        raise MeshError(
            f"{path.name}: a mesh file must end in one of {', '.join(SUFFIXES)}. Convert the file, or give a CAD file "
            "(STEP)"
        )
    mesh = read_quietly(path)
    blocks = _solid_blocks(path.name, mesh)
    nodes = np.asarray(mesh.points, float)
    if nodes.shape[1] != 3:
        raise MeshError(f"{path.name} is flat: its nodes have {nodes.shape[1]} coordinates; a housing needs 3")
    whole = {one.meshio: one for one in SOLIDS.values()}
    cut = ""
    try:
        if len(blocks) == 1 and next(iter(blocks)) in whole:
            (name, elements), *_ = blocks.items()
            elements = ordered(scale * nodes, elements)[:, np.argsort(whole[name].in_vtk)]
        else:
            more, elements = divided(scale * nodes, list(blocks.values()))
            nodes = np.vstack([nodes, more[len(nodes) :] / scale])
            cut = described(list(blocks.values()))
    except ElementError as error:
        raise MeshError(f"{path.name}: {error}") from error
    facets, node_sets = _groups(mesh, corners=3 if solid_element(elements).corners == 4 else 4)
    return RawMesh(nodes=nodes, elements=elements, facets=facets, node_sets=node_sets, divided=cut)


def _solid_blocks(name: str, mesh: Any) -> dict[str, np.ndarray]:
    """Solid elements by their kind, without duplicates: Gmsh 2.2 writes an element once for every group of it."""
    found: dict[str, np.ndarray] = {}
    for kind in dict.fromkeys(block.type for block in mesh.cells if block.type.startswith(_SOLID)):
        sizes = {block.data.shape[1] for block in mesh.cells if block.type == kind}
        if sizes != {KINDS.get(kind)}:
            known = ", ".join(KINDS)
            raise MeshError(
                f"{name} has {kind} elements of {', '.join(map(str, sorted(sizes)))} nodes; known are {known}. Mesh "
                "the part with ten-node tetrahedra, and in a Nastran file write continuation lines with +"
            )
        elements = np.vstack([block.data for block in mesh.cells if block.type == kind]).astype(np.int64)
        once = np.unique(np.sort(elements, axis=1), axis=0, return_index=True)[1]
        if len(once) < len(elements):
            _log.info("%s: %d duplicate elements were removed", name, len(elements) - len(once))
        found[kind] = elements[np.sort(once)]
    if not any(map(len, found.values())):
        kinds = ", ".join(f"{len(block.data)} {block.type}" for block in mesh.cells) or "nothing"
        raise MeshError(
            f"{name} has no solid elements (it has {kinds}); give a volume mesh, best of ten-node tetrahedra"
        )
    return {kind: elements for kind, elements in found.items() if len(elements)}


def read_quietly(path: Path) -> Any:
    """The mesh as meshio reads it; its terminal output goes to the log, or into the message if it fails.

    Raises
    ------
    MeshError : unreadable
    """
    if path.suffix.lower() in _COMPILED:
        return call_in_own_process(READER.format(path.name), MeshError, DAMAGED, _read, path)
    return _read(path)


def _read(path: Path) -> Any:
    import meshio
    from meshio._mesh import topological_dimension

    topological_dimension.update(pyramid13=3, wedge15=3)  # without this meshio 5.3 does not read them
    said = io.StringIO()
    try:
        with (
            contextlib.redirect_stdout(said),
            contextlib.redirect_stderr(said),
            warnings.catch_warnings(action="ignore"),
        ):
            found = _READERS.get(path.suffix.lower(), meshio.read)(path)
    except ImportError as error:
        raise MeshError(f"{path.name} needs the package {error.name}: pip install {error.name}") from error
    except (Exception, SystemExit) as error:  # meshio exits on some damaged files
        _log.info("%s: %s %s", path.name, error, said.getvalue())
        raise MeshError(f"{path.name} cannot be read as a mesh{_reason(error, said.getvalue())}; {DAMAGED}") from error
    for line in said.getvalue().splitlines():
        _log.info("meshio: %s", line)
    return found


def _reason(error: BaseException, said: str) -> str:
    """Message of a reader, in brackets; "" for Python exceptions, which do not help a user."""
    import meshio

    if not isinstance(error, (MeshError, meshio.ReadError, SystemExit)):
        return ""
    words = " ".join(f"{'' if isinstance(error, SystemExit) else error} {said}".split())
    words = re.sub(r"\x1b\[[0-9;]*m|Error: |Couldn't read file \S+ as .*", "", words).strip(" .")
    return f" ({words[:200]})" if words else ""


def _nastran(path: Path) -> Any:
    """A bulk data file, also without BEGIN BULK and ENDDATA, as gmsh writes it."""
    import meshio

    text = path.read_text(encoding="latin-1")
    begins, ends = (
        re.search(rf"^\s*{word}", text, re.IGNORECASE | re.MULTILINE) for word in (r"BEGIN\s+BULK", "ENDDATA")
    )
    whole = f"{'' if begins else 'BEGIN BULK'}\n{text}\n{'' if ends else 'ENDDATA'}\n"
    return meshio.read(io.StringIO(whole), "nastran")


def _abaqus(path: Path) -> Any:
    """An input deck; plane elements, as gmsh writes them on the faces of a body, are read as shells."""
    import meshio
    from meshio.abaqus._abaqus import abaqus_to_meshio_type

    abaqus_to_meshio_type.update(C3D5="pyramid", C3D13="pyramid13", C3D6H="wedge", C3D15H="wedge15")
    text = path.read_text(encoding="latin-1")
    shells = {"3": "S3", "4": "S4", "6": "STRI65", "8": "S8R", "9": "S9R5"}
    known = re.sub(
        r"(TYPE\s*=\s*)(?:CPS|CPE|M3D)([34689])R?(?=\s*(?:,|$))",
        lambda found: found[1] + shells[found[2]],
        text,
        flags=re.IGNORECASE | re.MULTILINE,
    )
    return meshio.read(path if known == text else io.StringIO(known), "abaqus")


def _through_gmsh(path: Path) -> Any:
    """A mesh read by gmsh, for formats that meshio cannot read or reads wrongly; groups become physical groups."""
    import meshio

    from fem.casing.mesh.gmsh_session import session

    with session() as gmsh, tempfile.TemporaryDirectory() as folder:
        try:
            with bounded(path):
                gmsh.merge(str(path))
        except Exception as error:  # gmsh raises this class itself
            raise MeshError(str(error)) from error
        if not len(gmsh.model.mesh.getNodes()[0]):
            raise MeshError("no nodes are found in it")
        copy = Path(folder) / "mesh.msh"
        gmsh.option.setNumber("Mesh.SaveAll", 1)
        gmsh.write(str(copy))
        return meshio.read(copy)


_READERS = {
    ".bdf": _nastran,
    ".nas": _nastran,
    ".inp": _abaqus,
    ".unv": _through_gmsh,
    ".mesh": _through_gmsh,
    ".med": _through_gmsh,
}


def _groups(mesh: Any, *, corners: int) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Groups by facets of 3 or 4 corners, or by nodes; quadrilaterals of divided elements are divided likewise."""
    facets: dict[str, list[np.ndarray]] = {}
    node_sets: dict[str, list[np.ndarray]] = {}
    for name, number, cells in _named_cells(mesh):
        block = mesh.cells[number]
        if block.type.startswith("triangle"):
            if corners == 3:
                facets.setdefault(name, []).append(block.data[cells][:, :3])
        elif block.type.startswith("quad"):
            sides = block.data[cells][:, :4]
            facets.setdefault(name, []).append(sides if corners == 4 else cut_quadrilaterals(sides))
        elif not block.type.startswith(_SOLID):
            node_sets.setdefault(name, []).append(block.data[cells].ravel())
    for name, nodes in mesh.point_sets.items():
        node_sets.setdefault(name, []).append(np.asarray(nodes, np.int64).ravel())
    for name, values in mesh.point_data.items():
        if np.ndim(values) == 1:
            node_sets.setdefault(name, []).append(np.flatnonzero(values))
    return (
        {name: np.vstack(parts).astype(np.int64) for name, parts in facets.items()},
        {name: np.unique(np.concatenate(parts)) for name, parts in node_sets.items() if name not in facets},
    )


def _named_cells(mesh: Any) -> Iterator[tuple[str, int, np.ndarray]]:
    """Name, block and cells of every group of cells."""
    titles = {(int(tag), int(dim)): name.strip() for name, (tag, dim) in mesh.field_data.items()}  # padded in MED
    for key, blocks in mesh.cell_data.items():
        for number, values in enumerate(blocks):
            if np.ndim(values) != 1 or key == "gmsh:geometrical":
                continue
            if key not in _IDENTIFIERS:
                yield key, number, np.flatnonzero(values)
                continue
            dimension = mesh.cells[number].dim
            for tag in np.unique(values):
                yield titles.get((int(tag), dimension), str(int(tag))), number, np.flatnonzero(values == tag)
    for name, blocks in mesh.cell_sets.items():
        if name.startswith("gmsh:"):
            continue
        for number, cells in enumerate(blocks):
            if cells is not None and len(cells):
                yield name.strip(), number, np.asarray(cells, np.int64)


def write_hexahedra(
    nodes: np.ndarray, cells: np.ndarray, fields: Mapping[str, np.ndarray], groups: Mapping[str, np.ndarray], path: Path
) -> None:
    """Write linear hexahedra as .vtu, .inp, .msh or .bdf.

    Parameters
    ----------
    nodes : (node, 3) m
    cells : int (cell, 8), into the nodes, in the order of VTK
    fields : (node,) or (node, 3) by name, written to .vtu and .msh only
    groups : bool (cell,) by name; every cell is in one group. Element sets in .inp, physical groups in .msh, property
        numbers 1, 2, ... in .bdf and in the array "group" of .vtu
    path : its suffix selects the format
    """
    import meshio

    number = [1 + np.argmax(np.array(list(groups.values())), axis=0).astype(np.int32)]
    titles = {name: np.array([place, 3]) for place, name in enumerate(groups, 1)}
    tags = {"gmsh:physical": number, "gmsh:geometrical": number}
    contents: dict[str, tuple[str, dict[str, Any]]] = {  # format and content of meshio
        ".inp": ("abaqus", {"cell_sets": {name: [np.flatnonzero(inside)] for name, inside in groups.items()}}),
        ".bdf": ("nastran", {"cell_data": {"nastran:ref": number}}),
        ".msh": ("gmsh22", {"point_data": dict(fields), "cell_data": tags, "field_data": titles}),
        ".vtu": ("vtu", {"point_data": dict(fields), "cell_data": {"group": number}}),
    }
    kind, data = contents[path.suffix.lower()]
    if kind == "nastran":
        nodes = np.round(nodes, 10)  # smaller values need an exponent, for which a coordinate has no room
    meshio.Mesh(nodes, [("hexahedron", cells)], **data).write(path, file_format=kind)


def write_fields(mesh: CasingMesh, fields: Mapping[str, np.ndarray], path: Path) -> None:
    """Write a mesh with fields (node, k) on its nodes as VTU."""
    import meshio

    kind = solid_element(mesh.elements)
    cells = [(kind.meshio, mesh.elements[:, kind.in_vtk])]
    meshio.Mesh(mesh.nodes, cells, point_data=dict(fields)).write(path, file_format="vtu")
