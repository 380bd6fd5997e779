"""Reader of REXS files in XML (.rexs).

A document type is refused: the format has none, and its entities can grow without bound.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import Any

from pipelines.io.shown_text import shown
from pipelines.rexs.document import Document, RexsError
from pipelines.rexs.json_form import document_of_model


class _Builder(ET.TreeBuilder):
    def doctype(self, name: str, public: str | None, system: str | None) -> None:
        raise RexsError(f"it has a document type ({shown(name)}), and must have none. Remove the line <!DOCTYPE ...>.")


def document_of_xml(content: bytes, source: str) -> Document:
    """The document of an XML text.

    Raises
    ------
    RexsError : no XML, another root than model, or numbers that are none
    """
    try:
        root = ET.fromstring(content, parser=ET.XMLParser(target=_Builder()))
    except RexsError as error:
        raise RexsError(f"{source}: {error}") from None
    except (ET.ParseError, LookupError, ValueError) as error:  # the last two: encodings that are not known
        raise RexsError(f"{source}: not valid XML: {shown(str(error))}. Correct that line.") from error
    if root.tag != "model":
        raise RexsError(f"{source}: its root is <{shown(root.tag)}>, that of REXS is <model>. Give a REXS file.")
    return document_of_model(
        {
            **root.attrib,
            "components": [_component(one) for one in root.iterfind("components/component")],
            "relations": [
                {"type": one.get("type", ""), "refs": [ref.attrib for ref in one.iterfind("ref")]}
                for one in root.iterfind("relations/relation")
            ],
            "load_spectrum": {
                "load_cases": [
                    {**one.attrib, "components": [_component(part) for part in one.iterfind("component")]}
                    for one in root.iterfind("load_spectrum/load_case")
                ]
            },
        },
        source,
    )


def _component(element: ET.Element) -> dict[str, Any]:
    return {**element.attrib, "attributes": [_attribute(one) for one in element.iterfind("attribute")]}


def _attribute(element: ET.Element) -> dict[str, Any]:
    array = element.find("array")
    value = element.text or "" if array is None else [_number(one.text or "") for one in array.iterfind("c")]
    return {"id": element.get("id", ""), "unit": element.get("unit", "none"), "value": value}


def _number(text: str) -> float | str:
    """The number of a text; the text itself, of which a scene asks for none."""
    try:
        return float(text)
    except ValueError:
        return text
