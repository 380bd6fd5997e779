"""Step `diagnose`: all cases of a study against their controls, as files and as words."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray

    from mbd.output.trajectory import Trajectory
    from pipelines.diagnosis.control_diagnosis import Diagnosis
    from pipelines.signals.analysis import DiagnosisSettings


@dataclass(frozen=True, kw_only=True)
class CaseSpec:
    """One comparison: what is looked for."""

    settings: DiagnosisSettings
    full: bool  # its lines are shown in full; else it enters summaries


@dataclass(frozen=True, kw_only=True)
class DiagnosingSpec:
    """All comparisons, and the labels of the motions that are taken: faulty, healthy, faulty, ..."""

    cases: tuple[CaseSpec, ...]
    labels: tuple[Mapping[str, Any], ...]


def build(spec: DiagnosingSpec, *, motions: Sequence[Trajectory]) -> dict[str, Any]:
    """diagnosis.nc, .csv, .json, .md as bytes under "files", the tables of lines as text under "words".

    A window in which no diagnosis is possible must not cost the signals: its reason is returned under "failure".
    """
    from pipelines.diagnosis.export import save_diagnoses
    from pipelines.diagnosis.line_words import markdown
    from pipelines.signals.analysis import DiagnosisError
    from pipelines.signals.response import make_response
    from pipelines.signals.spectrum import SpectrumError

    try:
        found = diagnoses(spec.cases, list(map(make_response, motions, spec.labels)))
    except (DiagnosisError, SpectrumError) as error:
        return {"files": {}, "words": "", "failure": str(error)}
    with tempfile.TemporaryDirectory() as folder:
        files = {path.name: path.read_bytes() for path in save_diagnoses(Path(folder), found)}
    files["diagnosis.md"] = markdown(found).encode()
    full = [d for d, case in zip(found, spec.cases, strict=True) if case.full]
    return {"files": files, "words": words(full), "failure": ""}


def diagnoses(cases: Sequence[CaseSpec], responses: Sequence[xarray.Dataset]) -> list[Diagnosis]:
    """One diagnosis per case; of a case that only enters summaries the lines alone, its spectra would fill memory."""
    from pipelines.diagnosis.control_diagnosis import diagnose

    out = []
    for number, case in enumerate(cases):
        faulty, healthy = responses[2 * number : 2 * number + 2]
        found = diagnose(faulty, healthy, case.settings)
        out.append(found if case.full else replace(found, spectra={}, envelopes={}))
    return out


def words(full: list[Diagnosis]) -> str:
    """The tables of lines of the cases shown in full."""
    from pipelines.diagnosis.line_words import criterion, lines_grid

    parts = [criterion(full[0].settings)]
    for diagnosis in full:
        parts += [lines_grid(diagnosis, window).to_text() for window in diagnosis.settings.windows]
    return "\n\n".join(parts) + "\n"
