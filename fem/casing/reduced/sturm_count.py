"""Sturm-sequence count of the fixed-interface modes, with which a reduction is verified."""

from __future__ import annotations

import math

import scipy.sparse as sp

from fem.casing.reduced.lanczos import EigenError
from fem.casing.reduced.reduction import Interface


def count_fixed_modes(interface: Interface, K: sp.spmatrix, M: sp.spmatrix, highest: float) -> int:
    """Sturm-sequence count of the fixed-interface modes below `highest`: negative eigenvalues of K - s M.

    One further factorisation verifies that an eigensolution has missed no mode (theorem of Sylvester; used by Grimes,
    Lewis & Simon 1994). If the limit coincides with an eigenvalue, it is lowered by a millionth.

    Parameters
    ----------
    interface, K, M : those of `reduce_body`
    highest : Hz

    Raises
    ------
    EigenError : the limit coincides with an eigenvalue, even when lowered
    """
    from fem.numerics.multifrontal import NearlySingularError, count_negative

    reason = ""
    for step in range(3):
        shift = (2.0 * math.pi * highest * (1.0 - 1e-6 * step)) ** 2
        try:
            return count_negative(interface.factor.plan, K, M, shift, interface.rows)
        except NearlySingularError as error:
            reason = str(error)
    raise EigenError(f"the modes below {highest:g} Hz cannot be counted ({reason}); choose another band")
