"""The card of a data set: README.md in its folder, with its content, origin, warnings, limits and ways to read it.

References
----------
Gebru et al. (2021), Communications of the ACM 64(12), 86-92 (what the documentation of a data set has to contain).
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pipelines.datasets.labels import COLUMNS
from pipelines.datasets.rows import DONE, FAILED
from pipelines.datasets.run_warnings import stored_scene
from pipelines.datasets.summary import Summary, plan_texts, summarised, words
from pipelines.datasets.variables_grid import design_words, varied_grid
from pipelines.io.text_table import Grid
from pipelines.io.user_files import write_whole
from pipelines.scene.scene import Scene

_LOADING = {  # by program; the paths are those in the folder of the data set
    "xarray, by run": """\
import gearcase

data = gearcase.open_dataset(".")                      # reads a run when it is used
train = data.isel(run=(data.split == "train") & (data.status == "done"))
first = train.acceleration[0]                          # (sensor, axis, time), m/s2
print(first.std("time"))

for one in gearcase.pieces(train, 0.1, noise_m_s2=0.01):   # a run at a time: (piece, sensor, axis, time)
    print(int(one.run[0]), str(one.label.values[0]), one.shape)
""",
    "xarray alone": """\
import xarray

signals = xarray.open_zarr("signals.zarr", consolidated=False, chunks=None)   # without gearcase, without labels
print(signals.acceleration.sizes)
""",
    "pandas": """\
import pandas

rows = pandas.read_parquet("rows.parquet")             # a line per run: variables, labels, split
print(rows.groupby(["split", "label"]).size())
""",
    "scikit-learn": """\
import pandas
from sklearn.ensemble import RandomForestClassifier

rows = pandas.read_parquet("rows.parquet").set_index("run")
features = pandas.read_parquet("features.parquet")     # made by: gearcase features .
signals = ["sensor", "axis", "component", "feature"]
wide = features.pivot(index="run", columns=signals, values="value").dropna(axis="columns")
wide.columns = [" ".join(names) for names in wide.columns]
table = rows.join(wide, how="inner")
train, test = table[table.split == "train"], table[table.split == "test"]
model = RandomForestClassifier(random_state=0).fit(train[wide.columns], train.label)
print(model.score(test[wide.columns], test.label))
""",
    "PyTorch": """\
import gearcase
import torch

class Pieces(torch.utils.data.IterableDataset):
    def __init__(self, part):
        data = gearcase.open_dataset(".")
        self.data = data.isel(run=(data.split == part) & (data.status == "done"))
        self.labels = sorted(set(self.data.label.values))

    def __iter__(self):
        for one in gearcase.pieces(self.data, 0.1, noise_m_s2=0.01):
            label = self.labels.index(one.label.values[0])
            for signal in torch.tensor(one.values).flatten(1, 2):   # (sensor and axis, time)
                yield signal, label

batches = torch.utils.data.DataLoader(Pieces("train"), batch_size=32)   # runs come in order: shuffle them for training
""",
}


def write_card(folder: Path) -> Summary:
    """Write README.md of a data set, and return what it was made of.

    Raises
    ------
    InputError : the folder holds no data set, or a row is damaged
    OSError : it cannot be written
    """
    found = summarised(folder)
    write_whole(folder / "README.md", card(folder, found))
    return found


def card(folder: Path, found: Summary) -> str:
    """The card of a data set as Markdown."""
    plan = found.facts["facts"]["plan"]
    scene = stored_scene(folder)
    licence = plan_texts(folder).get("licence") or (
        'not stated. To publish the data set, choose one and set `licence = "..."` in its plan.'
    )
    meanings = {f"`{name}`": meaning for name, meaning in COLUMNS.items()} | {"variables": "one column each, see below"}
    parts = [
        f"# {found.title}",
        f"Simulated vibration of a gearbox with known damage, made by `gearcase campaign` from the scene "
        f"`{plan['scene']}`: {words(found.statuses)} of {found.facts['runs']} runs. The plan is `plan.toml`, "
        "the scene with all its defaults `scene.toml`.",
        f"Licence: {licence}",
        *(f"**Warning.** {text}" for text in found.warnings),
        f"## What is stored\n\n{_arrays(found)}",
        "Signals are in `signals.zarr` (Zarr 3), with one chunk per run and array. A run that is not done reads as "
        "NaN. "
        "`rows/` has a JSON file per run, `rows.parquet` all of them as a table; the column `status` is `done` when "
        "the signals of a run are stored.",
        Grid(title="", headers=("column", "meaning"), rows=tuple(meanings.items())).to_markdown(),
        f"## What was varied\n\n{design_words(plan)[0].upper()}{design_words(plan)[1:]}.",
        varied_grid(plan, found.columns).to_markdown() if plan["variables"] else "Nothing.",
        f"## Labels and split\n\n{_counts(found).to_markdown()}",
        _split_words(found),
        f"## How it was made\n\n{_bullets(_provenance(found, scene))}",
        f"## Limits\n\n{_bullets(_limits(found, scene))}",
        "## How to load it",
        *(f"### {name}\n\n```python\n{code}```" for name, code in _LOADING.items()),
    ]
    return "\n\n".join(parts) + "\n"


def _arrays(found: Summary) -> str:
    layout = found.facts["layout"]
    rows = [
        (
            f"`{one['name']}`",
            f"({', '.join(['run', *one['dims']])})",
            f"({', '.join(map(str, [found.facts['runs'], *one['shape']]))})",
            np.dtype(one["dtype"]).name,
            one["attributes"].get("units", ""),
            one["attributes"].get("long_name", ""),
        )
        for one in layout["signals"]
    ]
    table = Grid(title="", headers=("array", "dimensions", "shape", "type", "unit", "meaning"), rows=tuple(rows))
    named = "; ".join(f"{name}: {', '.join(map(str, values))}" for name, values in layout["names"].items())
    seconds = layout["samples"] / layout["rate"]
    return f"{table.to_markdown()}\n\nTime from 0, {seconds:g} s at {layout['rate']:g} Hz. Names: {named}."


def _counts(found: Summary) -> Grid:
    """Runs that are done by label and part of the split."""
    columns = found.columns
    done = columns["status"] == DONE

    def count(label: str, part: str) -> str:
        return str(int(np.sum(done & (columns["label"] == label) & (columns["split"] == part))))

    rows = [(label, *(count(label, part) for part in found.splits)) for label in found.labels]
    return Grid(title="", headers=("label", *found.splits), rows=tuple(rows))


def _split_words(found: Summary) -> str:
    if not found.facts["groups by"]:
        return (
            f"Every run is a separate group: {found.groups} groups, assigned to the parts by the seed of the plan. "
            "`deviations.seed` is constant, so that all runs have the same pair of gears. A test does not show how a "
            "classifier performs on other gears; vary `deviations.seed` in the plan for that."
        )
    by = ", ".join(f"`{name}`" for name in found.facts["groups by"])
    return (
        f"Runs with equal {by} are one group ({found.groups} groups), and a group is in one part only. Train on "
        "one part and test on another. Cut signals into pieces after the split, never before: two pieces of one run, "
        "or two runs of one pair of gears, have more in common than their label, so a classifier trained on one "
        "recognises the other. Use the column `group` for cross-validation, too."
    )


def _bullets(lines: Iterator[str]) -> str:
    return "\n".join(f"- {line}" for line in lines)


def _provenance(found: Summary, scene: Scene | None) -> Iterator[str]:
    facts = found.facts
    versions = {**facts["made with"], **facts["facts"]["versions"]}
    yield f"Versions: {', '.join(f'{name} {version}' for name, version in versions.items())}."
    if scene is not None:
        models = ", ".join(
            f"{name} {model if isinstance(model, str) else '/'.join(dict.fromkeys(model))}"
            for name, model in scene.models().items()
        )
        yield f"Models, unless a variable changes them: {models}."
    errors = _numbers(found, "step_error")
    if errors.size:
        yield (
            f"Error of the accelerations caused by the time step, as share of their rms: median "
            f"{100 * np.median(errors):.2g} %, worst {100 * errors.max():.2g} %."
        )
    until = _numbers(found, "repeatable_until_s")
    layout = found.facts["layout"]
    parted = int(np.sum(until < (layout["samples"] - 1.5) / layout["rate"]))
    if parted:
        yield (
            f"{parted} of {until.size} motions cannot be repeated to their end: after `repeatable_until_s` they depend "
            "on rounding (rattling gears). Their levels are valid, their single samples are not."
        )
    else:
        yield "All motions can be repeated sample by sample."
    yield (
        "The same plan gives the same samples and the same bits with these versions. Identity: "
        f"{facts['identity']}, code {facts['facts']['code']}."
    )


def _limits(found: Summary, scene: Scene | None) -> Iterator[str]:
    rate = found.facts["layout"]["rate"]
    yield "The data are simulated, not measured. Validate a classifier on a real machine before you use it."
    yield "The data do not cover values outside the ranges above, nor other faults, places and machines."
    yield f"Signals are low-pass filtered before they are sampled at {rate:g} Hz."
    band = getattr(scene.casing, "band_Hz", None) if scene is not None else None
    if band:
        yield f"The casing model contains modes up to {band:g} Hz. Above that, the casing responds too stiffly."
    yield "The signals hold no sensor noise: `gearcase.pieces` and `gearcase dataset export` add it."
    yield "Every run starts with a run-up or transient: leave it out where a steady state is required."
    yield "The page docs/choosing-a-model.md of gearcase gives the limits of each model with measured errors."
    if failed := int(np.sum(found.columns["status"] == FAILED)):
        yield f"Failed runs: {failed}, see the column `reason`. They may be the extremes of a range."


def _numbers(found: Summary, name: str) -> np.ndarray:
    """A column of the runs that are done."""
    values = found.columns.get(name, np.array([]))
    return values[np.isfinite(values)] if values.dtype.kind in "fi" else np.array([])
