"""What is wrong with a CAD file is one sentence: which body, where in mm, and what to do; nothing else is printed."""

import subprocess
import sys

import pytest

from fem.casing.geometry.locators import ByCylinder, ByPlane
from fem.casing.mesh.cad_file import import_solids
from fem.casing.mesh.choose_mesher import mesh_geometry
from fem.casing.mesh.gmsh_session import session
from fem.casing.mesh.imported_housing import ImportedHousing, Seat, content_hash
from fem.casing.mesh.mesh import MeshError
from fem.casing.mesh.sizes import Sizes
from fem.casing.recognition.read_geometry import geometry_contents
from pipelines.scene.validation_messages import nearest


def bored(occ):
    """A block of 60 x 30 x 20 mm with a bore of 12 mm."""
    return occ.cut([(3, occ.addBox(0, 0, 0, 60, 30, 20))], [(3, occ.addCylinder(30, -1, 10, 0, 32, 0, 6))])[0]


def a_groove_of_50_um(occ):
    occ.cut(bored(occ), [(3, occ.addBox(20, -1, 19, 0.05, 40, 2))])


def a_hole_of_80_um(occ):
    occ.cut(bored(occ), [(3, occ.addCylinder(10, 10, -1, 0, 0, 30, 0.04))])


def one_body_twice(occ):
    bored(occ)
    bored(occ)


def a_neighbour(occ):
    bored(occ)
    occ.addBox(60, 0, 0, 30, 30, 20)


def a_neighbour_at_an_edge(occ):
    bored(occ)
    occ.addBox(60, 0, 20, 30, 30, 20)


def a_neighbour_at_a_corner(occ):
    bored(occ)
    occ.addBox(60, 30, 20, 30, 30, 20)


def faces_alone(occ):
    occ.synchronize()
    occ.addRectangle(0, 0, 0, 60, 30)


def written(path, make):
    with session() as gmsh:
        make(gmsh.model.occ)
        gmsh.model.occ.synchronize()
        gmsh.write(str(path))
    return path


def meshed(path, **changes):
    seat = Seat(name="bearing_1", locator=ByCylinder(through=(0.03, 0.015, 0.01), diameter=0.012))
    ground = ByPlane(through=(0.0, 0.0, 0.0), normal=(0.0, 0.0, -1.0))
    usual = {"path": str(path), "sha256": content_hash(path), "unit": "mm", "seats": (seat,), "grounds": (ground,)}
    return mesh_geometry(ImportedHousing(**(usual | changes)), Sizes(element=0.008))


@pytest.mark.parametrize(
    ("make", "glue", "words"),
    [
        (a_groove_of_50_um, False, r"2 edges .* smaller than 0.1 mm, .* 0.05 mm at \(20.025, .* remove"),
        (a_hole_of_80_um, False, r"2 edges .* smaller than 0.1 mm, .* of 0.08 mm at \(10, 10, .* remove"),
        (
            one_body_twice,
            False,
            r"solids 1 and 2 are duplicates of one body, both at \(30, 15, 10\) mm .* leave",
        ),
        (one_body_twice, True, r"solids 1 and 2 are duplicates of one body"),
        (a_neighbour, False, r"has 2 solids .* set glue = true .* or choose some by solids = \[1\]"),
        (a_neighbour_at_an_edge, True, r"share only an edge or a vertex with the others, around \(60, 15, 20\) mm"),
        (a_neighbour_at_a_corner, True, r"share only an edge or a vertex with the others, around \(60, 30, 20\) mm"),
        (faces_alone, False, r"has no volume: it holds 1 surfaces .* Sew the surfaces"),
    ],
)
def test_a_doubtful_body_is_refused_with_its_place_and_the_remedy(tmp_path, make, glue, words):
    path = written(tmp_path / "part.step", make)
    with pytest.raises(MeshError, match=words):
        meshed(path, glue=glue)


@pytest.mark.parametrize(("said", "shown"), [("Could not read file '{}'", ""), ("no root", " (no root)")])
def test_the_words_of_gmsh_are_shown_unless_they_repeat_the_path(tmp_path, monkeypatch, said, shown):
    path = written(tmp_path / "part.step", bored)
    with session() as gmsh:

        def refuse(*_, **__):
            raise Exception(said.format(path))  # gmsh raises this class itself

        monkeypatch.setattr(gmsh.model.occ, "importShapes", refuse)
        with pytest.raises(MeshError) as refused:
            import_solids(gmsh, path, "mm")
    assert str(refused.value).startswith(f"part.step cannot be read as STEP{shown}; it is damaged, or its format")


def test_a_file_in_inches_says_so(tmp_path):
    """The block in a file that calls its unit inch: the number 60 means 1524 mm."""
    path = written(tmp_path / "part.step", bored)
    text = path.read_text(encoding="utf-8")
    line = next(line for line in text.splitlines() if "LENGTH_UNIT" in line)
    number = line.split("=")[0].strip()
    inch = (
        f"{number} = ( CONVERSION_BASED_UNIT('INCH',#90001) LENGTH_UNIT() NAMED_UNIT(#90002) );\n"
        "#90001 = LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#90003);\n"
        "#90002 = DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);\n"
        "#90003 = ( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) );"
    )
    path.write_text(text.replace(line, inch), encoding="utf-8")
    with pytest.raises(MeshError, match=r'declares its unit of length as inch, .* Set unit = "inch", or export'):
        meshed(path)
    assert geometry_contents(path).declared == "inch"
    assert geometry_contents(path).box[1] == pytest.approx([60 * 0.0254, 30 * 0.0254, 20 * 0.0254])


def test_a_damaged_file_leaves_one_line_on_the_terminal(tmp_path):
    """Every kind of file that a library reads, cut off: what the libraries say goes to the log, not to the shell."""
    step = written(tmp_path / "part.step", bored)
    half = step.read_bytes()[: step.stat().st_size // 2]
    names = ["a.step", "a.brep", "a.iges", "a.stl", "a.msh", "a.inp", "a.bdf", "a.unv", "a.med", "a.vtu", "a.vtk"]
    names += ["a.mesh", "a.xdmf", "a.cgns", "a.e", "a.mtx", "a.matrix", "a.sti", "a.npz", "a.h5", "a.op4", "a.pch"]
    code = "import sys; from pipelines.cli.main import main\nfor name in sys.argv[1:]: main(['housing', name])"
    for name in [*names, "a.dof"]:  # the latter beside a.sti
        (tmp_path / name).write_bytes(half)
    done = subprocess.run(
        [sys.executable, "-c", code, *names], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=120
    )
    assert done.stdout == ""
    lines = done.stderr.splitlines()
    assert len(lines) == len(names), done.stderr
    for name, line in zip(names, lines, strict=True):
        assert name in line.replace("a.dof", "a.sti")
        assert "\x1b" not in line


def test_a_common_unit_is_no_reason_to_offer_a_key():
    assert nearest("width_mm", ["depth_um", "file", "unit"]) == ""
    assert nearest("widht_mm", ["depth_um", "width_mm"]) == "width_mm"
    assert nearest("elastic_modulus", ["density_kg_m3", "elastic_modulus_GPa"]) == "elastic_modulus_GPa"
