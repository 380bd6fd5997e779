"""The reference of all scene keys as Markdown, made from the validators: `python -m pipelines.scene.keys`."""

from __future__ import annotations

import typing
from pathlib import Path

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from pipelines.scene.scene import Scene

HEAD = """# Scene keys

Made from the validators by `python -m pipelines.scene.keys docs/scene-keys.md`; a test keeps it current. Numbers are
in the unit of the key's suffix. Arrays of tables are numbered from 1 in messages and in
`--set stages.1.face_width_mm=14`. `extends = "rig-healthy"` at the top of a file takes over everything of another scene
that the file does not give itself.
"""


def tables(annotation: object) -> list[type[BaseModel]]:
    """The table classes inside a type: itself, the members of a union, the items of a tuple."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    found: list[type[BaseModel]] = []
    for argument in typing.get_args(annotation):
        found += tables(argument)
    return found


def limits(field: FieldInfo) -> str:
    """Bounds and choices of a field as text."""
    parts = []
    for item in field.metadata:
        for kind, sign in ((Gt, ">"), (Ge, ">="), (Lt, "<"), (Le, "<=")):
            if isinstance(item, kind):
                parts.append(f"{sign} {getattr(item, kind.__name__.lower()):g}")
    if typing.get_origin(field.annotation) is typing.Literal:
        parts.append(" \\| ".join(f"`{choice}`" for choice in typing.get_args(field.annotation)))
    return ", ".join(parts)


def meaning(field: FieldInfo) -> str:
    """What the key is: its description, else that of the table behind it."""
    if field.description:
        return field.description
    inner = tables(field.annotation)
    return (
        (inner[0].__doc__ or "").split("\n")[0].strip() if len(inner) == 1 else "one of the models below" * bool(inner)
    )


def default(field: FieldInfo) -> str:
    """The default as text; empty for a required key."""
    if field.is_required():
        return "required"
    value = field.default if field.default_factory is None else field.default_factory()  # type: ignore[call-arg]
    if isinstance(value, BaseModel):
        return "see below"
    return "none" if value is None else f"`{list(value) if isinstance(value, tuple) else value}`"


def section(path: str, table: type[BaseModel], seen: list[str]) -> list[str]:
    """The lines of one table and of the tables in it."""
    lines = [f"\n## {path or 'top level'}" + (f" ({table.model_fields['model'].default})" if _is_model(table) else "")]
    lines += ["", " ".join((table.__doc__ or "").split()), ""]
    lines += ["| key | meaning | limits | default |", "|---|---|---|---|"]
    inner: list[tuple[str, type[BaseModel]]] = []
    for name, field in table.model_fields.items():
        lines.append(f"| `{name}` | {meaning(field)} | {limits(field)} | {default(field)} |")
        inner += [(f"{path}.{name}".strip("."), member) for member in tables(field.annotation)]
    for where, member in inner:
        if f"{where}:{member.__name__}" not in seen:
            seen.append(f"{where}:{member.__name__}")
            lines += section(where, member, seen)
    return lines


def _is_model(table: type[BaseModel]) -> bool:
    return "model" in table.model_fields and isinstance(table.model_fields["model"].default, str)


def scene_keys() -> str:
    """The whole page."""
    return HEAD + "\n".join(section("", Scene, [])) + "\n"


if __name__ == "__main__":
    import sys

    Path(sys.argv[1]).write_text(scene_keys(), encoding="utf-8")
