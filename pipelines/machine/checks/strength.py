"""Strength of teeth, gear bodies and shafts: flank pressure, tooth deflection, bursting, torsion.

There is no nominal root stress: `pipelines.runs.root_stress` computes root stresses by finite elements.
Pressure of the flanks at the pitch point, without load factors:

    sigma_H0 = Z_H Z_E Z_eps Z_beta sqrt(F_t / (d_1 b) (u + 1) / u)

References
----------
ISO 6336-2:2019, 6 to 9 (sigma_H0 and its factors), table 2 (Z_NT of static load); ISO 6336-5:2016 (sigma_H lim of
case-carburized steel, grade ME); ISO 683-2:2016 (30CrNiMo8); DIN 743-3:2012 (42CrMo4).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fem.elements.materials import STEEL
from fem.gears.geometry import GearPair
from pipelines.io.errors import InputError, Problem
from pipelines.machine.checks.flank_checks import TYPICAL_STIFFNESS
from pipelines.machine.layout import TrainLayout
from pipelines.scene.scene import Scene
from pipelines.scene.validation_messages import other_unit

ENDURANCE = 1650e6  # Pa: sigma_H lim of the best case-carburized gear steel
STATIC_STRENGTH = 1.6 * ENDURANCE  # Pa: the same with Z_NT of a load that occurs only a few times
LARGEST_GIVE = 0.25  # modules, limit of small deflections of the teeth
TORSION_ENDURANCE = 330e6  # Pa: torsion fatigue strength of 42CrMo4
YIELD_STRENGTH = 1050e6  # Pa: 30CrNiMo8 in tension
TORSION_STRENGTH = YIELD_STRENGTH / math.sqrt(3)  # Pa: its yield in shear
RIM_SPEED = math.sqrt(8 * YIELD_STRENGTH / ((3 + STEEL.poisson_ratio) * STEEL.density))


@dataclass(frozen=True, kw_only=True)
class Torsion:
    """Torsion of the most stressed section of a shaft under the largest load; numbers from 1, SI."""

    shaft: int
    section: int
    torque: float
    stress: float
    diameter: float

    @property
    def path(self) -> str:
        """Key of its diameter."""
        return f"shafts.{self.shaft}.sections.{self.section}.diameter_mm"


def contact_pressure(pair: GearPair, pinion_torque: float) -> float:
    """Pressure sigma_H0 (Pa) at the pitch point under a pinion torque (N m)."""
    moduli = [material.plane_strain_modulus for material in (pair.pinion_material, pair.wheel_material)]
    alpha_t, alpha_w = pair.pinion.transverse_pressure_angle, pair.working_pressure_angle
    zone = 2 * math.cos(pair.base_helix_angle) / (math.cos(alpha_t) ** 2 * math.tan(alpha_w))
    elastic = 1 / (math.pi * sum(1 / modulus for modulus in moduli))
    across, along = pair.transverse_contact_ratio, min(1.0, pair.overlap_ratio)
    ratio = max(0.0, (4 - across) / 3 * (1 - along)) + along / across
    slant = 1 / math.cos(pair.pinion.helix_angle)
    diameter = 2 * pair.pinion.reference_radius
    load = 2 * abs(pinion_torque) / diameter / (diameter * pair.face_width) * (pair.ratio + 1) / pair.ratio
    return math.sqrt(zone * elastic * ratio * slant * load)


def torques_along(scene: Scene, layout: TrainLayout) -> list[list[tuple[float, float]]]:
    """By shaft: positions y (m) and the torques (N m, driving positive) that act there, without losses."""
    entering: list[list[tuple[float, float]]] = [[] for _ in scene.shafts]
    places = [(stage.si.position, stage.si.position) for stage in scene.stages]
    places += [coupling.si.positions for coupling in scene.couplings if coupling.turns_both]
    joined = (*layout.pair_shafts, *layout.coupling_shafts)
    for (giver, taker), (first, second), power in zip(joined, places, layout.power_flows, strict=True):
        entering[giver].append((first, -power / layout.shaft_ratios[giver]))
        entering[taker].append((second, power / layout.shaft_ratios[taker]))
    motors = [(layout.driven, y, layout.input_torque / len(layout.motors)) for y in layout.motors]
    for shaft, y, torque in (*motors, *layout.torques):
        entering[shaft].append((y, torque))
    return entering


def torsions(scene: Scene, layout: TrainLayout) -> list[Torsion]:
    """The most stressed section of every shaft with torque."""
    found = []
    for number, (shaft, entering) in enumerate(zip(scene.shafts, torques_along(scene, layout), strict=True), 1):
        places, torques = np.array(sorted(entering)).reshape(-1, 2).T
        inside, sections = np.cumsum(torques)[:-1], []
        for place, section in enumerate(shaft.sections, 1):
            start, end = section.si.start, section.si.end
            crossed = (places[:-1] < end - 1e-9) & (places[1:] > start + 1e-9) & (np.diff(places) > 0)
            torque = float(abs(inside[crossed]).max(initial=0.0))
            outer, inner = section.si.diameter, section.si.bore
            resistance = math.pi / 16 * outer**3 * (1 - (inner / outer) ** 4)
            stress = torque / resistance if resistance else math.inf
            sections.append(Torsion(shaft=number, section=place, torque=torque, stress=stress, diameter=outer))
        worst = max(sections, key=lambda one: one.stress if one.torque else -1.0)
        found += [worst] if worst.torque else []
    return found


def overloaded(scene: Scene, layout: TrainLayout) -> Iterator[Problem]:
    """Teeth and shafts for which no steel is strong enough at the largest load."""
    for number, (pair, facts) in enumerate(zip(layout.pairs, layout.stages, strict=True), 1):
        yield from _overloaded_teeth(number, pair, facts.pinion_torque)
    for worst in torsions(scene, layout):
        if not worst.stress <= TORSION_STRENGTH:
            yield Problem(
                worst.path,
                f"shaft {worst.shaft} is too thin for {worst.torque:.4g} N m: the torsional stress is "
                f"{worst.stress / 1e6:.4g} MPa, and the strongest shaft steel yields at {TORSION_STRENGTH / 1e6:.0f} "
                "MPa "
                "(30CrNiMo8, ISO 683-2)",
                f"Set {_enough(worst, TORSION_ENDURANCE):.4g} or more, or reduce the load.",
                f"{1000 * worst.diameter:g}",
            )


def refuse_overload(number: int, pair: GearPair, pinion_torque: float) -> None:
    """Raise InputError if no gear steel bears the torque (N m) of an option in a stage (from 1)."""
    for problem in _overloaded_teeth(number, pair, pinion_torque):
        softness = STEEL.elastic_modulus / pair.pinion_material.elastic_modulus
        stiff = LARGEST_GIVE * pair.pinion.normal_module * TYPICAL_STIFFNESS / softness
        most = min(
            pinion_torque * (STATIC_STRENGTH / contact_pressure(pair, pinion_torque)) ** 2,
            stiff * pair.working_radii[0] * pair.face_width,
        )
        raise InputError(
            f"--torque {pinion_torque:g} N m: {problem.path}: {problem.message}. Set at most {math.floor(most)} N m."
        )


def _overloaded_teeth(number: int, pair: GearPair, pinion_torque: float) -> Iterator[Problem]:
    pressure = contact_pressure(pair, pinion_torque)
    line_load = abs(pinion_torque) / pair.working_radii[0] / pair.face_width
    load = f"line load {line_load / 1000:.4g} N/mm"
    key, modulus = "elastic_modulus_GPa", pair.pinion_material.elastic_modulus / 1e9
    remedy = (
        f"Reduce the load, raise face_width_mm or module_mm, or correct gear_material.{key}. {other_unit(key, modulus)}"
    ).rstrip()
    softness = STEEL.elastic_modulus / pair.pinion_material.elastic_modulus
    give = line_load / TYPICAL_STIFFNESS * softness
    if not pressure <= STATIC_STRENGTH:
        yield Problem(
            f"stages.{number}",
            f"the {load} gives a contact stress of {pressure / 1e6:.4g} MPa, and the best gear steel bears "
            f"{STATIC_STRENGTH / 1e6:.0f} MPa for few cycles (ISO 6336-2 and -5: 1650 MPa, Z_NT 1.6)",
            remedy,
        )
    elif not give <= LARGEST_GIVE * pair.pinion.normal_module:
        yield Problem(
            f"stages.{number}",
            f"the {load} deflects the teeth by about {1000 * give:.3g} mm, more than {LARGEST_GIVE:g} modules "
            f"({1000 * LARGEST_GIVE * pair.pinion.normal_module:.3g} mm), where linear elasticity does not hold",
            remedy,
        )


def bursting(scene: Scene, layout: TrainLayout) -> Iterator[Problem]:
    """The first stage with a gear whose tip speed would burst a solid disc of the strongest steel.

    The largest stress of a solid disc with the rim speed v is the tangential stress (3 + nu)/8 rho v^2 at its centre
    (Timoshenko & Goodier, Theory of Elasticity, section 32). A bore doubles it, which is neglected here.
    """
    for number, (pair, shafts) in enumerate(zip(layout.pairs, layout.pair_shafts, strict=True), 1):
        for name, gear, shaft in zip(("pinion", "wheel"), (pair.pinion, pair.wheel), shafts, strict=True):
            ratio = abs(layout.shaft_ratios[shaft])
            tips = layout.motor_speed * ratio * gear.tip_radius
            if not tips <= RIM_SPEED:
                limit = RIM_SPEED / gear.tip_radius / ratio * 30 / math.pi
                yield Problem(
                    scene.drive.speed_key,
                    f"the tips of the stage {number} {name} would move at {tips:.4g} m/s, and a disc of the strongest "
                    f"steel bursts at {RIM_SPEED:.0f} m/s",
                    f"Set at most {limit:.4g} rpm.",
                    f"{60 * layout.turns:.4g}",
                )
                return


def strength_warnings(scene: Scene, layout: TrainLayout) -> Iterator[str]:
    """Warnings of loads above the fatigue strength of steel."""
    for number, (pair, fact) in enumerate(zip(layout.pairs, layout.stages, strict=True), 1):
        pressure = contact_pressure(pair, fact.pinion_torque)
        if pressure > ENDURANCE:
            yield (
                f"stages.{number}: the contact stress of {pressure / 1e6:.4g} MPa is above the endurance limit of the "
                f"best gear steel ({ENDURANCE / 1e6:.0f} MPa, ISO 6336-5, case-carburized, ME). Reduce the load, or "
                "raise "
                "face_width_mm or module_mm"
            )
    for worst in torsions(scene, layout):
        if worst.stress > TORSION_ENDURANCE:
            yield (
                f"{worst.path} = {1000 * worst.diameter:g}: the torsional stress of {worst.stress / 1e6:.4g} MPa under "
                f"{worst.torque:.4g} N m is above the endurance limit of 42CrMo4 ({TORSION_ENDURANCE / 1e6:.0f} MPa, "
                f"DIN 743-3). Set {_enough(worst, TORSION_ENDURANCE):.4g} or more"
            )


def _enough(worst: Torsion, allowed: float) -> float:
    """Diameter (mm) with the allowed stress, for the same ratio of bore to diameter."""
    return 1000 * worst.diameter * math.ceil(100 * (worst.stress / allowed) ** (1 / 3)) / 100
