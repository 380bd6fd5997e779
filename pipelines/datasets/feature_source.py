"""Features of recordings, runs and data sets as one tidy table: a row for each signal, channel, component and feature.

Those of a data set are the rows of `pipelines.datasets.feature_tables`.
"""

from __future__ import annotations

import logging
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from pipelines.datasets.feature_tables import Progress, Window, dataset_rows, stored_table
from pipelines.datasets.signal_layout import FACTS
from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown
from pipelines.io.user_files import whole_file
from pipelines.recordings.formats import BY_ENDING
from pipelines.runs.recorded_file import machine_of, read_features, recording_and_window, requested_windows
from pipelines.runs.run_folder import RESPONSE

if TYPE_CHECKING:
    import pandas

    from pipelines.signals.features.feature_table import FeatureTable

_LOG = logging.getLogger(__name__)
FEATURES = "features.parquet"
ENDINGS = (".parquet", ".csv")
_NAMED = 3  # signals that a warning names


class FeatureSource:
    """Features of recordings and runs, or of one data set.

    Parameters
    ----------
    sources : files, runs, folders of files, or the folder of one data set
    machine : its description or scene; that of the run or data set if None
    start, end : of the part to evaluate, s; an infinite end is that of the signal
    noise : rms (m/s2) of added white noise, which depends only on the signals

    Raises
    ------
    InputError : a data set is not given alone, or is damaged; a folder has no recording
    """

    def __init__(
        self, sources: Sequence[str | Path], machine: str | Path | None, start: float, end: float, noise: float
    ) -> None:
        self.failures: dict[str, str] = {}
        self._sources, self._machine, self._noise = sources, machine, noise
        self._windows = {"the window": (start, end)} if (start, end) != (0.0, math.inf) else {}
        kept = [Path(one) for one in sources if (Path(one) / FACTS).is_file()]
        if kept and (len(sources) > 1 or machine is not None):
            raise InputError(f"{shown(kept[0])}: a data set has its own machine. Give it alone, without --machine.")
        self.folder = kept[0] if kept else None

    def frames(self, executor: Executor, on_progress: Progress) -> Iterator[pandas.DataFrame]:
        """The rows of every signal. A signal without features is added to `failures`, with the reason.

        At the end these are logged, once for each reason, and the shafts and features that some signals lack.

        Raises
        ------
        InputError : no signal has features; the message states the reason for the first one
        """
        import pandas as pd

        found, lines = 0, Counter[tuple[str, str]]()  # signals with features, in total and by component and feature
        lacking, refused = dict[str, list[str]](), dict[str, list[str]]()  # signals, by shaft and its gears; by reason
        for key, name, table, failure in self._computed(executor, on_progress):
            if table is None:
                self.failures[str(name)] = failure
                refused.setdefault(failure.removeprefix(f"{shown(str(name))}: "), []).append(shown(str(name)))
                continue
            for shaft, _, reason in (one.partition(": ") for one in table.left_out):
                lacking.setdefault(shaft, []).append(f"{key} {shown(str(name))}: {reason}")
            yield pd.DataFrame({key: name, **table.columns()})
            found += 1
            lines.update(table.lines)
        for shaft, signals in lacking.items():
            _LOG.warning("no features of %s in %d signals. The first: %s", shaft, len(signals), signals[0])
        few = [
            f"{component} {feature} (in {count} of {found})"
            for (component, feature), count in lines.items()
            if count < found and not any(component in shaft for shaft in lacking)
        ]
        if few:
            _LOG.warning(
                "features that some signals lack: %s. Too few of their orders are within the spectrum and differ from "
                "multiples of the shaft speeds, or their shaft has no features",
                ", ".join(few),
            )
        for reason, names in list(refused.items())[0 if found else 1 :]:  # the first is the error below
            some = ", ".join(names[:_NAMED]) + ", ..." * (len(names) > _NAMED)
            _LOG.warning(
                "no features of %d of %d signals, %s: %s", len(names), found + len(self.failures), some, reason
            )
        if not found:
            raise InputError(next(iter(self.failures.values()), "There is no finished run. Repeat the campaign."))

    def _computed(
        self, executor: Executor, on_progress: Progress
    ) -> Iterator[tuple[str, str | int, FeatureTable | None, str]]:
        if self.folder is not None:
            for row in dataset_rows(self.folder, self._windows, self._noise, executor, on_progress):
                yield "run", row["run"], stored_table(row["table"]), row["failure"]
            return
        files = [file for one in self._sources for file in _files(one)]
        compute = partial(_of_recording, machine=self._machine, windows=self._windows, noise=self._noise)
        done = map(compute, files) if len(files) == 1 else executor.map(compute, files)
        for number, (file, (table, failure)) in enumerate(zip(files, done, strict=True), 1):
            on_progress(number, len(files))
            yield "recording", str(file), table, failure


def write_features(path: Path, frames: Iterable[pandas.DataFrame]) -> int:
    """Write a table as Parquet or CSV by the ending of the path, completely or not at all; its number of rows.

    Raises
    ------
    OSError : it cannot be written
    """
    import pyarrow as pa
    import pyarrow.csv
    import pyarrow.parquet

    count, writer = 0, None
    kind = pa.csv.CSVWriter if path.suffix.lower() == ".csv" else pa.parquet.ParquetWriter
    with whole_file(path) as aside:
        try:
            for frame in frames:
                table = pa.Table.from_pandas(frame, preserve_index=False).replace_schema_metadata()
                writer = writer or kind(aside, table.schema)
                writer.write_table(table)
                count += len(frame)
        finally:
            if writer is not None:
                writer.close()
    return count


def _files(source: str | Path) -> list[str | Path]:
    """The recordings of a folder by name; a file, run or scene by itself."""
    folder = Path(source)
    if not folder.is_dir() or (folder / RESPONSE).is_file():
        return [source]
    files: list[str | Path] = sorted(one for one in folder.iterdir() if one.suffix.lower() in BY_ENDING)
    if not files:
        raise InputError(
            f"{shown(folder)}: holds no recording, no finished run and no data set. Give a folder with files that end "
            f"in {', '.join(BY_ENDING)}."
        )
    return files


def _of_recording(
    source: str | Path, machine: str | Path | None, windows: Mapping[str, Window], noise: float
) -> tuple[FeatureTable | None, str]:
    """The features of a recording or run, or the reason why it has none."""
    try:
        path, asked = recording_and_window(source)
        known, of_scene = machine_of(path, machine)
        chosen = requested_windows(source, asked, of_scene) if asked else windows
        return read_features(path, known, chosen, noise).table, ""
    except InputError as error:
        return None, str(error)
