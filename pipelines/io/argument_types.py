"""Types of command line arguments; an ArgumentTypeError explains why a value is not allowed."""

from __future__ import annotations

import argparse
import math
from typing import TypeVar

MOST = 1000  # upper bound of all counts
T = TypeVar("T")


def _accepted(value: T, accepted: bool, words: str) -> T:
    """The value, or ArgumentTypeError with `words` if it is not accepted."""
    if not accepted:
        raise argparse.ArgumentTypeError(words)
    return value


def path(text: str) -> str:
    """A name that a file can have."""
    from pipelines.io.errors import InputError
    from pipelines.io.user_files import checked_path

    try:
        checked_path(text)
    except InputError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
    return text


def count(text: str) -> int:
    """A whole number from 1."""
    inside = text.isdecimal() and len(text) <= len(str(MOST)) and 1 <= int(text) <= MOST
    return int(_accepted(text, inside, f"{text!r} is not a whole number from 1 to {MOST}"))


def mode_number(text: str) -> int | str:
    """A whole number from 1, or the word "all"."""
    return text if text == "all" else count(text)


def several(text: str) -> int:
    """A whole number from 2."""
    return _accepted(count(text), count(text) >= 2, f"{text!r} is not a whole number from 2 to {MOST}")


def number(text: str) -> float:
    """A finite number."""
    from pipelines.io.shown_text import number_of

    parts = text.replace(";", ",").split(",")
    remedy = f". Separate numbers by blanks: {' '.join(parts)}" if len(parts) > 1 and all(parts) else ""
    value = number_of(text)
    return _accepted(value, math.isfinite(value), f"{text!r} is not a finite number{remedy}")


def positive(text: str) -> float:
    """A number above 0."""
    return _accepted(number(text), number(text) > 0, f"{text!r} is not a number above 0")


def tilt(text: str) -> float | str:
    """A finite number, or the word "balanced" or "machine"."""
    try:
        return text if text in ("balanced", "machine") else number(text)
    except argparse.ArgumentTypeError as error:
        raise argparse.ArgumentTypeError(f"{error}, balanced or machine") from None


def picture(text: str) -> str:
    """The file name of a picture; .png is added to a name without suffix."""
    path(text)
    suffix = text.rpartition(".")[2].lower() if "." in text.rpartition("/")[2] else ""
    words = f"{text!r} does not end in .png, .svg or .pdf"
    return _accepted(text if suffix else f"{text}.png", suffix in ("", "png", "svg", "pdf"), words)


def share(text: str) -> float:
    """A share up to 1, as a number or in percent."""
    value = positive(text.removesuffix("%")) / 100 if text.endswith("%") else positive(text)
    return _accepted(value, value <= 1.0, f"{text!r} is above 1 (100 %); for 2 per cent write 2%")


def seconds(text: str) -> float:
    """A time in seconds, with or without the letter s."""
    try:
        return positive(text.removesuffix("s"))
    except argparse.ArgumentTypeError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a time above 0 in s, as in 10 or 10s") from None


def days(text: str) -> float:
    """Days from 0."""
    from pipelines.io.shown_text import number_of

    value = number_of(text)
    return _accepted(value, 0 <= value < math.inf, f"{text!r} is not a number of days, 0 or more")


def from_zero(text: str) -> float:
    """A finite number from 0."""
    return _accepted(number(text), number(text) >= 0, f"{text!r} is negative; give 0 or more")


def part(text: str) -> float:
    """A share from 0 to below 1, as a number or in percent."""
    value = number(text.removesuffix("%")) / 100 if text.endswith("%") else number(text)
    return _accepted(value, 0 <= value < 1, f"{text!r} is not a fraction from 0 to below 1")


def whole(text: str) -> int:
    """A whole number from 0."""
    return int(_accepted(text, text.isdecimal() and len(text) <= 18, f"{text!r} is not a whole number of 0 or more"))
