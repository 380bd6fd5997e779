"""The verdict: sentences and summary tables made from the numbers of the line table, and from nothing else."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from pipelines.diagnosis.control_diagnosis import Diagnosis
from pipelines.io.grid import Grid
from pipelines.signals import pass_lines, shaft_lines
from pipelines.signals.lines import IN_ENVELOPE, LOADS, LineTable

EQUAL = 1.0  # dB; modulations this close are called equal
_GRADES = {"seen": "seen", "partly": "partly detected", "not seen": "not seen"}
SIDEBANDS_WANTED = 3  # of the eight around one mesh order, and one envelope harmonic: the fault is seen


def headline(diagnoses: Sequence[Diagnosis]) -> str:
    """The answer in one sentence for the gears and one for every fault of a bearing or shaft: where it is seen.

    Seen: at least three of the eight sidebands around one mesh order and at least one harmonic in the envelope
    are detected; of a spall, see `pipelines.signals.pass_lines`, of a shaft `pipelines.signals.shaft_lines`.
    """
    first = diagnoses[0].settings
    parts = [_headline(diagnoses, first.fault, grade)] if first.fault else []
    return " ".join([*parts, *(_headline(diagnoses, other.fault, other.grade) for other in first.beside_gears)])


def _headline(diagnoses: Sequence[Diagnosis], fault: str, graded: Callable[[LineTable], str]) -> str:
    first = diagnoses[0].settings
    cases = [(d, window) for d in diagnoses for window in d.settings.windows]
    grades = [graded(d.lines.where(window=window)) for d, window in cases]
    seen, partly = grades.count("seen"), grades.count("partly")
    what, where = _capital(fault), f"{first.sensor} ({_axis(first.axis)})"
    if seen == len(cases):
        many = "in the one analysed window" if len(cases) == 1 else f"in all {len(cases)} cases"
        return f"{what}: seen at {where} {many}."
    if seen == 0:
        many = f" in {partly or 'any'} of {len(cases)} cases" if len(cases) > 1 else ""
        if partly:
            return f"{what}: only partly detected at {where}{many}."
        return f"{what}: not seen at {where}; no line is detected{many}."
    named = [name for name, g in zip(_short_names(cases), grades, strict=True) if g == "seen"]
    where_seen = f" ({'; '.join(named)})" if named and len(named) <= 4 else ""
    tail = f"; partly detected in {partly} further case{'s' if partly > 1 else ''}" if partly else ""
    return f"{what}: seen at {where} in {seen} of {len(cases)} cases{where_seen}{tail}."


def _short_names(cases: Sequence[tuple[Diagnosis, str]]) -> list[str]:
    """Of every case what the others do not share of load, deviations and window."""
    parts = [(LOADS.get(d.load, d.load), _deviations(d), window) for d, window in cases]
    unlike = [i for i in range(3) if len({part[i] for part in parts}) > 1]
    return [", ".join(part[i] for i in unlike) for part in parts]


def criterion(diagnosis: Diagnosis) -> str:
    """The conditions for a detected line, for a fault that is seen and for one that is partly detected."""
    settings = diagnosis.settings
    gears = (
        f"a fault of a gear is seen if at least {SIDEBANDS_WANTED} sidebands around one mesh order and one harmonic in "
        "the envelope are detected"
    )
    required = [gears] * bool(settings.fault)
    required += [pass_lines.criterion()] * bool(settings.passes) + [shaft_lines.criterion()] * bool(settings.turning)
    return (
        f"A line is detected if it is at least {settings.difference_limit:g} dB over the same line of the healthy "
        f"control and at least {settings.floor_limit:g} dB over its floor, the median of the bins between the orders. "
        "A case is one window of the signal with one load and one set of deviations. "
        f"In a case, {', and '.join(required)}. A fault with fewer detected lines is partly detected."
    )


def all_seen(diagnosis: Diagnosis, window: str) -> bool:
    """Whether every fault is seen in a window."""
    lines, settings = diagnosis.lines.where(window=window), diagnosis.settings
    grades = [grade(lines)] * bool(settings.fault) + [other.grade(lines) for other in settings.beside_gears]
    return set(grades) == {"seen"}


def grade(lines: LineTable) -> str:
    """ "seen", "partly" (some line is detected) or "not seen" for the lines of one case and window."""
    sidebands = lines.where(kind="sideband")
    most = max((sidebands.where(mesh_harmonic=n).detected.sum() for n in set(sidebands.mesh_harmonic)), default=0)
    if most >= SIDEBANDS_WANTED and lines.where(kind="envelope").detected.any():
        return "seen"
    return "partly" if lines.without_mesh().detected.any() else "not seen"


def sentences(diagnosis: Diagnosis) -> tuple[str, ...]:
    """What one faulty run shows against its control, one sentence or more per window, with the control's own lines."""
    settings = diagnosis.settings
    result = []
    for window in settings.windows:
        lines = diagnosis.lines.where(window=window)
        parts = [_standing(diagnosis, lines), _control(lines, settings.floor_limit)] if settings.fault else []
        parts += [other.sentence(lines) for other in settings.beside_gears]
        result.append(f"{_capital(window)}, {case_name(diagnosis)}: {' '.join(parts)}")
        rope = settings.rope_mode.get(window, 0.0)
        if rope > 0:
            result[-1] += " " + _rope(rope, lines, settings.revolution_frequency)
    return tuple(result)


def case_name(diagnosis: Diagnosis) -> str:
    """Words for load and deviations."""
    return f"{LOADS.get(diagnosis.load, diagnosis.load)}, {_deviations(diagnosis)}"


def _deviations(diagnosis: Diagnosis) -> str:
    return "error-free gears" if diagnosis.deviations == "off" else f"deviations of {diagnosis.deviations}"


def modulation(lines: LineTable, state: str, mesh_harmonic: int = 1) -> float:
    """Root sum square of the sidebands around one mesh order over the mesh line itself, dB."""
    sidebands = getattr(lines.where(kind="sideband", mesh_harmonic=mesh_harmonic), state)
    carrier = getattr(lines.where(kind="mesh", mesh_harmonic=mesh_harmonic), state)
    tiny = np.finfo(float).tiny
    return float(20 * np.log10(max(np.linalg.norm(sidebands), tiny) / max(carrier[0], tiny)))


def directions(diagnosis: Diagnosis) -> str:
    """In which of the first two windows the faulty run shows its modulation more clearly; "" with one window."""
    windows = list(diagnosis.settings.windows)[:2]
    if len(windows) < 2:
        return ""
    first, second = (modulation(diagnosis.lines.where(window=window), "faulty") for window in windows)
    if abs(first - second) < EQUAL:
        end = f"equal within {EQUAL:g} dB"
    else:
        end = f"{abs(first - second):.1f} dB higher in {windows[0] if first > second else windows[1]}"
    return (
        f"Modulation of the faulty run with {case_name(diagnosis)}: {first:.1f} dB in {windows[0]} and {second:.1f} dB "
        f"in {windows[1]}, {end}. It is the root sum square of the sidebands around f_m over the line at f_m."
    )


def lines_grid(diagnosis: Diagnosis, window: str) -> Grid:
    """The envelope table of one case and window."""
    lines = diagnosis.lines.where(window=window)
    rope = diagnosis.settings.rope_mode.get(window, 0.0)
    low, high = diagnosis.band
    headers = ("line", "Hz", "faulty m/s²", "healthy m/s²", "difference dB", "over floor dB", "healthy over floor dB")
    rows, marked = [], set()
    for i in range(len(lines)):
        where = "envelope " if lines.kind[i] in IN_ENVELOPE else ""
        found = "detected" if lines.detected[i] else "-"
        if lines.kind[i] in ("mesh", "bearing"):
            found = f"{lines.kind[i]} line"
        elif lines.detected[i]:
            marked.add(i)
        near = ("on this line" if lines.near_rope[i] else f"{rope:.2f}",) if rope else ()
        rows.append(
            (
                where + lines.label[i],
                f"{lines.frequency[i]:.3f}",
                f"{lines.faulty[i]:.3g}",
                f"{lines.healthy[i]:.3g}",
                f"{lines.difference[i]:+.1f}",
                f"{lines.over_floor[i]:+.1f}",
                f"{lines.healthy_over_floor[i]:+.1f}",
                found,
                *near,
            )
        )
    title = f"{_capital(window)}, {case_name(diagnosis)}; envelope of {low:.4g} to {high:.4g} Hz"
    last = ("verdict", "rope mode Hz") if rope else ("verdict",)
    return Grid(title=title, headers=(*headers, *last), rows=tuple(rows), marked=frozenset(marked))


def summary_grid(diagnoses: Sequence[Diagnosis]) -> Grid:
    """A row per case: how many lines of each kind are detected, and whether each fault is seen."""
    settings = diagnoses[0].settings
    graders: list[tuple[str, Callable[[LineTable], str]]] = [(settings.fault, grade)] * bool(settings.fault)
    graders += [(other.fault, other.grade) for other in settings.beside_gears]
    faults = ["fault"] if len(graders) == 1 else [_capital(fault) for fault, _ in graders]
    loads = list(dict.fromkeys(d.load for d in diagnoses))
    ordered = sorted(diagnoses, key=lambda d: (loads.index(d.load), _seed_order(d.deviations)))
    cases = [(d, window, d.lines.where(window=window)) for d in ordered for window in d.settings.windows]
    counts = [_counts(lines) for _, _, lines in cases]
    kinds = list(dict.fromkeys(kind for count in counts for kind in count))
    rows = tuple(
        (
            LOADS.get(d.load, d.load),
            "error-free" if d.deviations == "off" else d.deviations,
            window,
            *(count.get(kind, "-") for kind in kinds),
            *(_GRADES[graded(lines)] for _, graded in graders),
        )
        for (d, window, lines), count in zip(cases, counts, strict=True)
    )
    headers = ("load", "deviations", "window", *kinds, *faults)
    return Grid(title="Number of detected lines in each case", headers=headers, rows=rows)


def seeds_grid(diagnoses: Sequence[Diagnosis], load: str, window: str) -> Grid:
    """Difference faulty over healthy of every line, a column per set of deviations; a dot marks detected lines."""
    chosen = sorted((d for d in diagnoses if d.load == load), key=lambda d: _seed_order(d.deviations))
    tables = [d.lines.where(window=window).of("envelope", "sideband", "pass", "shaft") for d in chosen]
    rows = []
    for i, label in enumerate(tables[0].label):
        where = "envelope " if tables[0].kind[i] in IN_ENVELOPE else ""
        cells = [f"{t.difference[i]:+.1f}" + (" ●" if t.detected[i] else "") for t in tables]
        rows.append(
            (where + label, f"{tables[0].frequency[i]:.3f}", *cells, str(sum(int(t.detected[i]) for t in tables)))
        )
    names = ["error-free" if d.deviations == "off" else d.deviations for d in chosen]
    title = f"{_capital(window)}, {LOADS.get(load, load)}: faulty over healthy in dB (● detected)"
    return Grid(title=title, headers=("line", "Hz", *names, "detected in"), rows=tuple(rows))


def markdown(diagnoses: Sequence[Diagnosis]) -> str:
    """Verdict, detected lines, and every line of every load and window with all deviations side by side."""
    parts = [f"**{headline(diagnoses)}**", criterion(diagnoses[0]), _titled(summary_grid(diagnoses))]
    parts.append(directions(diagnoses[0]))
    for load in dict.fromkeys(d.load for d in diagnoses):
        for window in dict.fromkeys(w for d in diagnoses if d.load == load for w in d.settings.windows):
            parts.append(_titled(seeds_grid(diagnoses, load, window)))
    return "\n\n".join(filter(None, parts)) + "\n"


def _titled(grid: Grid) -> str:
    return f"**{grid.title}**\n\n{grid.to_markdown()}"


def _seed_order(deviations: str) -> tuple[int, int]:
    """Error-free gears first, then the seeds in their order."""
    return (0, 0) if deviations == "off" else (1, int(deviations.split()[-1]))


def _counts(lines: LineTable) -> dict[str, str]:
    """How many lines of a case are detected, "2 of 8", by what they are."""
    sidebands = lines.where(kind="sideband")
    parts = {"envelope harmonics": lines.where(kind="envelope")}
    for n in dict.fromkeys(sidebands.mesh_harmonic.tolist()):
        parts[f"sidebands of {'' if n == 1 else f'{n} '}f_m"] = sidebands.where(mesh_harmonic=n)
    parts |= {"lines of the spalls": lines.where(kind="pass"), "orders of the shafts": lines.where(kind="shaft")}
    return {name: f"{int(part.detected.sum())} of {len(part)}" for name, part in parts.items() if len(part)}


def _standing(diagnosis: Diagnosis, lines: LineTable) -> str:
    settings, (low, high) = diagnosis.settings, diagnosis.band
    counted = lines.without_mesh()
    if not counted.detected.any():
        return f"none of the {len(counted)} lines is detected. {_reason(diagnosis, counted)}"
    envelope = lines.where(kind="envelope")
    parts = [
        f"{int(envelope.detected.sum())} of {len(envelope)} harmonics of f_r = {settings.revolution_frequency:.4f} Hz "
        f"in the envelope of {low:.4g} to {high:.4g} Hz"
    ]
    for n in settings.mesh_harmonics:
        around = lines.where(kind="sideband", mesh_harmonic=n)
        parts.append(
            f"{int(around.detected.sum())} of {len(around)} sidebands around {n * settings.mesh_frequency:.4g} Hz"
        )
    best = int(np.argmax(np.where(counted.detected == 1, counted.difference, -np.inf)))
    where = "in the envelope" if counted.kind[best] == "envelope" else "in the spectrum"
    return (
        f"{', '.join(parts[:-1])} and {parts[-1]} are detected. The largest increase of a detected line over the "
        f"control is {counted.difference[best]:+.1f} dB, at {counted.label[best]} {where}."
    )


def _reason(diagnosis: Diagnosis, lines: LineTable) -> str:
    """Which of the two conditions failed, with its physical meaning, and the reason the settings give."""
    settings = diagnosis.settings
    hidden = int(((lines.difference < settings.difference_limit) & (lines.over_floor >= settings.floor_limit)).sum())
    buried = int((lines.over_floor < settings.floor_limit).sum())
    words = []
    if hidden:
        cause = (
            "pitch deviations repeat with every revolution and mask the fault"
            if diagnosis.deviations != "off"
            else "gears without deviations excite these orders as well and mask the fault"
        )
        words.append(f"{hidden} are about as strong in the healthy control ({cause})")
    if buried:
        words.append(
            f"{buried} do not exceed the local floor by {settings.floor_limit:g} dB (the floor is sensor noise of "
            f"{diagnosis.noise:.3g} m/s² rms and vibration that is not periodic with the shaft)"
        )
    text = "Of these lines " + " and ".join(words) + "."
    return f"{text} {settings.reason}".strip()


def _control(lines: LineTable, limit: float) -> str:
    counted = lines.without_mesh()
    shown = int(counted.healthy_shows.sum())
    if shown == 0:
        return f"In the healthy control none of these lines is {limit:g} dB over its floor."
    best = int(np.argmax(np.where(counted.healthy_shows == 1, counted.healthy_over_floor, -np.inf)))
    return (
        f"In the healthy control {shown} of the {len(counted)} lines {'is' if shown == 1 else 'are'} at least "
        f"{limit:g} dB over the floor. Highest over its floor is {counted.label[best]}, by "
        f"{counted.healthy_over_floor[best]:.1f} dB."
    )


def _rope(rope: float, lines: LineTable, f_r: float) -> str:
    counted = lines.without_mesh()
    near = list(dict.fromkeys(abs(int(k)) for k in counted.order[counted.near_rope == 1]))
    text = f"The natural frequency of the container on its rope is {rope:.2f} Hz ({rope / f_r:.2f} f_r)"
    if near:
        return f"{text}, on the lines of order {', '.join(map(str, near))}, which it can raise without a fault."
    return f"{text}. It coincides with none of these lines."


def _axis(axis: str) -> str:
    return "resultant of its axes" if axis == "resultant" else f"axis {axis}"


def _capital(words: str) -> str:
    return words[:1].upper() + words[1:]
