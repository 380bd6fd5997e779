"""Small machines for the multibody tests: a synthetic mesh law, a casing of few coordinates, rigs of 1 to 3 stages."""

import dataclasses
import math

import numpy as np

from fem.casing.reduced.reduced_body import ReducedBody
from fem.contact.law import MeshLaw
from mbd.forces.pendulum import RopePendulum, RopePendulumLoad
from mbd.forces.rope import RopeLoad
from mbd.parts.bearings import BearingSpec
from mbd.parts.gear_mesh import MeshSpec
from mbd.parts.load import StaticTorque
from mbd.parts.machine import Machine
from mbd.parts.shafts import Disk, Section, ShaftSpec
from mbd.parts.speed_drive import MotorCoupling, SpeedProfile

AXES = ("ux", "uy", "uz", "rx", "ry", "rz")
ROPE = {
    "container_mass": 1000.0, "drum_radius": 0.1, "drum_mass": 10.0, "drum_inertia": 0.05,
    "rope_modulus": 3.57e6 / (0.455 * math.pi / 4 * 0.01**2),
}  # fmt: skip
TRANSVERSE_ANGLE = math.radians(20.5)


def mesh_law(flank="drive", *, module=0.002, helix=0.2, width=0.012, teeth=(20, 55), ripple=0.3, hand=1, hertz=True):
    """Law with two or one pairs in mesh, softer at the tips; ``ripple`` 0 gives one pair and a constant stiffness."""
    sign = 1 if flank == "drive" else -1
    slices = 7 if helix else 5
    width_s = width / slices
    y = (np.arange(slices) - 0.5 * (slices - 1)) * width_s
    pitch = math.pi * module * math.cos(TRANSVERSE_ANGLE)
    xi = np.linspace(-1.2, 1.2, 121)
    stiffness = 14e9  # N/m per m of face
    if ripple:
        compliance = (1 + ripple * xi**2) / stiffness
        reach = 0.8
        gap = np.maximum(abs(xi) - reach, 0.0) ** 2 * 4e-3
        fraction = np.ones_like(xi)
        between = np.full((1, xi.size), 0.05 / stiffness)
    else:
        compliance = np.full_like(xi, 1 / stiffness)
        gap = np.zeros_like(xi)
        fraction = np.clip((1.0 - abs(xi)) / 1.0, 0.0, 1.0)  # two hats add up to one pair
        between = np.zeros((0, xi.size))
    return MeshLaw(
        model="test",
        flank=flank,
        face_coordinate=y,
        slice_width=np.full(slices, width_s),
        cycle_shift=sign * hand * y * math.tan(helix) / pitch,
        cycle_sign=sign,
        cycle_offset=0.0 if sign == 1 else 0.5,
        position_start=xi[0],
        position_step=xi[1] - xi[0],
        compliance=compliance,
        contact_slope=3e-12 if hertz and ripple else 0.0,
        contact_offset=np.full_like(xi, 20.0),
        neighbour_compliance=between,
        gap=gap,
        fraction=fraction,
        base_pitch=pitch,
        pinion_teeth=teeth[0],
        wheel_teeth=teeth[1],
        wheel_tooth_offset=0 if sign == 1 else 1,
    )


def mesh(name, driving, driven, y, *, teeth, module, helix, width, backlash=60e-6, tau=1.8e-6, start=0.0, **law):
    """A gear pair on a standard centre distance with the base radii of its teeth."""
    radius = [0.5 * z * module * math.cos(TRANSVERSE_ANGLE) for z in teeth]
    options = {"teeth": teeth, "module": module, "helix": helix, "width": width, **law}
    return MeshSpec(
        name=name,
        driving=driving,
        driven=driven,
        y=y,
        base_radius_driving=radius[0],
        base_radius_driven=radius[1],
        pressure_angle=TRANSVERSE_ANGLE,
        base_helix_angle=helix,
        backlash=backlash,
        damping_time=tau,
        drive=mesh_law("drive", **options),
        coast=mesh_law("coast", **options),
        cycle_at_start=start,
    )


def gear_disk(name, y, radius, width):
    mass = 7850 * math.pi * radius**2 * width
    return Disk(name=name, y=y, mass=mass, polar_inertia=mass * radius**2 / 2, diametral_inertia=mass * radius**2 / 4)


STAGES = (
    {"teeth": (20, 55), "module": 0.002 / math.cos(0.21), "helix": 0.2, "width": 0.012},
    {"teeth": (21, 62), "module": 0.0025 / math.cos(0.21), "helix": 0.2, "width": 0.018},
    {"teeth": (22, 65), "module": 0.003 / math.cos(0.19), "helix": 0.18, "width": 0.028},
)
MESH_Y = (-0.05, 0.04, -0.04)
DIAMETERS = (0.025, 0.03, 0.04, 0.055)


def train(n_stages=1, *, load="torque", speed=94.2477796, profile=None, model="timoshenko", stages=STAGES, **options):
    """Machine of ``n_stages`` shafts-and-meshes in line along x; options: torque, rope, coupling, tau, bearing."""
    shafts, bearings, meshes = [], [], []
    x = 0.0
    for i in range(n_stages + 1):
        disks = []
        if i < n_stages:
            stage = stages[i]
            disks.append(
                gear_disk(f"pinion_{i + 1}", MESH_Y[i], 0.5 * stage["teeth"][0] * stage["module"], stage["width"])
            )
        if i > 0:
            stage = stages[i - 1]
            disks.append(
                gear_disk(f"wheel_{i}", MESH_Y[i - 1], 0.5 * stage["teeth"][1] * stage["module"], stage["width"])
            )
        if i == n_stages:
            disks += [gear_disk("drum_1", -0.2, 0.1, 0.02), gear_disk("drum_2", 0.2, 0.1, 0.02)]
        shafts.append(
            ShaftSpec(
                name=f"shaft_{i + 1}",
                x=x,
                z=0.0,
                sense=1 if i % 2 == 0 else -1,
                sections=(Section(y_start=-0.2, y_end=0.2, outer_diameter=DIAMETERS[i]),),
                disks=tuple(disks),
                model=model,
                damping_time=options.get("shaft_tau", 1e-6),
                element_length=0.05,
            )
        )
        for k, y in enumerate((-0.1, 0.1)):
            bearings.append(
                BearingSpec(
                    name=f"bearing_{2 * i + k + 1}",
                    shaft=f"shaft_{i + 1}",
                    y=y,
                    stiffness=(1e8, 5e7, 1e8, 1e4, 1e4),
                    damping_time=options.get("bearing_tau", 1e-5),
                )
            )
        if i < n_stages:
            stage = stages[i] | options.get("stage", {})
            meshes.append(mesh(f"stage_{i + 1}", f"shaft_{i + 1}", f"shaft_{i + 2}", MESH_Y[i], **stage))
            x += 0.5 * sum(stage["teeth"]) * stage["module"]
    coupling = options.get("coupling", 2e4)
    couplings = tuple(
        MotorCoupling(
            name=f"motor_{k + 1}",
            shaft="shaft_1",
            y=y,
            stiffness=coupling,
            damping=options.get("coupling_damping", 0.2),
        )
        for k, y in enumerate((-0.2, 0.2))
    )
    last, drums = f"shaft_{n_stages + 1}", (-0.2, 0.2)
    if load == "torque":
        hanging = StaticTorque(shaft=last, drums=drums, torque=options.get("torque", 30.0))
    else:
        hanging = RopeLoad(**ROPE | options.get("rope", {})).load(last, drums)
    if profile is None:
        profile = SpeedProfile(times=np.array([0.0]), speeds=np.array([speed]))
    return Machine(
        shafts=tuple(shafts), bearings=tuple(bearings), meshes=tuple(meshes), couplings=couplings, profile=profile,
        load=hanging, gravity=options.get("gravity", 9.80665),
    )  # fmt: skip


def hoisting(model="timoshenko", **rope):
    """One stage that lifts a container of 300 kg, with the options of its rope."""
    return train(1, load="rope", rope={"container_mass": 300.0, **rope}, model=model)


def swinging():
    """One stage whose container swings."""
    machine = hoisting()
    return dataclasses.replace(machine, load=pendulum(machine.load, sway_x=0.05, sway_y=0.02))


def pendulum(load, **options):
    """A load on ropes, with a container that swings."""
    given = {f.name: getattr(load.hoist, f.name) for f in dataclasses.fields(load.hoist) if f.name != "model"}
    hoist = RopePendulumLoad(**given | options)
    return RopePendulum(shaft=load.shaft, drums=load.drums, hoist=hoist, follow_length=load.follow_length)


def no_casing():
    """Bearings to ground."""
    return ReducedBody(
        model="none", mass=np.zeros((0, 0)), stiffness=np.zeros((0, 0)), damping=np.zeros((0, 0)),
        coordinate_names=(), row_names=(), rows=np.zeros((0, 0)), point_names=(), point_positions=np.zeros((0, 3)),
        ground_inertia=np.zeros((0, 3)), row_shifts=np.zeros((0, 3)), foot_stiffness=np.zeros((0, 0)),
        foot_inertia=np.zeros((0, 3)),
    )  # fmt: skip


def rigid_casing(machine, mass=40.0, mount=4e7, extra=0, ratio=0.01, seed=0):
    """A rigid box on springs that carries all bearings and sensor_1..3; ``extra`` random elastic modes on top."""
    shafts = {s.name: s for s in machine.shafts}
    points = {b.name: (shafts[b.shaft].x, b.y, shafts[b.shaft].z) for b in machine.bearings}
    points |= {f"sensor_{i + 1}": (0.1 * i, 0.1, 0.05) for i in range(3)}
    random = np.random.default_rng(seed)
    m = np.diag([mass, mass, mass, 0.8, 2.0, 1.6])
    k = np.diag([mount, mount, 2 * mount, 0.05 * mount, 0.1 * mount, 0.08 * mount])
    omega = 2 * np.pi * np.linspace(400, 7500, extra)
    m, k = (
        np.block([[m, np.zeros((6, extra))], [np.zeros((extra, 6)), np.eye(extra)]]),
        np.block([[k, np.zeros((6, extra))], [np.zeros((extra, 6)), np.diag(omega**2)]]),
    )
    c = np.diag(2 * ratio * np.sqrt(np.diag(k) * np.diag(m)))
    names, rows = [], []
    for name, (x, y, z) in points.items():
        for a, axis in enumerate(AXES):
            arm = np.array([[0, z, -y], [-z, 0, x], [y, -x, 0]])
            rigid = np.concatenate([np.eye(3)[a], arm[a]]) if a < 3 else np.eye(6)[a]
            shape = 0.15 * random.standard_normal(extra) * (1.0 if a < 3 else 5.0)
            names.append(f"{name}:{axis}")
            rows.append(np.concatenate([rigid, shape]))
    return ReducedBody(
        model="rigid", mass=m, stiffness=k, damping=c, coordinate_names=tuple(f"q{i}" for i in range(6 + extra)),
        row_names=tuple(names), rows=np.array(rows), point_names=tuple(points),
        point_positions=np.array(list(points.values())), ground_inertia=m[:, :3], row_shifts=np.array(rows)[:, :3],
        foot_stiffness=np.zeros((0, 6 + extra)), foot_inertia=np.zeros((0, 3)),
    )  # fmt: skip
