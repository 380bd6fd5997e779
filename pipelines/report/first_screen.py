"""First screen of the report of a run: verdict, main numbers, a time-synchronous average and an envelope spectrum."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray

from pipelines.diagnosis import verdict_words
from pipelines.diagnosis.control_diagnosis import Diagnosis
from pipelines.diagnosis.known_damage import Case, Damage, any_found, sentences
from pipelines.diagnosis.verdict import Finding, Verdict, decibels
from pipelines.io.text_table import grid
from pipelines.machine.machine_model import MachineModel
from pipelines.machine.scene_kinematics import kinematics_of
from pipelines.report import page
from pipelines.report.chart_data import ENVELOPE_ORDERS, streams
from pipelines.report.first_figures import average_figure, envelope_figure
from pipelines.scene.tables.diagnosis import Monitored
from pipelines.signals.analysis import DiagnosisSettings, analyse, noisy_signal
from pipelines.signals.features.recording_features import envelope_band
from pipelines.signals.features.shaft_turns import cut_turns
from pipelines.signals.features.synchronous_averages import FEWEST_TURNS, Average
from pipelines.signals.orders.kinematics import Gear, Kinematics
from pipelines.signals.orders.rotation import Rotation
from pipelines.signals.pass_lines import HARMONICS, PassLines

RANKED_AT_ONCE = 5  # components on the first screen; the others open on a click
IN_MESH = 1.0  # pitches on either side of the pitch point, approximate range in which a tooth is in mesh


def first_screen(
    machine: MachineModel,
    settings: DiagnosisSettings | None,
    diagnoses: Sequence[Diagnosis],
    runs: Sequence[xarray.Dataset],
    failure: str,
    cases: Sequence[Case] = (),
    damages: Sequence[Damage] = (),
) -> list[str]:
    """Parts of the page: verdict, main numbers, an average over one revolution and an envelope spectrum.

    Parameters
    ----------
    machine : machine model of the run
    settings : windows and monitored lines, None if no diagnosis is possible
    diagnoses : lines of all cases, that of the scene first; empty without a control
    runs : the response of the scene and that of its control, if there is one
    failure : reason why the diagnosis was not possible, "" if it was
    cases, damages : verdicts, that of the scene in its first window first, empty without a reference; known damage
    """
    verdict = cases[0].verdict if cases else None
    evidence = []
    kinematics = kinematics_of(machine.layout, machine.rolling)
    lines = None if settings is None else pass_lines(settings, kinematics, verdict)
    if settings is not None and verdict is not None and lines is not None:
        at = verdict.first.evidence
        evidence.append(_pass_envelope(replace(settings, sensor=at.sensor, axis=at.axis), runs, kinematics, lines))
    elif settings is not None:
        evidence = _average(machine, settings, runs, verdict)
        evidence.append(_gear_envelope(settings, diagnoses[0].band if diagnoses else None, runs))
    return screen_parts(
        sentences=sentences(cases, damages) if cases else [_no_verdict(machine, failure)],
        found=any_found(cases, damages) if cases else None,
        figures=_numbers(machine, settings, lines),
        evidence=evidence,
        ranking=() if verdict is None else [_ranked(finding, finding is verdict.first) for finding in verdict.findings],
        ranking_note="" if verdict is None else _ranking_note(verdict),
    )


def screen_parts(
    *,
    sentences: Sequence[str] = (),
    found: bool | None = None,
    figures: Sequence[tuple[str, str]] = (),
    evidence: Sequence[str] = (),
    ranking: Sequence[tuple[str, float, str, str]] = (),
    ranking_note: str = "",
) -> list[str]:
    """The parts of the page: verdict, numbers, figures, ranking; parts that a run does not have are omitted.

    Parameters
    ----------
    sentences, found : the verdict, the answer first; whether damage is found, None without a diagnosis
    figures : names with their values: f_m, f_r, speed
    evidence : the figures that support the verdict, as HTML
    ranking : components with their increase in dB, their evidence ("-" where it has no limit), and a remark
    ranking_note : explains the columns of the ranking
    """
    style = {True: "fault", False: "none", None: "open"}[found]
    pairs = (f"<div><dt>{page.typeset(n)}</dt><dd>{page.typeset(v)}</dd></div>" for n, v in figures)
    parts = [
        f'<div class="verdict {style}" id="verdict">{"".join(map(page.paragraph, sentences))}</div>',
        f'<dl id="numbers">{"".join(pairs)}</dl>',
    ]
    if evidence:
        parts.append(f'<div id="evidence">{"".join(evidence)}</div>')
    if ranking:
        rows = [
            {"component": name, "increase dB": decibels(increase), verdict_words.STRENGTH: strength, "remark": remark}
            for name, increase, strength, remark in ranking
        ]
        inside = page.table(grid("Components by their evidence", rows[:RANKED_AT_ONCE]))
        if more := rows[RANKED_AT_ONCE:]:
            inside += page.folded(f"{len(more)} more components", page.table(grid("", more)))
        parts.append(f'<div id="ranking">{inside}{page.note(ranking_note) if ranking_note else ""}</div>')
    return parts


def _ranked(finding: Finding, first: bool) -> tuple[str, float, str, str]:
    """A row of the ranking. Only a damaged first gear has its tooth: the impact is elsewhere in the other averages."""
    shown = first and finding.damaged and finding.tooth is not None
    remarks = [f"the impact begins at tooth {finding.tooth}"] if shown else []
    remarks += [f"same orders as {', '.join(finding.alike)}"] if finding.alike else []
    return finding.component, finding.evidence.increase, verdict_words.strength(finding.evidence), "; ".join(remarks)


def _ranking_note(verdict: Verdict) -> str:
    texts = [verdict_words.note(verdict)]
    if any(finding.alike for finding in verdict.findings):
        texts.append("Components with equal orders, or integer multiples of them, cannot be distinguished.")
    return " ".join(texts)


def _no_verdict(machine: MachineModel, failure: str) -> str:
    if failure:
        reason = failure
    elif not machine.fault_words:
        reason = "the scene has no fault. To simulate a fault, add a table [[faults]]."
    elif not machine.monitored.possible:
        reason = "the scene has no sensor, or no window of constant speed. Add sensors or diagnosis.windows_s."
    else:
        reason = 'there is no healthy control to compare with. Set control = "without-faults".'
    return f"No verdict: {reason}"


def _numbers(
    machine: MachineModel, settings: DiagnosisSettings | None, lines: PassLines | None
) -> list[tuple[str, str]]:
    """Speed, and the frequencies of the bearing part with `lines` or else of the monitored gear."""
    monitored, layout = machine.monitored, machine.layout
    stage = machine.facts.stages[monitored.stage - 1]
    shaft = layout.pair_shafts[monitored.stage - 1][monitored.gear == "wheel"]
    f_m = stage.mesh_frequency if settings is None else settings.mesh_frequency
    f_r = stage.wheel_frequency if monitored.gear == "wheel" else stage.pinion_frequency
    f_r = f_r if settings is None else settings.revolution_frequency
    speed = 60 * f_r * abs(layout.shaft_ratios[layout.driven] / layout.shaft_ratios[shaft])
    pair = layout.pairs[monitored.stage - 1]
    teeth = pair.wheel.teeth if monitored.gear == "wheel" else pair.pinion.teeth
    measured = settings is not None and not monitored.speed_is_known
    motor = ("Speed of the motor" + (", measured" if measured else ""), f"{speed:.5g} rpm")
    if lines is not None:
        return [motor, (f"Pass frequency {lines.label}", f"{lines.frequency:.5g} Hz")]
    found = [
        motor,
        ("Mesh frequency f_m", f"{f_m:.5g} Hz"),
        (f"Revolution frequency f_r of shaft {shaft + 1}", f"{f_r:.5g} Hz"),
        ("Monitored gear", f"stage {monitored.stage} {monitored.gear}, {teeth} teeth"),
    ]
    return found + ([("Channel in the diagrams", _channel(monitored))] if monitored.sensor else [])


def _channel(monitored: Monitored) -> str:
    return f"{monitored.sensor}, {'all axes' if monitored.axis == 'resultant' else monitored.axis}"


def shown_gear(machine: MachineModel, verdict: Verdict | None, kinematics: Kinematics) -> Gear:
    """The gear that ranks first if it is found damaged, else the monitored gear of the scene."""
    gears = {gear.name: gear for gear in kinematics.gears}
    if verdict is not None and verdict.damaged:
        ranked = [gears[finding.component] for finding in verdict.findings[:1] if finding.component in gears]
        if ranked:
            return ranked[0]
    return gears[f"stage {machine.monitored.stage} {machine.monitored.gear}"]


def _average(
    machine: MachineModel, settings: DiagnosisSettings, runs: Sequence[xarray.Dataset], verdict: Verdict | None
) -> list[str]:
    """The figure of the time-synchronous average over the teeth of a gear with a marked tooth in the middle.

    The marked tooth is that of the verdict if it finds the gear damaged, else the damaged one of the scene. The list
    is empty if the shaft makes too few turns in the first window.
    """
    kinematics = kinematics_of(machine.layout, ())
    gear = shown_gear(machine, verdict, kinematics)
    named = [one.tooth for one in verdict.findings if one.component == gear.name] if verdict is not None else []
    damaged = [
        fault.tooth for fault in machine.faults_of(gear.stage) if gear.name == f"stage {gear.stage} {fault.gear}"
    ]
    first = named if verdict is not None and verdict.damaged else damaged
    marked = next((tooth for tooth in (*first, *named, *damaged) if tooth is not None), None)
    middle = gear.teeth / 2 if marked is None else float(marked)
    window = next(iter(settings.windows))
    meshes = [other.teeth for other in kinematics.gears_on(gear.shaft)]
    found = [
        over_teeth(run, settings, stream, window, replace(gear, cycle=gear.cycle - middle), meshes)
        for run, stream in zip(runs, streams(len(runs)), strict=True)
    ]
    if found[0] is None:
        return []
    place, values, turns = found[0]
    axis = int(np.ptp(values, axis=1).argmax())  # with the largest peak-to-peak value
    other = found[1] if len(found) > 1 else None
    reference = None if other is None else np.interp(place, other[0], other[1][axis], period=gear.teeth)
    across = f"teeth of the {gear.name}"
    caption = (
        f"Time-synchronous average of the acceleration at {_channel(machine.monitored)} over {turns} revolutions of "
        f"{gear.shaft.replace('_', ' ')} in the window {window}, without the mesh orders (residual signal)."
    )
    if reference is not None:
        alone = ", the effect of the fault alone" if machine.fault_words else ""
        caption += f" Below: this run minus the healthy run{alone}."
    if marked is None:
        place = place + middle
    else:
        across += f", from tooth {marked}"
        whys = ["which is damaged in the scene"] * (marked in damaged)
        whys += ["at which the impact begins"] * (marked in named)
        caption += f" Shaded: the engagement of tooth {marked}, {' and '.join(whys)}. Teeth are numbered from 0."
    figure = average_figure(
        place,
        values[axis],
        reference,
        across=across,
        marked=None if marked is None else (-IN_MESH, IN_MESH),
        marked_name="" if marked is None else f"tooth {marked}",
    )
    return [page.picture(figure, caption)]


def over_teeth(
    run: xarray.Dataset, settings: DiagnosisSettings, stream: int, window: str, gear: Gear, meshes: Sequence[int]
) -> tuple[np.ndarray, np.ndarray, int] | None:
    """Residual signal of a gear over its teeth: place (n,), residual (axis, n) and number of averaged turns.

    The place is counted in teeth from -z/2 to z/2. The result is None without an angle of the shaft, or with too few
    turns.

    Parameters
    ----------
    run, settings, stream : signals, monitored channel, and number of the noise sequence
    window : name of the averaged window
    gear : the gear; its `cycle` is the place at the angle zero of its shaft
    meshes : numbers of teeth of all gears on its shaft
    """
    if "shaft_angle" not in run:
        return None
    signal = noisy_signal(run, settings, stream).reshape(run.sizes["time"], -1).T
    angle = np.asarray(run.shaft_angle.sel(shaft=gear.shaft).values, dtype=float)
    rotation = Rotation(angle=angle, source="recorded angle", error=0.0, absolute=True)
    turns = cut_turns(signal, run.time.values, rotation, 1.0, settings.windows[window])
    if turns is None or turns.count < FEWEST_TURNS:
        return None
    residual = Average(values=turns.values.mean(axis=1), orders=turns.orders, teeth=meshes).residual
    half, count = gear.teeth / 2, residual.shape[1]
    place = (gear.cycle + gear.teeth * np.arange(count) / count + half) % gear.teeth - half
    order = np.argsort(place)
    return place[order], residual[:, order], turns.count


def pass_lines(settings: DiagnosisSettings, kinematics: Kinematics, verdict: Verdict | None) -> PassLines | None:
    """Lines of the bearing part that ranks first, with sidebands of the shaft or cage; None if it is not damaged."""
    part = verdict.first.component if verdict is not None and verdict.damaged else ""
    for bearing in (one for one in kinematics.bearings if part in one.strikes):
        turn = _first_frequency(settings, kinematics) * kinematics.shaft(bearing.shaft).ratio
        inner = part.endswith("BPFI")
        return PassLines(
            label=part,
            fault="",
            frequency=turn * bearing.strikes[part],
            spacing=turn * (1.0 if inner else bearing.sidebands.get(part, 0.0)),
            spacing_label=bearing.shaft.replace("_", " ") if inner else "the cage",
        )
    return None


def _first_frequency(settings: DiagnosisSettings, kinematics: Kinematics) -> float:
    return settings.revolution_frequency / kinematics.shaft(settings.shaft or kinematics.shafts[0].name).ratio


def _pass_envelope(
    settings: DiagnosisSettings, runs: Sequence[xarray.Dataset], kinematics: Kinematics, lines: PassLines
) -> str:
    """The envelope spectrum in the band of the verdict, with the lines of a bearing part."""
    band = envelope_band(kinematics, runs[0].time.values, _first_frequency(settings, kinematics))
    bearing = f"{lines.label.partition(' ')[0]} "
    marked = [
        (f, name.replace(bearing, "") if np.isclose(f, n * lines.frequency) else "") for name, n, f in lines.monitored()
    ]
    sides = f", with sidebands at the frequency of {lines.spacing_label}, {lines.spacing:.4f} Hz" * bool(lines.spacing)
    caption = f"{lines.label} = {lines.frequency:.4f} Hz and its multiples{sides}. Damage of this part raises them."
    return _envelope(settings, band, runs, marked, (HARMONICS + 0.7) * lines.frequency, caption)


def _gear_envelope(
    settings: DiagnosisSettings, band: tuple[float, float] | None, runs: Sequence[xarray.Dataset]
) -> str:
    """The envelope spectrum up to ENVELOPE_ORDERS orders of the shaft."""
    f_r = settings.revolution_frequency
    marked = [(k * f_r, "f_r" if k == 1 else f"{k} f_r") for k in range(1, settings.envelope_harmonics + 1)]
    caption = f"harmonics of the revolution frequency f_r = {f_r:.4f} Hz. A damaged tooth raises them."
    return _envelope(settings, band, runs, marked, ENVELOPE_ORDERS * f_r, caption)


def _envelope(
    settings: DiagnosisSettings,
    band: tuple[float, float] | None,
    runs: Sequence[xarray.Dataset],
    marked: Sequence[tuple[float, str]],
    top: float,
    marks: str,
) -> str:
    """The figure of the envelope spectrum of the first window.

    Parameters
    ----------
    settings, runs : signal and windows, and the runs
    band : Hz, as of `analyse`
    marked : place (Hz) and name of each marked line
    top : Hz, highest frequency
    marks : what the marked lines are, for the caption
    """
    window = next(iter(settings.windows))
    own, *healthy = (
        analyse(run, settings, stream=stream, band=band).envelopes[window]
        for run, stream in zip(runs[:2], streams(len(runs)), strict=False)
    )
    shown = own.frequency <= top
    figure = envelope_figure(
        own.frequency[shown],
        own.amplitude[shown],
        healthy[0].amplitude[shown] if healthy else None,
        marked=marked,
        band=f"band {own.band_low:.4g} to {own.band_high:.4g} Hz",
    )
    caption = f"Envelope spectrum of {settings.sensor} ({settings.axis}) in the window {window}. Marked: {marks}"
    return page.picture(figure, caption)
