"""Tables that rules read: places that rise, and their levels right behind them among the numbers of an element."""

from __future__ import annotations

from fem.numerics.inner import inner


@inner()
def cell_below(values, first, count, place):
    """Number (0 .. count - 2) of the cell in which a place lies; a place outside counts to the cell at that end.

    Parameters
    ----------
    values : (k,) numbers of the element
    first, count : where its rising places begin, and how many there are, two at least
    place : the place looked for
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
    first, count : where its rising places begin, and how many there are; as many levels follow them
    place : where the level is wanted
    """
    last = first + count - 1
    if place <= values[first]:
        return values[first + count], 0.0
    if place >= values[last]:
        return values[last + count], 0.0
    i = first + cell_below(values, first, count, place)
    slope = (values[i + 1 + count] - values[i + count]) / (values[i + 1] - values[i])
    return values[i + count] + slope * (place - values[i]), slope
