"""Measured recordings of bearings with known damage, judged without healthy ones.

    python -m benchmarks.bearing_records TABLE

TABLE is a CSV file with the columns `file`, `machine` and `damaged`: a recording and its machine file, both relative to
the folder of the table, and the name of the damaged component as in "DE BPFO", empty if the machine is healthy.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

from pipelines.runs.recorded import judge_files


def main(table: Path) -> None:
    """Print the first component of every recording, and how many answers are right."""
    right = wrong = first = damaged = 0
    with table.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        found = next(judge_files([table.parent / row["file"]], machine=table.parent / row["machine"])).impacts
        true, clear = row["damaged"], [one.component for one in found if one.clear][:1]
        damaged += bool(true)
        right += clear == [true]
        wrong += bool(clear) and clear != [true]
        first += bool(found) and found[0].component == true
        level = f"{found[0].component} {found[0].level:.1f} dB" if found else "-"
        print(f"{row['file']:40} {true or 'healthy':12} {level}")
    print(f"{len(rows)} recordings, {damaged} damaged: stated and right {right}, wrong {wrong}, ranks first {first}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
