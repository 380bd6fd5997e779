"""Tables that rules read: ascending abscissae followed by their levels among the numbers of an element."""

from __future__ import annotations

from fem.numerics.inner_functions import inner


@inner()
def cell_below(values, first, count, place):
    """Number (0 .. count - 2) of the cell that contains a place; outside the table, the cell at that end.

    Parameters
    ----------
    values : (k,) numbers of the element
    first, count : start of its ascending places, and how many there are, at least two
    place : the abscissa
    """
    low, high = 0, count - 1
    while high - low > 1:
        middle = (low + high) // 2
        if place < values[first + middle]:
            high = middle
        else:
            low = middle
    return low


@inner()
def interpolated(values, first, count, place):
    """Level at a place and its slope: linear between the places, constant outside.

    Parameters
    ----------
    values : (k,) numbers of the element
    first, count : start of its ascending places, and how many there are; as many levels follow them
    place : the abscissa
    """
    last = first + count - 1
    if place <= values[first]:
        return values[first + count], 0.0
    if place >= values[last]:
        return values[last + count], 0.0
    i = first + cell_below(values, first, count, place)
    slope = (values[i + 1 + count] - values[i + count]) / (values[i + 1] - values[i])
    return values[i + count] + slope * (place - values[i]), slope
