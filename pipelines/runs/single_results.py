"""Results of a scene that need no run: gear pairs, casing, modes of the loaded machine, and signals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from fem.casing.reduced.reduced_body import MODES_OVER_BAND
from fem.storage import shown_html
from pipelines.io.errors import InputError
from pipelines.steps.run_plan import plan_run

if TYPE_CHECKING:
    import numpy as np
    import xarray

    from fem.casing.imported.imported_casing import ImportedMatrices
    from fem.casing.mesh.choose_mesher import Geometry
    from fem.casing.mesh.mesh import CasingMesh
    from fem.casing.reduced.casing_modes import CasingModes, NaturalModes
    from fem.casing.reduced.checkup import CheckUp
    from fem.casing.reduced.reduced_body import ReducedBody
    from fem.casing.reduced.reduction_error import ErrorStatement
    from fem.casing.uncertainty.frequency_limits import FrequencyLimits
    from mbd.system.linearised import LinearModes
    from mbd.system.system import System
    from pipelines.engine.run_graph import Work
    from pipelines.engine.step import Graph, StepRecord
    from pipelines.machine.machine_model import MachineModel
    from pipelines.scene.load_scene import LoadedScene
    from pipelines.steps.pair_curves import PairLaws

_MODES_SHOWN = 20
STATIC_BAND = 1000.0  # Hz, upper limit for comparison and export of a casing model without a band


@dataclass(frozen=True, eq=False, kw_only=True)
class Casing:
    """The casing of a scene; an elastic one with its mesh, modes and checks."""

    body: ReducedBody  # mass, stiffness, damping, rows of bearings and sensors; SI
    mesh: CasingMesh | None = None
    modes: CasingModes | None = None
    natural: NaturalModes | None = None  # frequencies in Hz, effective masses
    checkup: CheckUp | None = None
    limits: FrequencyLimits | None = None  # of its frequencies, extrapolated to zero element size
    error: ErrorStatement | None = None  # against the full model, on request
    records: tuple[StepRecord, ...]  # seconds and memory of its steps
    band: float  # Hz
    participation: np.ndarray | None = None  # T^T M R (coordinate, 6) about the centre of gravity, of an elastic casing
    requested_error: float | None = None  # in half of its frequencies, from which the element size was chosen
    joint: str = ""  # joint of its halves in words; the mesh is then divided there
    housing: Geometry | ImportedMatrices | None = None

    @property
    def frequencies(self) -> np.ndarray:
        """Natural frequencies (mode,) on its mounts, Hz; also those of a rigid casing."""
        import numpy as np
        from scipy.linalg import eigh

        if self.natural is not None:
            return self.natural.frequencies
        squares = eigh(self.body.stiffness, self.body.mass, eigvals_only=True)
        return np.sqrt(np.maximum(squares, 0.0)) / (2 * math.pi)

    @property
    def bands(self) -> np.ndarray:
        """Half widths (mode,) of the uncertainty bands of `frequencies`, Hz; NaN if unknown.

        The band of a mode contains its extrapolated frequency with the uncertainty band of that.
        """
        import numpy as np

        from fem.casing.uncertainty.extrapolation import RIGID_MOTIONS

        found = np.full(len(self.frequencies), np.nan)
        if self.limits is not None and self.modes is not None:
            corrected = self.limits.frequencies * (1.0 - self.limits.correction)
            relative = (abs(self.limits.limits - corrected) + self.limits.bands) / corrected
            first = RIGID_MOTIONS if self.modes.ground == "springs" else 0
            inside = found[first:][: len(relative)]
            inside[:] = relative[: len(inside)] * self.frequencies[first:][: len(inside)]
        return found

    def shape(self, mode: int) -> np.ndarray:
        """Displacement (node, axis) of natural mode 0, 1, ... at the nodes `modes.nodes`, with a greatest length of 1.

        Raises
        ------
        InputError : the casing has no finite-element mesh, or there is no such mode
        """
        if self.modes is None or self.natural is None or not len(self.modes.nodes):
            raise InputError('casing: no mode shapes without finite elements. Set casing.model = "craig-bampton".')
        if not 0 <= mode < len(self.natural.frequencies):
            raise InputError(f"mode {mode}: there is no such mode. Set 0 to {len(self.natural.frequencies) - 1}.")
        return mode_shapes(self.modes, self.natural, [mode])[0]

    def __repr__(self) -> str:
        return f"<{self._words()}>"

    def _words(self) -> str:
        return f"Casing: {len(self.body.mass)} coordinates, {len(self.frequencies)} natural modes on its feet"

    def _repr_html_(self) -> str:
        """The lowest natural frequencies with their uncertainty bands, for a notebook."""
        found = self.frequencies
        bands = (float(one) if one == one else None for one in self.bands)
        rows = zip(range(1, _MODES_SHOWN + 1), map(float, found), bands, strict=False)
        return shown_html.table(self._words(), ("mode", "Hz", "+- Hz"), rows)


def mode_shapes(modes: CasingModes, natural: NaturalModes, numbers: Sequence[int]) -> list[np.ndarray]:
    """Displacements (node, 3) of natural modes, scaled to a greatest length of 1."""
    import numpy as np

    shapes = []
    for mode in numbers:
        shape = modes.basis @ natural.vectors[:, mode]
        shapes.append(shape / np.linalg.norm(shape, axis=1).max())
    return shapes


def scene_graph(loaded: LoadedScene) -> tuple[Graph, MachineModel]:
    """The steps of a scene without its control, and its machine in SI."""
    plan = plan_run(loaded, with_control=False, both_loads=False)
    return plan.graph, plan.machine


def build_pairs(loaded: LoadedScene, work: Work) -> tuple[PairLaws, ...]:
    """The mesh laws of every gear pair of a scene."""
    from pipelines.steps.pair_curves import law_names, pair_laws

    graph, machine = scene_graph(loaded)
    outcome = work.build(graph, law_names(machine))
    return pair_laws(machine, outcome.value)


def build_casing(loaded: LoadedScene, work: Work, *, error_check: bool = False) -> Casing:
    """The reduced casing of a scene; `error_check` compares it with the full model, which doubles the computing time.

    Raises
    ------
    InputError : an error check is requested for a casing that has no full model
    """
    from pipelines.engine.step import Graph
    from pipelines.machine.joint import joint_words
    from pipelines.steps.machine_steps import casing_step

    graph, machine = scene_graph(loaded)
    structure, limit = machine.structure, machine.casing.limit
    band = STATIC_BAND if limit is None else limit / MODES_OVER_BAND
    elastic = "casing modes" in graph.steps
    meshed = elastic and "casing mesh" in graph.steps
    coarser = graph.steps["casing"].takes.get("coarser", ())
    requested = ["casing", *(["casing mesh"] if meshed else []), *(["casing modes"] if elastic else [])]
    requested += coarser
    if error_check:
        check = machine.casing.error_check(structure, band)
        if check is None:
            raise InputError(machine.casing.no_full_model)
        graph = Graph([*graph, casing_step(check)])
        requested.append("casing error")
    outcome = work.build(graph, requested)
    body, found = outcome.value("casing"), dict[str, Any]()  # of an elastic casing
    if elastic:
        from fem.casing.reduced.casing_modes import kept_modes, natural_modes

        modes, checkup = outcome.value("casing modes")[:2]
        spec = graph.steps["casing"].spec
        chosen = kept_modes(modes, modes.springs(spec.mounts), limit=limit, frequency_error=spec.frequency_error)
        found = {
            "modes": modes,
            "checkup": checkup,
            "natural": natural_modes(modes, spec.mounts, limit=limit, stiffness_factor=body.stiffness_factor),
            "participation": chosen.basis.T @ modes.participation,
        }
        if coarser:
            from fem.casing.uncertainty.extrapolation import measured_limits

            found["limits"] = measured_limits(modes, [outcome.value(name) for name in coarser])
    mesh = outcome.value("casing mesh") if meshed else None
    words = ""
    if mesh is not None and structure.joint is not None and structure.material is not None:
        from fem.casing.parts.bolted_joint import contact_areas
        from fem.casing.parts.split_mesh import split_mesh

        joint = structure.joint
        split = split_mesh(mesh, joint.plane)
        mesh, shares = split.mesh, contact_areas(joint, split) / joint.bolt.contact_area
        low, high = (f"{100 * min(share, 1.0):.0f} %" for share in (shares.min(), shares.max()))
        words = f"{joint_words(joint, structure.material)}; in contact on {low} to {high} of their rings"
    return Casing(
        body=body,
        mesh=mesh,
        joint=words,
        **found,
        error=outcome.value("casing error") if error_check else None,
        requested_error=getattr(machine.casing, "target_error", 0.0) or None,
        records=tuple(record for record in outcome.records if "casing" in record.name),
        band=band,
        housing=structure.housing,
    )


def build_machine_modes(
    loaded: LoadedScene, work: Work, *, up_to: float = 10e3, cycle: float | None = None, speed: float = 0.0
) -> tuple[LinearModes, float]:
    """Natural modes of the loaded machine, and the mesh cycle of stage 1 at which they are computed.

    Parameters
    ----------
    loaded, work : the scene, and the executor of its steps
    up_to : upper limit of the frequencies, Hz
    cycle : mesh cycle of stage 1; by default that of the start
    speed : of the motors, rad/s, for losses and gyroscopic moments
    """
    from mbd.system.linearised import linear_modes
    from mbd.system.system import DEFAULT_BAND

    system = build_system(loaded, work, max(DEFAULT_BAND, 2 * up_to), cycle)
    return linear_modes(system, up_to=up_to, speed=speed), system.machine.meshes[0].cycle_at_start


def build_system(loaded: LoadedScene, work: Work, band: float | None = None, cycle: float | None = None) -> System:
    """The machine of a scene in its casing.

    Parameters
    ----------
    loaded, work : the scene, and the executor of its steps
    band : Hz, see `assemble_system`
    cycle : mesh cycle of stage 1 to which the machine is rotated; by default that of the start
    """
    from mbd.system.linearised import turned
    from pipelines.machine.system_assembly import assemble_machine, assemble_system

    graph, machine = scene_graph(loaded)
    outcome = work.build(graph, [*machine.law_names, "casing"])
    train = assemble_machine(machine.parts, [outcome.value(name) for name in machine.law_names])
    if cycle is not None:
        first = train.meshes[0]
        train = turned(train, (cycle - first.cycle_at_start) / first.cycles_per_radian)
    return assemble_system(train, outcome.value("casing"), machine.recorded, band)


def build_signals(loaded: LoadedScene, work: Work) -> xarray.Dataset:
    """The signals of a scene with the contents of response.nc, without writing a file."""
    from pipelines.signals.motion_warnings import log_warnings
    from pipelines.signals.response import make_response

    graph, machine = scene_graph(loaded)
    motion = work.build(graph, ["simulate"]).value("simulate")
    log_warnings([motion])
    return make_response(motion, machine.labels)
