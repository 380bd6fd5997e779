"""docs/benchmarks.md, and the measured blocks of docs/choosing-a-model.md, from the results."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.markdown import markdown
from benchmarks.peers_page import sections as peer_sections

_LAWS = (
    "Time from geometry to mesh law for both flanks of one gear pair with 15 slices; `solid` at refinement 0.7. "
    "A cracked gear also needs the flexibility of the cracked tooth, once per crack angle."
)
_MODELS = (
    "`rig-healthy` with one model changed, 0.3 s of motion, 900 rpm from 0.05 s on. Acceleration and mesh force are "
    "standard deviations from 0.1 s to 0.3 s; for the mesh force the container on its rope causes most of this value. "
    "Without a casing the acceleration is that of the journal of bearing 3."
)
_PRECISION = (
    "The full rig over 0.2 s of motion, acceleration of sensor_3 along z after the output filter. Error: RMS of the "
    "difference from the signal of the exponential method at 1.25 µs, over the RMS of that signal."
)
_PRESETS = (
    "`gearcase simulate rig-missing-tooth --preset ...` from an empty cache to written signals, with compiled code on "
    "disk. Errors are the largest against the preset `reference`. Total is wall time; two steps run in parallel."
)
BEGIN, END = "<!-- measured: {} -->", "<!-- end of measured -->"


def write(result: dict[str, Any], docs: Path) -> None:
    """Write docs/benchmarks.md and fill the blocks of docs/choosing-a-model.md."""
    (docs / "benchmarks.md").write_text(benchmarks_page(result), encoding="utf-8")
    choosing = docs / "choosing-a-model.md"
    if choosing.exists():
        text = choosing.read_text(encoding="utf-8")
        for name, block in blocks(result).items():
            text = filled(text, name, block)
        choosing.write_text(text, encoding="utf-8")


def blocks(result: dict[str, Any]) -> dict[str, str]:
    """Tables by the name of their block."""
    parts = result["parts"]
    return {
        "conditions": conditions_text(result["conditions"]),
        "mesh": f"{_LAWS}\n\n{_part(parts, 'laws', law_table)}",
        "casing": "\n\n".join([_part(parts, "modes", casing_table), _part(parts, "static", casing_table)]),
        "models": f"{_MODELS}\n\n{_part(parts, 'models', model_table)}",
        "precision": f"{_PRECISION}\n\n{_part(parts, 'precision', precision_table)}",
        "presets": f"{_PRESETS}\n\n{_part(parts, 'presets', preset_table)}",
    }


def filled(text: str, name: str, block: str) -> str:
    """The text with the part between the marks of `name` replaced; unchanged if it has no such mark."""
    begin = BEGIN.format(name)
    before, found, rest = text.partition(begin)
    if not found:
        return text
    return f"{before}{begin}\n\n{block}\n\n{END}{rest.partition(END)[2]}"


def benchmarks_page(result: dict[str, Any]) -> str:
    """The whole page."""
    parts = result["parts"]
    sections = [
        ("Evaluation of a mesh law", "One call of the compiled kernel computes force, moment, energy and their "
         "derivatives at one position in mesh, for stage 1 of `rig-healthy` at the deflection under the nominal load.",
         "evaluation", evaluation_table),
        ("Casing: mesh", "The housing of `rig-healthy`.", "mesh", casing_table),
        ("Casing: assembly and factorisation", "Cubic hexahedra with edge-singularity enrichment. The factorised "
         "matrix is K + s M of the whole free body (s: shift).", "factors", casing_table),
        ("Time loop", "Time steps, output filter and energy balance. Set-up is assembly, modes, equilibrium and the "
         "start of the filter. The rig reaches 900 rpm at 0.05 s. Compiled code is loaded in advance.", "loop",
         loop_table),
        ("Campaigns", "Scenes per hour of `gearcase campaign`, counted after every process has done two scenes. The "
         "bare loop repeats the motion of one assembled machine in as many processes, before and after the campaign. "
         "The ratio is the rate of the campaign divided by the mean rate of the loops.", "campaign", campaign_table),
        ("Scenes in lockstep", "Scenes with the same modes could advance together, as columns of a matrix; gearcase "
         "does not. Advancing them together would speed up the arithmetic over modes, but not the forces.",
         "lockstep", lockstep_table),
    ]  # fmt: skip
    text = [
        "# Benchmarks",
        "This page gives time and memory of each part of a computation, and compares gearcase with other programs. "
        "`python -m benchmarks` (`make bench`) writes it, in 13 minutes without other programs. "
        "[Choosing a model](choosing-a-model.md) compares mesh laws, casings, integrators and presets.",
        conditions_text(result["conditions"]),
    ]
    for title, lead, name, table in sections:
        text += [f"## {title}", *([lead] if lead else []), _part(parts, name, table)]
    return "\n\n".join(text + peer_sections()) + "\n"


def conditions_text(found: dict[str, Any]) -> str:
    """The conditions in one paragraph."""
    versions = ", ".join(f"{name} {version}" for name, version in found["libraries"].items())
    return (
        f"Measured on {found['date']}: {found['system']} on {found['architecture']}, {found['cores']} shared cores, "
        f"one thread (two for the expensive steps of the casing and of `solid`); Python {found['python']}, {versions}. "
        "Seconds are wall-clock times (processor times in brackets), each the median of the given number of calls. "
        "Memory is the peak of the process, imports included."
    )


def _part(parts: dict[str, Any], name: str, table: Callable[[list[dict[str, Any]]], str]) -> str:
    found = parts.get(name, {"skipped": "not measured"})
    if "skipped" in found:
        return f"Not measured: {found['skipped']}"
    if "peak_MB" in found["rows"][0]:  # the table has a column of memory
        return table(found["rows"])
    return f"{table(found['rows'])}\n\nPeak memory of this part: {found['peak_MB']:.0f} MB."


def _seconds(row: dict[str, Any]) -> str:
    return f"{row['seconds']:.3g} ({row['cpu_seconds']:.3g})"


def law_table(rows: list[dict[str, Any]]) -> str:
    """Models of the mesh law."""
    cells = [[r["stage"], r["pair"], r["model"], _seconds(r), str(r["calls"])] for r in rows]
    return markdown(("stage", "teeth", "model", "seconds", "calls"), cells)


def evaluation_table(rows: list[dict[str, Any]]) -> str:
    """The compiled kernel."""
    cells = [[r["model"], str(r["slices"]), f"{r['force_N']:.0f}", f"{r['microseconds']:.2f}"] for r in rows]
    return markdown(("model", "slices", "force, N", "µs per call"), cells)


def casing_table(rows: list[dict[str, Any]]) -> str:
    """Steps of the casing."""
    cells = [[r["step"], r.get("size", ""), r["solver"], _seconds(r), str(r["calls"])] for r in rows]
    return markdown(("step", "size", "solver", "seconds", "calls"), cells)


def loop_table(rows: list[dict[str, Any]]) -> str:
    """The time loop."""
    cells = [
        [
            r["scene"], str(r["coordinates"]), str(r["modes"]), f"{r['step_us']:.3g}",
            f"{r['iterations_per_step']:.2f}", f"{r['microseconds_per_step']:.0f}",
            f"{r['seconds_per_second']:.2f} ({r['cpu_per_second']:.2f})", f"{r['assembly_s'] + r['setup_s']:.2f}",
            str(r["calls"]),
        ]
        for r in rows
    ]  # fmt: skip
    headers = ("scene", "coordinates", "modes kept", "step size, µs", "iterations per step",
               "time per step, µs", "time per second of motion, s", "set-up, s", "calls")  # fmt: skip
    return markdown(headers, cells)


def model_table(rows: list[dict[str, Any]]) -> str:
    """The rig with one model changed."""
    cells = [
        [
            r["variant"], str(r["coordinates"]), str(r["modes"]),
            f"{r['seconds_per_second']:.2f} ({r['cpu_per_second']:.2f})",
            f"{r['rms']:.3g} ({r['channel']})", f"{r['mesh_force_rms_N']:.3g}", f"{r['delta_ptp_um']:.3g}",
        ]
        for r in rows
    ]  # fmt: skip
    headers = ("model changed", "coordinates", "modes kept", "seconds per second of motion", "acceleration m/s²",
               "mesh force, stage 1, N", "approach peak to peak, stage 1, µm")  # fmt: skip
    return markdown(headers, cells)


def preset_table(rows: list[dict[str, Any]]) -> str:
    """Cold time, memory and errors of the presets."""
    cells = []
    for r in rows:
        shares = [
            f"{round(100 * r['errors'].get(name, 0.0), 6):.2g} %" for name in ("signals", "gears", "casing", "machine")
        ]
        levels = [f"{r['decibels'].get(name, 0.0):.2g} dB" for name in ("lines", "frf")]
        wall = "" if r["wall_seconds"] is None else f"{r['wall_seconds']:.0f}"
        parts = [f"{r[name]:.1f}" for name in ("law_seconds", "casing_seconds", "motion_seconds")]
        cells.append([r["preset"], wall, *parts, f"{r['peak_MB']:.0f}", shares[0], levels[0], *shares[1:], levels[1]])
    headers = ("preset", "total s", "mesh laws s", "casing s", "motion s", "memory MB", "error of sensor RMS",
               "of fault lines", "of mesh stiffness, TE", "of casing frequencies", "of machine frequencies",
               "of FRF")  # fmt: skip
    return markdown(headers, cells)


def campaign_table(rows: list[dict[str, Any]]) -> str:
    """Scenes per hour, and those of the bare loop."""
    cells = [
        [r["scene"], f"{r['motion_s']:g}", str(r["scenes"]), str(r["processes"]), f"{r['per_hour']:.0f}",
         f"{r['loop_before']:.0f}, {r['loop_after']:.0f}", f"{r['share']:.3f}", f"{r['megabytes_per_scene']:.2f}"]
        for r in rows
    ]  # fmt: skip
    headers = ("scene", "motion, s", "scenes", "processes", "scenes per hour", "bare loop before, after, per hour",
               "ratio", "disk, MB per scene")  # fmt: skip
    return markdown(headers, cells)


def lockstep_table(rows: list[dict[str, Any]]) -> str:
    """What columns of a matrix would gain."""
    cells = [
        [r["scene"], str(r["modes"]), str(r["rows"]), f"{r['step_us']:.1f}",
         ", ".join(f"{n}: {us:.2g}" for n, us in r["columns_us"].items()), f"{r['gain']:.2f}"]
        for r in rows
    ]  # fmt: skip
    headers = (
        "scene",
        "modes",
        "forces",
        "time of a step, µs",
        "number of columns: arithmetic per column, µs",
        "speed-up",
    )
    return markdown(headers, cells)


def precision_table(rows: list[dict[str, Any]]) -> str:
    """Work against precision."""
    cells = [
        [r["method"], f"{r['step_us']:g}", _seconds(r), f"{r['setup_s']:.2g}", f"{100 * r['error']:.2g} %",
         f"{100 * r['rms_error']:.2g} %"]
        for r in rows
        if "left_out" not in r
    ]  # fmt: skip
    text = markdown(
        ("integrator", "step µs", "seconds", "of which set-up", "error of the signal", "error of its RMS"), cells
    )
    return "\n\n".join([text, *(f"Left out: {r['method']}. {r['left_out']}." for r in rows if "left_out" in r)])
