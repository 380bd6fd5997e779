"""Measured recordings with known damage, judged against healthy ones of the same machine.

    python -m benchmarks.gear_records TABLE

TABLE is a CSV file with the columns `file`, `machine` and `damaged`: a recording and its machine file, both relative to
the folder of the table, and the name of the damaged component, empty if the machine is healthy. Damaged ones are
compared with all healthy ones, a healthy one with the others.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

from pipelines.diagnosis.verdict import judge
from pipelines.diagnosis.words import headline, standing
from pipelines.runs.recorded import machine_of, read_features
from pipelines.signals.features.table import with_common_components


def main(table: Path) -> None:
    """Print the verdict on every recording, and how many are called damaged and different."""
    with table.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    paths = [table.parent / row["file"] for row in rows]
    known, windows = machine_of(paths[0], table.parent / rows[0]["machine"])
    tables = with_common_components([read_features(path, known, windows).table for path in paths])
    healthy = [number for number, row in enumerate(rows) if not row["damaged"]]
    counts = {True: [0, 0, 0], False: [0, 0, 0]}  # by whether it is healthy: recordings, damaged, different
    for number, row in enumerate(rows):
        others = [other for other in healthy if other != number]
        found = judge(
            tables[number], [tables[other] for other in others], known.kinematics, [rows[o]["file"] for o in others]
        )
        count = counts[not row["damaged"]]
        count[:] = count[0] + 1, count[1] + bool(found.damaged), count[2] + bool(found.different)
        print(f"{row['file']:40} {row['damaged'] or 'healthy':20} {headline(found)} {standing(found.first.evidence)}")
    for is_healthy, (total, damaged, different) in counts.items():
        kind = "healthy" if is_healthy else "damaged"
        print(f"{total} {kind} recordings: called damaged {damaged}, different {different}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
