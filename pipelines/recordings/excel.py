"""Excel workbooks: the first sheet, read as text with tabulators. They need the package openpyxl."""

from __future__ import annotations

import tempfile
from datetime import date, datetime, time
from pathlib import Path
from typing import Any

from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown
from pipelines.recordings import delimited
from pipelines.recordings.recording_channels import RecordedContents


def open_channels(path: Path) -> RecordedContents:
    """The channels of the first sheet; its rows are the lines of messages.

    Raises
    ------
    InputError : the package is not installed; or see `pipelines.recordings.delimited.open_channels`
    """
    try:
        from openpyxl import load_workbook
    except ImportError as error:
        raise InputError(
            f"{shown(path)}: openpyxl is not installed. Type: pip install 'gearcase[excel]'; or save the sheet as CSV."
        ) from error
    book = load_workbook(path, read_only=True, data_only=True)
    with tempfile.TemporaryDirectory() as folder:
        text = Path(folder) / "sheet.tsv"
        with text.open("w", encoding="utf-8") as file:
            for row in book.worksheets[0].iter_rows(values_only=True):
                file.write("\t".join(map(_cell, row)) + "\n")
        book.close()
        return delimited.open_channels(path, text)


def _cell(value: Any) -> str:
    """As text; dates and times of day in the form of ISO 8601."""
    if isinstance(value, date | datetime | time):
        return value.isoformat()
    return "" if value is None else " ".join(str(value).split())
