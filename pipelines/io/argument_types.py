"""Values of command line arguments; ArgumentTypeError says what is wrong with one."""

from __future__ import annotations

import argparse
import math

MOST = 1000  # of anything that is counted


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
    if not text.isdecimal() or len(text) > len(str(MOST)) or not 1 <= int(text) <= MOST:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from 1 to {MOST}")
    return int(text)


def mode_number(text: str) -> int | str:
    """A whole number from 1, or the word "all"."""
    return text if text == "all" else count(text)


def several(text: str) -> int:
    """A whole number from 2."""
    if count(text) < 2:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from 2 to {MOST}")
    return int(text)


def number(text: str) -> float:
    """A finite number."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is not a finite number")
    return value


def positive(text: str) -> float:
    """A number above 0."""
    if number(text) <= 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number above 0")
    return number(text)


def tilt(text: str) -> float | str:
    """A finite number, or the word "balanced" or "machine"."""
    try:
        return text if text in ("balanced", "machine") else number(text)
    except argparse.ArgumentTypeError as error:
        raise argparse.ArgumentTypeError(f"{error}, nor balanced or machine") from None


def picture(text: str) -> str:
    """The file of a picture; without an ending it gets .png."""
    path(text)
    suffix = text.rpartition(".")[2].lower() if "." in text.rpartition("/")[2] else ""
    if suffix not in ("", "png", "svg", "pdf"):
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a picture format that can be written; end it in .png, .svg or .pdf"
        )
    return text if suffix else f"{text}.png"


def share(text: str) -> float:
    """A share, as a number or in per cent."""
    return positive(text.removesuffix("%")) / 100 if text.endswith("%") else positive(text)


def seconds(text: str) -> float:
    """Seconds, with or without the letter s."""
    try:
        return positive(text.removesuffix("s"))
    except argparse.ArgumentTypeError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a time above 0 in s, as in 10 or 10s") from None


def days(text: str) -> float:
    """Days from 0."""
    try:
        found = float(text)
    except ValueError:
        found = -1.0
    if not 0 <= found < float("inf"):
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of days, 0 or more")
    return found


def from_zero(text: str) -> float:
    """A finite number from 0."""
    if number(text) < 0:
        raise argparse.ArgumentTypeError(f"{text!r} is negative; give 0 or more")
    return number(text)


def part(text: str) -> float:
    """A share from 0 to below 1, as a number or in per cent."""
    value = number(text.removesuffix("%")) / 100 if text.endswith("%") else number(text)
    if not 0 <= value < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a fraction from 0 to below 1")
    return value


def whole(text: str) -> int:
    """A whole number from 0."""
    if not text.isdecimal() or len(text) > 18:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number of 0 or more")
    return int(text)
