"""Random samples of a casing with errors of its natural frequencies and with mode mixing.

In its natural modes a casing has the stiffness diag(omega^2); with errors it is

    omega_i omega_j (delta_ij + E_ij),    E_ii = (1 + e_i)^2 - 1,    E_ij ~ normal(0, sqrt(2 s_i s_j))

with the error e_i of mean m_i and standard deviation s_i. The diagonal then has the standard deviation 2 s_i. For modes
of equal frequency the distribution must not depend on the choice of their basis. It must therefore be that of the
Gaussian orthogonal ensemble, whose off-diagonal terms have half the variance of the diagonal (Mehta 2004, Random
Matrices, 2.5).

Modes are close where their bands (two standard deviations) overlap; their part of the matrix is solved for frequencies
and shapes. Other modes mix by the first-order angle E_ij omega_i omega_j / (omega_j^2 - omega_i^2); the extrapolated
frequencies already contain its effect on the frequencies.

Modes far above the evaluated frequencies contribute only their flexibility; a sample scales it by one factor.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fem.casing.uncertainty.frequency_errors import FrequencyErrors
from fem.casing.uncertainty.frequency_limits import WIDTH
from fem.casing.uncertainty.modal_form import ModalForm

NEAR = 1.5  # times the highest evaluated frequency: modes above contribute only flexibility


@dataclass(frozen=True, eq=False, kw_only=True)
class CasingSamples:
    """Sampled casings in the `near` lowest modes of the nominal casing; (sample, near) or (sample,)."""

    squares: np.ndarray  # (sample, near), 1/s2
    turns: np.ndarray  # (sample, near, near): columns are the sampled modes
    stiffening: np.ndarray  # (sample,) of all other modes, relative
    damping: np.ndarray  # (sample,) factor of all damping ratios

    def __len__(self) -> int:
        return len(self.squares)


def near_modes(form: ModalForm, highest: float) -> int:
    """Number of individually sampled modes for frequencies up to `highest` (Hz)."""
    return max(1, int((form.frequencies <= NEAR * highest).sum()))


def nominal_samples(form: ModalForm, near: int, count: int = 1) -> CasingSamples:
    """The nominal casing, `count` times."""
    return CasingSamples(
        squares=np.tile(form.squares[:near], (count, 1)),
        turns=np.tile(np.eye(near), (count, 1, 1)),
        stiffening=np.zeros(count),
        damping=np.ones(count),
    )


def sampled_frequencies(form: ModalForm, near: int, errors: FrequencyErrors, count: int, seed: int) -> CasingSamples:
    """Samples of the natural frequencies.

    Parameters
    ----------
    form, near, errors : the casing, its number of individually sampled modes, and their errors
    count : number of samples
    seed : of the random numbers
    """
    random = np.random.default_rng(seed)
    means, spreads, common = _moments(near, errors)
    rest = random.standard_normal(count)
    single = means + spreads * random.standard_normal((count, near)) + np.outer(rest, common)
    off = np.sqrt(2.0 * np.outer(spreads, spreads)) * np.triu(random.standard_normal((count, near, near)), 1)
    off = off + off.transpose(0, 2, 1)
    frequencies = form.frequencies[:near]
    bands = WIDTH * spreads * frequencies
    close = abs(frequencies[:, None] - frequencies) < bands[:, None] + bands  # their bands overlap
    found = _changed(form, near, single, off * close, errors.rest * rest)
    return replace(found, turns=_turned(form.squares[:near], off * ~close) @ found.turns)


def single_errors(form: ModalForm, near: int, errors: FrequencyErrors) -> CasingSamples:
    """The casing with mean errors, then with an added standard deviation in one mode at a time, then in the rest.

    Returns
    -------
    near + 2 casings: the effect of each error alone is the difference to the first one
    """
    means, spreads, common = _moments(near, errors)
    single = np.vstack([means, means + np.diag(spreads), means + common])
    nothing = np.zeros((near + 2, near, near))
    return _changed(form, near, single, nothing, np.r_[np.zeros(near + 1), errors.rest])


def sampled_damping(form: ModalForm, near: int, spread: float, count: int, seed: int) -> CasingSamples:
    """Samples of one log-normal factor of all damping ratios.

    Parameters
    ----------
    form, near : the casing, and its number of individually sampled modes
    spread : 5 % of the factors are below 1/(1 + spread), 5 % above 1 + spread
    count : number of samples
    seed : of the random numbers
    """
    factors = np.exp(np.log1p(spread) / NORMAL_95 * np.random.default_rng(seed).standard_normal(count))
    return replace(nominal_samples(form, near, count), damping=factors)


NORMAL_95 = 1.6448536269514722  # standard deviations below which 95 % of a normal distribution lie


def _moments(near: int, errors: FrequencyErrors) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean, individual and common standard deviation (near,) of the errors of the modes."""
    means, spreads, common = np.zeros(near), np.full(near, errors.rest_spread), np.full(near, errors.rest)
    known = slice(errors.first, min(near, errors.first + len(errors.means)))
    count = max(0, known.stop - known.start)
    means[known], spreads[known], common[known] = errors.means[:count], errors.spreads[:count], 0.0
    spreads[: errors.first], common[: errors.first] = 0.0, 0.0
    return means, spreads, common


def _turned(squares: np.ndarray, off: np.ndarray) -> np.ndarray:
    """Orthogonal matrices (sample, near, near) that rotate modes by the angles of the off-diagonal terms `off`."""
    omega, apart = np.sqrt(squares), squares - squares[:, None]
    angles = off * omega * omega[:, None] / np.where(apart == 0.0, np.inf, apart)
    whole = np.eye(len(squares))
    return np.linalg.solve(whole + 0.5 * angles, whole - 0.5 * angles)  # Cayley: orthogonal, for any angles


def _changed(form: ModalForm, near: int, single: np.ndarray, mixed: np.ndarray, rest: np.ndarray) -> CasingSamples:
    """Casings from errors of their modes.

    Parameters
    ----------
    form, near : the casing, and its number of individually sampled modes
    single : (sample, near) relative errors of the frequencies
    mixed : (sample, near, near) terms E_ij of close modes
    rest : (sample,) relative errors of all other modes
    """
    omega = np.sqrt(form.squares[:near])
    matrix = mixed * omega[:, None] * omega
    places = np.arange(near)
    matrix[:, places, places] = (omega * (1.0 + single)) ** 2
    squares, turns = np.linalg.eigh(matrix)
    return CasingSamples(squares=squares, turns=turns, stiffening=2.0 * rest, damping=np.ones(len(rest)))


def joined(parts: Sequence[CasingSamples]) -> CasingSamples:
    """All samples of several sets, in order."""
    return CasingSamples(
        squares=np.concatenate([part.squares for part in parts]),
        turns=np.concatenate([part.turns for part in parts]),
        stiffening=np.concatenate([part.stiffening for part in parts]),
        damping=np.concatenate([part.damping for part in parts]),
    )
