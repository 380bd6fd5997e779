"""docs/validation.md: every published or exact number that gearcase is held against.

python -m benchmarks.validation computes all rows and writes the page; it takes a few minutes. Exit code 1 if a
deviation is beyond its gate.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path

from benchmarks.checks import gears, motion, plane, signals, solid, structures
from benchmarks.checks.invariants import INVARIANTS
from benchmarks.checks.record import Check, Subject, Values, numbers

SUBJECTS: tuple[Subject, ...] = (
    *gears.SUBJECTS,
    plane.SUBJECT,
    solid.SUBJECT,
    *structures.SUBJECTS,
    *motion.SUBJECTS,
    signals.SUBJECT,
)
PAGE = Path(__file__).resolve().parent.parent / "docs" / "validation.md"
HEADERS = ("quantity", "source", "unit", "reference", "gearcase", "deviation", "gate", "test")
LEAD = """# Validation

This page compares results of gearcase with published, independently computed or exact values. Each row gives the
largest accepted deviation (gate) and the test that enforces it. `python -m benchmarks.validation` computes the page in
minutes. The rig is the scene `rig-healthy`, c the mesh cycle. Version {version}.

For several values the deviation is the largest. A deviation in % is relative, unless the unit of
the quantity is %. Other deviations are absolute. The last table lists properties without a single reference number;
*see test* means that the test has several gates or none.""".format(version=metadata.version("gearcase"))


def fixed_cells(check: Check) -> tuple[str, ...]:
    """The cells that do not depend on the machine: quantity, source, unit, reference, gate, test."""
    file, _, function = check.test.partition("::")
    cells = (check.quantity, check.source, check.unit, numbers(check.reference), check.shown(check.gate))
    return (*(cell.replace("|", "\\|") for cell in cells), f"`{file}` {function}")


def row(check: Check, ours: Values) -> str:
    """One line of the page."""
    *front, gate, test = fixed_cells(check)
    found = check.shown(check.deviation(ours))
    return "| " + " | ".join((*front, numbers(ours), found, gate, test)) + " |"


def page(values: Mapping[Check, Values]) -> str:
    """The whole page from the library's values."""
    lines = [LEAD]
    for subject in SUBJECTS:
        lines += [f"\n## {subject.title}\n", _line(HEADERS), _line(["---"] * len(HEADERS))]
        lines += [row(check, values[check]) for check in subject.checks]
    lines += ["\n## Invariants\n", _line(("statement", "gate", "test")), _line(["---"] * 3)]
    for statement, gate, test in INVARIANTS:
        file, _, function = test.partition("::")
        lines.append(_line((statement, gate, f"`{file}` {function}")))
    return "\n".join(lines) + "\n"


def _line(cells: tuple[str, ...] | list[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def main() -> int:
    """Compute every row, write the page; 1 if a gate is missed."""
    values, missed = {}, 0
    for check in (check for subject in SUBJECTS for check in subject.checks):
        values[check] = check.compute()
        deviation = check.deviation(values[check])
        if not deviation < check.gate:
            missed += 1
            print(f"beyond its gate: {check.quantity}: {check.shown(deviation)} (gate {check.shown(check.gate)})")
    PAGE.write_text(page(values), encoding="utf-8")
    print(f"{len(values)} rows, {missed} beyond their gates; see {PAGE.name}")
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main())
