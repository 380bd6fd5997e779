"""docs/validation.md lists exactly the rows of the code, its cheap numbers hold, and every test it names exists."""

import ast
import re
from functools import cache

import pytest
from sources import ROOT

from benchmarks.checks.invariants import INVARIANTS
from benchmarks.checks.record import Check
from benchmarks.validation import PAGE, SUBJECTS, fixed_cells

TESTS = ROOT / "tests"
CHECKS = [check for subject in SUBJECTS for check in subject.checks]
REMEDY = "run: python -m benchmarks.validation"


def cells(line):
    return tuple(cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1])


def tables():
    """Rows of the page by the number of their columns, without heads."""
    lines = [cells(line) for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("|")]
    return [line for line in lines if line[0] not in ("quantity", "statement") and set(line[0]) != {"-"}]


def test_the_page_lists_exactly_the_rows_of_the_code():
    rows = [line for line in tables() if len(line) == 8]
    shown = [(*line[:4], line[6], line[7]) for line in rows]
    assert shown == [tuple(cell.strip() for cell in fixed_cells(check)) for check in CHECKS], REMEDY


def test_every_deviation_on_the_page_is_inside_its_gate():
    def size(text):
        return float(text.split()[0])

    beyond = [line[0] for line in tables() if len(line) == 8 and not size(line[5]) < size(line[6])]
    assert beyond == []


def test_the_page_lists_the_invariants():
    shown = [line for line in tables() if len(line) == 3]
    assert [line[:2] for line in shown] == [statement[:2] for statement in INVARIANTS], REMEDY


def of_subjects(cheap):
    chosen = [check for subject in SUBJECTS if subject.cheap == cheap for check in subject.checks]
    return pytest.mark.parametrize("check", chosen, ids=lambda c: c.quantity[:50])


@of_subjects(cheap=True)
def test_cheap_numbers_are_inside_their_gates(check):
    assert check.deviation(check.compute()) < check.gate


@pytest.mark.slow
@of_subjects(cheap=False)
def test_dear_numbers_are_inside_their_gates(check):
    assert check.deviation(check.compute()) < check.gate


@cache
def names_in(file):
    (path,) = TESTS.rglob(file)
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return {node.name for node in tree.body if isinstance(node, ast.FunctionDef | ast.ClassDef)}


@pytest.mark.parametrize("test", sorted({c.test for c in CHECKS} | {test for _, _, test in INVARIANTS}))
def test_every_test_that_the_page_names_exists(test):
    file, _, name = test.partition("::")
    assert name in names_in(file)


def test_a_deviation_is_the_largest_one():
    fields = {"quantity": "", "source": "", "unit": "mm", "gate": 1.0, "compute": list, "test": ""}
    relative = Check(reference=(2.0, 4.0), **fields)
    assert relative.deviation((2.0, 3.0)) == pytest.approx(0.25)
    assert Check(reference=(2.0, 4.0), kind="absolute", **fields).deviation((2.0, 3.0)) == pytest.approx(1.0)
    with pytest.raises(ValueError, match="1 values for 2"):
        relative.deviation((2.0,))
