"""CalculiX CrunchiX: find it, run a deck, read its tables."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import time
from pathlib import Path

import numpy as np


class PeerMissing(RuntimeError):
    """A program to compare with is not installed."""


class PeerFailed(RuntimeError):
    """A program to compare with did not finish its work."""


def find() -> str:
    """Path of the program; PeerMissing with the remedy."""
    for name in ("ccx", "ccx_2.20", "ccx_2.21", "ccx_2.22"):
        if path := shutil.which(name):
            return path
    raise PeerMissing("CalculiX is not installed: apt-get install calculix-ccx")


def version() -> str:
    """Version of the installed program."""
    done = subprocess.run([find(), "-v"], capture_output=True, text=True, check=False)
    found = re.search(r"[Vv]ersion\s+([\d.]+)", done.stdout)
    return found.group(1).rstrip(".") if found else "unknown"


def run(deck: Path, *, threads: int = 1, limit: float = 7200.0) -> tuple[float, float]:
    """Solve a deck in its folder; wall-clock and processor seconds. The output is kept beside it as .out.

    Raises
    ------
    PeerMissing, PeerFailed : with the last lines of the output
    """
    environment = os.environ | {"OMP_NUM_THREADS": str(threads), "OPENBLAS_NUM_THREADS": str(threads)}
    before, start = os.times(), time.perf_counter()
    log = deck.with_suffix(".out")
    with log.open("w", encoding="utf-8") as out:
        done = subprocess.run(
            [find(), "-i", deck.stem],
            cwd=deck.parent,
            env=environment,
            stdout=out,
            stderr=subprocess.STDOUT,
            timeout=limit,
            check=False,
        )
    after = os.times()
    said = log.read_text(encoding="utf-8")
    if done.returncode or "*ERROR" in said:
        raise PeerFailed(f"CalculiX failed on {deck.name}:\n" + "\n".join(said.splitlines()[-15:]))
    processor = after.children_user - before.children_user + after.children_system - before.children_system
    return time.perf_counter() - start, processor


def tables(result: Path, title: str) -> list[tuple[float, np.ndarray]]:
    """The tables of a .dat file whose heading starts with `title`: (time, rows of numbers)."""
    out: list[tuple[float, list[list[float]]]] = []
    reading = False
    for line in result.read_text(encoding="utf-8").splitlines():
        if line.lstrip().startswith(title):
            out.append((float(line.split()[-1]), []))
            reading = True
        elif reading and line.strip():
            try:
                out[-1][1].append([float(word) for word in line.split()])
            except ValueError:
                reading = False
    return [(moment, np.array(rows)) for moment, rows in out]
