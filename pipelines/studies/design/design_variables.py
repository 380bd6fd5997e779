"""Variables of a search: modifications of the flanks and values of a stage, each in manufacturing steps."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from fem.gears.geometry import GearPair, sum_of_shifts
from fem.gears.modifications import FlankModifications, PairModifications
from fem.options import options_of
from pipelines.io.errors import InputError, SceneError
from pipelines.io.shown_text import nearest_name, shown
from pipelines.machine.scene_flanks import GEARS, modifications
from pipelines.scene.load_scene import LoadedScene, changed
from pipelines.scene.tables.derived import key_of
from pipelines.studies.detect.detection_axis import Over, parse_over

BOTH = "both"
STEPS = {"um": "1", "mm": "0.1", "deg": "0.5", "shift": "0.05", "teeth": "1"}  # manufacturing steps, by unit
KEYS = tuple(key_of(field.name, one) for field, one in options_of(FlankModifications))
WHEEL_SHIFT, DISTANCE = "wheel_profile_shift", "centre_distance_mm"
STAGE_KEYS = (
    "pinion_teeth", "wheel_teeth", "module_mm", "pressure_angle_deg", "helix_angle_deg", "face_width_mm",
    "pinion_profile_shift", WHEEL_SHIFT, DISTANCE,
)  # fmt: skip


def parse_vary(text: str) -> Over:
    """`GEAR.KEY=LOW:HIGH[:STEP]` or `GEAR.KEY=A,B,C` with GEAR pinion, wheel or both; a key of `STAGE_KEYS` alone.

    One value is a fixed one.

    Raises
    ------
    InputError : the key is neither, or the values are none
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
    if found.key not in STAGE_KEYS and (gear not in (*GEARS, BOTH) or own not in KEYS):
        near = nearest_name(own or gear, (*KEYS, *STAGE_KEYS))
        hint = f" Did you mean {near}?" if near and near != own else ""
        raise InputError(
            f"--vary {shown(found.key)}: is neither a modification of a flank nor a value of the stage. Start with "
            f"pinion., wheel. or both., and continue with one of {', '.join(KEYS)}; or give one of "
            f"{', '.join(STAGE_KEYS)}.{hint}"
        )
    return found


_EXAMPLE = "Write --vary both.tip_relief.amount_um=0:40:1, or --vary pinion.lead_crowning_um=0,5,10."


@dataclass(frozen=True)
class Variables:
    """The variables of a stage (from 1) of a scene.

    The centre distance and the backlash of the scene are kept if values of the stage are varied, unless the profile
    shift of the wheel is one of them: it follows.

    Raises
    ------
    SceneError : a value is outside the range of its key, or a key is not complete
    InputError : a key is varied twice
    """

    loaded: LoadedScene
    stage: int
    sense: int  # lifting sense of the pinion
    pair: GearPair  # of the scene, with its backlash
    given: tuple[Over, ...]

    def __post_init__(self) -> None:
        paths = [path for over in self.given for path in self.paths(over)]
        twice = next((path for path in paths if paths.count(path) > 1), None)
        if twice is not None:
            raise InputError(f"--vary {twice}: is varied twice. Delete one of the two.")
        flanks = [one for one in self.given if one.key not in STAGE_KEYS]
        amounts = {name for name in self.names if name.endswith("_relief.amount_um")}
        lengths = sorted({name.replace("amount_um", "length_mm") for name in amounts} - set(self.names))
        for end in (0, -1):
            try:
                changed(self.loaded, self._settings((one, one.values[end]) for one in flanks))
            except SceneError as error:
                if lengths and error.problems[0].path.endswith("_relief"):  # not one of its keys
                    raise InputError(
                        f"--vary: the start of a relief is missing. Add its length, as in --vary {lengths[0]}=2."
                    ) from error
                raise

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

    @property
    def stage_columns(self) -> tuple[int, ...]:
        """Numbers of the variables that are values of the stage."""
        return tuple(n for n, over in enumerate(self.given) if over.key in STAGE_KEYS)

    def stage_index(self, index: Sequence[int]) -> tuple[int, ...]:
        """Numbers of the values of the stage of a candidate (variable,)."""
        return tuple(int(index[column]) for column in self.stage_columns)

    def stage_settings(self, index: Sequence[int]) -> dict[str, Any]:
        """Keys of the scene with the values of the stage of `stage_index`; GeometryError as `settings`."""
        own = [self.given[column] for column in self.stage_columns]
        return replace(self, given=tuple(own)).settings([over.values[at] for over, at in zip(own, index, strict=True)])

    def settings(self, values: Sequence[Any]) -> dict[str, Any]:
        """Keys of the scene with the values of a candidate.

        Raises
        ------
        GeometryError : the gears are too large for the centre distance
        """
        found = self._settings(zip(self.given, values, strict=True))
        keys = {self.given[column].key for column in self.stage_columns}
        if keys <= {"face_width_mm"} or WHEEL_SHIFT in keys:
            return found
        stage = changed(self.loaded, found).scene.stages[self.stage - 1]
        distance = stage.si.centre_distance if DISTANCE in keys else round(self.pair.axis_distance, 9)
        teeth, angles = stage.pinion_teeth + stage.wheel_teeth, (stage.si.helix_angle, stage.si.pressure_angle)
        wheel = sum_of_shifts(teeth, stage.si.module, *angles, distance) - stage.pinion_profile_shift
        kept = {DISTANCE: round(1e3 * distance, 6), "backlash_um": round(1e6 * self.pair.backlash, 2)}
        kept[WHEEL_SHIFT] = math.floor(1e4 * wheel) / 1e4  # rounded down: the teeth do not jam
        return found | {f"stages.{self.stage}.{key}": value for key, value in kept.items()}

    def _settings(self, pairs: Iterable[tuple[Over, Any]]) -> dict[str, Any]:
        return {f"stages.{self.stage}.{path}": value for over, value in pairs for path in self.paths(over)}

    def modifications(self, values: Sequence[Any]) -> PairModifications:
        """The modifications of a candidate."""
        scene = changed(self.loaded, self.settings(values)).scene
        return modifications(scene.stages[self.stage - 1], self.sense)

    @staticmethod
    def paths(over: Over) -> list[str]:
        """Keys of the stage that a variable sets."""
        gear, _, rest = over.key.partition(".")
        return [f"{one}.{rest}" for one in GEARS] if gear == BOTH else [over.key]
