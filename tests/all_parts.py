"""Run every test, the slow ones too, file by file; a part that passed on this source tree is not run again.

Usage: python tests/all_parts.py [--restart]. Marks are kept in .test-all/<hash of the sources>/. Processor seconds of
every part are printed, of the extremes also what they counted; a part may take 8 minutes.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SECONDS_PER_PART = 8 * 60
NO_TESTS_COLLECTED = 5


def source_hash() -> str:
    """SHA-256 over all Python, TOML and Markdown files of the project."""
    total = hashlib.sha256()
    folders = [
        path for path in ROOT.iterdir() if path.is_dir() and not path.name.startswith(".") and path.name != "runs"
    ]
    files = [*ROOT.glob("*"), *(path for folder in folders for path in folder.rglob("*"))]
    for path in sorted(files):
        if path.is_file() and path.suffix in (".py", ".toml", ".md"):
            total.update(path.relative_to(ROOT).as_posix().encode())
            total.update(path.read_bytes())
    return total.hexdigest()[:16]


def run_part(path: Path) -> bool:
    """Run one test file with all markers; True if it passed."""
    counts = ("-s",) if "extremes" in path.parts else ()
    command = [sys.executable, "-m", "pytest", "-m", "slow or not slow", *counts, str(path)]
    try:
        code = subprocess.run(command, cwd=ROOT, timeout=SECONDS_PER_PART, check=False).returncode
    except subprocess.TimeoutExpired:
        print(f"{path.name}: not finished after {SECONDS_PER_PART} s", flush=True)
        return False
    return code in (0, NO_TESTS_COLLECTED)


def processor_seconds() -> float:
    """Of all child processes that have ended."""
    times = os.times()
    return times.children_user + times.children_system


def main() -> int:
    marks = ROOT / ".test-all" / source_hash()
    if "--restart" in sys.argv:
        shutil.rmtree(marks, ignore_errors=True)
    marks.mkdir(parents=True, exist_ok=True)
    parts = sorted((ROOT / "tests").rglob("test_*.py"))
    failed = []
    taken: dict[str, float] = {}
    for number, path in enumerate(parts, 1):
        mark = marks / path.stem
        started, before = time.monotonic(), processor_seconds()
        print(f"[{number}/{len(parts)}] {path.relative_to(ROOT)}", flush=True)
        if mark.exists():
            print(f"passed before on the same sources, {mark.read_text(encoding='utf-8').strip()}", flush=True)
            continue
        passed = run_part(path)
        taken[path.name] = processor_seconds() - before
        words = f"{time.monotonic() - started:.1f} s, {taken[path.name]:.1f} s of the processor"
        print(words, flush=True)
        if passed:
            mark.write_text(words + "\n", encoding="utf-8")
        else:
            failed.append(path.name)
    longest = sorted(taken, key=lambda name: -taken[name])[:5]
    print("longest: " + ", ".join(f"{name} {taken[name]:.0f} s" for name in longest), flush=True)
    print(f"{len(parts) - len(failed)} passed, {len(failed)} failed {' '.join(failed)}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
