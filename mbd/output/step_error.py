"""Error estimate of the time step: parts of the run are computed again with half the step.

For a method of second order, the error of the accelerations a_h is 4/3 of their difference from a_(h/2). All methods
have this order for gears. The exponential method has the third order only for smooth forces, and mesh forces have kinks
where a pair of teeth touches. A part starts without error. The error then increases until damping removes as much as
each step adds, so only the second half of a part is evaluated. The estimate is the RMS of the error over all parts,
relative to the RMS of the signal, after the filter of the recorder.

For a single stage, compared with steps of 2.5 us, the estimate is 0.8 to 1.5 times the true error, with loaded and
overloaded teeth, friction, rolling bearings and loss of contact. If the error is due to a few impacts in a run-up, the
parts may miss them: the factor is then 0.2 to 2.9.
"""

from __future__ import annotations

import logging

import numpy as np

from mbd.integrators.base import Block, Integrator
from mbd.output.recorder import Recorder, low_pass
from mbd.parts.checks import StepError
from mbd.parts.speed_drive import SpeedProfile

logger = logging.getLogger(__name__)

ORDER = 2
STRETCH = 160  # samples of a part
LEAST = 60  # samples; a shorter part is within the length of the filter
STRETCHES = 4  # least number of parts
SHARE = 0.012  # of a long run; with half the step the cost is twice this share


class StepCheck:
    """Error estimate of a run of ``n_steps`` steps, ``every`` of which make a sample.

    Before and after the integrator advances by at most `reach` steps, call `before` and `after` with the number of
    steps before the advance.
    """

    def __init__(self, recorder: Recorder, profile: SpeedProfile, step: float, every: int, n_steps: int) -> None:
        self._recorder, self._profile, self._step, self._every = recorder, profile, step, every
        self._n_steps = n_steps
        samples = min(STRETCH, n_steps // every)
        if samples < LEAST or recorder.signals.size == 0:
            count = 0
        else:
            most = max(1, n_steps // (2 * samples * every))
            count = min(most, max(STRETCHES, round(SHARE * n_steps / (samples * every))))
        self._length = samples * every
        middles = (np.arange(count) + 0.5) / max(count, 1) * n_steps
        self._starts = [int(at) // every * every for at in np.maximum(middles - 0.5 * self._length, 0.0)]
        self._finer: Integrator | None = None
        self._left = 0
        self._pairs: list[np.ndarray] = []
        self._error, self._signal = 0.0, 0.0

    def reach(self, done: int) -> int:
        """Steps from ``done`` to the next start or end of a part."""
        if self._finer is not None:
            return self._left
        return self._starts[0] - done if self._starts else self._n_steps

    def before(self, integrator: Integrator, done: int) -> None:
        """Start a part if one starts at this step."""
        if self._starts and done == self._starts[0]:
            del self._starts[0]
            self._finer, self._left = integrator.halved(), self._length

    def after(self, done: int, steps: int, block: Block) -> None:
        """Repeat the ``steps`` after ``done``, whose result is ``block``, with half the step."""
        if self._finer is None:
            return
        angles, speeds, accelerations = self._profile.motion(2 * done, 2 * steps, 0.5 * self._step)
        try:
            finer = self._finer.advance(angles, speeds, accelerations)
        except StepError as error:  # the run itself may converge; the part is omitted
            logger.debug("stretch given up: %s", error)
            self._finer, self._pairs = None, []
            return
        finer = finer._replace(whole=finer.whole[1::2])
        self._pairs.append(np.stack([self._recorder.unfiltered(one)[self._recorder.signals] for one in (block, finer)]))
        self._left -= steps
        if self._left == 0:
            self._finish()

    def _finish(self) -> None:
        taps = low_pass(self._every)
        values = np.concatenate(self._pairs, axis=2)
        windows = np.lib.stride_tricks.sliding_window_view(values, len(taps), axis=2)[:, :, :: self._every]
        coarse, fine = (windows @ taps)[:, :, windows.shape[2] // 2 :]
        self._error += float(np.sum((coarse - fine) ** 2))
        self._signal += float(np.sum((fine - fine.mean(axis=1, keepdims=True)) ** 2))
        self._finer, self._pairs = None, []

    @property
    def error(self) -> float:
        """RMS of the error of the accelerations relative to that of the signal; 0 without a part or a signal."""
        share = 1.0 - 0.5**ORDER  # the difference relative to the error at h
        return float(np.sqrt(self._error / self._signal)) / share if self._signal > 0.0 else 0.0
