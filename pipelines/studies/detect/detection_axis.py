"""What a study of detectability is over: a key of the scene and its values, as the command line gives them."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from typing import Any

from pipelines.datasets.plan import VariedKey
from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown
from pipelines.scene.merge import setting_value

MOST_VALUES = 100
_EXAMPLE = "Write --over faults.1.depth_mm=0.2:2:0.2, or --over faults.1.depth_mm=0.5,1,2."


@dataclass(frozen=True, kw_only=True)
class Over(VariedKey):
    """A key of the scene and its values in their order."""

    values: tuple[Any, ...]

    @property
    def first_key(self) -> str:
        """The table of the scene that it stands in."""
        return self.key.partition(".")[0]


def parse_over(text: str, option: str = "--over", example: str = _EXAMPLE) -> Over:
    """`KEY=from:to:step`, whose end belongs to it, or `KEY=a,b,c`.

    Parameters
    ----------
    text : of the command line
    option, example : name of the option, and the end of its messages

    Raises
    ------
    InputError : there is no key, a value is none, a range has no end, or there are more than MOST_VALUES
    """
    key, equals, given = text.partition("=")
    given_as = f"{option} {shown(text)}"
    if not equals or not all(part.strip() for part in key.split(".")):
        raise InputError(f"{given_as}: is not a key with values. {example}")
    parts = given.split(":")
    if len(parts) == 2:
        raise InputError(f"{given_as}: the step is missing. {example}")
    values = _range(given_as, example, parts) if len(parts) == 3 else _listed(given_as, example, given)
    if len(set(values)) < len(values):
        raise InputError(f"{given_as}: a value is given twice. Give each value once.")
    return Over(key=key.strip(), values=tuple(values))


def _range(given_as: str, example: str, parts: list[str]) -> list[float | int]:
    """Decimal arithmetic, so that 0.2:2:0.2 has 0.6 in it and not 0.6000000000000001."""
    refusal = f"{given_as}: from, to and step must be numbers, and the step not 0. {example}"
    try:
        start, end, step = (Decimal(part.strip()) for part in parts)
    except InvalidOperation:
        raise InputError(refusal) from None
    if step == 0 or not (start.is_finite() and end.is_finite() and step.is_finite()):
        raise InputError(refusal)
    steps = (end - start) / step
    if steps < 0:
        raise InputError(f"{given_as}: the step leads away from the end. Change its sign. {example}")
    if not steps < MOST_VALUES:
        raise InputError(f"{given_as}: has more than {MOST_VALUES} values. Increase the step.")
    values = [start + number * step for number in range(int(steps) + 1)]
    whole = all(
        one == one.to_integral_value() and "." not in part for one, part in zip((start, end, step), parts, strict=True)
    )
    return [int(value) if whole else float(value) for value in values]


def _listed(given_as: str, example: str, given: str) -> list[Any]:
    parts = [part.strip() for part in given.split(",")]
    if not all(parts) or len(parts) > MOST_VALUES:
        raise InputError(f"{given_as}: give 1 to {MOST_VALUES} values, separated by commas. {example}")
    try:
        values = [setting_value(part) for part in parts]
    except ValueError as error:
        raise InputError(f"{given_as}: {error}. {example}") from error
    if not all(isinstance(value, bool | int | float | str) for value in values):
        raise InputError(f"{given_as}: values must be numbers, texts, true or false. {example}")
    return values
