"""An undisturbed run, which disturbed ones are compared with."""

from __future__ import annotations

import time

import pytest


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory) -> tuple[str, float]:
    """Digest of an undisturbed run, and its seconds once the compiled code is stored."""
    from machine import start, whole_results

    seconds, found = 0.0, set()
    for _ in range(2):
        folder = tmp_path_factory.mktemp("undisturbed")
        begin = time.perf_counter()
        process = start(folder)
        _, err = process.communicate()
        assert process.returncode == 0, err
        seconds = time.perf_counter() - begin
        found |= set(whole_results(folder).values())
    assert len(found) == 1
    return found.pop(), seconds
