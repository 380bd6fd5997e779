"""Formats of recordings: one reader each, chosen by the ending of the file's name."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from pipelines.io.errors import InputError
from pipelines.io.shown_text import nearest_name, shown
from pipelines.io.user_files import regular_file, sibling_names
from pipelines.recordings.recording_channels import RecordedContents

SHARE = 0.5  # of the memory that is free, which one file may take


@dataclass(frozen=True, kw_only=True)
class RecordingFormat:
    """A reader by the name of its module, which is imported when a file of the format is opened.

    Its function `open_channels` gives the channels of a file. The function named `measures` gives the bytes that this
    takes; "" where the file is read part by part.
    """

    name: str
    endings: tuple[str, ...]
    reader: str  # module
    measures: str = ""

    def open(self, path: Path) -> RecordedContents:
        """The channels of a file."""
        contents: RecordedContents = import_module(self.reader).open_channels(path)
        return contents

    def memory(self, path: Path) -> int:
        """Bytes of memory that `open` takes; 0 where it reads the file part by part."""
        return int(getattr(import_module(self.reader), self.measures)(path)) if self.measures else 0


_TEXT, _ROOM = (".csv", ".txt", ".tsv", ".dat", ".asc", ".lvm"), "pipelines.recordings."
_NUMPY = _ROOM + "numpy_files"
FORMATS = (
    RecordingFormat(name="text", endings=_TEXT, reader=_ROOM + "delimited"),
    RecordingFormat(name="MATLAB", endings=(".mat",), reader=_ROOM + "matlab", measures="memory"),
    RecordingFormat(name="HDF5", endings=(".h5", ".hdf5", ".hdf", ".nc"), reader=_ROOM + "hdf5"),
    RecordingFormat(name="UFF 58", endings=(".uff", ".unv"), reader=_ROOM + "universal", measures="memory"),
    RecordingFormat(name="NPY", endings=(".npy",), reader=_NUMPY),
    RecordingFormat(name="NPZ", endings=(".npz",), reader=_NUMPY, measures="memory"),
    RecordingFormat(name="WAV", endings=(".wav",), reader=_ROOM + "wav", measures="memory"),
    RecordingFormat(name="Excel", endings=(".xlsx",), reader=_ROOM + "excel"),
    RecordingFormat(name="TDMS", endings=(".tdms",), reader=_ROOM + "tdms", measures="memory"),
)
BY_ENDING: Mapping[str, RecordingFormat] = {ending: one for one in FORMATS for ending in one.endings}


def format_of(path: Path) -> RecordingFormat:
    """The format of a file.

    Raises
    ------
    InputError : there is no such file, or no format has the ending of its name
    """
    found = BY_ENDING.get(path.suffix.lower())
    if found is None:
        ending = f'the ending "{shown(path.suffix)}" is unknown' if path.suffix else "its name has no ending"
        raise InputError(f"{shown(path)}: {ending}. Allowed are {', '.join(BY_ENDING)}.")
    try:
        if not regular_file(path).stat().st_size:
            raise InputError(f"{shown(path)}: is empty (0 bytes). Give a recording.")
    except FileNotFoundError:
        near = nearest_name(path.name, sibling_names(path))
        hint = f"Did you mean {shown(near)}?" if near else "Check the path."
        raise InputError(f"{shown(path)}: no such file. {hint}") from None
    return found


def memory_needed(path: Path) -> int:
    """Bytes of memory that reading a file takes, 0 where it is read part by part.

    Raises
    ------
    InputError : not a file that can be read, or damaged
    """
    form = format_of(path)
    with damage_refused(path, form):
        return form.memory(path)


def open_channels(path: Path) -> RecordedContents:
    """The channels of a file, to be closed.

    Raises
    ------
    InputError : not a file that can be read, damaged, or larger than the memory that is free
    """
    import psutil

    form, needed = format_of(path), memory_needed(path)
    free = psutil.virtual_memory().available
    if needed > SHARE * free:
        raise InputError(
            f"{shown(path)}: takes {needed / 1e6:.0f} MB of memory, {SHARE * free / 1e6:.0f} MB may be used (half of "
            "what is free). Shorten it, or save it as HDF5, NPY or CSV, which are read in parts."
        )
    with damage_refused(path, form):
        return form.open(path)


@contextlib.contextmanager
def damage_refused(path: Path, form: RecordingFormat) -> Iterator[None]:
    """Turn what a library raises, when it reads a file in the block, into InputError."""
    try:
        yield
    except (InputError, MemoryError):
        raise
    except Exception as error:  # a library that meets a damaged file raises errors of every kind
        reason = " ".join(str(error).split()).partition(". ")[0].rstrip(".") or type(error).__name__
        raise InputError(
            f"{shown(path)}: cannot be read as {form.name} ({shown(reason)}). It is damaged, cut off or of another "
            "format. Save or copy it again."
        ) from error
