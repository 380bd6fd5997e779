"""Run every test, the slow ones too, file by file; a part that passed on this source tree is not run again.

Usage: python tests/all_parts.py [--restart]. Marks are kept in .test-all/<hash of the sources>/.
"""

from __future__ import annotations

import hashlib
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
    for folder in ("fem", "mbd", "pipelines", "meshes", "tests", "docs", "."):
        pattern = "*" if folder == "." else "**/*"
        for path in sorted((ROOT / folder).glob(pattern)):
            if path.is_file() and path.suffix in (".py", ".toml", ".md"):
                total.update(path.relative_to(ROOT).as_posix().encode())
                total.update(path.read_bytes())
    return total.hexdigest()[:16]


def run_part(path: Path) -> bool:
    """Run one test file with all markers; True if it passed."""
    command = [sys.executable, "-m", "pytest", "-m", "slow or not slow", str(path)]
    try:
        code = subprocess.run(command, cwd=ROOT, timeout=SECONDS_PER_PART, check=False).returncode
    except subprocess.TimeoutExpired:
        print(f"{path.name}: not finished after {SECONDS_PER_PART} s", flush=True)
        return False
    return code in (0, NO_TESTS_COLLECTED)


def main() -> int:
    marks = ROOT / ".test-all" / source_hash()
    if "--restart" in sys.argv:
        shutil.rmtree(marks, ignore_errors=True)
    marks.mkdir(parents=True, exist_ok=True)
    parts = sorted((ROOT / "tests").rglob("test_*.py"))
    passed = failed = 0
    for number, path in enumerate(parts, 1):
        mark = marks / path.stem
        started = time.monotonic()
        print(f"[{number}/{len(parts)}] {path.relative_to(ROOT)}", flush=True)
        if mark.exists():
            print("passed before on the same sources", flush=True)
            passed += 1
        elif run_part(path):
            mark.write_text(f"{time.monotonic() - started:.1f} s\n", encoding="utf-8")
            passed += 1
        else:
            failed += 1
    print(f"{passed} passed, {failed} failed", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
