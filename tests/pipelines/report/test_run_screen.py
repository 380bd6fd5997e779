"""The average of the first screen: a tooth that knocks appears at its own place, and what every tooth does vanishes."""

import dataclasses

import numpy as np
import pytest
import xarray
from synthetic import MESH, WHEEL

from pipelines.diagnosis.known_damage import Case
from pipelines.diagnosis.verdict import Evidence, Finding, Verdict
from pipelines.machine.checks.checked_machine import checked_machine
from pipelines.machine.scene_kinematics import kinematics_of
from pipelines.report.first_screen import first_screen, over_teeth, pass_lines, shown_gear
from pipelines.scene.load_scene import load_scene
from pipelines.signals.analysis import DiagnosisSettings
from pipelines.signals.orders.kinematics import Gear

RATE, TEETH, SECONDS = 10_000, 55, 2.0


def knocking(tooth, sense):
    """A wheel whose mesh hums and one tooth of which knocks as it passes the pitch point."""
    time = np.arange(round(SECONDS * RATE)) / RATE
    angle = sense * 2 * np.pi * WHEEL * time
    place = TEETH * angle / (2 * np.pi)
    away = (place - tooth + TEETH / 2) % TEETH - TEETH / 2
    signal = 5.0 * np.cos(2 * np.pi * place) + np.exp(-((away / 0.3) ** 2))
    return xarray.Dataset(
        {
            "acceleration": (("time", "sensor", "axis"), signal[:, None, None]),
            "shaft_angle": (("time", "shaft"), angle[:, None]),
        },
        coords={"time": time, "sensor": ["casing"], "axis": ["z"], "shaft": ["shaft_2"]},
        attrs={"sensor_noise_m_s2": 0.0},
    )


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("tooth", [0, 21, 54])
def test_the_tooth_that_knocks_stands_in_the_middle_of_an_average_from_it(tooth, sense):
    settings = DiagnosisSettings(
        revolution_frequency=WHEEL,
        mesh_frequency=MESH,
        windows={"steady": (0.3, 1.9)},
        sensor="casing",
        axis="z",
        shaft="shaft_2",
    )
    wheel = Gear(name="wheel", shaft="shaft_2", stage=1, teeth=TEETH, cycle=-tooth)
    place, (value,), turns = over_teeth(knocking(tooth, sense), settings, 0, "steady", wheel, [TEETH])
    assert turns == 8
    assert np.all(np.diff(place) > 0)
    assert (place.min(), place.max()) == pytest.approx((-TEETH / 2, TEETH / 2), abs=0.05)
    assert place[value.argmax()] == pytest.approx(0.0, abs=0.05)
    assert np.abs(value[np.abs(place) > 2]).max() < 0.1  # the hum, five times as strong as the knock, is gone


def finding(component, damaged):
    evidence = Evidence(features=("fm4",), sensor="a", axis="z", increase=9.0, deviation=9.0, limit=6.0, p=1e-6)
    return Finding(component=component, evidence=evidence, damaged=damaged, repeating=True, alike=(), tooth=3)


@pytest.mark.parametrize(("damaged", "shown"), [(True, "stage 1 pinion"), (False, "stage 1 wheel")])
def test_the_average_is_that_of_the_gear_that_is_damaged(damaged, shown):
    machine = checked_machine(load_scene("bench").scene, "bench")
    verdict = verdict_of(tuple(finding(f"stage 1 {gear}", damaged) for gear in ("pinion", "wheel")), damaged)
    text = "".join(
        first_screen(
            machine, None, (), (), "", [Case(load="torque", deviations="off", window="steady", verdict=verdict)]
        )
    )
    assert ("begins at tooth 3" in text) == damaged
    assert shown_gear(machine, verdict, kinematics_of(machine.layout, ())).name == shown


def verdict_of(findings, damaged):
    return Verdict(
        findings=findings,
        different=damaged,
        damaged=damaged,
        p_different=0.5,
        changes=(),
        exact=False,
        healthy=8,
        at_speed=False,
        outlying=(),
        tested=8,
        false_differences=(),
        false_alarms=(),
        left_out=(),
        not_examined=(),
    )


def test_the_figure_of_a_damaged_bearing_is_its_envelope_spectrum_and_names_no_gear():
    """The lines are those of the inner ring at the channel of its evidence, with sidebands of the shaft."""
    balls = {"bearings": {"model": "hertz", "designation": "6205"}}
    machine = checked_machine(load_scene("minimal", balls).scene, "minimal")
    first = dataclasses.replace(finding("bearing_1 BPFI", True), tooth=None)
    verdict = verdict_of((first, finding("stage 1 wheel", False)), True)
    time = np.arange(20_000) / RATE
    shafts = [f"shaft_{number}" for number in (1, 2)]
    speeds = 2 * np.pi * machine.layout.turns * np.array(machine.layout.shaft_ratios)
    run = xarray.Dataset(
        {
            "acceleration": (("time", "sensor", "axis"), np.random.default_rng(0).standard_normal((20_000, 1, 1))),
            "shaft_angle": (("time", "shaft"), np.outer(time, speeds)),
        },
        coords={"time": time, "sensor": ["a"], "axis": ["z"], "shaft": shafts},
        attrs={"sensor_noise_m_s2": 0.0},
    )
    settings = dataclasses.replace(machine.diagnosis, windows={"steady": (0.2, 1.8)})
    case = Case(load="torque", deviations="off", window="steady", verdict=verdict)
    text = "".join(first_screen(machine, settings, (), (run,), "", [case]))
    turn = machine.layout.turns
    order = kinematics_of(machine.layout, machine.rolling).bearings[0].strikes["bearing_1 BPFI"]
    assert f"bearing_1 BPFI = {order * turn:.4f} Hz and its multiples, with sidebands" in text
    assert f"at the frequency of shaft 1, {turn:.4f} Hz" in text
    assert "Envelope spectrum of a (z)" in text
    assert text.count("<figure") == 1
    assert "Monitored gear" not in text
    assert "tooth 10" not in text
    kinematics = kinematics_of(machine.layout, machine.rolling)
    assert pass_lines(settings, kinematics, verdict_of((finding("stage 1 wheel", True), first), True)) is None
