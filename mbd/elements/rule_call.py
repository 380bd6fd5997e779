"""Calls of rules (`mbd.elements.element`) from compiled code and from Python."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from numba import types

from fem.numerics.compiled import FLOAT, MATRIX, VECTOR, Signature, stored
from mbd.elements.element import LOG_COLUMNS, WIDTH, Answer, Motion, Rule

MOTION = types.NamedTuple((FLOAT, FLOAT, FLOAT, VECTOR, VECTOR, VECTOR, VECTOR, MATRIX, VECTOR, MATRIX), Motion)
ANSWER = types.NamedTuple((VECTOR, MATRIX, VECTOR, MATRIX, MATRIX, VECTOR, MATRIX, VECTOR), Answer)
RULE = Signature(types.none, VECTOR, MOTION, ANSWER)
call_rule: Any = RULE.call


@functools.cache
def rule_number(rule: Rule) -> int:
    """The number by which compiled code calls a rule in this process; compiled at the first call, kept on disk."""
    return RULE.cell(stored(rule.file, entry=False, **rule.options)(rule.function))


@stored(__file__)
def _evaluate_rule(chosen, values, motion, answer):
    """Call a rule from Python."""
    call_rule(chosen, values, motion, answer)


def evaluated(
    chosen: Rule, values: np.ndarray, u: np.ndarray, v: np.ndarray | None = None, angle: float = 0.0,
    seen: np.ndarray | None = None,
) -> Answer:  # fmt: skip
    """Answer of a rule for given displacements, with the motor at rest.

    Parameters
    ----------
    chosen : the rule
    values : (k,) parameters of the element, in the order of its kind
    u : (n,) displacements of its rows, m or rad
    v : (n,) their rates, m/s or rad/s; None: at rest
    angle : of the motor, rad
    seen : (k,) displacements of observed rows, m or rad; None if there are none
    """
    n = len(u)
    none, still = np.zeros(0), np.zeros(n) if v is None else np.array(v, dtype=float)
    empty, observed = np.zeros((0, WIDTH)), none if seen is None else np.array(seen, dtype=float)
    motion = Motion(angle, 0.0, 0.0, np.array(u, dtype=float), still, observed, none, empty, none, empty)
    answer = Answer(
        *(np.zeros(n), np.zeros((n, WIDTH)), np.zeros(n), np.zeros((n, WIDTH)), np.zeros((n, WIDTH))),
        *(np.zeros(n), np.zeros((n, WIDTH)), np.zeros(len(LOG_COLUMNS))),
    )
    _evaluate_rule(rule_number(chosen), np.ascontiguousarray(values, dtype=float), motion, answer)
    return answer
