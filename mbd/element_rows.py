"""Rows and constants of a machine's further nonlinear elements (`mbd.elements`), from its parts."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from mbd.bearings import BEARING_AXES
from mbd.channels import bearing_row
from mbd.elements import (
    BALL,
    DRAG,
    EFFICIENCY,
    GROUND,
    GYROSCOPIC,
    PENDULUM,
    ROLLER,
    ROWS,
    SLIDING,
    VALUES,
    WIDTH,
    Extra,
)
from mbd.layout import Layout
from mbd.load import Rope, RopePendulum
from mbd.losses import SMOOTHING, Coulomb, Efficiency, sliding_rows
from mbd.mesh_reference import sliding_shares
from mbd.rolling_elements import element_values, pass_frequencies, reference_load

SLOWEST = 1.0  # rad/s: smoothing speed of a machine that never turns


@dataclass(eq=False)
class ElementRows:
    """Collects elements one after another; ``names`` are those of their parts in the energy books."""

    size: int
    first: int  # number of the first row among all force rows
    kinds: list[int] = field(default_factory=list)
    names: list[str] = field(default_factory=list)
    flanks: list[int] = field(default_factory=list)
    values: list[np.ndarray] = field(default_factory=list)
    shares: list[np.ndarray] = field(default_factory=list)
    rows: list[np.ndarray] = field(default_factory=list)
    row_names: list[str] = field(default_factory=list)
    patterns: list[list[int]] = field(default_factory=list)
    stiffness: list[float] = field(default_factory=list)
    damping: list[float] = field(default_factory=list)
    scale: list[float] = field(default_factory=list)

    def add(
        self, kind: int, name: str, rows: np.ndarray, values: list[float] | np.ndarray, scale: list[float], *,
        words: tuple[str, ...], stiffness: list[float] | None = None, damping: list[float] | None = None,
        flank: int = -1, reads: tuple[int, ...] = (),
    ) -> None:  # fmt: skip
        """An element on ``rows``; ``reads`` are flank rows that its forces depend on besides its own."""
        n = ROWS[kind]
        at = self.first + len(self.rows)
        own = [*reads, *range(at, at + n)]
        if kind == SLIDING:
            own = [*reads, at + 1]  # both forces depend on kappa' alone
        self.kinds.append(kind)
        self.names.append(name)
        self.flanks.append(flank)
        self.values.append(np.pad(np.asarray(values, dtype=float), (0, VALUES - len(values))))
        self.rows += list(rows)
        self.row_names += [f"{name}:{word}" for word in words]
        self.patterns += [own + [-1] * (WIDTH - len(own))] * n
        self.stiffness += stiffness or [0.0] * n
        self.damping += damping or [0.0] * n
        self.scale += scale

    def matrix(self) -> np.ndarray:
        """All rows (row, coordinate)."""
        return np.array(self.rows).reshape(-1, self.size)

    def extra(self, rolling: np.ndarray) -> Extra:
        """The tables; ``rolling`` (coordinate,) is the motion per motor angle."""
        counts = [ROWS[kind] for kind in self.kinds]
        at = np.concatenate([[0], np.cumsum(counts)])[:-1] if counts else np.zeros(0)
        roll = self.matrix() @ rolling
        roll[abs(roll) < 1e-12 * abs(roll).max(initial=0.0)] = 0.0
        if self.kinds:  # bearings and ropes do not move while the machine rolls
            still = np.repeat([kind in (BALL, ROLLER, PENDULUM, GYROSCOPIC) for kind in self.kinds], counts)
            roll[still] = 0.0
        return Extra(
            kind=np.array(self.kinds, dtype=np.int64),
            at=at.astype(np.int64),
            flank=np.array(self.flanks, dtype=np.int64),
            values=np.array(self.values).reshape(-1, VALUES),
            shares=np.array(self.shares) if self.shares else np.zeros((0, 2, 1)),
            pattern=np.array(self.patterns, dtype=np.int64).reshape(-1, WIDTH),
            stiffness=np.array(self.stiffness),
            damping=np.array(self.damping),
            scale=np.array(self.scale),
            roll=roll,
        )


def element_rows(lay: Layout, first: int, loads: dict[str, float]) -> ElementRows:
    """All further elements but drag and gyroscopic planes, which need the assembled matrices.

    first : number of flank and rope rows; loads : reference loads (N) by mesh name
    """
    found = ElementRows(lay.size, first)
    _bearings(found, lay)
    _meshes(found, lay, loads)
    _brake(found, lay)
    _load(found, lay)
    return found


def _smoothing(lay: Layout) -> float:
    """Motor speed (rad/s) over which losses reverse."""
    return SMOOTHING * lay.machine.profile.highest or SLOWEST


def _bearings(found: ElementRows, lay: Layout) -> None:
    ratios = lay.machine.ratios()
    for bearing in lay.machine.bearings:
        elements = bearing.rolling
        if elements is None:
            continue
        shaft = lay.machine.shaft(bearing.shaft)
        cage = shaft.sense * ratios[bearing.shaft] * pass_frequencies(elements).cage
        load, arm = reference_load(elements), elements.pitch_diameter / 2
        found.add(
            BALL if elements.kind == "ball" else ROLLER,
            bearing.name,
            np.array([bearing_row(lay, bearing, axis) for axis in BEARING_AXES]),
            element_values(elements, cage, bearing.damping_time),
            [load, load, load, load * arm, load * arm],
            words=BEARING_AXES,
            stiffness=list(bearing.stiffness),
            damping=[bearing.damping_time * k for k in bearing.stiffness],
        )


def _meshes(found: ElementRows, lay: Layout, loads: dict[str, float]) -> None:
    machine = lay.machine
    losses, ratios = machine.losses, machine.ratios()
    for i, mesh in enumerate(machine.meshes):
        driving, driven = machine.shaft(mesh.driving), machine.shaft(mesh.driven)
        roll = ratios[mesh.driving] + ratios[mesh.driven]
        smooth = _smoothing(lay) * roll
        for flank in (0, 1):
            both = sliding_rows(mesh, driving, driven, 1 - 2 * flank)
            rows = np.array(
                [lay.node_row(mesh.driving, mesh.y, r[:6]) + lay.node_row(mesh.driven, mesh.y, r[6:]) for r in both]
            )
            if isinstance(losses, Efficiency) and flank == 0:
                found.add(
                    EFFICIENCY,
                    f"{mesh.name} losses",
                    rows[1:],
                    [losses.mesh_efficiency, mesh.base_radius_driving, mesh.ratio, roll, smooth],
                    [loads[mesh.name] * mesh.base_radius_driving],
                    words=("kappa",),
                    flank=2 * i,
                    reads=tuple(range(4 * i, 4 * i + 4)),
                )
            if isinstance(losses, Coulomb) and losses.tooth_friction > 0.0:
                law = mesh.coast if flank else mesh.drive
                values = [losses.tooth_friction, roll, smooth, len(found.shares), mesh.cycle_at_start]
                found.shares.append(sliding_shares(law, loads[mesh.name]))
                found.add(
                    SLIDING,
                    f"{mesh.name} losses",
                    rows,
                    [*values, mesh.cycles_per_radian * ratios[mesh.driving]],
                    [loads[mesh.name], loads[mesh.name] * mesh.base_radius_driving],
                    words=(f"{('drive', 'coast')[flank]}_w", f"{('drive', 'coast')[flank]}_kappa"),
                    flank=2 * i + flank,
                    reads=(4 * i + 2 * flank, 4 * i + 2 * flank + 1),
                )


def bearing_drag(found: ElementRows, lay: Layout, forces: dict[str, float]) -> None:
    """Add the drag of all bearings at their loads (N) by name."""
    losses, ratios = lay.machine.losses, lay.machine.ratios()
    if not isinstance(losses, Coulomb) or losses.bearing_friction == 0.0:
        return
    for bearing in lay.machine.bearings:
        shaft = lay.machine.shaft(bearing.shaft)
        section = next(s for s in shaft.sections if s.y_start - 1e-9 <= bearing.y <= s.y_end + 1e-9)
        torque = losses.bearing_friction * forces[bearing.name] * section.outer_diameter / 2
        roll = ratios[bearing.shaft]
        found.add(
            DRAG,
            f"{bearing.name} drag",
            lay.angle_row(bearing.shaft, bearing.y)[None],
            [torque, roll, _smoothing(lay) * roll, 0.0],
            [max(torque, 1e-6)],
            words=("angle",),
        )


def _brake(found: ElementRows, lay: Layout) -> None:
    brake = lay.machine.brake
    if brake is None or brake.torque == 0.0:
        return
    roll, smooth = lay.machine.ratios()[brake.shaft], _smoothing(lay)
    found.add(
        DRAG,
        "brake",
        lay.angle_row(brake.shaft, brake.y)[None],
        [brake.torque, roll, smooth * roll, smooth],
        [brake.torque],
        words=("angle",),
    )


def _load(found: ElementRows, lay: Layout) -> None:
    load, machine = lay.machine.load, lay.machine
    if not isinstance(load, Rope):
        return
    rise = load.travel_per_radian * machine.ratios()[load.shaft]
    weight = load.container_mass * machine.gravity
    if isinstance(load, RopePendulum):
        n = len(load.drums)
        loss = 2 * load.damping_ratio * (load.container_mass / n) ** 0.5
        stiff, swing = load.stiffness_times_length / load.length, max(weight, 1.0) / n / load.length
        travel = rise if load.follow_length else 0.0
        for i, y in enumerate(load.drums):
            sway = np.zeros((2, lay.size))
            sway[0, -3] = sway[1, -2] = 1.0
            found.add(
                PENDULUM,
                "rope",
                np.vstack([lay.stretch_row(y)[None], sway]),
                [load.stiffness_times_length, load.length, travel, loss],
                [max(weight, 1.0) / n] * 3,
                words=(f"{i}:stretch", f"{i}:x", f"{i}:y"),
                stiffness=[stiff, swing, swing],
                damping=[loss * stiff**0.5, 0.0, 0.0],
            )
    if load.ground is not None:
        ground, lift = load.ground, np.zeros((1, lay.size))
        lift[0, -1] = 1.0
        damping = 2 * ground.damping_ratio * (ground.stiffness * load.container_mass) ** 0.5
        found.add(
            GROUND,
            "ground",
            lift,
            [ground.stiffness, damping, ground.level, rise],
            [max(weight, 1.0)],
            words=("lift",),
        )


def gyroscopic_planes(
    found: ElementRows, first: np.ndarray, second: np.ndarray, strengths: np.ndarray, smooth: float
) -> None:
    """Add gyroscopic planes on the rows ``first`` and ``second`` (plane, coordinate) with the strengths g (kg m2)."""
    for a, b, g in zip(first, second, strengths, strict=True):
        size = abs(g) * smooth
        found.add(GYROSCOPIC, "gyroscopic", np.vstack([a, b]), [g], [size, size], words=("a", "b"))
