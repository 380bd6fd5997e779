"""`gearcase schema`: the JSON schema of scene files, so that an editor completes and checks their keys.

It is made (draft 2020-12) from the tables that validate scenes. A file may hold only a part of a scene; ``extends``
supplies the rest. So no key is required, not even `model`. An array of tables may also be a table whose keys are the
numbers of the items to change.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import Any

from pipelines.io.argument_types import path

ADDRESS = "https://json-schema.org/draft/2020-12/schema"
HELP = (
    "Print the JSON schema of scene files, with which an editor completes and checks keys and values. Takes a second."
)
EXAMPLE = """\
gearcase schema --out scene.schema.json
scene.schema.json"""


def arguments(sub: argparse.ArgumentParser) -> None:
    """The file."""
    sub.add_argument("--out", metavar="FILE", type=path, help="file to write (default: print the schema)")


def main(options: argparse.Namespace) -> Iterator[str]:
    """Print the schema, or write it to a file."""
    from pipelines.io.errors import InputError
    from pipelines.io.json_text import json_text
    from pipelines.io.user_files import writable_file, write_whole

    text = json_text(scene_schema())
    if options.out is None:
        yield text
        return
    target = writable_file(options.out)
    try:
        write_whole(target, text)
    except OSError as error:
        raise InputError(f"{target}: cannot be written ({error.strerror}). Choose another --out.") from error
    yield str(target)


def scene_schema() -> dict[str, Any]:
    """The JSON schema as a dict."""
    from pipelines.scene.scene import Scene

    made = Scene.model_json_schema()
    found: dict[str, Any] = {"$schema": ADDRESS, **_partial(made)}
    found["title"] = "gearcase scene"
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
