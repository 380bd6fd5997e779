"""Train a classifier on simulated runs of a test bench, and test it on other gears, speeds and loads.

    python examples/classify_bench.py

The script simulates the 240 runs of classify_bench.toml, which takes four minutes on two idle cores. It computes their
features with a sensor noise of 0.05 m/s2 rms. It trains a random forest on the part `train` of the split, and prints
and plots the confusion matrix of the part `test`. For comparison, it repeats this with splits that put data of the
same gears or runs into both parts.
"""

import subprocess
import sys
from pathlib import Path

import matplotlib
import numpy as np
import pandas
from sklearn.ensemble import RandomForestClassifier
from sklearn.metrics import ConfusionMatrixDisplay, confusion_matrix
from sklearn.model_selection import GroupShuffleSplit

import gearcase

PLAN = Path(__file__).with_suffix(".toml")
START = 0.25  # s, after the run-up
NOISE = 0.05  # m/s2 rms
PIECE = 0.15  # s
REPEATS = 5  # of a random split


def main(folder: Path) -> None:
    """Simulate what is missing in the data set, then classify."""
    _gearcase("campaign", str(PLAN), "--out", str(folder))
    _gearcase("features", str(folder), "--start", str(START), "--noise", str(NOISE))
    table, names = run_table(folder)
    train, test = table[table.split == "train"], table[table.split == "test"]
    found = forest().fit(train[names], train.label).predict(test[names])
    labels = sorted(table.label.unique())
    counts = confusion_matrix(test.label, found, labels=labels)
    print(matrix_text(counts, labels))
    print(f"correct: {share(np.trace(counts) / counts.sum())}; by chance: {share(chance(test.label))}\n")
    draw(counts, labels, folder / "confusion.png")

    spectra, known = piece_table(folder)
    print(f"{'mean of random splits':42} by gears    leaking")
    for what, values, rows in (
        ("features; leaking: the same gears", table[names].to_numpy(), table),
        ("spectra of pieces; leaking: the same runs", spectra, known),
    ):
        fair = scores(values, rows.label, rows.group)
        leaking = scores(values, rows.label, np.arange(len(rows)))
        print(f"{what:42} {share(fair):>8} {share(leaking):>10}")


def run_table(folder: Path) -> tuple[pandas.DataFrame, list[str]]:
    """A line per run with its label, split and group, and the names of its features."""
    rows = pandas.read_parquet(folder / "rows.parquet").set_index("run")
    features = pandas.read_parquet(folder / "features.parquet")
    names = ["sensor", "axis", "component", "feature"]
    wide = features.pivot(index="run", columns=names, values="value").dropna(axis="columns")
    wide.columns = [" ".join(words) for words in wide.columns]
    return rows.join(wide, how="inner"), list(wide.columns)


def piece_table(folder: Path) -> tuple[np.ndarray, pandas.DataFrame]:
    """Spectra (piece, sensor x axis x band) of pieces in decibels, four lines to a band, and what each piece is of."""
    spectra, known = [], []
    dataset = gearcase.open_dataset(folder).sel(time=slice(START, None))
    for one in gearcase.pieces(dataset, PIECE, noise_m_s2=NOISE):
        lines = np.abs(np.fft.rfft(one.values * np.hanning(one.sizes["time"])))
        bands = lines[..., : lines.shape[-1] // 4 * 4].reshape(*lines.shape[:-1], -1, 4)
        spectra.append(20 * np.log10(np.sqrt((bands**2).mean(axis=-1))).reshape(len(one), -1))
        known.append(pandas.DataFrame({name: one[name].values for name in ("run", "label", "group")}))
    return np.concatenate(spectra), pandas.concat(known)


def scores(values: np.ndarray, labels: pandas.Series, groups: np.ndarray) -> float:
    """Mean share of correct answers over random splits that keep groups together."""
    label = labels.to_numpy()
    splits = GroupShuffleSplit(REPEATS, test_size=0.3, random_state=0).split(values, label, groups)
    return float(np.mean([forest().fit(values[a], label[a]).score(values[b], label[b]) for a, b in splits]))


def forest() -> RandomForestClassifier:
    """The classifier as scikit-learn ships it, with a fixed seed."""
    return RandomForestClassifier(random_state=0, n_jobs=2)


def chance(labels: pandas.Series) -> float:
    """Share of right answers of a classifier that always gives the most frequent label."""
    return float(labels.value_counts(normalize=True).max())


def share(value: float) -> str:
    """Per cent."""
    return f"{100 * value:.0f} %"


def matrix_text(counts: np.ndarray, labels: list[str]) -> str:
    """The confusion matrix, a line per true label."""
    width = max(map(len, labels))
    lines = [f"{'true / found':{width}}  " + "  ".join(f"{label:>{width}}" for label in labels)]
    for label, row in zip(labels, counts, strict=True):
        lines.append(f"{label:{width}}  " + "  ".join(f"{count:>{width}}" for count in row))
    return "\n".join(lines)


def draw(counts: np.ndarray, labels: list[str], path: Path) -> None:
    """The confusion matrix as a picture."""
    matplotlib.use("agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(5.4, 4.6), layout="constrained")
    ConfusionMatrixDisplay(counts, display_labels=labels).plot(ax=axes, cmap="Blues", colorbar=False)
    axes.set_title("Test runs: other gears, speeds and loads")
    figure.savefig(path, dpi=120)
    pyplot.close(figure)
    print(path)


def _gearcase(*words: str) -> None:
    subprocess.run([sys.executable, "-m", "gearcase", *words], check=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("campaigns/classify_bench"))
