"""What an element kind is: everything that makes a nonlinear force, a file of `mbd.forces` each.

A kind has a compiled rule. A component brings its elements, or a function finds them in a machine (a line in
`mbd.system.system.SOURCES_OF_FORCE`). An element acts on rows: u (n,) are linear readings of the coordinates, and a
force F on a row pulls the coordinates back by row^T F. It is the sum

    F = dU/du (elastic) + the rest (lost), dissipated power = lost . u'

of a part that follows from a potential U(u, motor angle) and of all that does not: damping, friction, an outside
force. A linear reference (k0, c0) of each row is part of the system's matrices; what is left,
lambda = k0 u + c0 u' - F, is what the time step solves for (`mbd.elements.newton`). The rest of this package asks for
nothing else of a kind: the loop, the equilibrium, the linearised view and the energy balance go by the tables of
`mbd.elements.table`.

The rule
--------
``rule(values, motion, answer)`` fills the views of `Answer` for one element; they are zero when it is called.
``values`` are the numbers that the kind packed for it. The columns of slopes are the element's own rows, then those it
reads.

The potential may depend on the motor angle besides the rows: by mesh cycle, cage or rope length. The work of that
dependence (parametric work) is the mean of log[BY_ANGLE] = dU/d angle times the step of the angle. Where dU/d angle
jumps (``audited`` of `Element`), such a sum would be first order. There the parametric work is what is left of the
change of U when the work of the force dU/du is taken off (`mbd.output.element_energy`), and whether that force is the
slope of U is checked at every AUDIT_STEPS-th step: the kind is asked for U, dU/du and its slopes at the rows ``before``
of the last instant and the angle of now, and the defect

    U(a_1, u_1) - U(a_1, u_0) - (F(a_1, u_0) + F(a_1, u_1)) . Du/2 + Du . (K(a_1, u_1) - K(a_1, u_0)) Du/12,

of fifth order in the step, counts AUDIT_STEPS times in the residual of the energy balance.

Calls
-----
The loop calls a rule through its address (`fem.numerics.compiled.Signature`). It knows no kind, a new one recompiles
nothing but itself, and what no machine uses is never compiled. A call costs 0.1 to 0.15 us more than code that is part
of the loop (rig: 8 elements, 26 us per step), or 0.5 us where references to arrays are counted
(`fem.numerics.inner.UNCOUNTED`). A static tuple of all rules that the compiler unrolls took no less time per step
(33 us against 29 to 33 us on a busy machine) and compiles every kind into every loop.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from mbd.elements.mode_words import ModeWords

LARGEST_APPROACH = 1e-2  # m: contacts that would have to give way further are not followed
AUDIT_STEPS = 64
WIDTH = 6  # rows at most that the force on a row depends on
LOG_COLUMNS = ("energy", "by_angle", "frozen_energy", "parametric")
ENERGY, BY_ANGLE, FROZEN_ENERGY, PARAMETRIC = range(len(LOG_COLUMNS))  # J, J/rad, J, J in the step that ends here
# (of an audited element, the last is the defect)


class Motion(NamedTuple):
    """Where an element is; u, v of the rows without the rolling of the train."""

    angle: float  # of the motor, rad
    speed: float  # rad/s
    time: float  # s
    u: np.ndarray  # (n,) displacements of its rows
    v: np.ndarray  # (n,) rates
    seen: np.ndarray  # (k,) displacements of the rows that it observes only
    before: np.ndarray  # (n,) u of the last instant; empty: no audit in this step
    held: np.ndarray  # (n, WIDTH) stiffness that damping takes instead of the present one; empty: the present one
    read_force: np.ndarray  # (r,) elastic forces on the rows of the elements that it reads
    read_stiffness: np.ndarray  # (r, WIDTH) their stiffness


class Answer(NamedTuple):
    """What a rule fills in."""

    elastic: np.ndarray  # (n,) dU/du
    stiffness: np.ndarray  # (n, WIDTH) d elastic/du
    lost: np.ndarray  # (n,) all other force
    lost_by_u: np.ndarray  # (n, WIDTH) d lost/du
    lost_by_v: np.ndarray  # (n, WIDTH) d lost/dv
    frozen: np.ndarray  # (n,) dU/du at the rows `before`
    frozen_stiffness: np.ndarray  # (n, WIDTH)
    log: np.ndarray  # (LOG_COLUMNS,): ENERGY, BY_ANGLE or FROZEN_ENERGY


@dataclass(frozen=True, eq=False)
class Rule:
    """The function of a kind in ``file``, with options of the compiler; `mbd.elements.rule_call` compiles it.

    This file does not import the compiler, so that a file may define both options of a scene and a rule.
    """

    file: str
    function: Callable
    options: Mapping[str, Any]


def rule(file: str, **options: Any) -> Callable[[Callable], Rule]:
    """Decorator of a kind's rule in ``file``; further options are those of the compiler."""
    return lambda function: Rule(file, function, options)


class Signal(NamedTuple):
    """A channel made of an element's rows: motion . u + force . F; elements with the same name add up."""

    name: str
    units: str
    motion: tuple[float, ...] = ()
    force: tuple[float, ...] = ()


@dataclass(frozen=True, eq=False, kw_only=True)
class Contact:
    """A side of a contact that holds the train: where it is open, the train is free to move.

    The equilibrium is sought from all of them pressed together; one that carries nothing rests where it just touches.
    """

    name: str  # of the pair
    side: int  # 0 the side that carries the load in lifting, with the linear reference of both; 1 the other
    nominal: float  # N at rest, positive on side 0, by statics of the train; 0: it carries nothing
    touching: Callable[[np.ndarray, np.ndarray], float]  # displacement of the first row, from ``seen`` and all rows


@dataclass(frozen=True, eq=False, kw_only=True)
class Element:
    """One element of a machine. Shapes: n rows, coordinates of the layout; SI."""

    kind: str
    name: str  # of this element alone, e.g. "mesh_1:drive"
    part: str  # whose energy it counts to; "" for forces that do no work
    words: ModeWords | None = None  # of natural modes whose energy is in its stiffness; None: it has none
    rule: Rule
    values: np.ndarray | Sequence[float]  # numbers that the rule reads
    rows: np.ndarray  # (n, coordinate)
    row_names: tuple[str, ...]  # (n,) behind the name
    scale: tuple[float, ...]  # (n,) force that counts as 1 for convergence
    stiffness: tuple[float, ...] = ()  # (n,) linear reference k0, 0 if left out
    damping: tuple[float, ...] = ()  # (n,) linear reference c0
    guess: tuple[float, ...] = ()  # (n,) lambda from which the equilibrium is sought
    seen: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))  # (k, coordinate) rows that are observed only
    reads: tuple[str, ...] = ()  # names of elements before it, one after another, whose forces its own follow
    rolls: bool = False  # its rows move while the train rolls, so that F does work on the rolling
    opens: bool = False  # it may lose contact, which is when the elastic force on its first row is 0
    inner_contacts: bool = False  # contacts inside it, or with the ground, open and close unseen by `opens`
    audited: bool = False  # its parametric work is what dU/du leaves of the change of U, see above
    contact: Contact | None = None  # if the train is without a hold where it is open
    in_matrix: bool = False  # its slopes are no part of the linearised view: a matrix stands for them, or they turn
    signals: tuple[Signal, ...] = ()
    shakes: tuple[float, ...] = ()  # (3,) where its lambda (m/s2) accelerates the ground, which accelerometers read too
    lets_go: str = ""  # counter of contacts lost
    touches: str = ""  # counter of contacts made

    def reference(self, name: str) -> np.ndarray:
        """``stiffness``, ``damping`` or ``guess`` (n,), zeros if left out."""
        return np.array(getattr(self, name) or (0.0,) * len(self.rows))
