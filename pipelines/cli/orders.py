"""`gearcase orders`: order spectra over speed, amplitudes of orders over speed, and a Campbell diagram."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from pipelines.cli.command_line import MACHINE, QUIET, RUN_HELP, argument
from pipelines.io.argument_types import count, path, positive, several
from pipelines.io.errors import InputError
from pipelines.runs import run_folder

if TYPE_CHECKING:
    import numpy as np

    from pipelines.engine.run_graph import Work
    from pipelines.scene.load_scene import LoadedScene
    from pipelines.signals.orders.kinematics import Kinematics
    from pipelines.signals.orders.order_spectra import Waterfall

STEADY = 0.01  # relative range of the speeds up to which amplitudes over speed have no meaning
SPEEDS = 9  # at which a Campbell diagram has natural frequencies
AXES = ("x", "y", "z")
ARGUMENTS = (
    argument("run", metavar="RECORD", type=path, help=f"recording file, {RUN_HELP}; add a window as in bench@0.5:2.5"),
    MACHINE,
    argument(
        "--shaft",
        metavar="N",
        type=count,
        help="number of the shaft whose speed is order 1 (default: the shaft that the motor drives)",
    ),
    argument("--sensor", metavar="NAME", help="sensor to analyse (default: that of the diagnosis, or the first)"),
    argument("--axis", choices=("x", "y", "z"), help="axis of the sensor (default: that of the diagnosis)"),
    argument(
        "--orders",
        metavar="K",
        type=positive,
        nargs="+",
        default=[],
        help="orders whose amplitudes are shown over speed (default: the first two mesh orders of each stage)",
    ),
    argument(
        "--revolutions",
        metavar="N",
        type=several,
        default=16,
        help="revolutions in the window of a spectrum, 2 or more (default 16)",
    ),
    argument("--campbell", action="store_true", help="add a Campbell diagram: natural frequencies over speed"),
    argument(
        "--out", metavar="FOLDER", type=path, help="folder for the pictures (default: the folder of the run or file)"
    ),
    QUIET,
)


def main(options: argparse.Namespace) -> Iterator[str]:
    """Analyse the run-up or coast-down of a finished run or a recording by orders of a shaft. Print the highest
    amplitude of each order. Write pictures of the order spectra over speed, and of the amplitude of each order over
    speed. Takes seconds.

    Example
    -------
    gearcase orders reducer
    input-bearing z over the orders of shaft 1, 11 windows
      order  highest m/s2  at rpm   at Hz
    -------  ------------  ------  ------
    ...
         46        0.0944    1470  1126.7
    ...
    runs/reducer/2026-11-25_01-02-30/orders.png
    ...
    """
    import numpy as np

    from pipelines.engine.run_graph import Work
    from pipelines.io.shown_text import shown
    from pipelines.io.user_files import writable_folder
    from pipelines.machine.machine_conversion import make_drivetrain
    from pipelines.report.figures.order_plots import campbell_figure, cuts_figure, waterfall_figure
    from pipelines.runs.recorded_file import recording_and_window
    from pipelines.signals.orders.order_spectra import OrderError, frequency_waterfall, order_waterfall

    (source, asked), work = recording_and_window(options.run), Work(quiet=options.quiet)
    measured = source.name != run_folder.RESPONSE or options.machine or asked
    if measured and options.campbell:
        raise InputError(
            "--campbell needs natural frequencies, which a recording does not have. Give a finished run, or delete "
            "--campbell."
        )
    read = _read_file(options, bool(asked)) if measured else _read(source.parent, options)
    target = writable_folder(options.out or source.parent)
    parts = read.signal, read.time, read.angle
    try:
        found = order_waterfall(*parts, shaft=read.shaft, revolutions=options.revolutions)
        inside = [order for order in read.orders if order + 2 * found.resolution < found.line[-1]]
        words = _table(found, inside, read)
    except OrderError as error:
        raise InputError(f"{shown(source)}: {error}") from error
    title = f"{read.title}: {read.place}"
    figures = {}
    if np.ptp(found.speed) <= STEADY * found.speed.max():
        words += f"\nThe speed is constant within {100 * STEADY:g} %: there are no pictures over the speed. "
        words += "`gearcase diagnose` with --out plots order spectra at constant speed."
    else:
        top = 2.2 * max(inside, default=found.line[-1] / 2.2)
        figures["orders"] = waterfall_figure(found, title, read.units, top=top)
        figures["order-cuts"] = cuts_figure(found, inside, title, read.units)
    if read.loaded is not None and options.campbell:
        flat = frequency_waterfall(*parts, shaft=read.shaft)
        ratio = make_drivetrain(read.loaded.scene).layout.shaft_ratios[int(read.shaft.removeprefix("shaft_")) - 1]
        speeds = np.linspace(0.0, float(found.speed.max()), SPEEDS)
        top = min(
            0.5 * float(flat.line[-1]), 1.3 * max(inside, default=20.0) * float(found.speed.max()) / (2 * math.pi)
        )
        natural = _natural_over_speed(read.loaded, work, speeds / ratio, top)
        by_shaft = {speed * ratio: values for speed, values in natural.items()}
        figures["campbell"] = campbell_figure(flat, by_shaft, inside, title, read.units)
    target.mkdir(parents=True, exist_ok=True)
    for name, figure in figures.items():
        figure.savefig(target / f"{name}.png", dpi=110)
    yield words + "\n"  # a table without rows ends in an empty line
    yield from (str(target / f"{name}.png") for name in figures)


@dataclass(frozen=True, eq=False, kw_only=True)
class _RunUp:
    """Signal and shaft angle of a run or a recording, and the orders to show; a recording has no scene."""

    loaded: LoadedScene | None
    title: str
    place: str  # as in "motor_side z"
    units: str
    shaft: str
    origin: str  # of the speed, with its uncertainty
    orders: tuple[float, ...]
    signal: np.ndarray
    time: np.ndarray
    angle: np.ndarray


def _read(folder: Path, options: argparse.Namespace) -> _RunUp:
    """The signal to analyse, from the files of a run.

    Raises
    ------
    InputError : no such shaft, sensor or axis
    """
    import numpy as np

    from pipelines.machine.machine_conversion import make_drivetrain
    from pipelines.machine.scene_kinematics import kinematics_of
    from pipelines.scene.load_scene import load_scene
    from pipelines.signals.analysis import DiagnosisError, channel, channel_names

    loaded = load_scene(folder / run_folder.RESOLVED)
    train = make_drivetrain(loaded.scene, loaded.source.shown)
    shafts = len(train.layout.axes)
    number = train.layout.driven if options.shaft is None else options.shaft - 1
    if number >= shafts:
        raise InputError(f"--shaft {number + 1}: the machine has {shafts} shafts. Give 1 to {shafts}.")
    with run_folder.opened_run(folder / run_folder.RESPONSE) as run:
        known = channel_names(run)
        sensor = options.sensor or (train.monitored.sensor if train.monitored.sensor in known else known[0])
        axis = options.axis or (train.monitored.axis if train.monitored.axis in AXES else AXES[-1])
        try:
            found = channel(run, sensor).sel(axis=axis)
        except DiagnosisError as error:
            raise InputError(f"--sensor: {error}") from error
        name = f"shaft_{number + 1}"
        return _RunUp(
            loaded=loaded,
            title=loaded.scene.title,
            place=f"{sensor} {axis}",
            units=str(found.attrs["units"]),
            shaft=name,
            origin=". Source: shaft angle of the run.",
            orders=tuple(options.orders) or _mesh_orders(kinematics_of(train.layout, train.rolling), name),
            signal=np.asarray(found.values, dtype=float),
            time=run.time.values,
            angle=run.shaft_angle.sel(shaft=name).values,
        )


def _read_file(options: argparse.Namespace, windowed: bool) -> _RunUp:
    """The signal to analyse, from a recording or its window.

    Raises
    ------
    InputError : no such shaft, sensor or axis; the recording or its machine cannot be used
    """
    from pipelines.diagnosis.comparison.compared_recording import chosen_channel
    from pipelines.runs.recorded_file import recorded_parts

    part = recorded_parts([options.run], options.machine, None)[0]
    inside = (part.time >= part.windows[0].start) & (part.time <= part.windows[0].end) | (not windowed)
    shafts, number = part.kinematics.shafts, 1 if options.shaft is None else options.shaft
    if number > len(shafts):
        raise InputError(f"--shaft {number}: the machine has {len(shafts)} shafts. Give 1 to {len(shafts)}.")
    sensor, axis = chosen_channel(part, options.sensor, options.axis)
    shaft = shafts[number - 1]
    return _RunUp(
        loaded=None,
        title=Path(options.run).name,
        place=f"{sensor} {axis}",
        units="m/s2",
        shaft=shaft.name,
        origin=part.rotation.origin,
        orders=tuple(options.orders) or _mesh_orders(part.kinematics, shaft.name),
        signal=part.acceleration[part.channels.index((sensor, axis)), inside],
        time=part.time[inside],
        angle=shaft.ratio * part.rotation.angle[inside],
    )


def _mesh_orders(kinematics: Kinematics, shaft: str) -> tuple[float, ...]:
    """The first two mesh orders of each stage, in orders of a shaft."""
    own = kinematics.shaft(shaft).ratio
    return tuple(sorted({round(k * order / own, 6) for order in kinematics.mesh_orders().values() for k in (1, 2)}))


def _natural_over_speed(loaded: LoadedScene, work: Work, speeds: np.ndarray, up_to: float) -> dict[float, np.ndarray]:
    """Natural frequencies (Hz) of the loaded machine with gyroscopic moments, by motor speed (rad/s).

    Parameters
    ----------
    loaded, work : the scene, and the executor of its steps
    speeds : (n,) of the motors, rad/s
    up_to : upper limit of the frequencies, Hz
    """
    from pipelines.runs.single_results import build_machine_modes
    from pipelines.scene.load_scene import changed

    turning = changed(loaded, {"shaft_model.gyroscopic": True})
    return {
        float(speed): build_machine_modes(turning, work, up_to=up_to, speed=float(speed))[0].frequencies
        for speed in speeds
    }


def _table(found: Waterfall, orders: list[float], read: _RunUp) -> str:
    """Table of the highest amplitude of each order and the speed at which it occurs; source of the speed."""
    from pipelines.io.text_table import grid

    rows = []
    for order in orders:
        cut = found.cut(order)
        at = int(cut.argmax())
        speed = float(found.speed[at])
        rows.append(
            {
                "order": f"{order:g}",
                f"highest {read.units}": f"{cut[at]:.3g}",
                "at rpm": f"{speed * 30 / math.pi:.0f}",
                "at Hz": f"{order * speed / (2 * math.pi):.1f}",
            }
        )
    title = f"{read.place} over the orders of {read.shaft.replace('_', ' ')}, {len(found.speed)} windows"
    lowest, highest = (end * 30 / math.pi for end in (found.speed.min(), found.speed.max()))
    return f"{grid(title, rows).to_text()}\n{read.shaft}: {lowest:.5g} to {highest:.5g} rpm{read.origin}"
