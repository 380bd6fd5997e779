"""`gearcase modes`: natural modes of the whole loaded machine; those of its casing alone: `pipelines.cli.casing`."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from pipelines.cli.command_line import JSON, WORK, argument, scene_and_work
from pipelines.io.argument_types import number, positive

if TYPE_CHECKING:
    from mbd.system.linearised import LinearModes
    from pipelines.io.text_table import Grid
    from pipelines.machine.machine_model import MachineModel

ARGUMENTS = (
    *WORK,
    argument("--up-to", metavar="HZ", type=positive, default=10e3, help="highest frequency, Hz (default 10000)"),
    argument(
        "--cycle",
        metavar="C",
        type=number,
        help="position of stage 1, in mesh cycles; at position N the damaged tooth N makes contact at the pitch point "
        "(default: that at the start of the simulation)",
    ),
    argument(
        "--speed",
        type=number,
        default=0.0,
        metavar="RPM",
        help="motor speed for losses and gyroscopic moments, rpm (default 0)",
    ),
    JSON,
)


KINDS = {"shaft": "shafts", "bearing": "bearings", "casing": "casing", "rope": "rope", "drive": "drive"}


def main(options: argparse.Namespace) -> Iterator[str]:
    """Linearise the loaded machine about its static equilibrium. Print natural frequencies, damping and the share of
    each part in the total energy of each mode. The column `dominant` names the part with the largest share of the
    strain energy; for casing and rope the mean of strain and kinetic share is used instead. Takes seconds if the
    cache holds mesh stiffness and casing.

    Example
    -------
    gearcase modes minimal
    minimal: small vibrations about the loaded static equilibrium, stage 1 at mesh cycle 0
    mode  frequency Hz  damping ratio %  shafts %  bearings %  casing %  drive %  mesh 1 %  dominant
    ...
       1        112.84            6.186      58.1         4.3       0.3     34.8       2.5  motor coupling
    ...
    mesh 1: force 1061 N, tangent stiffness 146.9 N/um
    ...
    """
    from pipelines.io.json_text import json_text
    from pipelines.runs.single_results import build_machine_modes, scene_graph

    loaded, work = scene_and_work(options)
    modes, cycle = build_machine_modes(
        loaded,
        work,
        up_to=options.up_to,
        cycle=options.cycle,
        speed=options.speed / 60 * 2 * math.pi,
    )
    _, machine = scene_graph(loaded)
    if options.json:
        found = {
            "scene": loaded.name,
            "cycle": cycle,
            "modes": [
                {
                    "frequency_Hz": frequency,
                    "damping_ratio": damping,
                    "dominant": dominant,
                    "shares": dict(zip(modes.part_names, shares, strict=True)),
                }
                for frequency, damping, dominant, shares in zip(
                    modes.frequencies, modes.damping_ratios, modes.dominant, modes.shares, strict=True
                )
            ],
            "foot_forces_N": dict(zip(modes.foot_names, modes.foot_forces.tolist(), strict=True)),
            "notes": notes(machine, modes, options.up_to),
        }
        yield json_text(found)
        return
    title = f"{loaded.name}: small vibrations about the loaded static equilibrium, stage 1 at mesh cycle {cycle:.4g}"
    yield machine_mode_table(title, modes).to_text() + "\n"  # a table without modes ends in an empty line
    yield from notes(machine, modes, options.up_to)


def machine_mode_table(title: str, modes: LinearModes) -> Grid:
    """One row per mode; shares of its strain and kinetic energy in per cent."""
    from pipelines.io.text_table import grid

    columns = {kind: words for kind, words in KINDS.items() if kind in modes.part_kinds}
    columns |= {name: name.replace("_", " ") for name in modes.mesh_names}
    shares = {f"{words} %": 100 * modes.share(part) for part, words in columns.items()}
    rows = [
        {
            "mode": i + 1,
            "frequency Hz": f"{modes.frequencies[i]:.5g}",
            "damping ratio %": 100 * float(modes.damping_ratios[i]),
        }
        | {words: f"{values[i]:.1f}" for words, values in shares.items()}
        | {"dominant": modes.dominant[i]}
        for i in range(len(modes.frequencies))
    ]
    return grid(title, rows)


def notes(machine: MachineModel, modes: LinearModes, up_to: float) -> list[str]:
    """What the table was made with, and what bounds it."""
    from fem.casing.reduced.reduced_body import MODES_OVER_BAND

    found = [
        f"{name.replace('_', ' ')}: force {force:.4g} N, tangent stiffness {stiffness / 1e6:.4g} N/um"
        for name, force, stiffness in zip(modes.mesh_names, modes.mesh_forces, modes.mesh_stiffness, strict=True)
    ]
    found += [
        f"{name.replace('_', ' ')}: force of the ground on the casing ({x:.4g}, {y:.4g}, {z:.4g}) N along x, y, z"
        for name, (x, y, z) in zip(modes.foot_names, modes.foot_forces, strict=True)
    ]
    if modes.overdamped:
        found.append(f"{modes.overdamped} overdamped motions do not oscillate and are not listed.")
    limit = machine.casing.limit
    if limit is not None and limit / MODES_OVER_BAND < up_to:
        found.append(
            f"The casing is resolved to {limit / MODES_OVER_BAND:g} Hz; modes above that are only indicative. "
            "Set a higher casing.band_Hz for them."
        )
    if not len(modes.frequencies):
        found.append(f"No mode up to {up_to:g} Hz; raise --up-to.")
    return found
