"""Pictures of `gearcase inspect`: a gear pair, its mesh and its contact pattern, healthy and with its faults."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fem.contact.evaluation.contact_pattern import contact_pattern, damaged_part
from fem.contact.faults.cracked_tooth import CrackedTooth
from pipelines.machine.machine_model import MachineModel
from pipelines.report.figures.damage import crack_depth
from pipelines.report.figures.frame_files import save_figure
from pipelines.report.figures.pattern_pictures import pattern_figure
from pipelines.report.figures.picture_geometry import PlacedPair, placed_pair, shown_cycle, stage_view
from pipelines.report.figures.tooth_mesh_frames import MeshView, mesh_frames
from pipelines.steps.pair_curves import PairLaws


@dataclass(frozen=True, eq=False, kw_only=True)
class InspectedStage:
    """A stage of a machine with its mesh laws, and the pictures of it."""

    machine: MachineModel
    laws: PairLaws

    @property
    def title(self) -> str:
        """Scene, stage and teeth."""
        pair = self.laws.pair
        return f"{self.machine.title}: stage {self.laws.stage}, {pair.pinion.teeth}/{pair.wheel.teeth} teeth"

    @property
    def placed(self) -> PlacedPair:
        """The pair in its position, with the fault that is shown."""
        return placed_pair(self.machine, self.laws.stage)

    @property
    def marked(self) -> str:
        """The damaged tooth in words; "" for a healthy pair."""
        return self.laws.passages[0].name if self.laws.passages else ""

    def mesh_view(self, cycles: np.ndarray) -> MeshView:
        """The mesh under load at the positions `cycles` (frame,), in mesh cycles, healthy and with its faults."""
        found, pair = self.laws, self.laws.pair
        states = [mesh_frames("healthy", pair, found.healthy, found.force, cycles, *found.teeth())]
        if found.faults:
            teeth = found.teeth(faulty=True)
            states.append(mesh_frames(found.faults, pair, found.drive, found.force, cycles, *teeth))
        return MeshView(**self.shown(), model=found.drive.model, force=found.force, cycles=cycles, states=tuple(states))

    def shown(self) -> dict[str, Any]:
        """Title, gears and damaged tooth of a picture of the stage under load, see `PairStates`."""
        placed, law = self.placed, self.laws.healthy
        return {
            "title": self.title,
            "gears": stage_view(placed, law, in_mesh=True, damaged=False),
            "damaged": None if placed.fault is None else stage_view(placed, law, in_mesh=True),
            "marked": self.marked,
        }

    def gears_title(self) -> str:
        """Title of the overview: scene, position in mesh, load and size."""
        pair, fault = self.laws.pair, self.placed.fault
        cycle = shown_cycle(pair, None if fault is None else (fault.gear, fault.tooth or 0))
        meshes = "" if fault is None else f" (damaged tooth in mesh at {fault.tooth or 0})"
        size = f"centre distance {1000 * pair.axis_distance:.4g} mm, face width {1000 * pair.face_width:.4g} mm"
        webs = [
            f"; {name}: web {1000 * gear.web_ratio * gear.face_width:.3g} mm thick, its middle at y "
            f"{1000 * self.laws.sense * gear.web_offset:+.3g} mm"
            for name, gear in (("pinion", pair.pinion), ("wheel", pair.wheel))
            if gear.web_ratio < 1.0
        ]
        return f"{self.title}\nmesh cycle {cycle}{meshes}, load {self.laws.force:.4g} N; {size}{''.join(webs)}"

    def write_overview(self, path: Path) -> Path:
        """Write a picture of the pair, the damaged tooth enlarged, and the stiffness."""
        from pipelines.report.figures.labelled_pictures import gear_figure
        from pipelines.report.figures.render import render_gears, render_tooth
        from pipelines.steps.pictures import gear_names, stiffness_plots

        placed = self.placed
        view = stage_view(placed, self.laws.healthy)
        with ThreadPoolExecutor(2) as pool:  # each picture is rendered in a separate process
            pending = pool.submit(render_gears, view)
            pending_near = pool.submit(render_tooth, view) if view.tooth is not None else None
            curve = stiffness_plots([self.laws])[0]
            picture, near = pending.result(), None if pending_near is None else pending_near.result()
        names = gear_names(placed)
        save_figure(gear_figure(picture, curve, names, self.gears_title(), near, view.tooth), path, dpi=115)
        return path

    def write_pattern(self, path: Path) -> Path:
        """Write the contact pattern of the damaged tooth, of both neighbours of a missing one, or of pinion tooth 0."""
        found, pair, placed = self.laws, self.laws.pair, self.placed
        fault = placed.fault
        gear, tooth = ("pinion", 0) if fault is None else (fault.gear, fault.tooth or 0)
        patterns = [contact_pattern("healthy", pair, found.healthy, gear, tooth, found.force, found.teeth())]
        shown = f"tooth {tooth} of the {gear}"
        states = [] if fault is None else [(self.marked, tooth)]
        if fault is not None and fault.kind == "missing-tooth":  # the neighbours carry the load
            shown = f"neighbours of the missing {shown}"
            count = getattr(pair, gear).teeth
            states = [(f"tooth {(tooth - 1) % count}, in mesh before the missing one", tooth - 1),
                      (f"tooth {(tooth + 1) % count}, in mesh after it", tooth + 1)]  # fmt: skip
        teeth = found.teeth(faulty=True)
        patterns += [
            contact_pattern(name, pair, found.drive, gear, number, found.force, teeth) for name, number in states
        ]
        cracks = [crack_depth(one, pair.face_width)[0] for one in placed.damage if isinstance(one, CrackedTooth)]
        radius = pair.working_radii[0 if gear == "pinion" else 1]
        figure = pattern_figure(
            f"{self.title}, {shown}",
            patterns,
            load=f"load {found.force:.4g} N, model {found.drive.model}",
            gear=gear,
            damaged=damaged_part(
                pair, found.healthy, gear, [fault.gap(found.healthy, pair, gear) for fault in placed.damage]
            ),
            crack=(float(cracks[0][0]), float(cracks[0][-1])) if cracks else None,
            pitch_diameter=2 * radius,
            sense=found.sense,
        )
        save_figure(figure, path, dpi=115)
        return path
