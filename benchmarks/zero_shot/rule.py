"""The rule: clear impacts name the damaged part, a linear classifier decides on weaker ones; and simpler rules.

From the limit of clear impacts of `gearcase diagnose` on, the highest pass order is the answer. The classifier is
multinomial logistic regression of standardised levels, fitted to simulated machines below this limit. Its
regularisation follows from cross-validation over machines. `outer`, `inner` and `element` are the levels of the pass
orders of the bearing, `sidebands` that of a rolling element with its sidebands.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas

from pipelines.diagnosis.impacts import CLEAR

RULE = Path(__file__).with_name("rule.json")
HASH = "2f75be97f9bf783602e0418023ba4c44153e316a6c75c426b89417da6714c1a9"  # of rule.json
STATES = ("healthy", "outer", "inner", "element")
DAMAGED = STATES[1:]
LEVELS = {
    ("BPFO", "pass_order"): "outer",
    ("BPFI", "pass_order"): "inner",
    ("2 BSF", "pass_order"): "element",
    ("2 BSF", "pass_sidebands"): "sidebands",
}
CLASSIFIERS = {
    "rule": tuple(LEVELS.values()),  # without kurtosis, which depends on resonances and bandwidth
    "kurtosis": ("kurtosis",),
    "rms": ("rms",),
}
COMB = "highest pass order"
INSIDE = 0.98  # of healthy simulated machines within the range of a feature
GROUPS = 5  # of machines in the cross-validation


def sha256() -> str:
    """SHA-256 of the file that contains the rule."""
    return hashlib.sha256(RULE.read_bytes()).hexdigest()


def levels(table: pandas.DataFrame, key: str, bearing: str) -> pandas.DataFrame:
    """Levels (dB) of a table of features: a row (signal, sensor, axis) per channel, a column per feature.

    Parameters
    ----------
    table : result of `gearcase.features`
    key : its column with the name of the signal
    bearing : name of the bearing; those of other components are left out, except of the whole machine and shaft_1
    """
    own = table.component.str.removeprefix(f"{bearing} ")
    named = [
        LEVELS.get((part, feature), feature if part in ("whole machine", "shaft_1") else f"{part} {feature}")
        for part, feature in zip(own, table.feature, strict=True)
    ]
    kept = table.component.isin(("whole machine", "shaft_1")) | (own != table.component)
    wide = table.assign(name=named)[kept].pivot(index=[key, "sensor", "axis"], columns="name", values="level_dB")
    if "sidebands" in wide:
        wide["sidebands"] = wide.sidebands.fillna(wide.element)  # too few of their lines are within the spectrum
    return wide


def fitted(table: pandas.DataFrame, state: pandas.Series) -> dict[str, Any]:
    """The classifiers, the limit of the highest pass order, and the ranges of all features of healthy machines.

    Parameters
    ----------
    table : levels, the first level of its index is the machine
    state : of each row
    """
    from sklearn.linear_model import LogisticRegressionCV
    from sklearn.model_selection import GroupKFold

    machine = table.index.get_level_values(0)
    best = table[list(DAMAGED)].max(axis=1)
    classifiers = {}
    for name, features in CLASSIFIERS.items():
        used = (best < CLEAR).to_numpy() if name == "rule" else np.ones(len(table), dtype=bool)
        values = table[list(features)].to_numpy()[used]
        mean, scale = values.mean(axis=0), values.std(axis=0)
        folds = list(GroupKFold(GROUPS).split(values, groups=machine[used]))
        model = LogisticRegressionCV(
            cv=folds, scoring="balanced_accuracy", max_iter=1000, l1_ratios=(0.0,), use_legacy_attributes=False
        )
        model.fit((values - mean) / scale, state[used])
        order = [list(model.classes_).index(one) for one in STATES]
        classifiers[name] = {
            "features": list(features),
            "mean": mean.round(4).tolist(),
            "scale": scale.round(4).tolist(),
            "weights": model.coef_[order].round(4).tolist(),
            "intercept": model.intercept_[order].round(4).tolist(),
        }
    limits = np.unique(best.round(1))
    is_healthy = (state == STATES[0]).to_numpy()
    share = [(best[is_healthy] < one).mean() + (best[~is_healthy] >= one).mean() for one in limits]
    healthy, tail = table[is_healthy], (1.0 - INSIDE) / 2.0
    return {
        "classifiers": classifiers,
        "clear_dB": CLEAR,
        "limit_dB": float(limits[int(np.argmax(share))]),
        "healthy_range_dB": {
            name: [round(float(column.quantile(one)), 2) for one in (tail, 1.0 - tail)]
            for name, column in healthy.dropna(axis=1, how="all").items()
        },
    }


def answers(rule: Mapping[str, Any], table: pandas.DataFrame) -> pandas.DataFrame:
    """Of each judge the answer (`name`), and the most probable part if the bearing is damaged (`name part`).

    Parameters
    ----------
    rule : contents of the file
    table : levels (recording, feature)
    """
    found = {}
    for name, model in rule["classifiers"].items():
        values = (table[model["features"]].to_numpy() - model["mean"]) / model["scale"]
        score = values @ np.transpose(model["weights"]) + model["intercept"]
        found[name] = _named(STATES, score)
        found[f"{name} part"] = _named(DAMAGED, score[:, 1:])
    combs = table[list(DAMAGED)].to_numpy()
    part = found[f"{COMB} part"] = _named(DAMAGED, combs)
    for name in ("rule", "rule part"):
        found[name] = np.where(combs.max(axis=1) >= rule["clear_dB"], part, found[name])
    found[COMB] = np.where(combs.max(axis=1) < rule["limit_dB"], STATES[0], found[f"{COMB} part"])
    return pandas.DataFrame(found, index=table.index)


def _named(names: Iterable[str], score: np.ndarray) -> np.ndarray:
    return np.array(tuple(names))[score.argmax(axis=1)]


def stored_rule() -> dict[str, Any]:
    """The frozen rule."""
    found: dict[str, Any] = json.loads(RULE.read_text(encoding="utf-8"))
    return found
