"""Element tables: all elements of a machine as flat arrays, and the compiled loops over them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numba import types

from fem.numerics.compiled import FLOAT, INTEGER_MATRIX, INTEGERS, MATRIX, VECTOR, by_address, stored
from fem.numerics.inner_functions import UNCOUNTED, inner
from mbd.elements.element import (
    BY_ANGLE,
    ENERGY,
    FROZEN_ENERGY,
    LOG_COLUMNS,
    PARAMETRIC,
    WIDTH,
    Answer,
    Element,
    Motion,
)
from mbd.elements.rule_call import call_rule, rule_number

LOG_WIDTH = len(LOG_COLUMNS)


class ElementTable(NamedTuple):
    """Constants of the elements in their order, as a tuple for compiled code; rows are counted over all elements."""

    rule: np.ndarray  # (element,) cell of the kind's rule
    row: np.ndarray  # (element + 1,) first row of each element, and the number of rows
    value: np.ndarray  # (element + 1,) first number of each element in `values`, and the number of all
    values: np.ndarray
    seen: np.ndarray  # (element, 2) first and end of the rows that it observes, counted among the observed rows
    read: np.ndarray  # (element, 2) first and end of the rows that it reads
    opens: np.ndarray  # (element,) 1 if it may lose contact
    audited: np.ndarray  # (element,) 1 if its parametric work is the change of U minus the work of its force
    pattern: np.ndarray  # (row, WIDTH) rows that the columns of its slopes refer to
    width: np.ndarray  # (row,) number of columns in use
    stiffness: np.ndarray  # (row,) reference k0
    damping: np.ndarray  # (row,) reference c0
    scale: np.ndarray  # (row,) unit of force for convergence


class Instant(NamedTuple):
    """Answers of all elements at an instant."""

    elastic: np.ndarray  # (row,) part of the forces that follows from the potentials
    lost: np.ndarray  # (row,) all other forces
    stiffness: np.ndarray  # (row, WIDTH) slopes of the elastic part by the element's own rows
    log: np.ndarray  # (element, column), see `mbd.elements.element.LOG_COLUMNS`
    frozen: np.ndarray  # (row,) elastic forces at the rows of the last instant and the motor angle of this one
    frozen_stiffness: np.ndarray  # (row, WIDTH)


TABLE = types.NamedTuple(
    (
        *(INTEGERS, INTEGERS, INTEGERS, VECTOR, INTEGER_MATRIX, INTEGER_MATRIX, INTEGERS, INTEGERS),
        *(INTEGER_MATRIX, INTEGERS, VECTOR, VECTOR, VECTOR),
    ),
    ElementTable,
)
INSTANT = types.NamedTuple((VECTOR, VECTOR, MATRIX, MATRIX, VECTOR, MATRIX), Instant)
CLOCK = types.UniTuple(FLOAT, 3)  # motor angle (rad), its speed (rad/s), time (s)


def element_table(elements: Sequence[Element], n_coordinates: int) -> tuple[ElementTable, np.ndarray]:
    """Table of the elements, and all rows (k, coordinate) that they observe."""
    first = _starts(len(element.rows) for element in elements)
    place = {element.name: i for i, element in enumerate(elements)}
    pattern, width, seen, reads = [], [], [], []
    observed: list[np.ndarray] = []
    for i, element in enumerate(elements):
        start, end = (first[place[element.reads[0]]], first[place[element.reads[-1]] + 1]) if element.reads else (0, 0)
        columns = [*range(first[i], first[i + 1]), *range(start, end)]
        pattern += [columns + [-1] * (WIDTH - len(columns))] * len(element.rows)
        width += [len(columns)] * len(element.rows)
        reads.append((start, end))
        seen.append(_observed(observed, element.seen))
    packed = [np.asarray(element.values, dtype=float) for element in elements]
    per_row = {
        name: np.concatenate([np.zeros(0), *(element.reference(name) for element in elements)])
        for name in ("stiffness", "damping", "scale")
    }
    table = ElementTable(
        rule=np.array([rule_number(element.rule) for element in elements], dtype=np.int64),
        row=first,
        value=_starts(len(values) for values in packed),
        values=np.concatenate([np.zeros(0), *packed]),
        seen=np.array(seen, dtype=np.int64).reshape(-1, 2),
        read=np.array(reads, dtype=np.int64).reshape(-1, 2),
        opens=np.array([element.opens for element in elements], dtype=np.int64),
        audited=np.array([element.audited for element in elements], dtype=np.int64),
        pattern=np.array(pattern, dtype=np.int64).reshape(-1, WIDTH),
        width=np.array(width, dtype=np.int64),
        **per_row,
    )
    return table, np.array(observed).reshape(-1, n_coordinates)


def _starts(counts: Iterable[int]) -> np.ndarray:
    return np.concatenate([[0], np.cumsum(np.fromiter(counts, dtype=np.int64))]).astype(np.int64)


def _observed(known: list[np.ndarray], rows: np.ndarray) -> tuple[int, int]:
    """First and end of ``rows`` among the known rows; new rows are added."""
    n = len(rows)
    for start in range(len(known) - n + 1 if n else 0):
        if all(np.array_equal(a, b) for a, b in zip(known[start : start + n], rows, strict=True)):
            return start, start + n
    known.extend(rows)
    return len(known) - n, len(known)


def instant(table: ElementTable) -> Instant:
    """Zero arrays for the answers of one instant."""
    m = len(table.pattern)
    return Instant(
        elastic=np.zeros(m),
        lost=np.zeros(m),
        stiffness=np.zeros((m, WIDTH)),
        log=np.zeros((len(table.rule), len(LOG_COLUMNS))),
        frozen=np.zeros(m),
        frozen_stiffness=np.zeros((m, WIDTH)),
    )


def slope_matrix(slope: np.ndarray, table: ElementTable) -> np.ndarray:
    """Matrix (m, m) of the slopes (m, WIDTH) with respect to the rows that each row's force depends on."""
    matrix = np.zeros((len(slope), len(slope)))
    for r, values in enumerate(slope):
        for k in range(table.width[r]):
            matrix[r, table.pattern[r, k]] += values[k]
    return matrix


@by_address(types.none, TABLE, CLOCK, VECTOR, VECTOR, VECTOR, MATRIX, VECTOR, MATRIX, MATRIX, INSTANT)
@stored(__file__, entry=False, **UNCOUNTED)
def row_forces(table, clock, u, v, before, held, force, slope_u, slope_v, now):
    """Residual forces lambda = k0 u + c0 u' - F and their slopes at an instant.

    k rows, of which the first m belong to elements; the others are observed.

    Parameters
    ----------
    table, clock : elements of the machine; motor angle, its speed and time, rad, rad/s and s
    u, v : (k,) and (m,) displacements and rates of the rows, m or rad, m/s or rad/s
    before : (m,) or more displacements of the last instant, see `mbd.elements.element.Motion`, or (0,)
    held : (m, WIDTH) stiffness used for damping, see `mbd.elements.element.Motion`, or (0, WIDTH)
    force : (m,) out: lambda, N or N m
    slope_u, slope_v : (m, WIDTH) out: slopes of lambda[r] by displacement and rate of the rows ``pattern[r]``
    now : out: answers of the elements
    """
    m = len(force)
    elastic, lost, stiffness, log, frozen, frozen_stiffness = now
    rules, starts, places, values, seen, read, _, _, pattern, widths, k, c, _ = table
    for r in range(m):
        elastic[r], lost[r], frozen[r] = 0.0, 0.0, 0.0
        for j in range(WIDTH):
            slope_u[r, j], slope_v[r, j], stiffness[r, j], frozen_stiffness[r, j] = 0.0, 0.0, 0.0, 0.0
    for e in range(len(rules)):
        for j in range(LOG_WIDTH):
            log[e, j] = 0.0
        a, b, first, last = starts[e], starts[e + 1], read[e, 0], read[e, 1]
        motion = Motion(
            clock[0], clock[1], clock[2], u[a:b], v[a:b], u[m + seen[e, 0] : m + seen[e, 1]], before[a:b],
            held[a:b], elastic[first:last], stiffness[first:last],
        )  # fmt: skip
        answer = Answer(
            elastic[a:b],
            stiffness[a:b],
            lost[a:b],
            slope_u[a:b],
            slope_v[a:b],
            frozen[a:b],
            frozen_stiffness[a:b],
            log[e],
        )
        call_rule(rules[e], values[places[e] : places[e + 1]], motion, answer)
    for r in range(m):
        force[r] = k[r] * u[r] + c[r] * v[r] - (elastic[r] + lost[r])
        for j in range(widths[r]):
            slope_u[r, j] = -stiffness[r, j] - slope_u[r, j]
            slope_v[r, j] = -slope_v[r, j]
            if pattern[r, j] == r:
                slope_u[r, j] += k[r]
                slope_v[r, j] += c[r]


@inner()
def follow_tangent(table, before, u, v, force, now):
    """Move the answers of the elements by their tangents to a nearby motion at which the forces are known.

    Parameters
    ----------
    table : elements of the machine, m rows
    before : (m,) displacements at the evaluation, m or rad
    u, v : (m,) or more displacements and rates nearby, m or rad, m/s or rad/s
    force : (m,) residual forces lambda there, N or N m
    now : answers of the elements, changed in place
    """
    for e in range(len(table.rule)):
        a, b = table.row[e], table.row[e + 1]
        energy = 0.0
        for r in range(a, b):
            change = 0.0
            for j in range(b - a):
                change += now.stiffness[r, j] * (u[a + j] - before[a + j])
            energy += (now.elastic[r] + 0.5 * change) * (u[r] - before[r])
            now.elastic[r] += change
        now.log[e, ENERGY] += energy
        if table.opens[e] == 1 and now.elastic[a] < 0.0:
            now.elastic[a] = 0.0
        for r in range(a, b):
            now.lost[r] = table.stiffness[r] * u[r] + table.damping[r] * v[r] - force[r] - now.elastic[r]


@inner()
def parametric_work(table, angles, u_before, u, last, now, audited):
    """Compute the parametric work (J) of a step, or the defect of audited elements (`mbd.elements.element`).

    Parameters
    ----------
    table : elements of the machine, m rows
    angles : (2,) of the motor at both ends of the step, rad
    u_before, u : (m,) or more displacements of the rows there, m or rad
    last, now : answers of the elements there; the log of ``now`` receives the work
    audited : number of steps that the defect of this one represents, 0: no audit in this step
    """
    for e in range(len(table.rule)):
        a, b = table.row[e], table.row[e + 1]
        now.log[e, PARAMETRIC] = 0.0
        if table.audited[e] == 0:
            slope = 0.5 * (last.log[e, BY_ANGLE] + now.log[e, BY_ANGLE])
            now.log[e, PARAMETRIC] = slope * (angles[1] - angles[0])
        elif audited > 0:
            work, bent = 0.0, 0.0
            for r in range(a, b):
                work += 0.5 * (now.frozen[r] + now.elastic[r]) * (u[r] - u_before[r])
                for j in range(b - a):
                    change = now.stiffness[r, j] - now.frozen_stiffness[r, j]
                    bent += change * (u[r] - u_before[r]) * (u[a + j] - u_before[a + j])
            now.log[e, PARAMETRIC] = audited * (now.log[e, ENERGY] - now.log[e, FROZEN_ENERGY] - work + bent / 12.0)


@inner()
def contact_changed(table, before, after):
    """True if an element lost or made contact between the elastic forces (row,) of two instants."""
    changed = False
    for e in range(len(table.rule)):
        if table.opens[e] == 1:
            r = table.row[e]
            changed = changed or (before[r] > 0.0) != (after[r] > 0.0)
    return changed
