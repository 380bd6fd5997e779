"""Measured recordings with known damage, judged against healthy ones of the same machine, or without.

    python -m benchmarks.measured_records TABLE [--alone]

TABLE is a CSV file with the columns `file`, `machine` and `damaged`: a recording and its machine file, both relative to
the folder of the table, and the name of the damaged component as in "DE BPFO", empty if the machine is healthy. Each
recording is compared with all other healthy ones that have its machine file. If there are none, or with --alone, its
bearings are judged by their impacts.
"""

from __future__ import annotations

import csv
import sys
from collections import Counter
from pathlib import Path

from pipelines.diagnosis.impacts import impacts
from pipelines.diagnosis.judge import judge
from pipelines.diagnosis.verdict_words import headline, standing
from pipelines.runs.recorded_file import machine_of, read_features
from pipelines.signals.features.feature_table import with_common_components


def main(table: Path, alone: bool) -> None:
    """Print the answer for every recording, and how many damaged and healthy ones are called damaged or different."""
    with table.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    known = [machine_of(table.parent / row["file"], table.parent / row["machine"]) for row in rows]
    read = [read_features(table.parent / row["file"], *one).table for row, one in zip(rows, known, strict=True)]
    healthy = [number for number, row in enumerate(rows) if not row["damaged"] and not alone]
    counts = {"damaged": Counter[str](), "healthy": Counter[str]()}
    for number, row in enumerate(rows):
        others = [other for other in healthy if other != number and rows[other]["machine"] == row["machine"]]
        tables = with_common_components([read[one] for one in (number, *others)])
        if others:
            found = judge(tables[0], tables[1:], known[number][0].kinematics, [rows[other]["file"] for other in others])
            first, damaged, different = found.first.component, bool(found.damaged), bool(found.different)
            words = f"{headline(found)} {standing(found.first.evidence)}"
        else:
            best = next(iter(impacts(tables[0])), None)
            first, damaged, different = ("-", False, False) if best is None else (best.component, best.clear, False)
            words = first if best is None else f"{first} {best.level:.1f} dB"
        right = first == row["damaged"]
        facts = {
            "different": different,
            "called damaged": damaged,
            "and right": damaged and right,
            "ranks first": right,
        }
        counts["damaged" if row["damaged"] else "healthy"].update(
            {"recordings": 1} | {k: int(v) for k, v in facts.items()}
        )
        print(f"{row['file']:40} {row['damaged'] or 'healthy':20} {words}")
    for kind, count in counts.items():
        print(f"{kind}: {', '.join(f'{name} {number}' for name, number in count.items()) or 'none'}")


if __name__ == "__main__":
    main(Path(sys.argv[1]), "--alone" in sys.argv[2:])
