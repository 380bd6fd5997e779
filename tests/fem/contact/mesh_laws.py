"""A made-up mesh law with every feature: Hertz term, neighbours, gaps, fractions, helix; its one potential."""

import numpy as np

from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.faults.missing_tooth import MissingTooth
from fem.contact.law import MeshLaw
from fem.contact.slice_means import slice_means


def line_loads(evaluator, *state, **teeth):
    """Numbers (n,) of the loaded pairs and their line loads (n, slice) at one state."""
    (pairs,), (loads,) = evaluator.line_loads(*state, **teeth)
    loaded = loads.any(axis=1)
    return pairs[loaded], loads[loaded]


def made_up_law(*, hertz=4e-12, neighbours=2, slices=7, helix=0.6, n=201, **changes):
    """Pairs touch over 1.6 pitches, edges beyond; about four candidates meet in a slice, up to three of them loaded."""
    xi = np.linspace(-1.5, 1.5, n)
    face = ((np.arange(slices) + 0.5) / slices - 0.5) * 0.03
    compliance = 6e-11 * (1 + 0.6 * xi**2)
    gap = 2e-4 * (np.clip(xi - 0.8, 0, None) ** 2 + np.clip(-0.8 - xi, 0, None) ** 2)
    gap[[0, 1, -2, -1]] = np.inf
    between = np.array([0.2 * compliance * (1 - 0.2 * xi), 0.05 * compliance])[:neighbours]
    data = {
        "model": "made up",
        "flank": "drive",
        "face_coordinate": face,
        "slice_width": np.full(slices, 0.03 / slices),
        "cycle_shift": helix * face / 0.03,
        "cycle_sign": 1,
        "cycle_offset": 0.0,
        "position_start": xi[0],
        "position_step": xi[1] - xi[0],
        "compliance": compliance,
        "contact_slope": hertz,
        "contact_offset": 25 + 0.5 * np.sin(2 * xi),
        "neighbour_compliance": between,
        "gap": gap,
        "fraction": np.clip(np.minimum((xi + 1.45) / 0.3, (1.42 - xi) / 0.3), 0, 1),
        "base_pitch": 6e-3,
        "pinion_teeth": 20,
        "wheel_teeth": 55,
        "wheel_tooth_offset": 0,
    }
    return MeshLaw(**(data | changes))


XI = np.linspace(-1.5, 1.5, 201)
TERMS = {  # coupling along the face
    "spread_compliance": 3e-11 * (1 + 0.3 * XI + 0.2 * XI**2),
    "spread_length": 4e-3,
    "body_compliance": 8e-10,
    "skew_compliance": 1e-8,
    "tilt_compliance": 4e-6,
}
PLAIN = made_up_law(slices=15, neighbours=1)
TWO = PLAIN.replaced(gap=np.where(np.abs(XI) < 0.9, PLAIN.gap, np.inf))  # at most two pairs in a slice


def gap_of_slice(law, xi):
    """Mean gap, rise, even part and closing load (n,) of slices about xi."""
    means = slice_means(law)
    first, last = law.position_start, law.position_start + law.position_step * (law.gap.size - 1)
    grid = np.linspace(first, last, means.gap.size)
    return [np.interp(xi, grid, table) for table in means]


def spared_approach(f, rise, even, whole):
    """What a slice that carries f (n,) approaches by less than one wholly in contact: a r of `part_contact`."""
    u = np.divide(f, whole, out=np.ones_like(f), where=whole > f)
    return rise * ((1 - np.sqrt(even**2 + (1 - even**2) * u)) / (1 - even)) ** 2


def missing_tooth(clearance, tooth):
    """The clearances (tooth,) with one tooth broken off."""
    broken = np.array(clearance, dtype=float)
    broken[tooth] = MissingTooth.clearance
    return broken


def potential_errors(law, states, pinion=None, wheel=None):
    """How far F, M and all slopes are from the derivatives of the energy: (6, state), each over its largest value.

    Central differences, so that a state on a kink (a pair just touching, a grid point of the tables) is off.
    """
    cycle, delta, psi = states
    evaluator = LawEvaluator(law)

    def slope(field, dd=0.0, dp=0.0):
        ahead = evaluator.evaluate(cycle, delta + dd, psi + dp, pinion, wheel)
        behind = evaluator.evaluate(cycle, delta - dd, psi - dp, pinion, wheel)
        return (getattr(ahead, field) - getattr(behind, field)) / (2 * (dd + dp))

    found = evaluator.evaluate(cycle, delta, psi, pinion, wheel)
    pairs = (
        (found.force, slope("energy", dd=1e-10)),
        (found.moment, slope("energy", dp=1e-8)),
        (found.stiffness, slope("force", dd=1e-10)),
        (found.cross_stiffness, slope("moment", dd=1e-10)),
        (found.cross_stiffness, slope("force", dp=1e-8)),
        (found.tilt_stiffness, slope("moment", dp=1e-8)),
    )
    return np.array([np.abs(exact - numeric) / np.abs(exact).max() for exact, numeric in pairs])
