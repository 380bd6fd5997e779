"""Step `diagnose`: comparison of all cases of a run with their controls, as files and as text."""

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
    """One comparison, with the settings of its diagnosis."""

    settings: DiagnosisSettings
    full: bool  # tables of its lines are printed; otherwise it is only in summaries


def build(
    cases: Sequence[CaseSpec], labels: Sequence[Mapping[str, Any]], *, motions: Sequence[Trajectory]
) -> dict[str, Any]:
    """The files diagnosis.nc, .csv, .json and .md as bytes under "files", the tables of lines as text under "words".

    If no diagnosis is possible, the reason is returned under "failure", so that the run keeps its signals.

    Parameters
    ----------
    cases : all comparisons
    labels, motions : of the motions in the order faulty, healthy, faulty, ...
    """
    from pipelines.diagnosis.line_words import markdown
    from pipelines.diagnosis.result_export import save_diagnoses
    from pipelines.signals.analysis import DiagnosisError
    from pipelines.signals.response import make_response
    from pipelines.signals.spectrum import SpectrumError

    try:
        found = diagnoses(cases, list(map(make_response, motions, labels)))
    except (DiagnosisError, SpectrumError) as error:
        return {"files": {}, "words": "", "failure": str(error)}
    with tempfile.TemporaryDirectory() as folder:
        files = {path.name: path.read_bytes() for path in save_diagnoses(Path(folder), found)}
    files["diagnosis.md"] = markdown(found).encode()
    full = [d for d, case in zip(found, cases, strict=True) if case.full]
    return {"files": files, "words": words(full), "failure": ""}


def diagnoses(cases: Sequence[CaseSpec], responses: Sequence[xarray.Dataset]) -> list[Diagnosis]:
    """One diagnosis for each case, without spectra if the case is only in summaries, to save memory."""
    from pipelines.diagnosis.control_diagnosis import diagnose

    out = []
    for number, case in enumerate(cases):
        faulty, healthy = responses[2 * number : 2 * number + 2]
        found = diagnose(faulty, healthy, case.settings)
        out.append(found if case.full else replace(found, spectra={}, envelopes={}))
    return out


def words(full: list[Diagnosis]) -> str:
    """The tables of lines of the diagnoses."""
    from pipelines.diagnosis.line_words import criterion, lines_grid

    parts = [criterion(full[0])]
    for diagnosis in full:
        parts += [lines_grid(diagnosis, window).to_text() for window in diagnosis.settings.windows]
    return "\n\n".join(parts) + "\n"
