"""The documentation follows the code."""

import re

from sources import ROOT

from benchmarks.scene_keys import scene_keys, slug

DOCS = ROOT / "docs"


def test_the_reference_of_scene_keys_is_current():
    stored = (DOCS / "scene-keys.md").read_text(encoding="utf-8")
    assert stored == scene_keys(), "run: python -m benchmarks.scene_keys docs/scene-keys.md"


def test_every_link_of_the_scene_keys_leads_to_one_heading():
    """On hosts of Markdown and in the site: both make the anchor of a heading from its text, twice the same if "
    "equal."""
    page = scene_keys()
    anchors = [slug(heading) for heading in re.findall(r"^#+ (.+)$", page, re.MULTILINE)]
    links = re.findall(r"\]\(#([^)]+)\)", page)
    assert len(anchors) == len(set(anchors)) > 60
    assert len(links) > 100
    assert sorted(set(links) - set(anchors)) == []


def test_limits_and_units_of_scene_keys_are_written_out():
    page = scene_keys()
    for row in (
        "| `face_width_mm` | common face width b | above 0 and at most 2000 mm | required |",
        "| `poisson_ratio` | Poisson's ratio | at least 0 and below 0.5 | required |",
        "| `mesh` | model of the mesh stiffness: [stages.mesh](#stagesmesh) | table | model `plane` |",
        "| `offset_um` | parallel misalignment: x and z of the axis of the second shaft relative to the first | "
        "2 numbers in um | `[0.0, 0.0]` |",
    ):
        assert row in page.splitlines()
