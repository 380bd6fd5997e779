"""Stages from a casing to its reduced body; each contains all its input, so that its result can be stored.

    mesh -> modes -> body       for models with finite elements; others have only the last stage

A stage receives results of earlier ones through the parameters of `build`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

if TYPE_CHECKING:
    from fem.casing.reduced.reduced_body import ReducedBody

MESH, MODES, BODY = "casing mesh", "casing modes", "casing"


class CasingError(RuntimeError):
    """A computation on a casing failed; the message gives the remedy."""


class CasingInputError(ValueError):
    """The input of a casing cannot be used."""


class Stage:
    """A computation with all its input except the results of other stages.

    `kind` names the stored results, which depend on the `libraries`. If `enough` names a number, a stored result of a
    stage with a larger one is valid too. `compiles` gives the time of compilation (s) by the prefix of the code's name.
    """

    kind: ClassVar[str]
    libraries: ClassVar[tuple[str, ...]] = ("numpy",)
    enough: ClassVar[str] = ""
    compiles: ClassVar[Mapping[str, float]] = {}
    build: ClassVar[Callable[..., Any]]  # from results of other stages; CasingError, CasingInputError


@dataclass(frozen=True, kw_only=True)
class PlannedStage:
    """A stage with its name, the results that it takes by the parameters of `build`, and its estimated run time (s)."""

    name: str
    stage: Stage
    takes: Mapping[str, str | tuple[str, ...]] = field(default_factory=dict)
    seconds: float = 0.1


def body_of(stages: Iterable[PlannedStage]) -> ReducedBody:
    """Run all stages in order; returns the result of the last."""
    results: dict[str, Any] = {}
    for one in stages:
        results[one.name] = one.stage.build(
            **{
                key: results[names] if isinstance(names, str) else [results[name] for name in names]
                for key, names in one.takes.items()
            }
        )
    body: ReducedBody = results[BODY]
    return body
