"""Steps `report sections` and `report`: the page of a run without its computing cost, from the results of other steps.

The sections that do not depend on the verdict are a separate step, which is built while features are computed.
"""

from __future__ import annotations

import contextlib
import gc
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.casing.parts.casing_choices import MODES_OVER_BAND
from fem.gears.modifications import EndRelief, FlankModifications, Relief
from fem.options import options_of
from pipelines.engine.step import Unkept
from pipelines.machine.layout import TrainLayout
from pipelines.machine.machine_model import MachineModel
from pipelines.machine.scene_kinematics import pass_rates, shaft_lines
from pipelines.signals.motion_warnings import gathered, stored_warnings
from pipelines.steps.casing import casing_warnings
from pipelines.steps.diagnosing import CaseSpec, diagnoses
from pipelines.steps.verdict import known_damages

if TYPE_CHECKING:
    import xarray

    from fem.casing.reduced.reduced_body import ReducedBody
    from mbd.output.trajectory import Trajectory
    from pipelines.diagnosis.control_diagnosis import Diagnosis
    from pipelines.diagnosis.uncertainty.bar_records import LineBars
    from pipelines.report.figures.views import LeftOut
    from pipelines.signals.analysis import DiagnosisSettings


@dataclass(frozen=True, eq=False, kw_only=True)
class ReportSpec:
    """Machine of a run; its cases and labels as in `pipelines.steps.diagnosing.build`, without a diagnosis only the
    labels of the scene; names of the runs in the report, first that of the scene."""

    machine: MachineModel
    cases: Sequence[CaseSpec]
    labels: Sequence[Mapping[str, Any]]
    responses: Sequence[str]


def build(
    spec: ReportSpec,
    *,
    motions: Sequence[Trajectory],
    sections: Mapping[str, Any],
    diagnosis: Mapping[str, Any] | None = None,
    verdict: Mapping[str, Any] | None = None,
) -> dict[str, Any] | Unkept:
    """The body of the page, and the reasons for missing pictures; it is stored only if no picture is missing.

    Parameters
    ----------
    spec : of the run
    motions : those of the labels
    sections, diagnosis, verdict : results of the steps `report sections`, `diagnose` and `verdict`
    """
    from pipelines.report.first_screen import first_screen
    from pipelines.report.report import report_body

    machine = spec.machine
    every, found, settings, failure = _diagnosed(spec, motions, diagnosis)
    judged, damages = verdict["cases"] if verdict else (), known_damages(machine)
    failure = failure or (verdict["failure"] if verdict else "")
    with _collector_paused():
        page = report_body(
            machine.title,
            sections["sections"],
            first=first_screen(machine, settings, found, every[: len(spec.responses)], failure, judged, damages),
            cases=judged,
            damages=damages,
            diagnoses=_in_full(spec, found),
            cautions=gathered(stored_warnings(response.attrs) for response in every),
        )
    return _kept_if_complete({"body": page, "left_out": sections["left_out"]})


def sections(
    spec: ReportSpec,
    warnings: Sequence[str],
    *,
    motions: Sequence[Trajectory],
    curves: Mapping[str, Any],
    body: ReducedBody,
    casing: str | LeftOut | None = None,
    modes: tuple[Any, ...] | None = None,
    diagnosis: Mapping[str, Any] | None = None,
    error_bars: LineBars | str = "",
) -> dict[str, Any] | Unkept:
    """The sections without the verdict, and the reasons for missing pictures; stored only if no picture is missing.

    Parameters
    ----------
    spec : of the run
    warnings : on the scene
    motions : those of the labels
    curves, casing : elements of the page, see `pipelines.steps.pictures`
    body, modes : the reduced casing, and the result of the step `casing modes`: `CasingModes`, `CheckUp`, and more
    diagnosis, error_bars : results of the steps `diagnose` and `error bars`
    """
    from pipelines.report.figures.views import LeftOut
    from pipelines.report.report import report_sections

    machine, monitored = spec.machine, spec.machine.monitored
    every, found, settings, _ = _diagnosed(spec, motions, diagnosis)
    with _collector_paused():
        made = report_sections(
            summary=_summary(machine),
            diagnoses=_in_full(spec, found),
            seeds=[d for d, case in zip(found, spec.cases, strict=False) if not case.full],
            error=error_bars if found else "",
            gears=gear_rows(machine),
            rolling=rolling_rows(machine),
            shafts=shaft_rows(machine),
            gear_picture=curves["gears"],
            stiffness=curves["stiffness"],
            casing_picture=casing,
            casing_rows=_casing_rows(body, modes),
            runs=dict(zip(spec.responses, every, strict=False)),
            windows=dict(monitored.windows),
            sensor=monitored.sensor or "",
            axis=monitored.axis,
            settings=settings,
            energy=energy_rows(every[0]),
            warnings=(*warnings, *casing_warnings(body, {one.name: one.position for one in machine.sensors})),
        )
    left_out = [p.reason for p in (curves["gears"], casing) if isinstance(p, LeftOut)]
    return _kept_if_complete({"sections": made, "left_out": left_out})


def _kept_if_complete(made: dict[str, Any]) -> dict[str, Any] | Unkept:
    return Unkept(made) if made["left_out"] else made


def _in_full(spec: ReportSpec, found: Sequence[Diagnosis]) -> list[Diagnosis]:
    """The diagnoses that are shown in full."""
    return [d for d, case in zip(found, spec.cases, strict=False) if case.full]


@contextlib.contextmanager
def _collector_paused() -> Iterator[None]:
    """Suspend garbage collection, which takes a fifth of the time: figures consist of many objects in cycles."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def _diagnosed(
    spec: ReportSpec, motions: Sequence[Trajectory], diagnosis: Mapping[str, Any] | None
) -> tuple[list[xarray.Dataset], list[Diagnosis], DiagnosisSettings | None, str]:
    """Responses, diagnoses, windows and lines at the speed of the run, or None and the reason."""
    from pipelines.signals.analysis import DiagnosisError
    from pipelines.signals.measured_speed import at_measured_speed
    from pipelines.signals.response import make_response

    every = list(map(make_response, motions, spec.labels))
    failure = diagnosis["failure"] if diagnosis else ""
    found = [] if failure else diagnoses(spec.cases, every)
    settings = found[0].settings if found else None if failure else spec.machine.diagnosis
    if not found and settings is not None and not settings.speed_is_known:
        try:
            settings = at_measured_speed(settings, every[:1])
        except DiagnosisError as error:
            settings, failure = None, str(error)
    return every, found, settings, failure


def _summary(machine: MachineModel) -> dict[str, Any]:
    facts, models, labels = machine.facts, machine.models, machine.labels
    hoist = {}
    if machine.hoist is not None:
        frequency = f"{facts.rope_frequency:.3g} Hz" if facts.rope_frequency else "no rope"
        hoist = {
            "mass of the container": f"{machine.hoist.container_mass:g} kg",
            "natural frequency on the rope at the start": frequency,
        }
    return {
        "motor speed": f"{facts.motor_speed * 30 / np.pi:.4g} rpm",
        "total ratio": facts.total_ratio,
        "torque at the input": f"{facts.input_torque:.4g} N m",
        f"torque at the {'load' if machine.hoist is None else 'drums'}": f"{facts.output_torque:.4g} N m",
        "model of the mesh stiffness, by stage": ", ".join(models["mesh"]),
        "model of the casing": models["casing"],
        "model of the shafts": models["shaft_model"],
        "model of the load": models["load"],
        **hoist,
        "faults": ", ".join(machine.fault_words) or "none",
        "deviations": "none"
        if labels["seed"] == "none"
        else f"ISO 1328-1 flank tolerance class {labels['iso_grade']}, random seed {labels['seed']}",
        "time integration": models["integrator"],
    }


def gear_rows(machine: MachineModel) -> list[dict[str, Any]]:
    """Rows of the gear table, two for each stage."""
    from fem.gears.sector_mesh import root_chord

    stages = zip(machine.layout.pairs, machine.facts.stages, machine.layout.modifications, strict=True)
    return [
        {
            "stage": number,
            "gear": name,
            "teeth z": gear.teeth,
            "normal module m_n mm": gear.normal_module * 1000,
            "helix angle deg": math.degrees(gear.helix_angle),
            "face width b mm": gear.face_width * 1000,
            "profile shift x": gear.profile_shift,
            "reference diameter d mm": gear.reference_radius * 2000,
            "tip diameter d_a mm": gear.tip_radius * 2000,
            "tooth root thickness mm": root_chord(gear)[1] * 1000,
            "bore diameter mm": gear.bore_radius * 2000,
            "transverse contact ratio": stage.transverse_contact_ratio,
            "overlap ratio": stage.overlap_ratio,
            "mesh frequency f_m Hz": stage.mesh_frequency,
            "revolution frequency f_r Hz": stage.pinion_frequency if name == "pinion" else stage.wheel_frequency,
            "force on the line of action N": stage.mesh_force,
            "line load F_t/b N/mm": stage.line_load / 1000,
            "flank modifications": _modification_words(getattr(modified, name), machine.layout, number),
        }
        for number, (pair, stage, modified) in enumerate(stages, 1)
        for name, gear in (("pinion", pair.pinion), ("wheel", pair.wheel))
    ]


def _modification_words(own: FlankModifications, layout: TrainLayout, stage: int) -> str:
    """The modifications of the flanks of a gear, with the ends of the face as in the scene."""
    own, words = own if layout.pinion_senses[stage - 1] > 0 else own.turned, []
    for item, one in options_of(FlankModifications):
        value, name = getattr(own, item.name), (one.key or item.name).replace("_", " ")
        if isinstance(value, Relief | EndRelief):
            starts = {"over": value.length, "from diameter": getattr(value, "diameter", None)}
            start = next(f"{word} {1000 * size:g} mm" for word, size in starts.items() if size)
            words.append(f"{name} {1e6 * value.amount:g} um {start}, {value.shape}")
        elif value:
            words.append(f"{name} {1e6 * value:g} um")
    return "; ".join(words) or "none"


def rolling_rows(machine: MachineModel) -> list[dict[str, Any]]:
    """Rows of the rolling bearings with their pass frequencies and faults."""
    return [
        {
            "bearing": bearing.name,
            "shaft": bearing.shaft + 1,
            "elements": bearing.elements.count,
            **{f"{name} Hz": value for name, value in pass_rates(machine.layout, bearing).items()},
            "spalls": ", ".join(f.spall.place for f in machine.spalls if f.bearing == bearing.name) or "none",
        }
        for bearing in machine.rolling
    ]


def shaft_rows(machine: MachineModel) -> list[dict[str, Any]]:
    """Rows of the faults of shafts with their orders."""
    return [
        {
            "fault": fault.name,
            "shaft": fault.shaft + 1,
            **{f"{k}x Hz": f for _, k, f in shaft_lines(machine.layout, fault).monitored()},
        }
        for fault in machine.shaft_faults
    ]


def _casing_rows(body: ReducedBody, result: tuple[Any, ...] | None) -> list[dict[str, Any]]:
    rows: dict[str, Any] = {"model": body.model, "coordinates": len(body.coordinate_names)}
    if result is not None:
        modes, check, *_ = result
        factor, band = body.stiffness_factor, modes.band_limit / MODES_OVER_BAND
        first = check.frequencies[:6] * math.sqrt(factor)
        rows |= {
            "unknowns of the finite-element mesh": modes.unknowns,
            "solver": modes.solver,
            "casing.band_Hz, above which modes are missing": f"{band:g}" if band else "static, without modes",
            "mass, kg": check.mass,
            "first natural frequencies on its feet, Hz": ", ".join(f"{f:.1f}" for f in first),
            "checks of the reduced model": f"all {len(check.item_names)} passed",
        }
        if factor != 1.0:
            rows["factor on the casing stiffness that corrects the element size"] = f"{factor:.4f}"
    return [{"property": name, "value": value} for name, value in rows.items()]


def energy_rows(run: xarray.Dataset) -> list[dict[str, Any]]:
    """Rows of the energy balance of a run, J, one for each part."""
    balance: dict[str, dict[str, float]] = json.loads(run.attrs.get("energy_balance_J", "{}"))
    return [{"part": part, **{f"{name} J": value for name, value in row.items()}} for part, row in balance.items()]
