"""Zero-shot benchmark of rolling bearings: python -m benchmarks.zero_shot COMMAND ...

    fit DATASET                     fit the rule to the data set of population.toml, and write rule.json
    measure TABLE NAME=FOLDER ...   compute the features of public data sets; names are the keys of records.toml
    score TABLE                     apply the rule to these features, and print the tables of docs/zero-shot.md

TABLE is a Parquet file. The tables compare the rule, file by file, with classifiers of kurtosis and rms from the same
simulated machines, with the highest pass order, and with the verdict of `gearcase diagnose` without a baseline.
"""

from __future__ import annotations

import json
import re
import sys
import tempfile
import tomllib
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas
from scipy.stats import binomtest

import gearcase
from benchmarks.markdown import markdown
from benchmarks.zero_shot.rule import COMB, DAMAGED, HASH, RULE, STATES, answers, fitted, levels, sha256, stored_rule
from pipelines.diagnosis.impacts import CLEAR

HERE = Path(__file__).parent
START = 0.3  # s, after the run-up
NOISES = (0.1, 1.0, 3.0, 10.0)  # m/s2 rms of noise added to the signals: each machine is used four times
VERDICT = "verdict of the product"
JUDGES = ("rule", COMB, VERDICT, "kurtosis", "rms")
WIDEST = 20.0  # dB, of the range of a feature
SHAPE = ("rms", "peak")  # features with a level that depends on the sensor


def fit(dataset: str) -> None:
    """Fit the rule to simulated machines, and write it."""
    rows = pandas.read_parquet(Path(dataset) / "rows.parquet").set_index("run")
    found = []
    for noise in NOISES:
        kept = Path(dataset) / f"features_{noise:g}.parquet"
        if not kept.is_file():
            gearcase.features(dataset, start=START, noise_m_s2=noise).to_parquet(kept)
        found.append(levels(pandas.read_parquet(kept), "run", "bearing_1"))
    table = pandas.concat(found)
    state = rows.state[table.index.get_level_values("run")]
    rule = {"machines": int(state.index.nunique()), **fitted(table, state)}
    RULE.write_text(json.dumps(rule, indent=1) + "\n", encoding="utf-8")
    print(sha256())
    named = answers(rule, table)
    for name in ("rule", COMB, "kurtosis", "rms"):
        print(f"{name:20} right on the simulated machines: {(named[name].to_numpy() == state.to_numpy()).mean():.3f}")


def measure(out: str, *sources: str) -> None:
    """Compute the features of public data sets, and write them with the title and state of each recording."""
    sets = tomllib.loads((HERE / "records.toml").read_text(encoding="utf-8"))
    pairs = [source.split("=", 1) for source in sources]
    found = [table for name, folder in pairs for group in sets[name] for table in _measured(group, Path(folder))]
    pandas.concat(found, ignore_index=True).to_parquet(out)


def _measured(group: Mapping[str, Any], folder: Path) -> Iterator[pandas.DataFrame]:
    """Features of the recordings of one group."""
    machine = (HERE / "rigs" / f"{group['rig']}.toml").read_text(encoding="utf-8")
    if "rpm" in group:
        machine = re.sub(r"\brpm = \d+", f"rpm = {group['rpm']}", machine)
    with tempfile.TemporaryDirectory() as aside:
        path = Path(aside) / f"{group['rig']}.toml"
        path.write_text(machine, encoding="utf-8")
        for state, pattern in group["files"].items():
            if files := sorted(folder.glob(pattern)):
                table = gearcase.features(files, path)
                print(*(f"{reason}\n" for reason in table.attrs["failures"].values()), end="")
                near = table.sensor.str.contains(group.get("channels", ""), regex=False)
                recording = f"{group['title']}: " + table.recording  # one file can be healthy for two machines
                yield table[near].assign(recording=recording[near], title=group["title"], state=state)


def score(table: str) -> None:
    """Print the tables of the page."""
    rule = stored_rule()
    if sha256() != HASH:
        raise SystemExit("rule.json is not the frozen rule: its hash is another one.")
    rows = pandas.read_parquet(table)
    facts = rows.groupby("recording")[["title", "state"]].first()
    print(coverage(rule, rows))
    judged = levels(rows, "recording", "bearing").groupby("recording").mean().join(facts)
    judged = judged.dropna(subset=["outer"]).copy()
    clear = rows[rows.feature.eq("pass_order") & ~rows.component.str.endswith("FTF")]
    clear = clear.sort_values("level_dB").groupby("recording").last()
    named = answers(rule, judged)
    part = clear.component.str.removeprefix("bearing ").map(dict(zip(("BPFO", "BPFI", "2 BSF"), DAMAGED, strict=True)))
    named[VERDICT] = part.where(clear.level_dB >= CLEAR, STATES[0])[named.index]
    print(parts(judged, named))
    print(paired(judged, named))
    print(confusion(judged, named))
    print(indicators(rows))


def parts(judged: pandas.DataFrame, named: pandas.DataFrame) -> str:
    """Of each data set the recordings whose damaged part is right, and the healthy ones called healthy."""
    damaged = judged.state != STATES[0]
    groups = {title: judged.title == title for title in judged.title.unique()} | {"all": judged.title != ""}
    lines = []
    for title, chosen in groups.items():
        for what, rows in (("damaged", chosen & damaged), ("healthy", chosen & ~damaged)):
            if rows.any():
                right = [_right(judged[rows], named[rows], judge) for judge in JUDGES]
                lines.append((title, what, str(rows.sum()), *(_share(one) for one in right)))
    return markdown(("data", "recordings", "number", *JUDGES), lines)


def _right(judged: pandas.DataFrame, named: pandas.DataFrame, judge: str) -> np.ndarray:
    """Whether the answer is right; of damaged bearings only the part counts, except in a verdict."""
    column = np.where(judged.state == STATES[0], named[judge], named.get(f"{judge} part", named[judge]))
    return np.asarray(column == judged.state.to_numpy())


def _share(right: np.ndarray) -> str:
    low, high = binomtest(int(right.sum()), len(right)).proportion_ci(method="wilson")
    return f"{right.sum()} ({100 * low:.0f} to {100 * high:.0f} %)"


def paired(judged: pandas.DataFrame, named: pandas.DataFrame) -> str:
    """Damaged recordings for which only the rule, or only another judge names the part; McNemar's exact test."""
    damaged = judged.state != STATES[0]
    own = _right(judged[damaged], named[damaged], "rule")
    lines = []
    for judge in JUDGES[1:]:
        other = _right(judged[damaged], named[damaged], judge)
        only = int((own & ~other).sum()), int((other & ~own).sum())
        lines.append((judge, *map(str, only), f"{binomtest(only[0], max(sum(only), 1)).pvalue:.2g}"))
    return markdown(("compared with", "only the rule is right", "only the other is right", "p"), lines)


def confusion(judged: pandas.DataFrame, named: pandas.DataFrame) -> str:
    """Answers of the rule and of the highest pass order by the true state."""
    lines = []
    for state in STATES:
        rows = named[judged.state == state]
        counts = [f"{(rows['rule'] == one).sum()}, {(rows[COMB] == one).sum()}" for one in STATES]
        lines.append((state, str(len(rows)), *counts))
    return markdown(("true state", "recordings", *STATES), lines)


def coverage(rule: Mapping[str, Any], rows: pandas.DataFrame) -> str:
    """Of each feature its range in healthy simulated machines, and the healthy recordings within it."""
    healthy = levels(rows[rows.state == STATES[0]], "recording", "bearing")
    lines = []
    for name, (low, high) in rule["healthy_range_dB"].items():
        if name in healthy and name not in SHAPE:
            values = healthy[name].dropna()
            inside = values.between(low, high)
            middle = f"{values.quantile(0.1):.1f} to {values.quantile(0.9):.1f}"
            wide = "" if high - low <= WIDEST else "wider than 20 dB"
            lines.append((name, f"{low:.1f} to {high:.1f}", middle, f"{inside.sum()} of {len(values)}", wide))
    return markdown(("feature", "98 % range of the population, dB", "80 % of the records, dB", "inside", ""), lines)


def indicators(rows: pandas.DataFrame) -> str:
    """Median and range of kurtosis and crest factor of every data set and state."""
    lines = []
    for (title, state), group in rows[rows.component == "whole machine"].groupby(["title", "state"]):
        values = {name: group[group.feature == name].value for name in ("kurtosis", "crest_factor")}
        words = [f"{one.median():.1f} ({one.min():.1f} to {one.max():.1f})" for one in values.values()]
        lines.append((title, state, str(group.recording.nunique()), *words))
    return markdown(("data", "state", "recordings", "kurtosis", "crest factor"), lines)


if __name__ == "__main__":
    commands: dict[str, Callable[..., None]] = {"fit": fit, "measure": measure, "score": score}
    commands[sys.argv[1]](*sys.argv[2:])
