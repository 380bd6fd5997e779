"""A damaged file of any kind is refused in one sentence, or read soundly: no crash, no traceback, no library's words.

Every file is damaged in ten ways, drawn from a seed, and given to `gearcase housing` in the shell.
"""

import re
import subprocess
import sys
import zlib

import meshio
import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp

from fem.casing.mesh.gmsh_session import session

CAD = ("a.step", "a.brep", "a.iges", "a.stl")
MESHES = ("a.msh", "a.inp", "a.bdf", "a.unv", "a.med", "a.vtk", "a.mesh", "a.vtu", "a.xdmf", "a.cgns")
MATRICES = ("k.npz", "sparse.npz", "k.h5", "k.mtx", "k.matrix", "k.sti", "k.op4", "k.pch")
MARK = "@@"
EVERY = f"""
import sys
from pipelines.cli.main import main
for name in sys.argv[1:]:
    try:
        code = main(["housing", name])
    except SystemExit as stopped:
        code = stopped.code
    for stream in (sys.stdout, sys.stderr):
        stream.write(f"{MARK} {{name}} {{code}}\\n")
        stream.flush()
"""


def truncated(data, rng):
    return data[: len(data) // 3]


def truncated_near_the_end(data, rng):
    return data[: int(0.97 * len(data))]


def flipped_in_the_middle(data, rng):
    found = np.frombuffer(data, np.uint8).copy()
    places = len(data) // 2 + rng.integers(0, max(len(data) // 10, 1), 30)
    found[places % len(data)] ^= rng.integers(1, 256, 30).astype(np.uint8)
    return found.tobytes()


def flipped_everywhere(data, rng):
    found = np.frombuffer(data, np.uint8).copy()
    places = rng.integers(0, len(data), len(data) // 200 + 5)
    found[places] = rng.integers(0, 256, len(places))
    return found.tobytes()


def garbage_in_the_middle(data, rng):
    half = len(data) // 2
    return data[:half] + rng.bytes(400) + data[half + 400 :]


def blank_lines(data, rng):
    lines = data.split(b"\n")
    return b"\n".join(b"" if rng.random() < 0.1 else line for line in lines)


def lines_twice(data, rng):
    lines = data.split(b"\n")
    return b"\n".join(line for line in lines for _ in range(1 + (rng.random() < 0.05)))


def wrong_digits(data, rng):
    """Numbers that are numbers still, but others: references and counts that lead nowhere."""
    found = np.frombuffer(data, np.uint8).copy()
    digits = np.flatnonzero((found >= ord("0")) & (found <= ord("9")))
    if len(digits):
        places = rng.choice(digits, min(60, len(digits)), replace=False)
        found[places] = ord("9")
    return found.tobytes()


def random_bytes(data, rng):
    return rng.bytes(2000)


def another_kind(data, rng):
    return b"\x89PNG\r\n\x1a\n" + b"1 2 3\n" * 300


DAMAGES = (
    truncated,
    truncated_near_the_end,
    flipped_in_the_middle,
    flipped_everywhere,
    garbage_in_the_middle,
    blank_lines,
    lines_twice,
    wrong_digits,
    random_bytes,
    another_kind,
)


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    """A block of 60 x 30 x 20 mm with a bore of 12 mm in every format, and matrices of a chain of springs."""
    made = tmp_path_factory.mktemp("sound")
    with session() as gmsh:
        occ = gmsh.model.occ
        occ.cut([(3, occ.addBox(0, 0, 0, 60, 30, 20))], [(3, occ.addCylinder(30, -1, 10, 0, 32, 0, 6))])
        occ.synchronize()
        for name in CAD[:3]:
            gmsh.write(str(made / name))
        gmsh.option.setNumber("Mesh.MeshSizeMax", 12)
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 12)
        gmsh.model.mesh.generate(3)
        gmsh.write(str(made / CAD[3]))
        gmsh.model.mesh.setOrder(2)
        gmsh.model.addPhysicalGroup(3, [1], 8, "BODY")
        for name in MESHES[:7]:
            gmsh.write(str(made / name))
    mesh = meshio.read(made / "a.msh")
    solid = meshio.Mesh(mesh.points, [("tetra10", mesh.cells_dict["tetra10"])])
    linear = meshio.Mesh(mesh.points, [("tetra", mesh.cells_dict["tetra10"][:, :4])])
    solid.write(made / "a.vtu")
    solid.write(made / "a.xdmf")
    linear.write(made / "a.cgns")
    write_matrices(made)
    return made


def write_matrices(made):
    """40 nodes in a row, three equations each."""
    n = 120
    K = sp.diags_array([2.0 * np.ones(n), -np.ones(n - 3), -np.ones(n - 3)], offsets=[0, 3, -3], format="csr") * 1e6
    M = sp.eye_array(n, format="csr")
    np.savetxt(made / "nodes.csv", np.column_stack([np.arange(1, 41), np.arange(40), np.zeros((40, 2))]), delimiter=",")
    np.savez(made / "k.npz", "sparse.npz", stiffness=K.toarray(), mass=M.toarray())
    sp.save_npz(made / "sparse.npz", K)
    import h5py

    with h5py.File(made / "k.h5", "w") as file:
        file["stiffness"], file["mass"] = K.toarray(), M.toarray()
    lower = sp.coo_array(sp.tril(K))
    scipy.io.mmwrite(made / "k.mtx", lower)
    scipy.io.hb_write(made / "k.matrix", sp.csc_matrix(K))
    for ending, matrix in (("sti", lower), ("mas", sp.coo_array(M))):
        rows = np.column_stack([matrix.row + 1, matrix.col + 1, matrix.data])
        np.savetxt(made / f"k.{ending}", rows, fmt=["%d", "%d", "%.15g"])
    (made / "k.dof").write_text("".join(f"{k // 3 + 1}.{k % 3 + 1}\n" for k in range(n)), encoding="ascii")
    cards = []
    for name, matrix in (("KAAX", K), ("MAAX", M)):
        cards.append(f"DMIG    {name:<8}{0:8d}{6:8d}{2:8d}{0:8d}")
        for column in range(n):
            cards.append(f"{'DMIG*':8}{name:<16}{column // 3 + 1:16d}{column % 3 + 1:16d}")
            for row in range(column, n):
                if matrix[row, column]:
                    value = f"{matrix[row, column]:.9E}".replace("E", "D")
                    cards.append(f"{'*':8}{row // 3 + 1:16d}{row % 3 + 1:16d}{value:>16}")
    (made / "k.pch").write_text("\n".join(cards) + "\n", encoding="ascii")
    op4 = pytest.importorskip("pyyeti.nastran.op4")
    op4.write(str(made / "k.op4"), {"KGG": sp.coo_matrix(K), "MGG": sp.coo_matrix(M)}, sparse="bigmat")


def commanded(folder, *names):
    """Exit code, standard output and standard error of `gearcase housing` for every file; one process for all."""
    done = subprocess.run(
        [sys.executable, "-c", EVERY, *names], cwd=folder, capture_output=True, check=False, timeout=600
    )
    assert done.returncode == 0, f"the process ended with {done.returncode}: {done.stderr[-2000:]!r}"
    printed, said = ({}, {})
    for stream, found in ((done.stdout, printed), (done.stderr, said)):
        pieces = re.split(rf"{MARK} (\S+) (\d+)\n", stream.decode("utf-8"))
        for text, name, code in zip(pieces[::3], pieces[1::3], pieces[2::3], strict=False):
            found[name] = (int(code), text)
    return {name: (*printed[name], said[name][1]) for name in names}


def damaged(sound, folder, name, ways):
    """Copies of a sound file in folders of their own, beside what belongs to it."""
    made = []
    for way in ways:
        own = folder / way.__name__
        own.mkdir()
        for beside in sound.iterdir():
            (own / beside.name).write_bytes(beside.read_bytes())
        rng = np.random.default_rng(zlib.crc32(f"{name} {way.__name__}".encode()))
        (own / name).write_bytes(way((sound / name).read_bytes(), rng))
        made.append(f"{way.__name__}/{name}")
    return made


def check_words(found):
    """One sentence of ours per refused file; nothing on standard error for one that is read."""
    for name, (code, printed, said) in found.items():
        lines = said.splitlines()
        assert code in (0, 1, 2), (name, code, said)
        if code:
            assert len(lines) == 1, (name, said)
            assert printed == "", name
            assert name.rpartition("/")[2].rpartition(".")[0] in lines[0], (name, said)
        else:
            assert lines == [], (name, said)
            assert "nan" not in printed, (name, printed)
        assert "\x1b" not in printed + said
        assert "Traceback" not in said


@pytest.mark.parametrize("name", ["a.brep", "a.iges", "a.med", "k.h5"])
def test_garbage_in_the_middle_of_a_file_is_no_crash(sound, tmp_path, name):
    """Each of these ends the process of the library that reads it, or makes it write to the terminal."""
    found = commanded(tmp_path, *damaged(sound, tmp_path, name, [garbage_in_the_middle]))
    check_words(found)


@pytest.mark.slow
@pytest.mark.parametrize("name", [*CAD, *MESHES, *MATRICES])
def test_a_file_damaged_in_ten_ways_is_refused_in_a_sentence_or_sound(sound, tmp_path, name):
    check_words(commanded(tmp_path, *damaged(sound, tmp_path, name, DAMAGES)))
