"""Stage `diagnose`: all cases of a study against their controls, as files and as words."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray

    from pipelines.analysis import DiagnosisSettings
    from pipelines.diagnosis import Diagnosis


@dataclass(frozen=True, kw_only=True)
class CaseSpec:
    """One comparison: what is looked for."""

    settings: DiagnosisSettings
    full: bool  # its lines are shown in full; else it enters summaries


@dataclass(frozen=True, kw_only=True)
class DiagnosingSpec:
    """All comparisons, in the order of the responses that are taken: faulty, healthy, faulty, ..."""

    cases: tuple[CaseSpec, ...]


def build(spec: DiagnosingSpec, *responses: xarray.Dataset) -> dict[str, Any]:
    """diagnosis.nc, .csv, .json, .md as bytes under "files", the verdict with its tables as text under "words".

    A window in which no diagnosis is possible must not cost the signals: its reason is returned under "failure".
    """
    from pipelines.analysis import DiagnosisError
    from pipelines.export import save_diagnoses
    from pipelines.spectrum import SpectrumError
    from pipelines.verdict import markdown

    try:
        found = diagnoses(spec, responses)
    except (DiagnosisError, SpectrumError) as error:
        return {"files": {}, "words": "", "failure": str(error)}
    with tempfile.TemporaryDirectory() as folder:
        files = {path.name: path.read_bytes() for path in save_diagnoses(Path(folder), found)}
    files["diagnosis.md"] = markdown(found).encode()
    full = [d for d, case in zip(found, spec.cases, strict=True) if case.full]
    return {"files": files, "words": words(found, full), "failure": ""}


def diagnoses(spec: DiagnosingSpec, responses: tuple[xarray.Dataset, ...]) -> list[Diagnosis]:
    """One diagnosis per case."""
    from pipelines.diagnosis import diagnose

    out = []
    for number, case in enumerate(spec.cases):
        faulty, healthy = responses[2 * number : 2 * number + 2]
        out.append(diagnose(faulty, healthy, case.settings))
    return out


def words(every: list[Diagnosis], full: list[Diagnosis]) -> str:
    """The answer first, then the envelope tables of the cases shown in full, then the summary."""
    from pipelines.verdict import criterion, headline, lines_grid, sentences, summary_grid

    parts = [headline(every), criterion(every[0])]
    for diagnosis in full:
        parts += sentences(diagnosis)
        parts += [lines_grid(diagnosis, window).to_text() for window in diagnosis.settings.windows]
    parts.append(summary_grid(every).to_text())
    return "\n\n".join(parts) + "\n"
