"""REXS files: XML (.rexs), JSON (.rexsj), or one of these in a ZIP archive (.rexsz)."""

from __future__ import annotations

import io
import zipfile
import zlib
from pathlib import Path

from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown
from pipelines.io.user_files import checked_path, regular_file
from pipelines.rexs.document import Document, RexsError
from pipelines.rexs.json_form import document_of_json
from pipelines.rexs.xml_form import document_of_xml

ENDINGS = (".rexs", ".rexsj", ".rexsz")
MOST_BYTES = 50_000_000  # of the text of a document
VERSIONS = ("1.0", "1.1", "1.2", "1.3", "1.4", "1.5", "1.6")


def is_rexs(name: str | Path) -> bool:
    """Whether a name has the ending of a REXS file."""
    return Path(name).suffix.lower() in ENDINGS


def read_document(name: str | Path) -> Document:
    """The document of a file.

    Raises
    ------
    InputError : nothing lies there, or it cannot be read
    RexsError : too large, no REXS, or a version that is not read
    """
    path, source = checked_path(name), shown(name)
    try:
        content = regular_file(path, MOST_BYTES).read_bytes()
    except FileNotFoundError:
        raise InputError(f"{source}: no such file. Check the path.") from None
    except OSError as error:
        raise InputError(f"{source}: cannot be read ({error.strerror}). Give a readable file.") from error
    ending = path.suffix.lower()
    if ending == ".rexsz":
        content, ending = _unpacked(content, source)
    document = document_of_json(content, source) if ending == ".rexsj" else document_of_xml(content, source)
    if document.version not in VERSIONS:
        raise RexsError(
            f'{source}: REXS version "{shown(document.version)}" is not supported. Export the file in version '
            f"{VERSIONS[0]} to {VERSIONS[-1]}."
        )
    return document


def _unpacked(content: bytes, source: str) -> tuple[bytes, str]:
    """The one document in an archive, and its ending."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            names = [name for name in archive.namelist() if is_rexs(name) and not name.endswith(".rexsz")]
            if len(names) != 1:
                raise RexsError(f"{source}: holds {len(names)} REXS documents, one is read. Pack one .rexs file.")
            with archive.open(names[0]) as file:
                text = file.read(MOST_BYTES + 1)
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError) as error:
        raise RexsError(
            f"{source}: not a ZIP archive that can be read ({shown(str(error))}). Pack it again."
        ) from error
    if len(text) > MOST_BYTES:
        raise RexsError(f"{source}: its document has more than {MOST_BYTES / 1e6:g} MB. Give a smaller one.")
    return text, Path(names[0]).suffix.lower()
