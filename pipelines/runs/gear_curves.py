"""Curves and summary of gear pairs while each damaged tooth is in mesh, compared with the healthy pair.

Positions are in mesh cycles from the instant at which the tooth touches at the pitch point at mid face. Pair 0 is that
of the tooth, pair 1 the following one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray

from fem.contact.contact_pressure import flank_pressure
from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.evaluation.stiffness_curve import StiffnessCurve, loaded_approach
from fem.gears.geometry import GearPair
from pipelines.engine.run_graph import Work
from pipelines.io.errors import InputError
from pipelines.io.user_files import whole_file
from pipelines.report.figures.plots import TransmissionErrors
from pipelines.scene.load_scene import LoadedScene
from pipelines.steps.pair_curves import PITCHES_SHOWN, POSITIONS, PairLaws, Passage, engagement, quantity

PER_CYCLE = 40  # positions per mesh cycle
ERROR_POSITIONS = 256  # in the mesh cycle whose mesh orders are computed
EQUAL = 1e-9  # relative difference of stiffnesses by rounding
FORMATS = (".csv", ".nc")
UNMODIFIED = "healthy, unmodified"
_CURVES = {
    "secant": ("N/m", "secant stiffness: force over the approach since first touch"),
    "tangent": ("N/m", "tangent stiffness: slope of the force over the approach"),
    "transmission_error": ("m", "approach at the force"),
    "no_load_error": ("m", "approach at first touch"),
    "tilt": ("rad", "tilt of the gears in the plane of action"),
}
_BY_PAIR = {
    "share": ("1", "part of the force that a tooth pair carries"),
    "pressure": ("Pa", "greatest Hertz pressure along the contact line of a tooth pair"),
}


@dataclass(frozen=True, kw_only=True)
class MeshState:
    """Force (N) and tilt (rad, in the face coordinate of the law) of a pair; without tilt the force is at mid face."""

    force: float
    tilt: float | None


@dataclass(frozen=True, eq=False, kw_only=True)
class _Case:
    laws: PairLaws
    state: str
    faulty: bool
    modified: bool
    passage: Passage


def machine_states(loaded: LoadedScene, work: Work) -> list[MeshState]:
    """Forces and tilts of all stages in equilibrium at the start of the motion.

    Raises
    ------
    InputError : a mesh has no load there
    EquilibriumError : there is no equilibrium at the load
    """
    from mbd.forces.flank import flank_name
    from mbd.system.statics import equilibrium
    from pipelines.runs.single_results import build_system

    system = build_system(loaded, work)
    rest = equilibrium(system)
    rows = system.rows @ rest.displacement
    found = []
    for number, (mesh, force) in enumerate(zip(system.machine.meshes, rest.mesh_force, strict=True), 1):
        if force <= 0.0:
            raise InputError(
                f"--tilt machine: the drive flank of stage {number} carries {force:.4g} N at the start of the motion. "
                "Set a load in the scene, such as load.torque_N_m, or set --torque and --tilt to numbers."
            )
        found.append(MeshState(force=float(force), tilt=float(rows[system.at(flank_name(mesh.name, 0)).start + 1])))
    return found


def gear_curves(pairs: Sequence[PairLaws], states: Sequence[MeshState]) -> xarray.Dataset:
    """Curves of every pair, healthy and while each of its damaged teeth is in mesh.

    Parameters
    ----------
    pairs, states : the pairs at every load, and the state of each

    Returns
    -------
    secant, tangent (N/m), transmission_error, no_load_error (m), tilt (rad): (case, position); share (1), pressure
    (Pa, on the active flanks): (case, position, pair); greatest_pressure (Pa, of the contact pattern), peak_to_peak
    (m, of the transmission error in the mesh cycles with the tooth in contact, within 1 %): (case,).
    Coordinates of a case: stage, state, cycle (mesh cycle at position 0), force (N), torque (N m, on the pinion).

    Raises
    ------
    LawError : a force cannot be reached
    """
    reach = round(max(PITCHES_SHOWN, *(np.ceil(max(np.abs(engagement(p.pair)))) + 1 for p in pairs)) * PER_CYCLE)
    position = np.arange(-reach, reach + 1) / PER_CYCLE
    found = []
    for laws, state in zip(pairs, states, strict=True):
        inside = _in_contact(laws.pair, position)
        near = position[inside.start - 1 : inside.stop + 1]
        for case in _cases(laws):
            options: dict[str, Any] = {
                "faulty": case.faulty,
                "modified": case.modified,
                "force": state.force,
                "tilt": state.tilt,
            }
            curve = laws.stiffness(case.passage.cycle + position, **options)
            ranged = _peak_to_peak(_error(case, state), near)
            found.append((case, curve, _pressures(case, curve), _greatest_pressure(case, state), ranged))
    cases, curves, shares, greatest, ranges = map(list, zip(*found, strict=True))
    numbers = np.unique(np.concatenate([pair for pair, _, _ in shares]))
    spread = np.zeros((2, len(cases), position.size, numbers.size))
    for i, (pair, share, pressure) in enumerate(shares):
        at = np.searchsorted(numbers, pair)
        spread[0, i, :, at], spread[1, i, :, at] = share.T, pressure.T
    torques = [curve.force * c.laws.pair.pinion.base_radius for c, curve in zip(cases, curves, strict=True)]
    data: dict[str, Any] = {
        name: (("case", "position"), np.array([getattr(c, name) for c in curves])) for name in _CURVES
    }
    data |= {name: (("case", "position", "pair"), spread[i]) for i, name in enumerate(_BY_PAIR)}
    words = _CURVES | _BY_PAIR
    along = quantity("1", "mesh cycles from contact of the tooth at the pitch point")
    return xarray.Dataset(
        {name: (dims, values, quantity(*words[name])) for name, (dims, values) in data.items()}
        | {
            "greatest_pressure": (
                "case",
                list(greatest),
                quantity("Pa", "greatest Hertz pressure of the contact pattern"),
            ),
            "peak_to_peak": ("case", ranges, quantity("m", "peak-to-peak transmission error")),
        },
        coords={
            "position": ("position", position, along),
            "pair": numbers,
            "stage": ("case", [case.laws.stage for case in cases]),
            "state": ("case", [case.state for case in cases]),
            "cycle": ("case", [case.passage.cycle for case in cases], quantity("1", "mesh cycle at position 0")),
            "force": ("case", [curve.force for curve in curves], quantity("N", "on the transverse line of action")),
            "torque": ("case", torques, quantity("N m", "on the pinion")),
        },
    )


def _cases(found: PairLaws) -> list[_Case]:
    first = Passage(name="healthy", cycle=found.cycle)
    cases = [_Case(laws=found, state=UNMODIFIED, faulty=False, modified=False, passage=first)] if found.modified else []
    return cases + [
        _Case(laws=found, state=passage.name, faulty=passage is not first, modified=True, passage=passage)
        for passage in (first, *found.passages)
    ]


def _pressures(case: _Case, curve: StiffnessCurve) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Numbers (pair,) of the loaded pairs from that of the tooth, their shares and pressures (position, pair)."""
    pair, law = case.laws.pair, case.laws.law(faulty=case.faulty, modified=case.modified)
    state = curve.cycle, curve.transmission_error, curve.tilt
    pairs, loads = LawEvaluator(law).line_loads(*state, *case.laws.teeth(faulty=case.faulty))
    loaded, pressure = loads.any(axis=2), np.zeros(curve.share.shape)
    greatest = flank_pressure(pair, law, curve.cycle, pairs, loads).max(axis=2)
    pressure[np.nonzero(loaded)[0], np.searchsorted(curve.pair, pairs[loaded])] = greatest[loaded]
    return curve.pair - round(case.passage.cycle), curve.share, pressure


def _greatest_pressure(case: _Case, state: MeshState) -> float:
    """Largest Hertz pressure (Pa) of the tooth and, if it is damaged, of its neighbours, which carry more."""
    near = math.ceil(case.laws.pair.total_contact_ratio) - 1 if case.faulty else 0
    patterns = (
        case.laws.pattern(
            tooth=round(case.passage.cycle) + number,
            faulty=case.faulty,
            modified=case.modified,
            force=state.force,
            tilt=state.tilt,
        )
        for number in range(-near, near + 1)
    )
    return max(float(np.nanmax(pattern.values, initial=0.0)) for pattern in patterns)


def _in_contact(pair: GearPair, position: np.ndarray) -> slice:
    """Positions of the whole mesh cycles in which one tooth is in mesh."""
    first, last = engagement(pair)
    at = int(np.searchsorted(position, first - 1e-9))
    return slice(at, at + round((last - first) * PER_CYCLE))


def _error(case: _Case, state: MeshState) -> Callable[[np.ndarray], np.ndarray]:
    """The transmission error (m) as a function of positions, in mesh cycles from that of the tooth."""
    evaluator = LawEvaluator(case.laws.law(faulty=case.faulty, modified=case.modified))
    teeth = case.laws.teeth(faulty=case.faulty)
    return lambda place: loaded_approach(evaluator, state.force, case.passage.cycle + place, state.tilt, *teeth)[0]


def _peak_to_peak(error: Callable[[np.ndarray], np.ndarray], position: np.ndarray) -> float:
    """Difference of the greatest and the least value at positions, of which the first and the last are neighbours only.

    The transmission error has corners where a tooth pair comes into or leaves contact, which may be between the 40
    positions of a mesh cycle. So the neighbourhood of both extrema is evaluated twice, each time at a tenth of the
    distances.
    """
    extrema, known = [], error(position)[1:-1]
    for sign in (1.0, -1.0):
        places, values, peak = position, known, 1 + int((sign * known).argmax())
        for _ in range(2):
            places = np.linspace(places[max(peak - 1, 0)], places[min(peak + 1, places.size - 1)], 21)
            values = error(places)
            peak = int((sign * values).argmax())
        extrema.append(float(values[peak]))
    return extrema[0] - extrema[1]


def gear_rows(pairs: Sequence[PairLaws], curves: xarray.Dataset) -> list[dict[str, Any]]:
    """Summary with one row for each case; means over the whole pitches in which the tooth is in mesh.

    The mean of a healthy pair is the same over any whole pitches. Least stiffness and `TE p-p` are those of the same
    interval, `share` is the greatest value of the pair of the tooth, `pressure` that of the pairs in mesh with it, too.
    """
    by_stage = {pair.stage: pair for pair in pairs}
    rows = []
    for case in range(curves.sizes["case"]):
        one = curves.isel(case=case)
        found = by_stage[int(one.stage)]
        own = one.sel(pair=0)
        one = one.isel(position=_in_contact(found.pair, one.position.values))
        soft = np.flatnonzero(one.secant.values <= float(one.secant.min()) * (1.0 + EQUAL))
        softest = min(soft, key=lambda i: abs(float(one.position[i])))  # the least stiffness recurs in every cycle
        rows.append(
            {
                "stage": found.stage,
                "pair": f"{found.pair.pinion.teeth}/{found.pair.wheel.teeth}",
                "state": str(one.state.values),
                "torque N m": float(one.torque),
                "load N": float(one.force),
                "secant N/um": float(one.secant.mean()) / 1e6,
                "tangent N/um": float(one.tangent.mean()) / 1e6,
                "least N/um": float(one.secant[softest]) / 1e6,
                "at": float(one.position[softest]),
                "TE um": float(one.transmission_error.mean()) * 1e6,
                "TE p-p um": float(one.peak_to_peak) * 1e6,
                "share %": 100 * min(float(own.share.max()), 1.0),
                "pressure MPa": float(one.greatest_pressure) / 1e6,
            }
        )
    return rows


def tilt_words(found: PairLaws, state: MeshState) -> str:
    """The tilt of a pair, "tilt 5 um over the face", and the misalignment of its scene with the same sign."""
    scale, given = 1e6 * found.sense * found.pair.face_width, found.flanks.modifications.misalignment
    words = "load centred on the face" if state.tilt is None else f"tilt {scale * state.tilt:.3g} um over the face"
    if opening := given.opening(found.pair.working_pressure_angle):
        words += f", misalignment {-scale * opening:.3g} um (positive: closer at +y)"
    return words


def transmission_errors(found: PairLaws, state: MeshState) -> TransmissionErrors:
    """The transmission error of a pair over one mesh cycle, and while each of its damaged teeth is in mesh."""
    cycle = np.arange(ERROR_POSITIONS) / ERROR_POSITIONS
    pair, place = found.pair, np.linspace(-PITCHES_SHOWN, PITCHES_SHOWN, POSITIONS)

    def error(at: np.ndarray, **state_of_pair: bool) -> np.ndarray:
        return found.stiffness(at, force=state.force, tilt=state.tilt, **state_of_pair).transmission_error

    passages = {one.name: error(one.cycle + place, faulty=True) for one in found.passages}
    return TransmissionErrors(
        stage=found.stage,
        title=f"stage {found.stage}, {pair.pinion.teeth}/{pair.wheel.teeth} teeth, model {found.drive.model}\n"
        f"{tilt_words(found, state)}",
        torque=state.force * pair.pinion.base_radius,
        cycle=cycle,
        unmodified=error(cycle, modified=False) if found.modified else None,
        actual=error(cycle),
        place=place,
        passages={"healthy": error(found.cycle + place), **passages} if passages else {},
    )


def write_curves(curves: xarray.Dataset, path: Path) -> None:
    """Write curves as netCDF, or as CSV with a row for each case and position and the units in the header."""
    with whole_file(path) as partial:
        if path.suffix.lower() == ".nc":
            partial.write_bytes(curves.to_netcdf(engine="h5netcdf"))
            return
        _table(curves).to_csv(partial, index=False, float_format="%.9g")


def _table(curves: xarray.Dataset) -> Any:
    """A data frame with a row for each case and position; columns of pairs are named by their numbers."""
    import pandas as pd

    count = curves.sizes["position"]
    columns: dict[str, Any] = {
        "stage": np.repeat(curves.stage.values, count),
        "state": np.repeat(curves.state.values, count),
        "torque [N m]": np.repeat(curves.torque.values, count),
        "force [N]": np.repeat(curves.force.values, count),
        "position [mesh cycles]": np.tile(curves.position.values, curves.sizes["case"]),
        "mesh cycle": (curves.cycle + curves.position).transpose("case", "position").values.ravel(),
    }
    columns |= {f"{name} [{units}]": curves[name].values.ravel() for name, (units, _) in _CURVES.items()}
    for name, (units, _) in _BY_PAIR.items():
        for pair in curves.pair.values:
            columns[f"{name} of pair {pair:+d} [{units}]"] = curves[name].sel(pair=pair).values.ravel()
    return pd.DataFrame(columns)
