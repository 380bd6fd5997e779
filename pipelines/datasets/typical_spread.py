"""The typical spread of a machine: what differs between machines of one design, as variables of a plan.

`spread = "typical"` in a plan adds these variables for the parts that its scene has. Their values are sampled in
`pipelines.datasets.sampling`. The settings of the plan override them. A source is a standard or a publication, or
"guess": an assumption of this program, not judged by measurements. Unbalance and misaligned couplings are labels of
faults and are not varied, nor are sensors, which all runs of a data set have in common.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

TYPICAL = "typical"
_PREFIX = "spread_"  # of the names of the variables


@dataclass(frozen=True, kw_only=True)
class Spread:
    """One property: the distribution of its variable, the keys that it sets, and the source.

    `keys` are places in a scene; "*" is every item of a list. `text` is the value: an expression in the variable x,
    where c is the value of the key in the scene. Without such a value, or if the table has another `model`, the
    property is left out.
    """

    name: str
    keys: tuple[str, ...]
    variable: Mapping[str, Any]
    text: str = "x * c"
    model: str = ""
    default: float | None = None
    source: str


def _factor(deviation: float) -> dict[str, Any]:
    """A log-normal factor with median 1, cut at three standard deviations of its logarithm."""
    return {
        "distribution": "lognorm",
        "parameters": {"s": deviation},
        "from": math.exp(-3.0 * deviation),
        "to": math.exp(3.0 * deviation),
    }


_STIFFNESS = ("radial_stiffness_N_per_um", "axial_stiffness_N_per_um", "tilt_stiffness_N_m_per_rad")
_SHIFT = {"values": [-1, 0, 1], "weights": [1.0, 2.0, 1.0]}
SPREADS = (
    Spread(
        name="specimen",
        keys=("deviations.seed",),
        variable={"from": 1, "to": 1_000_000},
        text="x",
        default=1,
        source="another pair of gears: deviations within the tolerances of ISO 1328-1:2013",
    ),
    Spread(
        name="grade",
        keys=("deviations.iso_grade",),
        variable=_SHIFT,
        text="max(1, min(11, c + x))",
        default=5,
        source="guess: a lot contains gears one class better or worse",
    ),
    Spread(
        name="bearing_stiffness",
        keys=tuple(f"bearings.{key}" for key in _STIFFNESS),
        variable=_factor(0.3),
        model="linear",
        source="guess: clearance, fit and preload change the stiffness by 30 %",
    ),
    Spread(
        name="bearing_damping",
        keys=("bearings.damping_time_us",),
        variable=_factor(0.5),
        default=5.0,
        source="guess",
    ),
    Spread(
        name="clearance",
        keys=("bearings.radial_clearance_um", "shafts.*.bearings.*.radial_clearance_um"),
        variable={"from": 0.0, "to": 20.0},
        text="x",
        model="hertz",
        default=0.0,
        source="ISO 5753-1:2009, group N (5 to 20 um at bores of 24 to 30 mm), less up to 5 um by the fits (guess)",
    ),
    Spread(
        name="slip",
        keys=("bearings.cage_slip", "shafts.*.bearings.*.cage_slip"),
        variable={"from": 0.005, "to": 0.02},
        text="x",
        model="hertz",
        default=0.0,
        source="Randall & Antoni (2011), Mech. Syst. Signal Process. 25(2), 485-520: 1 to 2 %",
    ),
    Spread(
        name="casing_damping",
        keys=("casing.damping_ratio",),
        variable=_factor(0.5),
        source="guess: joints and mounting",
    ),
    Spread(
        name="casing_modulus",
        keys=("casing.material.elastic_modulus_GPa",),
        variable=_factor(0.035),
        source="EN 1561:2011, annex: 103 to 118 GPa for EN-GJL-250",
    ),
    Spread(
        name="mounts", keys=("casing.mount_stiffness_N_per_um",), variable=_factor(0.3), source="guess: floor and bolts"
    ),
    Spread(
        name="coupling",
        keys=("drive.coupling_stiffness_N_m_per_rad",),
        variable=_factor(0.2),
        source="guess: elastomer couplings",
    ),
    Spread(
        name="load",
        keys=("load.torque_N_m",),
        variable={"distribution": "norm", "parameters": {"loc": 1.0, "scale": 0.05}, "from": 0.85, "to": 1.15},
        source="guess: setting and drift of the load",
    ),
    Spread(
        name="in_plane",
        keys=("stages.*.misalignment.in_plane_um",),
        variable={"distribution": "norm", "parameters": {"scale": 5.0}, "from": -15.0, "to": 15.0},
        text="c + x",
        default=0.0,
        source="guess, of the order of ISO/TR 10064-3:1996 for class 5",
    ),
    Spread(
        name="out_of_plane",
        keys=("stages.*.misalignment.out_of_plane_um",),
        variable={"distribution": "norm", "parameters": {"scale": 3.0}, "from": -9.0, "to": 9.0},
        text="c + x",
        default=0.0,
        source="guess, of the order of ISO/TR 10064-3:1996 for class 5",
    ),
)


def typical(scene: Mapping[str, Any], settings: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Variables and settings of the typical population of a scene; keys that the plan sets are left to it.

    Parameters
    ----------
    scene : tree of the scene
    settings : of the plan
    """
    variables: dict[str, Any] = {}
    added: dict[str, Any] = {}
    for spread in SPREADS:
        name = f"{_PREFIX}{spread.name}"
        for key in spread.keys:
            for place, value in _places(scene, key.split("."), spread):
                if not _is_set(settings, place):
                    words = {"x": name, "c": str(value)}
                    text = "".join(words.get(one, one) for one in re.split(r"\b", spread.text))
                    put_setting(added, place, f"${text}")
                    variables[name] = dict(spread.variable)
    return variables, added


def _places(tree: Any, path: list[str], spread: Spread, done: tuple[str, ...] = ()) -> Iterator[tuple[Any, float]]:
    """Paths of a key in a scene, with its value or the default."""
    head, *rest = path
    if head == "*":
        for number, item in enumerate(tree if isinstance(tree, list | tuple) else [], 1):
            yield from _places(item, rest, spread, (*done, str(number)))
    elif rest:
        missing: Any = {} if head == "misalignment" else None
        yield from _places(tree.get(head, missing), rest, spread, (*done, head)) if isinstance(tree, Mapping) else ()
    elif isinstance(tree, Mapping) and (not spread.model or tree.get("model") == spread.model):
        value = tree.get(head, spread.default)
        if value is not None:
            yield (*done, head), value


def _is_set(settings: Any, path: tuple[str, ...]) -> bool:
    """Whether the settings of a plan have a key, or replace a table or list that holds it."""
    for name in path:
        if not isinstance(settings, Mapping):
            return True
        if name not in settings:
            return False
        settings = settings[name]
    return True


def put_setting(tree: dict[str, Any], path: Sequence[str], value: Any) -> None:
    """Insert a value into a tree of settings."""
    for name in path[:-1]:
        tree = tree.setdefault(name, {})
    tree[path[-1]] = value
