"""What follows from a scene before anything is computed: ratios, frequencies, torques, tooth loads, and warnings."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from mbd.machine import STANDARD_GRAVITY
from mbd.train import power_flow
from pipelines.flank_checks import flank_warnings
from pipelines.layout import Layout
from pipelines.scene import Scene
from pipelines.tables.motion import RopeTable

# ISO 6336-1:2019: the stiffness formula is meant for at least this line load; below, it is reduced
LOW_LINE_LOAD = 100e3  # N/m

# fewer leave no bins between the orders for a local floor (pipelines.spectrum)
FEWEST_REVOLUTIONS = 6


@dataclass(frozen=True, kw_only=True)
class StageFacts:
    """One stage at the highest motor speed and the hanging load (SI)."""

    ratio: float
    centre_distance: float
    transverse_contact_ratio: float
    overlap_ratio: float
    mesh_frequency: float
    pinion_frequency: float
    wheel_frequency: float
    pinion_torque: float
    mesh_force: float
    line_load: float
    backlash: float


@dataclass(frozen=True, kw_only=True)
class Facts:
    """Derived quantities of a scene (SI)."""

    motor_speed: float
    total_ratio: float
    output_torque: float
    input_torque: float
    stages: tuple[StageFacts, ...]
    bearing_points: tuple[tuple[float, float, float], ...]
    rope_frequency: float | None
    container_speed: float
    warnings: tuple[str, ...]


def output_torque(scene: Scene) -> float:
    """Torque of the hanging weight on the last shaft (N m): m g R / reeving."""
    load = scene.load
    return load.container_kg * STANDARD_GRAVITY * load.drum_radius_mm / 1000 / load.reeving_ratio


def rope_stiffness(load: RopeTable, length: float) -> float:
    """Stiffness that carries the container (N/m): falls * E A / L, A the metallic area."""
    area = load.rope_fill_factor * math.pi / 4 * (load.rope_diameter_mm / 1000) ** 2
    return load.rope_falls * load.rope_modulus_GPa * 1e9 * area / length


def rope_frequency(scene: Scene, length: float | None = None) -> float | None:
    """Bounce frequency of the container on its rope, drum held (Hz); None without rope or container."""
    load = scene.load
    if not isinstance(load, RopeTable) or load.container_kg == 0:
        return None
    stiffness = rope_stiffness(load, load.rope_length_m if length is None else length)
    return math.sqrt(stiffness / load.container_kg) / (2 * math.pi)


def bearing_names(scene: Scene) -> list[tuple[str, int, int]]:
    """Name, shaft and place on it (0-based) of every bearing: bearing_1, bearing_2, ... carried by the casing, numbered
    in shaft order from -y; ground_bearing_1, ... by the ground."""
    found: list[tuple[str, int, int]] = []
    counts = {"casing": 0, "ground": 0}
    for number, shaft in enumerate(scene.shafts):
        supports = shaft.bearing_supports or ("casing",) * len(shaft.bearing_positions_mm)
        for place, support in enumerate(supports):
            counts[support] += 1
            found.append((f"{'' if support == 'casing' else 'ground_'}bearing_{counts[support]}", number, place))
    return found


def bearing_points(scene: Scene, layout: Layout) -> tuple[tuple[float, float, float], ...]:
    """(x, y, z) of bearing_1, bearing_2, ... (m), those that the casing carries."""
    return tuple(
        (layout.axes[shaft][0], scene.shafts[shaft].bearing_positions_mm[place] / 1000, layout.axes[shaft][1])
        for name, shaft, place in bearing_names(scene)
        if not name.startswith("ground")
    )


def power_shares(scene: Scene, layout: Layout) -> list[float]:
    """Share of the load's power that each stage carries without losses; parallel paths share alike, see `mbd.train`."""
    flows = [*layout.pair_shafts, *((c.shafts[0] - 1, c.shafts[1] - 1) for c in scene.couplings)]
    return power_flow(len(scene.shafts), flows, [layout.driven], layout.loaded)[: len(scene.stages)].tolist()


def derive(scene: Scene, layout: Layout) -> Facts:
    """All derived quantities and what a designer would frown at."""
    speed = max(abs(value) for value in scene.drive.speeds_rpm) / 60 * 2 * math.pi
    torque = output_torque(scene)
    shares = power_shares(scene, layout)
    stages = []
    for number, (stage, pair) in enumerate(zip(scene.stages, layout.pairs, strict=True)):
        pinion_speed = layout.shaft_ratios[layout.pair_shafts[number][0]]
        turn = speed * pinion_speed / (2 * math.pi)
        pinion_torque = torque / layout.ratio * shares[number] / pinion_speed
        force = pinion_torque / pair.pinion.base_radius
        stages.append(
            StageFacts(
                ratio=pair.ratio,
                centre_distance=pair.axis_distance,
                transverse_contact_ratio=pair.transverse_contact_ratio,
                overlap_ratio=pair.overlap_ratio,
                mesh_frequency=turn * stage.pinion_teeth,
                pinion_frequency=turn,
                wheel_frequency=turn / pair.ratio,
                pinion_torque=pinion_torque,
                mesh_force=force,
                line_load=abs(pinion_torque) / pair.working_radii[0] / pair.face_width,
                backlash=pair.backlash,
            )
        )
    drum_speed = speed * layout.shaft_ratios[layout.loaded] * scene.load.drum_radius_mm / 1000
    return Facts(
        motor_speed=speed,
        total_ratio=layout.ratio,
        output_torque=torque,
        input_torque=torque / layout.ratio,
        stages=tuple(stages),
        bearing_points=bearing_points(scene, layout),
        rope_frequency=rope_frequency(scene),
        container_speed=drum_speed / scene.load.reeving_ratio,
        warnings=tuple(_warnings(scene, layout, stages)),
    )


def _warnings(scene: Scene, layout: Layout, stages: list[StageFacts]) -> Iterator[str]:
    for number, (stage, pair, facts) in enumerate(zip(scene.stages, layout.pairs, stages, strict=True), 1):
        place = f"stages.{number}"
        if facts.transverse_contact_ratio < 1.2:
            yield (
                f"{place}: transverse contact ratio {facts.transverse_contact_ratio:.3f} is below 1.2; raise teeth or "
                "rack_addendum"
            )
        nearest = round(facts.overlap_ratio)
        if nearest >= 1 and abs(facts.overlap_ratio - nearest) < 0.05:
            yield (
                f"{place}: overlap ratio {facts.overlap_ratio:.3f} is almost whole, the mesh excitation nearly "
                "vanishes; good for noise, bad for seeing faults"
            )
        if stage.face_width_mm > 1.2 * pair.pinion.reference_radius * 2000:
            yield f"{place}: face width {stage.face_width_mm:g} mm is above 1.2 pinion diameters; load will not spread"
        divisor = math.gcd(stage.pinion_teeth, stage.wheel_teeth)
        if divisor > 5:
            yield (
                f"{place}: {stage.pinion_teeth} and {stage.wheel_teeth} teeth share the divisor {divisor}; the same "
                "teeth meet often and wear in a pattern"
            )
        if 0 < facts.line_load < LOW_LINE_LOAD and stage.mesh.model == "iso":
            yield (
                f"{place}: line load {facts.line_load / 1000:.1f} N/mm is below 100 N/mm; the iso rung applies the "
                "low-load reduction of ISO 6336-1"
            )
        if facts.backlash < 0.02e-3 and scene.load.container_kg > 0:
            yield f"{place}: backlash {facts.backlash * 1e6:.1f} um is small; both flanks may touch under deviations"
    yield from flank_warnings(scene, layout, stages)
    if scene.simulation.output_rate_Hz < 10 * stages[0].mesh_frequency:
        yield (
            f"simulation.output_rate_Hz = {scene.simulation.output_rate_Hz:g} holds fewer than 5 harmonics of the mesh "
            f"frequency {stages[0].mesh_frequency:.1f} Hz; raise it to {20 * stages[0].mesh_frequency:.0f}"
        )
    if scene.load.container_kg == 0:
        yield "load.container_kg = 0: nothing holds the drive flank; the gears will rattle in their backlash"
    looked_at = (scene.diagnosis.stage, scene.diagnosis.gear)
    if scene.faults and scene.diagnosis.windows_s and looked_at not in {(f.stage, f.gear) for f in scene.faults}:
        yield (
            f"diagnosis looks for the stage {looked_at[0]} {looked_at[1]}, no fault is there; set diagnosis.stage and "
            "diagnosis.gear to the faulty gear"
        )
    if scene.faults:
        facts = stages[looked_at[0] - 1]
        turn = facts.pinion_frequency if looked_at[1] == "pinion" else facts.wheel_frequency
        for name, (start, end) in scene.diagnosis.windows_s.items():
            if (end - start) * turn < FEWEST_REVOLUTIONS:
                turns = (end - start) * turn
                yield (
                    f"diagnosis.windows_s.{name} holds {turns:.1f} revolutions of the stage {looked_at[0]} "
                    f"{looked_at[1]}, the diagnosis needs {FEWEST_REVOLUTIONS}; give it "
                    f"{FEWEST_REVOLUTIONS / turn:.2f} s or more"
                )
    if scene.faults and not (scene.control and scene.diagnosis.windows_s):
        missing = "control" if not scene.control else "diagnosis.windows_s"
        yield f"{missing} is not given: the run makes signals, but no diagnosis"
