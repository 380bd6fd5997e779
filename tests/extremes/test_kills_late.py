"""kill -9 in the second half of a run: afterwards the results equal those of an undisturbed run, bit for bit."""

from __future__ import annotations

import os

import pytest
from machine import kill

KILLS = 50


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="signals as POSIX has them")
def test_kill_9_at_fifty_moments_of_the_second_half(undisturbed, tmp_path):
    at_work = kill(tmp_path, undisturbed, between=(0.5, 1.0), kills=KILLS, seed=10)
    assert at_work > KILLS // 4  # a run that finds the stages which a killed one stored ends before its moment
