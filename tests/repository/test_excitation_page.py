"""The example of docs/excitations.md, with the numbers it prints."""

import re

import numpy as np
from sources import ROOT

PAGE = ROOT / "docs" / "excitations.md"


def test_the_example_gives_the_numbers_of_the_page():
    (block,) = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    found = {"__name__": "page"}
    exec(compile(block.split("\n\nprint(")[0], PAGE.name, "exec"), found)
    lines = found["lines"]
    force, heard = lines([], (1, 6, 20))
    assert force[:2].max() < 2e-5
    assert abs(heard[2] - 0.13) < 0.005
    force, heard = lines([found["unbalance"]], (1, 2))
    assert abs(force[0] / (0.5 * 5e-4 * (30 * np.pi) ** 2) - 1) < 5e-3
    assert abs(heard[0] / 2.9e-5 - 1) < 0.05
    force, heard = lines([found["ripple"]], (6, 14, 20, 26))
    np.testing.assert_allclose((force[0], *heard[[0, 1, 3]]), (5.57, 2.2e-3, 1.2e-3, 6.9e-3), rtol=0.05)
