"""Texts are written in the terms of the field: no word that only the authors of the product would understand.

The table holds each expression that must not come back, and what to write instead. It covers every text that a user
reads, and the docstrings of the code.
"""

import ast
import re

import pytest
from sources import FILES, ROOT, nodes

INSTEAD = {
    r"ahead": "in advance",
    r"anew": "again",
    r"apart": "separate, except",
    r"(asked|wanted|looked) for|asked(?!\.toml)|wanted": "target, requested, monitored",
    r"believ\w+": "accepted",
    r"beside": "next to, in addition to",
    r"borders?(?!:)": "input and output",
    r"counts? more": "overrides",
    r"dear(er|est)?|cheap\w*|worth more": "expensive, inexpensive, more effective",
    r"doubts": "warnings",
    r"draws|drawn": "samples, sampled; plots, shows",
    r"elements? of (size zero|no size)": "extrapolated to zero element size",
    r"energy books?|books|booked": "energy balance",
    r"(?<!error[ -])bars": "error bars",
    r"foreign": "imported",
    r"foretold|foretells?": "predicted",
    r"frowns?": "questions",
    r"functions (of|at) edges|follows? the stresses": "edge-singularity enrichment",
    r"(?<!opposite )hands|workshop": "executor, worker cache",
    r"hangs? (together|on)": "shares only an edge or vertex; depends on",
    r"heard|hears?": "received, measured",
    r"(is|are|was|were|how far) off": "error estimate, deviates",
    r"law of a law": "evaluation",
    r"law of inertia": "Sturm-sequence count",
    r"leaves? open|left open|what is left": "numerical uncertainty, discretisation error",
    r"left to chance": "the mesh is reused",
    r"lent|lends?|borrow\w*": "borrowed reference: describe what happens",
    r"lets? go|shakes": "contact lost, ground acceleration",
    r"lines? (that )?stands?|lines that stand": "detected lines",
    r"mend(s|ed|ing)?": "correct, fixed",
    r"of (its|their) own": "the direct word: own, separate, another",
    r"parted": "divergence time, Lyapunov exponent",
    r"plants?": "machine model in SI",
    r"pulsat\w+": "time-varying",
    r"rings? mark|slices? rings?|rings? at": "circles mark; slicing causes spurious excitation",
    r"rungs?": "model",
    r"says?|said": "states, prints, gives",
    r"single lines are": "partly detected in",
    r"(?<!j\. )(?<!borne\s)sound(?! (power|pressure|radiation|and vibration))": "healthy, undamaged",
    r"spared?": "the symbol of the equation",
    r"stands? (above|behind|below|beside|for itself|nowhere|on the front|there|twice)": "see above, next to, is given",
    r"survey\w*": "geometry recognition",
    r"suspects?|suspected": "candidates",
    r"tells?|telling|told": "shows, estimates, reports",
    r"to the test|costs? and gains?": "check, verify; cost and accuracy",
    r"turn into one another": "mode mixing, veering",
    r"turn(s|ed)? (it )?round": "inverse problem, reversed",
    r"twins?": "control",
    r"whoever": "a user who, anyone who",
    r"will do": "is sufficient",
}
ANY = re.compile(rf"\b({'|'.join(INSTEAD)})\b", re.IGNORECASE)
MADE = {"docs/changelog.md"}  # from CHANGELOG.md


def named(path):
    return path.relative_to(ROOT).as_posix()


def words_to_replace(text):
    """Expressions of the table as they are found in a text, each with what to write instead."""
    if not ANY.search(text):
        return []
    return [
        f"{found[0]!r}: write {instead!r}"
        for expression, instead in INSTEAD.items()
        for found in re.finditer(rf"\b({expression})\b", text, re.IGNORECASE)
    ]


def texts_of_code(path):
    """The docstrings of a file, and its other string constants that are sentences: messages, help, headings."""
    docstrings, sentences = [], []
    owners = [n for n in nodes(path) if isinstance(n, ast.Module | ast.ClassDef | ast.FunctionDef) and n.body]
    bodies = {id(n.body[0].value) for n in owners if isinstance(n.body[0], ast.Expr)}
    for node in nodes(path):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            if id(node) in bodies:
                docstrings.append(node.value)
            elif " " in node.value.strip():
                sentences.append(node.value)
    return "\n".join(docstrings), "\n".join(sentences)


def pages():
    """Texts of the pages, examples and shipped scenes by name; of the changelog the changes since the last version."""
    paths = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
    paths += sorted((ROOT / "docs" / "tutorials").glob("*.md")) + sorted((ROOT / "examples").rglob("*.*"))
    paths += sorted((ROOT / "pipelines").rglob("*.toml"))
    kept = {".md", ".py", ".toml", ".txt"}
    found = {named(path): path.read_text(encoding="utf-8") for path in paths if path.suffix in kept}
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    return {name: text for name, text in found.items() if name not in MADE} | {
        "CHANGELOG.md": re.split(r"^## (?!Unreleased)", changes, flags=re.M)[0]
    }


def spoken(parser, name="gearcase"):
    """Help of a command and of the commands below it, as one text by name."""
    below = [action.choices for action in parser._actions if hasattr(action, "add_parser")]
    return {name: parser.format_help()} | {
        key: text
        for choices in below
        for word, command in choices.items()
        for key, text in spoken(command, f"{name} {word}").items()
    }


def test_pages_are_written_in_terms_of_the_field():
    texts = pages()
    assert len(texts) > 50
    found = {name: words_to_replace(text) for name, text in texts.items()}
    assert {name: words for name, words in found.items() if words} == {}


def test_messages_are_written_in_terms_of_the_field():
    found = {named(path): words_to_replace(texts_of_code(path)[1]) for path in FILES}
    assert {name: words for name, words in found.items() if words} == {}


def test_help_is_written_in_terms_of_the_field():
    from pipelines.cli.command_line import parser

    texts = spoken(parser())
    assert len(texts) > 30
    found = {name: words_to_replace(text) for name, text in texts.items()}
    assert {name: words for name, words in found.items() if words} == {}


def test_docstrings_are_written_in_terms_of_the_field():
    found = {named(path): words_to_replace(texts_of_code(path)[0]) for path in FILES}
    assert {name: words for name, words in found.items() if words} == {}


@pytest.mark.parametrize("text", ["the rung solid", "three lines stand", "energy books", "as dear as a reduction"])
def test_a_word_of_the_table_is_noticed(text):
    assert words_to_replace(text) != []


@pytest.mark.parametrize(
    "text",
    [
        "sound power of the casing",
        "J. Sound Vib. 176(5)",
        "Sound and Vibration 37(8)",
        "Structure-Borne Sound",
        "error bars",
        "error-bars.md",
        "scene.asked.toml",
        "the outer ring",
        "pinion_hand = 1",
        "need opposite hands",
        "border:1px",
    ],
)
def test_a_standard_term_is_no_word_of_the_table(text):
    assert words_to_replace(text) == []


def test_every_term_of_the_glossary_has_its_meaning():
    rows = re.findall(r"^\| (?!term|---)(.+?) \|$", (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8"), re.M)
    assert len(rows) > 30
    assert all(cell.strip() for row in rows for cell in re.split(r"(?<!\\)\|", row))
