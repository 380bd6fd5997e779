"""Pictures and mesh files of the von Mises stress in loaded teeth, both gears in mesh, healthy over faulty."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from fem.contact.models.solid_stress import SMOOTHED, LoadedTeeth
from fem.gears.gear import Gear
from fem.gears.geometry import GearPair
from pipelines.io.user_files import whole_file
from pipelines.report.figures.colours import CONTACT, GONE, STRESS_COLOURS
from pipelines.report.figures.frame_files import save_figure
from pipelines.report.figures.gear_frame import placed, rotated
from pipelines.report.figures.labelled_pictures import draw_axes, show
from pipelines.report.figures.plots import new_figure, plain
from pipelines.report.figures.render import render_stress
from pipelines.report.figures.tooth_mesh_frames import contact_places
from pipelines.report.figures.views import PairStates, Picture, Teeth

FORMATS = (".vtu", ".inp", ".msh", ".bdf")


@dataclass(frozen=True, eq=False, kw_only=True)
class StressView(PairStates):
    """What is shown: one or two states of the teeth, the healthy one first; `marked` names the damaged tooth."""

    note: str  # what the stress does not hold, "" if nothing
    cycle: float
    names: tuple[str, ...]
    states: tuple[Teeth, ...]
    roots: tuple[tuple[float, np.ndarray], ...]  # of each state the largest stress of the fillets, MPa, and its place


def teeth_in_mesh(pair: GearPair, found: LoadedTeeth) -> Teeth:
    """Both gears turned to their places; of a missing tooth the rim below the root circle remains."""
    teeth, count = [], 0
    for number, (name, field) in enumerate((("pinion", found.pinion), ("wheel", found.wheel)), 1):
        gear: Gear = getattr(pair, name)
        radius = pair.working_radii[number - 1]
        angle = (3 - 2 * number) * 2 * math.pi * found.cycle / gear.teeth - gear.half_thickness_angle(radius)
        centre = 0.0 if name == "pinion" else pair.axis_distance
        angle += 0.0 if name == "pinion" else math.pi
        mirror = found.hand * (3 - 2 * number)  # z is hand * zeta, and zeta of the wheel is -z
        cosine, sine = math.cos(angle), math.sin(angle)
        place = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, mirror]])
        order = slice(None) if mirror > 0 else [4, 5, 6, 7, 0, 1, 2, 3]  # a mirrored cell turned right side out
        for tooth in range(len(field.pair)):
            own = field.cells
            if found.missing[number - 1, tooth]:
                corner = np.linalg.norm(field.points[tooth, :, :2], axis=1)[own]
                own = own[corner.mean(axis=1) <= gear.root_radius]
            teeth.append(
                {
                    "points": field.points[tooth] @ place.T + [centre, 0.0, 0.0],
                    "cells": own[:, order] + count,
                    "gear": np.full(len(own), number),
                    "tooth_pair": np.full(len(own), field.pair[tooth]),
                    "displacement": field.displacement[tooth] @ place.T,
                    "von_mises": field.von_mises[tooth],
                    "root": field.root + count,
                    "root_gear": np.full(len(field.root), number),
                    "root_pair": np.full(len(field.root), field.pair[tooth]),
                }
            )
            count += len(field.points[tooth])
    return Teeth(
        **{name: np.concatenate([tooth[name] for tooth in teeth]) for name in teeth[0]},
        line_points=contact_places(pair, found.xi, found.hand * found.face),
        line_load=np.where(found.line_load > 0.0, found.line_load, np.nan),
    )


def write_teeth(teeth: Teeth, path: Path, frame: np.ndarray) -> None:
    """The hexahedra with the groups pinion and wheel; displacement (m) and von Mises stress (Pa) in .vtu and .msh.

    `frame` (4, 4) takes them to their place in the scene, see `pipelines.report.figures.gear_frame`.
    """
    from fem.casing.mesh.mesh_file import write_hexahedra

    used, cells = np.unique(teeth.cells, return_inverse=True)
    moved = rotated(teeth.displacement[used], frame)
    fields = {"displacement, m": moved, "von Mises stress, Pa": teeth.von_mises[used]}
    groups = {"pinion": teeth.gear == 1, "wheel": teeth.gear == 2}
    with whole_file(path) as partial:
        write_hexahedra(placed(teeth.points[used], frame), cells.reshape(teeth.cells.shape), fields, groups, partial)


def write_stress(view: StressView, path: Path) -> Path:
    """The picture."""
    most = 1e6 * max(stress for stress, _ in view.roots)
    pictures = [
        render_stress(view.of_state(n), view.cycle, state, most, place)
        for n, (state, (_, place)) in enumerate(zip(view.states, view.roots, strict=True))
    ]
    save_figure(stress_figure(view, pictures, most), path, dpi=115)
    return path


def stress_figure(view: StressView, pictures: Sequence[Picture], most: float) -> Figure:
    """A row per state of the teeth, one colour bar for all."""

    figure = new_figure(2.2 + 4.6 * len(pictures), 9.0)
    figure.suptitle(
        f"{plain(view.title)}\nvon Mises stress, mesh cycle {view.cycle:.4g}, load {view.force:.4g} N\n{view.model}",
        fontsize=11,
    )
    boxes = np.atleast_1d(figure.subplots(len(pictures), 1))
    for number, (axes, picture) in enumerate(zip(boxes, pictures, strict=True)):
        _draw(axes, picture, view, number)
    scale = ScalarMappable(Normalize(0.0, most / 1e6), cmap=STRESS_COLOURS)
    bar = figure.colorbar(scale, ax=list(boxes), location="bottom", shrink=0.7, aspect=40, extend="max")
    bar.set_label("von Mises stress, MPa, to the largest of the roots")
    return figure


def _draw(axes: Axes, picture: Picture, view: StressView, number: int) -> None:

    _, right, _, bottom = show(axes, picture, whole=True)
    draw_axes(axes, picture, (0.09 * right, 0.88 * bottom))
    state = view.states[number]
    greatest = state.von_mises[np.unique(state.cells)].max() / 1e6
    axes.set_title(
        f"{view.names[number]}: largest von Mises stress\n{greatest:.0f} MPa with the contact, "
        f"{view.roots[number][0]:.0f} MPa at the roots",
        fontsize=10,
        loc="left",
    )
    for gear in ("pinion", "wheel"):
        column, row = picture.places[gear]
        axes.text(column, row, gear, ha="center", va="center", fontsize=10, fontweight="bold",
                  bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.5})  # fmt: skip
    circle = axes.scatter(*picture.places["root"], s=150, linewidths=2, facecolors="none", edgecolors="cyan",
                          label="largest root stress")  # fmt: skip
    contact = Line2D([], [], color=CONTACT, lw=3, label="contact lines")
    handles: list[Artist] = [contact, circle]
    if number and view.marked:
        handles.append(Patch(color=GONE, alpha=0.6, label=view.marked))
    axes.legend(handles=handles, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, fontsize=8, frameon=False)
    note = (
        f"face width {1000 * view.gears.pair.face_width:.4g} mm along y; x, y, z 1:1, not deformed; lines, circle in "
        f"front\nstress within {SMOOTHED:g} modules of a contact line is smoothed; mesh_<stage>.png gives the Hertz "
        "pressure there"
    )
    if view.note and number == len(view.states) - 1:
        note += f"\n{view.note}"
    axes.text(0.0, -0.01, note, fontsize=8, transform=axes.transAxes, va="top")
