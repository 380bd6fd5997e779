"""Steps of a casing: each stores the result of one of its stages, see `fem.casing.models.stage`; its sensors."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from fem.casing.models.stage import CasingError, CasingInputError, Stage
from pipelines.io.errors import InputError, WorkError

if TYPE_CHECKING:
    from fem.casing.reduced.reduced_body import ReducedBody

_SENSOR_OFF = 0.005  # m: how far from its position a sensor may measure without a warning


def build(stage: Stage, **taken: Any) -> Any:
    """The result of a stage."""
    try:
        return stage.build(**taken)
    except CasingInputError as error:
        raise InputError(str(error)) from error
    except CasingError as error:
        raise WorkError(str(error)) from error


def casing_warnings(body: ReducedBody, positions: Mapping[str, tuple[float, float, float]]) -> Iterator[str]:
    """Warnings of a casing: those of its files, and sensors that measure elsewhere than stated, or not along all axes.

    They come from the stored result, so a casing from the cache has them too.

    Parameters
    ----------
    body : the reduced casing
    positions : m, of the sensors in the scene, by name
    """
    import numpy as np

    yield from body.notes

    places = dict(zip(body.point_names, body.point_positions, strict=True))
    moving = dict(zip(body.row_names, np.abs(body.rows).max(axis=1, initial=0.0) > 0.0, strict=True))
    for name, position in positions.items():
        if name in places and (distance := float(np.linalg.norm(places[name] - np.array(position)))) > _SENSOR_OFF:
            yield (
                f"{name} measures at the nearest point of the casing, {1000 * distance:.3g} mm from its position_mm. "
                "Correct the position, or, for matrices of another program, add a node there"
            )
        if still := [axis for axis in "xyz" if not moving.get(f"{name}:u{axis}", True)]:
            yield (
                f"{name} reads 0 along {' and '.join(still)}: its node has no equation for them. Add these equations "
                "to the matrices, or set casing.housing.rows_file"
            )
