"""A drawn casing as a body that can be simulated, to hold what is predicted for it against."""

from __future__ import annotations

import dataclasses

import numpy as np

from fem.casing.reduced.body import ReducedBody
from fem.casing.uncertainty.draws import CasingDraws
from fem.casing.uncertainty.modal_form import ModalForm


def drawn_body(body: ReducedBody, form: ModalForm, draws: CasingDraws, number: int) -> ReducedBody:
    """The casing with the number `number` of some draws.

    Parameters
    ----------
    body, form : the casing that they were drawn about, and its modes
    draws : the casings
    number : from 0
    """
    near, turn = draws.squares.shape[1], draws.turns[number]
    squares = np.concatenate([draws.squares[number], form.squares[near:] * (1.0 + draws.stiffening[number])])
    ratios = form.ratios.copy()
    ratios[:near] *= draws.damping[number]
    shapes = np.hstack([form.shapes[:, :near] @ turn, form.shapes[:, near:]])
    weighted = body.mass @ shapes
    return dataclasses.replace(
        body,
        stiffness=(weighted * squares) @ weighted.T,
        damping=(weighted * (2.0 * ratios * np.sqrt(squares))) @ weighted.T,
    )
