"""Element kind: the definition of a nonlinear force; each kind is one file of `mbd.forces` or `mbd.excitations`.

A kind has a compiled rule. A component makes its elements, or a function finds them in a machine (a line in
`mbd.system.system.SOURCES_OF_FORCE`). An element acts on rows: the displacements u (n,) are linear combinations of the
coordinates, and a force F on a row pulls the coordinates back by row^T F. The force is the sum

    F = dU/du (elastic) + the rest (lost), dissipated power = lost . u'

of a part that follows from a potential U(u, motor angle) and a part that does not: damping, friction, an external
force. A linear reference (k0, c0) of each row belongs to the matrices of the system. The time step solves for the
difference lambda = k0 u + c0 u' - F (`mbd.elements.newton`). The loop, the equilibrium, the linearised model and the
energy balance need nothing else of a kind: they use the tables of `mbd.elements.element_table`.

The rule
--------
``rule(values, motion, answer)`` fills the arrays of `Answer` for one element; they are zero when it is called.
``values`` are the numbers of this element. The columns of slopes are the element's rows, then the rows that it reads.

The potential may also depend on the motor angle: by mesh cycle, cage or rope length. The work of that
dependence (parametric work) is the mean of log[BY_ANGLE] = dU/d angle times the step of the angle. Where dU/d angle
jumps (``audited`` of `Element`), this would be of first order only. There the parametric work is the change of U minus
the work of the force dU/du (`mbd.output.element_energy`). Every AUDIT_STEPS-th step checks that this force is the slope
of U: the rule also evaluates U, dU/du and its slopes at the rows ``before`` of the last instant and the present angle,
and the defect

    U(a_1, u_1) - U(a_1, u_0) - (F(a_1, u_0) + F(a_1, u_1)) . Du/2 + Du . (K(a_1, u_1) - K(a_1, u_0)) Du/12,

of fifth order in the step, enters the residual of the energy balance AUDIT_STEPS times.

Calls
-----
The loop calls a rule through its address (`fem.numerics.compiled.Signature`). A new kind therefore compiles only its
rule, and a rule that no machine uses is never compiled. A call costs 0.1 to 0.15 us more than code inside the loop
(rig: 8 elements, 26 us per step), or 0.5 us where references to arrays are counted, see
`fem.numerics.inner_functions.UNCOUNTED`.
A static tuple of all rules, unrolled by the compiler, is not faster and compiles every kind into every loop.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from mbd.elements.mode_words import ModeWords

LARGEST_APPROACH = 1e-2  # m: largest approach at which a contact is sought
AUDIT_STEPS = 64
WIDTH = 6  # largest number of rows that the force on a row depends on
LOG_COLUMNS = ("energy", "by_angle", "frozen_energy", "parametric")
ENERGY, BY_ANGLE, FROZEN_ENERGY, PARAMETRIC = range(len(LOG_COLUMNS))  # J, J/rad, J, J in the step that ends here
# (PARAMETRIC of an audited element is the defect)


class Motion(NamedTuple):
    """Motion of an element: input of its rule; u, v of the rows without the rigid rolling of the train."""

    angle: float  # of the motor, rad
    speed: float  # rad/s
    time: float  # s
    u: np.ndarray  # (n,) displacements of its rows
    v: np.ndarray  # (n,) rates
    seen: np.ndarray  # (k,) displacements of the rows that it observes without a force on them
    before: np.ndarray  # (n,) u of the last instant; empty: no audit in this step
    held: np.ndarray  # (n, WIDTH) stiffness used for damping; empty: the present stiffness
    read_force: np.ndarray  # (r,) elastic forces on the rows of the elements that it reads
    read_stiffness: np.ndarray  # (r, WIDTH) their stiffness


class Answer(NamedTuple):
    """Forces, stiffness and energy of an element: output of its rule."""

    elastic: np.ndarray  # (n,) dU/du
    stiffness: np.ndarray  # (n, WIDTH) d elastic/du
    lost: np.ndarray  # (n,) all other forces
    lost_by_u: np.ndarray  # (n, WIDTH) d lost/du
    lost_by_v: np.ndarray  # (n, WIDTH) d lost/dv
    frozen: np.ndarray  # (n,) dU/du at the rows `before`
    frozen_stiffness: np.ndarray  # (n, WIDTH)
    log: np.ndarray  # (LOG_COLUMNS,): ENERGY, BY_ANGLE or FROZEN_ENERGY


@dataclass(frozen=True, eq=False)
class Rule:
    """Function of a kind in ``file``, with options of the compiler; `mbd.elements.rule_call` compiles it.

    This file does not import the compiler, so that a file may define both options of a scene and a rule.
    """

    file: str
    function: Callable
    options: Mapping[str, Any]


def rule(file: str, **options: Any) -> Callable[[Callable], Rule]:
    """Decorator of the rule of a kind in ``file``; further options are passed to the compiler."""
    return lambda function: Rule(file, function, options)


class Signal(NamedTuple):
    """Channel computed from the rows of an element: motion . u + force . F; elements with the same name are added."""

    name: str
    units: str
    motion: tuple[float, ...] = ()
    force: tuple[float, ...] = ()


@dataclass(frozen=True, eq=False, kw_only=True)
class Contact:
    """One side of a contact that holds the train: while all sides are open, the train is free to move.

    The search for the equilibrium starts with all contacts pressed together; one without a load just touches.
    """

    name: str  # of the contact, common to both sides
    side: int  # 0 the side that carries the load in lifting, with the linear reference of both; 1 the other
    nominal: float  # N at rest, positive on side 0, by statics of the train; 0: no load
    touching: Callable[[np.ndarray, np.ndarray], float]  # displacement of the first row, from ``seen`` and all rows


@dataclass(frozen=True, eq=False, kw_only=True)
class Element:
    """One nonlinear force of a machine. Shapes: n rows, coordinates of the layout; SI."""

    kind: str
    name: str  # unique, e.g. "mesh_1:drive"
    part: str  # part of the energy balance; "" for forces that do no work
    words: ModeWords | None = None  # for natural modes whose energy is in its stiffness; None: it stores none
    rule: Rule
    values: np.ndarray | Sequence[float]  # numbers that the rule reads
    rows: np.ndarray  # (n, coordinate)
    row_names: tuple[str, ...]  # (n,) added to the name
    scale: tuple[float, ...]  # (n,) unit of force for convergence
    stiffness: tuple[float, ...] = ()  # (n,) linear reference k0; empty: 0
    damping: tuple[float, ...] = ()  # (n,) linear reference c0
    guess: tuple[float, ...] = ()  # (n,) lambda at the start of the search for the equilibrium
    seen: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))  # (k, coordinate) rows observed without a force
    reads: tuple[str, ...] = ()  # names of consecutive earlier elements whose forces its force depends on
    rolls: bool = False  # its rows move in rigid rolling, so that F does work on the rolling
    opens: bool = False  # it may lose contact: then the elastic force on its first row is 0
    inner_contacts: bool = False  # contacts inside it, or with the ground, open and close that `opens` does not cover
    audited: bool = False  # its parametric work is the change of U minus the work of dU/du, see above
    contact: Contact | None = None  # if the train is free to move where the contact is open
    in_matrix: bool = False  # the linearised model omits its slopes: a matrix replaces them, or they turn
    signals: tuple[Signal, ...] = ()
    ground_acceleration: tuple[float, ...] = ()  # (3,) direction of its lambda (m/s2)
    contact_lost: str = ""  # name of the counter of contacts lost
    contact_made: str = ""  # name of the counter of contacts made

    def reference(self, name: str) -> np.ndarray:
        """``stiffness``, ``damping`` or ``guess`` (n,), zeros if empty."""
        return np.array(getattr(self, name) or (0.0,) * len(self.rows))
