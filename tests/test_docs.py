"""The documentation follows the code."""

from pathlib import Path

from pipelines.scene.keys import scene_keys

DOCS = Path(__file__).resolve().parent.parent / "docs"


def test_the_reference_of_scene_keys_is_current():
    stored = (DOCS / "scene-keys.md").read_text(encoding="utf-8")
    assert stored == scene_keys(), "run: python -m pipelines.scene.keys docs/scene-keys.md"
