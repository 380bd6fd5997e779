"""Posterior distribution of free parameters, from the features of a recording and of a campaign.

1. Summaries. With half of the runs, a ridge regression on the levels and their squares estimates each parameter. The
   estimates of the other half are the summaries: one number per parameter, which no run of this half has influenced.
2. Emulator. With the other half, a Gaussian process describes each summary over the parameters. The covariance of the
   leave-one-out residuals contains the scatter over gears and noise, and the error of the emulator.
3. Posterior. The residuals of the recording have a multivariate t distribution with this covariance; the prior is
   uniform. The posterior is sampled by an ensemble sampler.

References
----------
Fearnhead & Prangle (2012), J. R. Stat. Soc. B 74(3), 419-474 (summaries by regression); Rasmussen & Williams (2006),
Gaussian Processes for Machine Learning, MIT Press, 5.4.2 (leave-one-out residuals); Foreman-Mackey et al. (2013), Publ.
Astron. Soc. Pac. 125(925), 306-312 (emcee).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pipelines.io.errors import InputError

WALKERS, STEPS, LENGTHS = 64, 500, 20  # a chain of 20 autocorrelation times has 64 * 20 independent samples
_MOST_STEPS = 20_000
_SEED = 1


@dataclass(frozen=True, kw_only=True)
class Emulator:
    """`summaries` of levels (recording, line), their `mean` at parameters (point, parameter) in units of the prior,
    and the `covariance` of their residuals with its degrees of `freedom`."""

    summaries: Callable[[np.ndarray], np.ndarray]
    mean: Callable[[np.ndarray], np.ndarray]
    covariance: np.ndarray
    freedom: int

    def log_likelihood(self, points: np.ndarray, observed: np.ndarray) -> np.ndarray:
        """Logarithm (point,) of the t density of observed summaries (parameter,), up to a constant."""
        residuals = observed - self.mean(points)
        squares = np.sum(residuals * np.linalg.solve(self.covariance, residuals.T).T, axis=1)
        return -0.5 * (self.freedom + len(observed)) * np.log1p(squares / self.freedom)


def check_installed() -> None:
    """Raise InputError if the libraries of the extra are missing."""
    try:
        import emcee  # noqa: F401
        import sklearn  # noqa: F401
    except ImportError as error:
        raise InputError(
            f"calibrate needs scikit-learn and emcee ({error}). Install them with: pip install 'gearcase[calibrate]'"
        ) from error


def emulator(points: np.ndarray, levels: np.ndarray) -> Emulator:
    """The emulator of a campaign.

    Parameters
    ----------
    points : (run, parameter), shares of the ranges of the prior from 0 to 1
    levels : (run, line), dB
    """
    from sklearn.linear_model import RidgeCV
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import FunctionTransformer, StandardScaler

    half = len(points) // 2
    squares = FunctionTransformer(lambda values: np.hstack([values, values**2]))
    ridge = RidgeCV(alphas=np.logspace(0, 6, 13), alpha_per_target=True)
    regression = make_pipeline(StandardScaler(), squares, StandardScaler(), ridge).fit(levels[:half], points[:half])
    summaries = regression.predict(levels[half:])
    found = [_process(points[half:], column) for column in summaries.T]
    residuals = np.stack([residual for _, residual in found], axis=1)
    return Emulator(
        summaries=regression.predict,
        mean=lambda at: np.stack([mean(at) for mean, _ in found], axis=1),
        covariance=residuals.T @ residuals / len(residuals),
        freedom=len(residuals) - points.shape[1],
    )


def _process(points: np.ndarray, values: np.ndarray) -> tuple[Callable[[np.ndarray], np.ndarray], np.ndarray]:
    """The mean of a Gaussian process over points, and its leave-one-out residuals."""
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

    smooth = RBF(np.ones(points.shape[1]), (0.1, 100.0))
    kernel = ConstantKernel(1.0, (1e-2, 1e4)) * smooth + WhiteKernel(0.1, (1e-6, 10.0))
    found = GaussianProcessRegressor(kernel, normalize_y=True, n_restarts_optimizer=1, random_state=_SEED)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # at a bound: the summary does not depend on a parameter
        found.fit(points, values)
    inverse = np.linalg.inv(found.kernel_(points))
    scaled = (values - values.mean()) / values.std()
    smooth, weights = found.kernel_.k1, inverse @ scaled

    def mean(at: np.ndarray) -> np.ndarray:  # the method `predict` takes ten times as long for few points
        return np.asarray(values.mean() + values.std() * (smooth(at, points) @ weights))

    return mean, values.std() * weights / np.diag(inverse)


def sample(emulated: Emulator, observed: np.ndarray) -> np.ndarray:
    """Independent samples (sample, parameter) of the posterior, shares of the ranges of the prior.

    Parameters
    ----------
    emulated : of the campaign
    observed : summaries (parameter,) of the recording

    Raises
    ------
    InputError : the chain does not converge
    """
    import emcee

    def log_posterior(points: np.ndarray) -> np.ndarray:
        inside = np.all((points >= 0.0) & (points <= 1.0), axis=1)
        return np.where(inside, emulated.log_likelihood(points, observed), -np.inf)

    count = len(observed)
    walkers = max(WALKERS, 2 * count)
    random = np.random.RandomState(_SEED)
    sampler = emcee.EnsembleSampler(walkers, count, log_posterior, vectorize=True)
    state = emcee.State(random.random_sample((walkers, count)), random_state=random.get_state())
    length = np.inf
    while not sampler.iteration >= LENGTHS * length:
        if sampler.iteration >= _MOST_STEPS:
            raise InputError(f"the posterior is not sampled after {_MOST_STEPS} steps. Reduce the number of free keys.")
        state = sampler.run_mcmc(state, STEPS)
        length = float(np.max(sampler.get_autocorr_time(tol=0)))
    return sampler.get_chain(discard=int(5 * length), thin=max(1, int(length / 2)), flat=True)
