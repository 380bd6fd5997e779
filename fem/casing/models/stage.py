"""Stages from a casing to its reduced body: each holds what it depends on, so that its result can be stored.

    mesh -> modes -> body       of a model with finite elements; others have the last stage alone

A stage takes results of earlier ones by the names of the parameters of `build`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

if TYPE_CHECKING:
    from fem.casing.reduced.body import ReducedBody

MESH, MODES, BODY = "casing mesh", "casing modes", "casing"


class CasingError(RuntimeError):
    """The work on a casing failed; the message states what to set."""


class CasingInputError(ValueError):
    """What a casing is made of cannot be used."""


class Stage:
    """A computation, with all that it depends on besides results of other stages.

    `kind` names the stored results; `libraries` are those that they depend on. A stored result of a stage whose number
    `enough` is larger serves as well. `compiles`: s to compile, by the beginning of the name of the code.
    """

    kind: ClassVar[str]
    libraries: ClassVar[tuple[str, ...]] = ("numpy",)
    enough: ClassVar[str] = ""
    compiles: ClassVar[Mapping[str, float]] = {}
    build: ClassVar[Callable[..., Any]]  # the result, of those of other stages; CasingError, CasingInputError


@dataclass(frozen=True, kw_only=True)
class PlannedStage:
    """A stage by its name: which results it takes by the parameters of `build`, and about how many seconds it runs."""

    name: str
    stage: Stage
    takes: Mapping[str, str | tuple[str, ...]] = field(default_factory=dict)
    seconds: float = 0.1


def body_of(stages: Iterable[PlannedStage]) -> ReducedBody:
    """All stages, one after the other; the result of the last."""
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
