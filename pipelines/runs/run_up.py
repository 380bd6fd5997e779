"""A run-up read from a result folder: waterfall, order cuts, Campbell diagram."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from pipelines.io.errors import InputError
from pipelines.runs import run_folder

if TYPE_CHECKING:
    import numpy as np

    from pipelines.engine.working import Work
    from pipelines.machine.layout import Layout
    from pipelines.scene.file import LoadedScene
    from pipelines.signals.orders.order_spectra import Waterfall

SPEEDS = 9  # of a Campbell diagram
AXES = ("x", "y", "z")


@dataclass(frozen=True, kw_only=True)
class RunUpOptions:
    """What is looked at; None and () take the first shaft, the sensor and axis of the diagnosis, the mesh orders."""

    shaft: int | None = None  # from 1
    sensor: str | None = None
    axis: str | None = None
    orders: tuple[float, ...] = ()
    revolutions: int = 16
    campbell: bool = False
    out: str | None = None  # folder


@dataclass(frozen=True, eq=False, kw_only=True)
class RunUp:
    """Signal and angle of a run, and what is looked for in it."""

    loaded: LoadedScene
    place: str  # "motor_side z"
    units: str
    shaft: str
    orders: tuple[float, ...]
    signal: np.ndarray
    time: np.ndarray
    angle: np.ndarray


def read_run_up(folder: Path, wanted: RunUpOptions) -> RunUp:
    """What is looked at, from the files of a result folder.

    Raises
    ------
    InputError : no such shaft, sensor or axis
    """
    import numpy as np

    from pipelines.machine.plant import make_drivetrain
    from pipelines.scene.file import load_scene
    from pipelines.signals.analysis import DiagnosisError, channel, channel_names

    loaded = load_scene(folder / run_folder.RESOLVED)
    train = make_drivetrain(loaded.scene, loaded.source.shown)
    shafts = len(train.layout.axes)
    number = train.layout.driven if wanted.shaft is None else wanted.shaft - 1
    if number >= shafts:
        raise InputError(f"--shaft {number + 1}: the machine has {shafts} shafts. Give 1 to {shafts}.")
    with run_folder.opened_run(folder / run_folder.RESPONSE) as run:
        known = channel_names(run)
        sensor = wanted.sensor or (train.looked_for.sensor if train.looked_for.sensor in known else known[0])
        axis = wanted.axis or (train.looked_for.axis if train.looked_for.axis in AXES else AXES[-1])
        try:
            found = channel(run, sensor).sel(axis=axis)
        except DiagnosisError as error:
            raise InputError(f"--sensor: {error}") from error
        name = f"shaft_{number + 1}"
        return RunUp(
            loaded=loaded,
            place=f"{sensor} {axis}",
            units=str(found.attrs["units"]),
            shaft=name,
            orders=wanted.orders or _mesh_orders(train.layout, number),
            signal=np.asarray(found.values, dtype=float),
            time=run.time.values,
            angle=run.shaft_angle.sel(shaft=name).values,
        )


def _mesh_orders(layout: Layout, shaft: int) -> tuple[float, ...]:
    """Tooth meshing of every stage and its double, in orders of a shaft."""
    own = layout.shaft_ratios[shaft]
    first = [
        pair.pinion.teeth * layout.shaft_ratios[shafts[0]] / own
        for pair, shafts in zip(layout.pairs, layout.pair_shafts, strict=True)
    ]
    return tuple(sorted({round(k * order, 6) for order in first for k in (1, 2)}))


def natural_over_speed(loaded: LoadedScene, work: Work, speeds: np.ndarray, up_to: float) -> dict[float, np.ndarray]:
    """Natural frequencies (Hz) of the loaded machine with its gyroscopic moments, by motor speed (rad/s).

    Parameters
    ----------
    loaded, work : the scene, and what builds its steps
    speeds : (n,) of the motors, rad/s
    up_to : Hz, highest frequency
    """
    from pipelines.runs.single_results import build_machine_modes
    from pipelines.scene.file import changed

    turning = changed(loaded, {"shaft_model.gyroscopic": True})
    return {
        float(speed): build_machine_modes(turning, work, up_to=up_to, speed=float(speed))[0].frequencies
        for speed in speeds
    }


def write_run_up(folder: Path, wanted: RunUpOptions, work: Work) -> tuple[str, list[Path]]:
    """The pictures of a run-up; a table of the orders, and the files written.

    Raises
    ------
    InputError : the run holds no run-up that could be shown, or nothing can be written
    """
    import numpy as np

    from pipelines.io.user_files import writable_folder
    from pipelines.machine.plant import make_drivetrain
    from pipelines.report.figures.order_plots import campbell_figure, cuts_figure, waterfall_figure
    from pipelines.signals.orders.order_spectra import OrderError, frequency_waterfall, order_waterfall

    read = read_run_up(folder, wanted)
    target = writable_folder(wanted.out or folder)
    parts = read.signal, read.time, read.angle
    try:
        found = order_waterfall(*parts, shaft=read.shaft, revolutions=wanted.revolutions)
        shown = [order for order in read.orders if order + 2 * found.resolution < found.line[-1]]
        words = _table(found, shown, read)
    except OrderError as error:
        raise InputError(f"{folder}: {error}") from error
    title = f"{read.loaded.scene.title}: {read.place}"
    figures = {
        "orders": waterfall_figure(found, title, read.units, top=2.2 * max(shown, default=found.line[-1] / 2.2)),
        "order-cuts": cuts_figure(found, shown, title, read.units),
    }
    if wanted.campbell:
        flat = frequency_waterfall(*parts, shaft=read.shaft)
        ratio = make_drivetrain(read.loaded.scene).layout.shaft_ratios[int(read.shaft.removeprefix("shaft_")) - 1]
        speeds = np.linspace(0.0, float(found.speed.max()), SPEEDS)
        top = min(0.5 * float(flat.line[-1]), 1.3 * max(shown, default=20.0) * float(found.speed.max()) / (2 * math.pi))
        natural = natural_over_speed(read.loaded, work, speeds / ratio, top)
        by_shaft = {speed * ratio: values for speed, values in natural.items()}
        figures["campbell"] = campbell_figure(flat, by_shaft, shown, title, read.units)
    target.mkdir(parents=True, exist_ok=True)
    files = []
    for name, figure in figures.items():
        files.append(target / f"{name}.png")
        figure.savefig(files[-1], dpi=110)
    return words, files


def _table(found: Waterfall, orders: list[float], read: RunUp) -> str:
    """The highest amplitude along every order, and the speed where it is."""
    from pipelines.io.grid import Grid

    rows = []
    for order in orders:
        cut = found.cut(order)
        at = int(cut.argmax())
        speed = float(found.speed[at])
        rows.append(
            (f"{order:g}", f"{cut[at]:.3g}", f"{speed * 30 / math.pi:.0f}", f"{order * speed / (2 * math.pi):.1f}")
        )
    headers = ("order", f"highest {read.units}", "at rpm", "at Hz")
    title = f"{read.place} over the orders of {read.shaft.replace('_', ' ')}, {len(found.speed)} windows"
    return Grid(title=title, headers=headers, rows=tuple(rows)).to_text()
