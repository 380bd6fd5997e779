"""Parts `loop`, `models` and `precision`: the time loop on the shipped scenes, model by model and method by method."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.clock import timed
from benchmarks.rig import casing_body, kept, moving, read, stage_law, system
from mbd.integrators.base import Integrator
from mbd.integrators.methods import make_integrator
from mbd.integrators.settings import MotionSettings
from mbd.output.simulate import simulate
from mbd.output.trajectory import Trajectory
from mbd.system.system import System

CHANNEL = "sensor_3:az"
JOURNAL = "bearing_3:journal_az"  # where there is no casing
STEP = 1e-4 / 3  # s, as shipped
SHORT = 0.01  # s of motion: what this run takes is subtracted, so that set-up (modes, equilibrium) does not count


def mesh_mode_frequency(system: System, share: float = 0.1) -> float:
    """Highest frequency (Hz) of a mode that stores at least ``share`` of its strain energy in one contact that holds
    the train; 0 if none."""
    top = 0.0
    for element in system.elements:
        if element.contact is None or not element.stiffness[0]:
            continue
        stored = element.stiffness[0] * (element.rows[0] @ system.basis) ** 2 / system.frequencies**2
        if (stored > share).any():
            top = max(top, float(system.frequencies[stored > share].max()))
    return top / (2 * np.pi)


def run(machine: System, end: float, step: float = STEP, method: str = "exponential") -> Trajectory:
    """One run from equilibrium."""
    return simulate(machine, MotionSettings(end=end, step=step, integrator=method))


def rig(folder: Path, **settings: Any) -> System:
    """The rig with a moving start, from what the earlier parts kept as far as the settings leave it valid."""
    model = moving(**settings)
    laws = kept(folder, "laws") if model.laws == read().laws else [stage_law(model, n) for n in range(3)]
    model = model.models["casing"]
    body = kept(folder, model) if model in ("static", "craig-bampton") else casing_body(model)
    return system(model, laws, body)


def loop(folder: Path) -> list[dict[str, Any]]:
    """Seconds per second of motion of `minimal` and of the full rig at the shipped step."""
    rows = []
    model = read("minimal")
    small = system(model, [stage_law(model, 0)], casing_body(model))
    for name, build, span in (("minimal", lambda: small, 0.5), ("rig-healthy", lambda: rig(folder), 0.2)):
        assembling, machine = timed(build, repeats=1)
        run(machine, SHORT)
        setup, short = timed(lambda m=machine: run(m, SHORT))
        seconds, trajectory = timed(lambda m=machine, s=span: run(m, s))
        steps = trajectory.counter("steps")
        more = steps - short.counter("steps")
        rows.append(
            {
                "scene": name,
                "coordinates": machine.layout.size,
                "modes": len(machine.frequencies),
                "motion_s": span,
                "step_us": trajectory.step * 1e6,
                "assembly_s": assembling["seconds"],
                "setup_s": setup["seconds"],
                "iterations_per_step": trajectory.counter("iterations") / steps,
                "microseconds_per_step": (seconds["seconds"] - setup["seconds"]) / more * 1e6,
                "seconds_per_second": (seconds["seconds"] - setup["seconds"]) / (more * trajectory.step),
                "cpu_per_second": (seconds["cpu_seconds"] - setup["cpu_seconds"]) / (more * trajectory.step),
                **seconds,
            }
        )
    return rows


VARIANTS: dict[str, dict[str, Any]] = {
    "as shipped": {},
    "mesh iso": {f"stages__{n}__mesh__model": "iso" for n in (1, 2, 3)},
    "casing static": {"casing__model": "static"},
    "casing rigid": {"casing__model": "rigid"},
    "casing none": {"casing__model": "none", "sensors": []},
    "shafts torsion": {"shaft_model__model": "torsion"},
    "load static-torque": {"load__model": "static-torque"},
}


def models(folder: Path) -> list[dict[str, Any]]:
    """The rig with one model changed: size, seconds per second of motion, and the RMS it gives."""
    rows = []
    for name, settings in VARIANTS.items():
        building, machine = timed(lambda s=settings: rig(folder, **s), repeats=1)
        run(machine, SHORT)  # loads the compiled code
        setup, short = timed(lambda m=machine: run(m, SHORT))
        seconds, trajectory = timed(lambda m=machine: run(m, 0.3))
        more = (trajectory.counter("steps") - short.counter("steps")) * trajectory.step
        steady = trajectory.time >= 0.1
        force, delta = trajectory.channel("mesh_1:drive_force")[steady], trajectory.channel("mesh_1:delta")[steady]
        row = {
            "variant": name,
            "coordinates": machine.layout.size,
            "modes": len(machine.frequencies),
            "assembly_s": building["seconds"],
            "seconds_per_second": (seconds["seconds"] - setup["seconds"]) / more,
            "cpu_per_second": (seconds["cpu_seconds"] - setup["cpu_seconds"]) / more,
            "mesh_force_rms_N": float(force.std()),
            "delta_ptp_um": float(np.ptp(delta)) * 1e6,
            **seconds,
        }
        channel = CHANNEL if CHANNEL in trajectory.channel_names else JOURNAL
        row |= {"channel": channel, "rms": float(trajectory.channel(channel)[steady].std())}
        rows.append(row)
    return rows


PRECISION_STEPS = {
    "exponential": (100, 50, 34, 20, 10, 5),
    "trapezoidal": (34, 20, 10, 5),
    "generalised-alpha": (34,),
}  # us
REFERENCE_STEP = 1.25  # us, exponential; its error falls by 3.5 and more per halved step
SPAN = 0.2  # s of motion


def precision(folder: Path) -> list[dict[str, Any]]:
    """Error of sensor_3 z against seconds on 0.2 s of motion of the full rig, every method of METHODS."""
    machine = rig(folder)
    exact = run(machine, SPAN, REFERENCE_STEP * 1e-6).channel(CHANNEL)
    rows = []
    for method, steps in PRECISION_STEPS.items():
        run(machine, SHORT, 40e-6, method)
        setup, _ = timed(lambda m=method: run(machine, SHORT, 40e-6, m), repeats=1)
        for step in steps:
            seconds, trajectory = timed(lambda m=method, s=step: run(machine, SPAN, s * 1e-6, m), repeats=1)
            rows.append(
                {
                    "method": method,
                    "step_us": trajectory.step * 1e6,
                    "error": relative_error(trajectory.channel(CHANNEL), exact),
                    "rms_error": abs(float(trajectory.channel(CHANNEL).std() / exact.std()) - 1.0),
                    "estimate": trajectory.step_error,
                    "setup_s": setup["seconds"],
                    **seconds,
                }
            )
    rows.append({"method": "reference (explicit Runge-Kutta method DOP853)", "left_out": reference_cost(machine)})
    return rows


def shares(folder: Path) -> list[dict[str, Any]]:
    """CPU microseconds per step of the full rig: loop, channels, energy balance of linear parts and of elements."""
    from mbd.output.balance import EnergyBalance
    from mbd.output.recorder import Recorder
    from mbd.system.statics import equilibrium

    machine, n, block = rig(folder), 6000, 480
    clock = time.process_time()
    method = make_integrator("exponential", machine, STEP)
    values = np.zeros((len(machine.channels.names), n // 3))
    recorder = Recorder(machine, method, 3, 1.0 / (3 * STEP), values)
    balance = EnergyBalance(machine, method, STEP, n)
    spent = {"set-up (s)": time.process_time() - clock, "loop": 0.0, "channels": 0.0, "energy balance": 0.0}
    start = method.start(equilibrium(machine))
    recorder.take(start)
    balance.take(start, 0)
    times = STEP * np.arange(n + 1)
    angles, speeds = machine.parts.profile.angle(times), machine.parts.profile.speed(times)
    rates = np.diff(speeds) / STEP
    for first in range(0, n, block):
        at = slice(first, first + block)
        clock = time.process_time()
        done = method.advance(angles[1:][at], speeds[1:][at], rates[at])
        for name, act in (
            ("loop", None),
            ("channels", recorder.take),
            ("energy balance", lambda b, f=first: balance.take(b, f + 1)),
        ):
            if act is not None:
                act(done)
            now = time.process_time()
            spent[name] += (now - clock) / n * 1e6
            clock = now
    return [{"part": name, "cpu_us_per_step": value} for name, value in spent.items()]


def relative_error(found: np.ndarray, exact: np.ndarray) -> float:
    """RMS of the difference over the RMS of the reference."""
    return float(np.sqrt(np.mean((found - exact) ** 2)) / exact.std())


def reference_cost(machine: System) -> str:
    """Why the adaptive method is not in the table: its measured cost of a few steps."""
    from benchmarks.reference_integrator import Reference
    from mbd.system.statics import equilibrium

    step, n = 10e-6, 2
    method: Integrator = Reference(machine, step)
    method.start(equilibrium(machine))
    profile = machine.parts.profile
    times = step * np.arange(1, n + 1)
    start = time.perf_counter()
    speeds = profile.speed(np.concatenate([[0.0], times]))
    method.advance(profile.angle(times), speeds[1:], np.diff(speeds) / step)
    cost = (time.perf_counter() - start) / (n * step)
    return (
        f"Two measured steps give {cost:.0f} s per second of motion. Its steps must resolve the highest mode of the "
        f"machine model ({machine.frequencies.max() / (2 * np.pi) / 1e3:.0f} kHz); the highest mesh mode lies at "
        f"{mesh_mode_frequency(machine) / 1e3:.1f} kHz"
    )
