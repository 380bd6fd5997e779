"""REXS as XML (.rexs). A document type is refused: the format has none, and its entities can grow without bound."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from pipelines.io.shown import shown
from pipelines.rexs.document import Attribute, Component, Document, Relation, RexsError, by_number


class _Builder(ET.TreeBuilder):
    def doctype(self, name: str, public: str | None, system: str | None) -> None:
        raise RexsError(f"it has a document type ({shown(name)}), which REXS has not. Remove the line <!DOCTYPE ...>.")


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
        raise RexsError(f"{source}: its root is <{shown(root.tag)}>, that of REXS is <model>. Set a REXS file.")
    cases = {
        _whole(case, "id", source): {_whole(one, "id", source): _attributes(one) for one in case.iterfind("component")}
        for case in root.iterfind("load_spectrum/load_case")
    }
    components = [_component(one, source) for one in root.iterfind("components/component")]
    return Document(
        source=source,
        version=root.get("version", ""),
        written_by=f"{root.get('applicationId', 'unknown')} {root.get('applicationVersion', '')}".strip(),
        components=by_number(components, source),
        relations=tuple(_relation(one, source) for one in root.iterfind("relations/relation")),
        load_cases=cases,
    )


def _component(element: ET.Element, source: str) -> Component:
    return Component(
        number_in_file=_whole(element, "id", source),
        kind=element.get("type", ""),
        name=element.get("name", ""),
        attributes=_attributes(element),
        source=source,
    )


def _attributes(element: ET.Element) -> dict[str, Attribute]:
    return {one.get("id", ""): _attribute(one) for one in element.iterfind("attribute")}


def _attribute(element: ET.Element) -> Attribute:
    unit = element.get("unit", "none")
    array = element.find("array")
    if array is None:
        return Attribute(text=element.text or "", unit=unit)
    try:
        return Attribute(numbers=tuple(float(one.text or "") for one in array.iterfind("c")), unit=unit)
    except ValueError:
        return Attribute(unit=unit)  # texts, of which a scene asks for none


def _relation(element: ET.Element, source: str) -> Relation:
    roles = {ref.get("role", ""): _whole(ref, "id", source) for ref in element.iterfind("ref")}
    return Relation(kind=element.get("type", ""), roles=roles)


def _whole(element: ET.Element, key: str, source: str) -> int:
    text = element.get(key, "")
    if not (text.isascii() and text.isdigit() and len(text) < 10):
        raise RexsError(f'{source}: <{shown(element.tag)} {key}="{shown(text)}">: must be a whole number. Correct it.')
    return int(text)
