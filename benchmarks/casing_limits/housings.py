"""The housings whose limits are put to the test, each as the preset `standard` meshes it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from fem.casing.geometry.dimensions import Bore
from fem.casing.geometry.housing import Housing
from fem.casing.geometry.housing_features import Feet, Fillets, Ribs, Walls
from fem.casing.geometry.locators import ByCylinder, ByPlane
from fem.casing.mesh.cad_file import read_step
from fem.casing.mesh.choose_mesher import Geometry
from fem.casing.mesh.gmsh_session import session
from fem.casing.mesh.housing_solid import build_solid
from fem.casing.mesh.imported_housing import ImportedHousing, Seat, content_hash
from fem.casing.mesh.sizes import Sizes
from fem.casing.models.elastic_casing import ElasticCasing
from fem.elements.materials import CAST_IRON, STEEL, Material
from pipelines.machine.machine_conversion import make_machine
from pipelines.scene.load_scene import load_scene
from pipelines.scene.presets import preset_on

ALUMINIUM = Material(name="aluminium", elastic_modulus=70e9, poisson_ratio=0.33, density=2700.0)
FREE = Sizes(element=0.033)  # 1.5 times 22 mm, as the preset takes cubic tetrahedra


@dataclass(frozen=True, kw_only=True)
class Case:
    """A housing that is its own mirror image about y = 0, how it is meshed, and the elements of its reference (m).

    `reference_levels`: how often these are divided towards edges, of `benchmarks.casing_limits.reference`.
    """

    name: str
    geometry: Geometry
    material: Material
    sizes: Sizes
    element: str
    reference_size: float
    reference_levels: int = 1

    def build(self, gmsh: Any) -> None:
        """Make the solid in an open session, mm."""
        if isinstance(self.geometry, Housing):
            build_solid(gmsh, self.geometry)
        else:
            read_step(gmsh, self.geometry)


def rig(folder: Path) -> Case:
    """The shipped rig."""
    return _shipped("rig-healthy", 0.0155, levels=2)


def bench(folder: Path) -> Case:
    """A test bench of one stage: a small box with thick bosses, on four feet."""
    return _shipped("bench", 0.014, levels=2)


def reducer(folder: Path) -> Case:
    """A two-stage reducer, whose bosses leave no room for hexahedra: it gave no number of any law."""
    return _shipped("reducer", 0.014, levels=2)


def walls(folder: Path) -> Case:
    """Plain walls of 6 to 14 mm, of steel: they gave its lower end, after the limits had missed them."""
    housing = Housing(
        length=0.38,
        width=0.22,
        height=0.2,
        wall_thickness=0.01,
        walls=Walls(side=0.01, end=0.008, floor=0.014, cover=0.006),
        left=-0.09,
        axis_height=0.1,
        bores=_bores({0.0: (0.055, 0.075), 0.15: (0.080, 0.105)}, length=0.028),
        feet=Feet(x=(-0.06, 0.26), length=0.05, height=0.012),
    )
    return Case(
        name="walls of 6 to 14 mm",
        geometry=housing,
        material=STEEL,
        sizes=Sizes(element=0.027),
        element="hexahedron-32",
        reference_size=0.013,
        reference_levels=2,
    )


def tall(folder: Path) -> Case:
    """A tall box of aluminium with walls of 7 mm: it gave no number of any law."""
    housing = Housing(
        length=0.28,
        width=0.2,
        height=0.3,
        wall_thickness=0.007,
        left=-0.08,
        axis_height=0.16,
        bores=_bores({0.0: (0.047, 0.066), 0.12: (0.062, 0.084)}, length=0.022),
        feet=Feet(x=(-0.05, 0.17), length=0.045, height=0.014),
    )
    return Case(
        name="tall box",
        geometry=housing,
        material=ALUMINIUM,
        sizes=Sizes(element=0.020),
        element="hexahedron-32",
        reference_size=0.012,
        reference_levels=2,
    )


def rig_step(folder: Path) -> Case:
    """The shipped rig in a STEP housing with fillets, flange, ribs and pads."""
    return _shipped("rig-step", 0.034)


def thin(folder: Path) -> Case:
    """Plain walls of 5 mm, of aluminium: they gave the upper end of the law of hexahedra, after it had missed some."""
    housing = Housing(
        length=0.36,
        width=0.2,
        height=0.16,
        wall_thickness=0.005,
        left=-0.08,
        axis_height=0.08,
        bores=_bores({0.0: (0.040, 0.056), 0.08: (0.052, 0.068), 0.19: (0.068, 0.088)}, length=0.016),
        feet=Feet(x=(-0.04, 0.1, 0.24), length=0.04, height=0.01),
    )
    return Case(
        name="thin walls of aluminium",
        geometry=housing,
        material=ALUMINIUM,
        sizes=Sizes(element=0.015),  # three wall thicknesses
        element="hexahedron-32",
        reference_size=0.0062,
    )


def bench_tetrahedra(folder: Path) -> Case:
    """The test bench, of tetrahedra: a housing that gave no number of their law."""
    return replace(bench(folder), name="bench, of tetrahedra", element="tetrahedron-20", sizes=FREE)


def thin_tetrahedra(folder: Path) -> Case:
    """The plain walls of 5 mm, of tetrahedra: neither did these."""
    sizes = Sizes(element=0.0165)
    return replace(thin(folder), name="thin walls, of tetrahedra", element="tetrahedron-20", sizes=sizes)


def cast(folder: Path) -> Case:
    """Fillets in the cavity and at the feet, ribs outside, pads under standing-out feet."""
    housing = Housing(
        length=0.34,
        width=0.22,
        height=0.19,
        wall_thickness=0.01,
        walls=Walls(cover=0.008),
        left=-0.08,
        axis_height=0.095,
        bores=_bores({0.0: (0.047, 0.067), 0.11: (0.072, 0.096)}, length=0.026),
        feet=Feet(x=(-0.04, 0.22), length=0.05, height=0.016, overhang=0.03, pad_diameter=0.026, pad_height=0.004),
        ribs=Ribs(thickness=0.009, height=0.012, per_boss=1, end_wall=1, cover=1),
        fillets=Fillets(foot=0.006, inner=0.01),
    )
    return Case(
        name="filleted casting",
        geometry=housing,
        material=CAST_IRON,
        sizes=FREE,
        element="tetrahedron-20",
        reference_size=0.024,
    )


def drum(folder: Path) -> Case:
    """A STEP file of a tube with end plates on two rails, written here: no plane walls but its ends."""
    path = folder / "drum.step"
    with session() as gmsh:
        _drum(gmsh.model.occ)
        gmsh.model.occ.synchronize()
        gmsh.write(str(path))
    seats = tuple(
        Seat(name=f"bearing_{n}", locator=ByCylinder(through=(x, y, z), diameter=diameter), shaft_point=(x, y, z))
        for n, (x, y, z, diameter) in enumerate(
            [(x, y, z, d / 1000) for x, z, d, _ in _DRUM_BORES for y in (-0.137, 0.137)], 1
        )
    )
    housing = ImportedHousing(
        path=str(path),
        sha256=content_hash(path),
        unit="mm",
        seats=seats,
        grounds=(ByPlane(through=(0.0, 0.0, -0.16), normal=(0.0, 0.0, 1.0)),),
    )
    return Case(
        name="imported drum",
        geometry=housing,
        material=CAST_IRON,
        sizes=FREE,
        element="tetrahedron-20",
        reference_size=0.018,
    )


CASES: dict[str, Callable[[Path], Case]] = {
    "rig": rig,
    "thin": thin,
    "bench": bench,
    "walls": walls,
    "tall": tall,
    "rig-step": rig_step,
    "cast": cast,
    "drum": drum,
    "reducer": reducer,
    "bench-tetrahedra": bench_tetrahedra,
    "thin-tetrahedra": thin_tetrahedra,
}

_DRUM_BORES = ((-0.045, 0.0, 52.0, 72.0), (0.055, 0.0, 80.0, 104.0))  # x, z in m; bore and boss in mm


def _drum(occ: Any) -> None:
    """The drum, mm."""
    shell, _ = occ.cut(
        [(3, occ.addCylinder(0, -150, 0, 0, 300, 0, 140))], [(3, occ.addCylinder(0, -138, 0, 0, 276, 0, 130))]
    )
    added = [(3, occ.addBox(x, -150, -160, 50, 300, 60)) for x in (-110, 60)]
    rails, _ = occ.cut(added, [(3, occ.addCylinder(0, -150, 0, 0, 300, 0, 135))])
    bosses = [
        (3, occ.addCylinder(1000 * x, y, 1000 * z, 0, inwards, 0, boss / 2))
        for x, z, _, boss in _DRUM_BORES
        for y, inwards in ((-150, 26), (150, -26))
    ]
    body, _ = occ.fuse(shell, [*rails, *bosses])
    holes = [(3, occ.addCylinder(1000 * x, -160, 1000 * z, 0, 320, 0, bore / 2)) for x, z, bore, _ in _DRUM_BORES]
    occ.cut(body, holes)


def _bores(axes: dict[float, tuple[float, float]], length: float) -> tuple[Bore, ...]:
    """Two bearings on every axis: x -> diameters of bore and boss."""
    return tuple(
        Bore(
            name=f"bearing_{2 * place + number}",
            x=x,
            side=side,
            diameter=diameter,
            boss_diameter=boss,
            boss_length=length,
        )
        for place, (x, (diameter, boss)) in enumerate(axes.items())
        for number, side in ((1, -1), (2, 1))
    )


def _shipped(scene: str, reference_size: float, levels: int = 1) -> Case:
    machine = make_machine(preset_on(load_scene(scene, {"casing.extrapolated": True}), "standard").scene)
    casing, structure = machine.casing, machine.structure
    assert isinstance(casing, ElasticCasing), f"the casing of {scene} has no finite elements"
    return Case(
        name=scene,
        geometry=structure.housing,  # type: ignore[arg-type]
        material=structure.material,  # type: ignore[arg-type]
        sizes=casing.sizes(structure),
        element=casing.element,
        reference_size=reference_size,
        reference_levels=levels,
    )
