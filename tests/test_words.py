"""The product speaks the field's language: no word that only its authors would understand."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
FORBIDDEN = {
    r"rungs?": "model",
    r"energy books?|books|booked": "energy balance",
    r"lines? (that )?stands?|lines that stand": "detected lines",
    r"dear(er|est)?": "expensive",
    r"frowns?": "questions",
    r"twins?": "control",
    r"doubts": "warnings",
    r"law of a law": "evaluation",
}
DOCS = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
CODE = [path for room in ("fem", "mbd", "pipelines", "gearcase") for path in sorted((ROOT / room).rglob("*.py"))]
SCENES = sorted((ROOT / "pipelines").rglob("*.toml"))


def private_words(text):
    """Forbidden phrases as they are found, each with what to say instead."""
    plain = text.replace("_", " ")
    return [
        f"{found[0]!r}: say {instead!r}"
        for phrase, instead in FORBIDDEN.items()
        for found in re.finditer(rf"\b({phrase})\b", plain, re.IGNORECASE)
    ]


@pytest.mark.parametrize("files", [DOCS, CODE, SCENES], ids=["docs", "code and messages", "scenes"])
def test_no_private_word_is_used(files):
    assert files
    found = {str(path.relative_to(ROOT)): private_words(path.read_text(encoding="utf-8")) for path in files}
    assert {path: words for path, words in found.items() if words} == {}


@pytest.mark.parametrize("text", ["the rung solid", "three lines stand", "ENERGY_BOOKS", "as dear as a reduction"])
def test_a_private_word_is_noticed(text):
    assert private_words(text) != []


def test_every_term_of_the_glossary_has_its_meaning():
    rows = re.findall(r"^\| (?!term|---)(.+?) \|$", (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8"), re.M)
    assert len(rows) > 30
    assert all(cell.strip() for row in rows for cell in re.split(r"(?<!\\)\|", row))
