"""JSON schema (draft 2020-12) of scene files, made from the tables that validate them.

A file may hold only a part of a scene; ``extends`` supplies the rest. So no key is required, not even `model`. An array
of tables may also be a table whose keys are the numbers of the items to change.
"""

from __future__ import annotations

from typing import Any

from pipelines.scene.scene import Scene

ADDRESS = "https://json-schema.org/draft/2020-12/schema"


def scene_schema() -> dict[str, Any]:
    """The JSON schema as a dict."""
    found: dict[str, Any] = {"$schema": ADDRESS, **_partial(Scene.model_json_schema()), "title": "gearcase scene"}
    extends = {"type": "string", "description": "scene to start from: a shipped one or a path ending in .toml"}
    found["properties"] = {"extends": extends, **found["properties"]}
    return found


def _partial(node: Any) -> Any:
    """The schema without required keys, and with single items as an alternative to arrays of tables."""
    if isinstance(node, list):
        return [_partial(item) for item in node]
    if not isinstance(node, dict):
        return node
    found = {key: _partial(value) for key, value in node.items() if key != "required" or not isinstance(value, list)}
    if isinstance(found.get("oneOf"), list):
        found["anyOf"] = found.pop("oneOf")
    items = found.get("items")
    if found.get("type") == "array" and isinstance(items, dict) and items.keys() & {"$ref", "anyOf"}:
        words = {key: found.pop(key) for key in ("title", "description", "default") if key in found}
        single = {"type": "object", "patternProperties": {"^[1-9][0-9]*$": items}, "additionalProperties": False}
        found = {**words, "anyOf": [found, single]}
    return found
