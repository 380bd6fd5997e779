"""Variables of a search: modifications of the flanks of a stage, each with its values in manufacturing steps."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from fem.gears.modifications import FlankModifications, PairModifications
from fem.options import options_of
from pipelines.io.errors import InputError
from pipelines.io.shown_text import nearest_name, shown
from pipelines.machine.scene_flanks import GEARS, modifications
from pipelines.scene.load_scene import LoadedScene, changed
from pipelines.scene.tables.derived import key_of
from pipelines.studies.detect.detection_axis import Over, parse_over

BOTH = "both"
STEPS = {"um": "1", "mm": "0.1"}  # manufacturing steps, by unit
KEYS = tuple(key_of(field.name, one) for field, one in options_of(FlankModifications))


def parse_vary(text: str) -> Over:
    """`GEAR.KEY=LOW:HIGH[:STEP]` or `GEAR.KEY=A,B,C` with GEAR pinion, wheel or both.

    Raises
    ------
    InputError : the key is not a modification of a flank, the range is empty or not one of numbers
    """
    key, _, given = text.partition("=")
    gear, _, rest = key.strip().partition(".")
    if gear in KEYS:
        raise InputError(
            f"--vary {shown(text)}: the gear is missing. Start with pinion., wheel. or both., as in both.{shown(key)}. "
            f"Keys are {', '.join(KEYS)}."
        )
    step = STEPS.get(key.rpartition("_")[2], "")
    found = parse_over(f"{text}:{step}" if given.count(":") == 1 and step else text, "--vary", _EXAMPLE)
    own = rest.partition(".")[0]
    if gear not in (*GEARS, BOTH) or own not in KEYS:
        near = nearest_name(own, KEYS)
        hint = f" Did you mean {near}?" if near and near != own else ""
        raise InputError(
            f"--vary {shown(found.key)}: is not a modification of a flank. Start with pinion., wheel. or both., and "
            f"continue with one of {', '.join(KEYS)}.{hint}"
        )
    if len(found.values) < 2:
        fixed = GEARS if gear == BOTH else (gear,)
        ways = " ".join(f"--set stages.1.{one}.{rest}={found.values[0]:g}" for one in fixed)
        raise InputError(
            f"--vary {shown(text)}: {shown(found.key)} has one value only. Set a range with several steps, or a fixed "
            f"value for the stage, as in {ways}."
        )
    return found


_EXAMPLE = "Write --vary both.tip_relief.amount_um=0:40:1, or --vary pinion.lead_crowning_um=0,5,10."


@dataclass(frozen=True)
class Variables:
    """The variables of a stage (from 1) of a scene.

    Raises
    ------
    SceneError : a value is outside the range of its key, or a key is not complete
    InputError : a key is varied twice
    """

    loaded: LoadedScene
    stage: int
    sense: int  # lifting sense of the pinion
    given: tuple[Over, ...]

    def __post_init__(self) -> None:
        paths = [path for over in self.given for path in self._paths(over)]
        twice = next((path for path in paths if paths.count(path) > 1), None)
        if twice is not None:
            raise InputError(f"--vary {twice}: is varied twice. Delete one of the two.")
        for end in (0, -1):
            self.modifications([one.values[end] for one in self.given])

    @property
    def names(self) -> tuple[str, ...]:
        """Their keys."""
        return tuple(over.key for over in self.given)

    @property
    def sizes(self) -> tuple[int, ...]:
        """Numbers of their values."""
        return tuple(len(over.values) for over in self.given)

    def values(self, index: Iterable[int]) -> list[Any]:
        """The values of a candidate (variable,) from the numbers of its values."""
        return [over.values[int(at)] for over, at in zip(self.given, index, strict=True)]

    def settings(self, values: Sequence[Any]) -> dict[str, Any]:
        """Keys of the scene with the values of a candidate."""
        pairs = zip(self.given, values, strict=True)
        return {f"stages.{self.stage}.{path}": value for over, value in pairs for path in self._paths(over)}

    def modifications(self, values: Sequence[Any]) -> PairModifications:
        """The modifications of a candidate."""
        scene = changed(self.loaded, self.settings(values)).scene
        return modifications(scene.stages[self.stage - 1], self.sense)

    @staticmethod
    def _paths(over: Over) -> list[str]:
        gear, _, rest = over.key.partition(".")
        return [f"{one}.{rest}" for one in (GEARS if gear == BOTH else (gear,))]
