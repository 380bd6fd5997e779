"""Run every test, the slow ones too, two files at a time; one that passed on this source tree is not run again.

Usage: python tests/all_parts.py [--restart]. Marks are kept in .test-all/<hash of the sources>/. What the extremes
counted is printed with them; a file may take 8 minutes.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SECONDS_PER_PART = 8 * 60
SIDE_BY_SIDE = 2
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


def one_part(path: Path, mark: Path) -> tuple[bool, float]:
    """Run one test file with all markers, and print what it says at once; whether it passed, and its seconds."""
    if mark.exists():
        print(
            f"{path.relative_to(ROOT)}: passed before on the same sources, {mark.read_text('utf-8').strip()}",
            flush=True,
        )
        return True, 0.0
    counts = ("-s",) if "extremes" in path.parts else ()
    command = [sys.executable, "-m", "pytest", "-m", "slow or not slow", *counts, str(path)]
    started = time.monotonic()
    try:
        done = subprocess.run(command, cwd=ROOT, timeout=SECONDS_PER_PART, check=False, capture_output=True, text=True)
        passed, said = done.returncode in (0, NO_TESTS_COLLECTED), done.stdout + done.stderr
    except subprocess.TimeoutExpired as error:
        passed, said = False, f"{(error.stdout or b'').decode()}\nnot finished after {SECONDS_PER_PART} s\n"
    seconds = time.monotonic() - started
    print(f"{path.relative_to(ROOT)}: {seconds:.1f} s\n{said}", flush=True)
    if passed:
        mark.write_text(f"{seconds:.1f} s\n", encoding="utf-8")
    return passed, seconds


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
    before = processor_seconds()
    with ThreadPoolExecutor(SIDE_BY_SIDE) as pool:
        ended = list(pool.map(lambda path: one_part(path, marks / path.stem), parts))
    failed = [path.name for path, (passed, _) in zip(parts, ended, strict=True) if not passed]
    taken = {path.name: seconds for path, (_, seconds) in zip(parts, ended, strict=True)}
    longest = sorted(taken, key=lambda name: -taken[name])[:5]
    print("longest: " + ", ".join(f"{name} {taken[name]:.0f} s" for name in longest), flush=True)
    print(f"{processor_seconds() - before:.0f} s of the processor", flush=True)
    print(f"{len(parts) - len(failed)} passed, {len(failed)} failed {' '.join(failed)}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
