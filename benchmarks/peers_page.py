"""The sections of docs/benchmarks.md that set gearcase beside other programs, from their stored results."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.markdown import markdown

RESULTS = Path(__file__).resolve().parent / "results"
Found = dict[str, Any]


def sections() -> list[str]:
    """Headings, tables and conditions of every peer; those never measured say so."""
    text = ["## Comparison with other programs", LEAD]
    for title, name, table in PEERS:
        path = RESULTS / f"{name}.json"
        text.append(f"### {title}")
        if not path.exists():
            text.append(f"Not measured: `python -m benchmarks.peers.{name}` does it (make peers).")
            continue
        found = json.loads(path.read_text(encoding="utf-8"))
        text += [table(found), _conditions(found)]
    return text


LEAD = (
    "Each table is one run of the same problem on one thread. Times are processor times. "
    "CalculiX is the Debian package calculix-ccx with SPOOLES; `make peers` installs the Python packages."
)


def _conditions(found: Found) -> str:
    where = found["conditions"]
    program = f"{found['program']}; " if "program" in found else ""
    return f"{program}{where['system']} on {where['architecture']}, {where['cores']} cores, Python {where['python']}."


def contact_table(found: Found) -> str:
    """Approach at the load of the rig by CalculiX and by the models."""
    names = list(found["positions"][0]["models"])
    rows = []
    for place in found["positions"]:
        if not place["meshes"]:
            continue
        meshes = ", ".join(f"{1e6 * m['delta_m']:.3f} ({m['face_elements']})" for m in place["meshes"])
        seconds = sum(m["cpu_seconds"] for m in place["meshes"])
        models = [f"{100 * place['models'][name]['deviation']:+.1f} %" for name in names]
        what = "wheel tooth missing" if place["missing"] else "healthy"
        rows.append(
            [f"{place['cycle']:g}", what, meshes, f"{1e6 * place['extrapolated_m']:.3f}", f"{seconds:.0f}", *models]
        )
    headers = ("mesh cycle", "state", "CalculiX, µm (elements along the face)", "extrapolated, µm", "time, s", *names)
    lead = (
        f"Approach of stage 1 of the rig at {found['force_N']:.0f} N: CalculiX models both gears in 3-D "
        f"({found['element']}, penalty {found['penalty_N_per_mm3']:.0e} N/mm³). The deviations are those from CalculiX."
    )
    return f"{lead}\n\n{markdown(headers, rows)}"


def modified_table(found: Found) -> str:
    """Transmission error, pressure and root stress of modified pairs by finite elements and by model `solid`."""
    rows = []
    for name, case in found["cases"].items():
        for load, exact, own in zip((100, 200), *(case["compared"][k] for k in ("elements", "solid")), strict=True):
            by = [list(zip(*one, strict=True)) for one in (exact, own)]
            mean = [1e6 * sum(q[0]) / len(q[0]) for q in by]
            peak = [1e6 * (max(q[0]) - min(q[0])) for q in by]
            largest = [100 * (max(by[1][k]) / max(by[0][k]) - 1) for k in (2, 3)]
            coarse = case["0, 1"]["loads"][load // 200]
            change = [
                100 * abs(exact[0][k] / coarse[q] - 1)
                for k, q in ((0, "delta_m"), (2, "root_stress_pinion_Pa"), (3, "root_stress_wheel_Pa"))
            ]
            rows.append(
                [name, str(load), f"{mean[0]:.2f}", f"{100 * (mean[1] / mean[0] - 1):+.1f} ± {change[0]:.1f} %"]
                + [f"{peak[0]:.2f}", f"{peak[1]:.2f}"]
                + [f"{value:+.1f} ± {error:.1f} %" for value, error in zip(largest, change[1:], strict=True)]
            )
    headers = ("pair, m_n 2 mm", "N/mm", "mean δ, µm", "`solid`", "peak to peak, µm", "`solid`, µm")
    lead = (
        "Transmission error over six positions of a mesh cycle, and the largest root stress, by the 20-node elements "
        "of the CalculiX model with another contact solution (`benchmarks/peers/flank_contact.py`, "
        f"penalty 1e+08 N/mm³). {found['meshes']} Percentages are deviations of `solid`, and after ± the change of the "
        "finite elements by this extrapolation. With 16 instead of 8 elements along the face, their root stress at "
        "c = 0 is 0.9 to 2.6 % lower (25/62). "
        "The Hertz pressure by the line load, as the mean over an element along the face, deviates by -6 to +7 % at "
        "positions 1 to 4, without tip edges, on the coarser mesh (20 states)."
    )
    return f"{lead}\n\n{markdown((*headers, 'root, pinion', 'root, wheel'), rows)}"


def spall_table(found: Found) -> str:
    """Deflection that bridged spalls add, by finite elements and by model `solid`."""
    rows = []
    for name, case in found["cases"].items():
        for torque, row, own in zip((20, 75, 300), case["torques"], case["solid_m"], strict=True):
            added = row["added_m"]
            values = (1e6 * row["healthy_m"], 1e6 * added, 1e6 * own)
            rows.append([name, str(torque), *(f"{v:.2f}" for v in values), f"{100 * (own / added - 1):+.1f} %"])
    nodes = max(max(case["nodes"]) for case in found["cases"].values())
    lead = (
        "Deflection that a spall adds, over half of the face of a pinion tooth around the reference circle, 0.125 mm "
        "deep with vertical walls (z 20/55, m_n 2 mm, b 12 mm). Same elements, 12 µm at the rims, up to "
        f"{nodes} nodes per gear, one mesh. An uncertainty of about 0.1 µm comes from the mesh of the healthy pair."
    )
    headers = ("spall, mesh cycle", "torque, N m", "healthy, µm", "added, µm", "`solid`, µm", "deviation")
    return f"{lead}\n\n{markdown(headers, rows)}"


def frequency_table(found: Found) -> str:
    """Casing modes."""
    rows = [
        [name, f"{found[key]['cpu_seconds']:.1f}", f"{found[key]['seconds']:.1f}"]
        for name, key in (("gearcase", "gearcase"), ("CalculiX", "calculix"))
    ]
    lead = (
        f"Casing with clamped feet, {found['unknowns']} unknowns, {found['modes']} modes from "
        f"{found['first_Hz']:.0f} to {found['last_Hz']:.0f} Hz, on one mesh. The largest difference is "
        f"{100 * found['largest_deviation']:.4f} %. gearcase is {found['ratio']:.1f} times as fast."
    )
    return f"{lead}\n\n{markdown(('program', 'processor time, s', 'wall-clock time, s'), rows)}"


def motion_table(found: Found) -> str:
    """Seconds at equal error."""
    rows = []
    for name, seconds in found["cpu_seconds_at_error"].items():
        ratio = found["ratio"].get(name)
        rows.append([name, "not reached" if seconds is None else f"{seconds:.3g}", f"{ratio:.1f}" if ratio else ""])
    lead = (
        f"One gear stage in linear bearings, {found['coordinates']} coordinates, {found['span_s']:g} s at 900 rpm. "
        f"For all methods the RMS error of the approach is {found['error']:g} of its standard deviation. "
        "All use the same compiled mesh force."
    )
    return f"{lead}\n\n{markdown(('method', 'time, s', 'ratio to gearcase'), rows)}"


def ross_table(found: Found) -> str:
    """Mesh stiffness of a spur pair."""
    rows = [
        [name, *(f"{row[key] / 1e6:.1f}" for key in ("smallest", "mean", "largest")), f"{row['cpu_seconds']:.3g}"]
        for name, row in found["rows"].items()
    ]
    table = markdown(("program or model", "smallest, N/µm", "mean, N/µm", "largest, N/µm", "time, s"), rows)
    lead = "Spur pair 62/62, m 2 mm, b 20 mm, bore 35 mm, 1000 positions; `plane` at 1000 N. "
    lead += "ROSS was also run with a helix angle, which it ignores."
    return f"{lead}\n\n{table}"


def floor_table(found: Found) -> str:
    """Counts and the seconds they would take."""
    rows = [
        [name, f"{found[key]['flops']:.3g}", f"{found[key]['bytes']:.3g}", f"{found['seconds'][key]:.3g}"]
        for name, key in (
            ("factorisation of the casing", "factor"),
            ("one time step of the rig without mesh forces", "step"),
        )
    ]
    rates = found["rates"]
    lead = (
        f"Least time for the counted operations, on one thread: {rates['dgemm'] / 1e9:.0f} Gflop/s in a dense "
        f"product, {rates['memory'] / 1e9:.0f} GB/s from memory, {rates['cache'] / 1e9:.0f} GB/s from the cache."
    )
    return f"{lead}\n\n{markdown(('work', 'operations', 'bytes', 'least time, s'), rows)}"


PEERS: tuple[tuple[str, str, Callable[[Found], str]], ...] = (
    ("CalculiX: contact", "calculix_contact", contact_table),
    ("Finite elements in contact: modified pairs", "modified_pairs", modified_table),
    ("Finite elements in contact: bridged spalls", "bridged_spalls", spall_table),
    ("CalculiX: natural frequencies", "calculix_frequency", frequency_table),
    ("Exudyn: time integration", "exudyn_mesh", motion_table),
    ("SciPy: time integration", "scipy_mesh", motion_table),
    ("ROSS: mesh stiffness", "ross_stiffness", ross_table),
    ("Lower bounds of the time", "floor", floor_table),
)
