"""Small REXS documents with the structure of the public ones: a train of helical stages, as XML, JSON and ZIP."""

import io
import json
import math
import zipfile
from dataclasses import dataclass, field, replace
from xml.sax.saxutils import quoteattr

import numpy as np

UNIT, CASING = 1, 2


@dataclass(frozen=True)
class Row:
    """A stage: teeth, module, helix angle of the pinion, faces, shifts, centre distance, direction, mid faces."""

    teeth: tuple[int, int]
    module: float
    helix: float
    widths: tuple[float, float]
    shifts: tuple[float, float]
    distance: float
    angle: float  # rotating_angle_around_neg_u_axis
    middles: tuple[float, float]


@dataclass(frozen=True)
class Document:
    """Components (kind, name, attributes), relations, load cases; attributes are values or (value, unit)."""

    components: dict = field(default_factory=dict)
    relations: list = field(default_factory=list)
    cases: dict = field(default_factory=dict)
    version: str = "1.4"

    def changed(self, kind, attributes, which=0):
        """With some attributes of one component of a kind replaced, taken out where None."""
        number = [n for n, (one, *_) in self.components.items() if one == kind][which]
        one, name, old = self.components[number]
        new = {key: value for key, value in {**old, **attributes}.items() if value is not None}
        return replace(self, components={**self.components, number: (one, name, new)})

    def added(self, kind, name="", **attributes):
        return replace(self, components={**self.components, max(self.components) + 1: (kind, name, attributes)})

    def without(self, kind):
        kept = {number: one for number, one in self.components.items() if one[0] != kind}
        return replace(self, components=kept)

    def turned(self, rotation):
        """The whole unit turned in space."""
        components = {
            number: (kind, name, {key: _turned(value, rotation) for key, value in attributes.items()})
            for number, (kind, name, attributes) in self.components.items()
        }
        return replace(self, components=components)


def _turned(value, rotation):
    value, unit = value if isinstance(value, tuple) else (value, "none")
    return (list(np.array(rotation) @ value), unit) if isinstance(value, list) else (value, unit)


PLAIN = (  # two stages side by side
    Row((20, 61), 2.0, 20.0, (22.0, 20.0), (0.2, 0.0), 86.627, 120.0, (50.0, 50.0)),
    Row((19, 44), 2.5, 15.0, (30.0, 28.0), (0.1, 0.0), 81.776, 60.0, (110.0, 110.0)),
)


def unit(rows=PLAIN, speed=1200.0, torque=60.0, version="1.4", lengths=(0.0, 160.0), diameter=20.0):
    """A train: shaft i carries the wheel of stage i - 1 and the pinion of stage i; two 6205 on every shaft."""
    components = {UNIT: ("gear_unit", "unit", {"number_of_gears": 1}), CASING: ("gear_casing", "casing", {})}
    relations = []
    places = axes(rows)

    def add(kind, name, attributes):
        number = max(components) + 1
        components[number] = (kind, name, attributes)
        return number

    def relate(kind, **roles):
        relations.append((kind, roles))

    low, high = lengths
    shafts, flank = [], "cylindrical_gear_flank" if version > "1.2" else "flank_geometry"
    for number, (v, w) in enumerate(places):
        axes_of = {"u_axis_vector": ([1.0, 0.0, 0.0], "mm"), "w_axis_vector": ([0.0, 0.0, 1.0], "mm")}
        shaft = add("shaft", f"shaft {number + 1}", {"support_vector": ([low, v, w], "mm"), **axes_of})
        relate("assembly", assembly=UNIT, part=shaft)
        shafts.append(shaft)
        size = {f"outer_diameter_{end}": (diameter, "mm") for end in ("begin", "end")}
        size |= {f"inner_diameter_{end}": (0.0, "mm") for end in ("begin", "end")}
        section = {"u_coordinate_on_shaft": (0.0, "mm"), "length": (high - low, "mm"), **size}
        relate("assembly", assembly=shaft, part=add("shaft_section", "section", section))
        for place in (10.0, high - low - 10.0):
            data = {
                "catalogue_designation": "6205-2Z",
                "bearing_type": "radial_grooved_ball_bearing",
                "axial_force_absorption": "both_directions",
                "u_coordinate_on_shaft_inner_side": (place, "mm"),
            }
            bearing = add("rolling_bearing_with_catalog_geometry", f"bearing at {place:g}", data)
            relate("side", assembly=bearing, inner_part=shaft, outer_part=CASING)
    for number, row in enumerate(rows):
        stage = add("cylindrical_stage", f"stage {number + 1}", {"center_distance": (row.distance, "mm")})
        gears = []
        for side in (0, 1):
            v, w = places[number + side]
            gear = add(
                "cylindrical_gear",
                f"gear {number + 1}.{side + 1}",
                {
                    "support_vector": ([row.middles[side], v, w], "mm"),
                    "u_axis_vector": ([1.0, 0.0, 0.0], "mm"),
                    "w_axis_vector": ([0.0, 0.0, 1.0], "mm"),
                    "face_width": (row.widths[side], "mm"),
                    "number_of_teeth": row.teeth[side],
                    "normal_module": (row.module, "mm"),
                    "helix_angle_reference_diameter": ((1, -1)[side] * row.helix, "deg"),
                },
            )
            shape = {"normal_pressure_angle": (20.0, "deg"), "addendum_modification_coefficient": row.shifts[side]}
            left, right = (add(flank, f"flank {name}", shape) for name in ("left", "right"))
            relate("flank", gear=gear, left=left, right=right)
            relate("assembly", assembly=shafts[number + side], part=gear)
            gears.append(gear)
        relate("stage", stage=stage, gear_1=gears[0], gear_2=gears[1])
    for shaft, given in ((shafts[0], torque), (shafts[-1], None)):
        data = {"transmits_torque": True, "u_coordinate_on_shaft": (0.0 if given is not None else high - low, "mm")}
        data |= {} if given is None else {"torque_around_u_axis": (given, "N m")}
        relate("assembly", assembly=shaft, part=add("external_load", "load", data))
    if speed is not None:
        components[shafts[0]][2].update({"rotational_speed": (speed, "1 / min"), "defines_speed": True})
    return Document(components, relations, {}, version)


def axes(rows):
    """(v, w) of the shafts, from centre distances and rotating angles."""
    found = [(0.0, 0.0)]
    for row in rows:
        angle = math.radians(row.angle)
        found.append((found[-1][0] + row.distance * math.sin(angle), found[-1][1] + row.distance * math.cos(angle)))
    return found


def xml(document):
    """The text of a .rexs file."""
    lines = ["<?xml version='1.0' encoding='UTF-8'?>", f'<model version="{document.version}" applicationId="test">']
    lines.append("<relations>")
    for number, (kind, roles) in enumerate(document.relations, 1):
        refs = "".join(f'<ref role="{role}" id="{target}" hint="part"/>' for role, target in roles.items())
        lines.append(f'<relation id="{number}" type="{kind}">{refs}</relation>')
    lines += ["</relations>", "<components>"]
    lines += [_xml_component(number, *one) for number, one in document.components.items()]
    lines += ["</components>", '<load_spectrum id="1">']
    for number, parts in document.cases.items():
        inside = "".join(_xml_component(part, "", "", attributes) for part, attributes in parts.items())
        lines.append(f'<load_case id="{number}">{inside}</load_case>')
    return "\n".join([*lines, "</load_spectrum>", "</model>"])


def _xml_component(number, kind, name, attributes):
    inside = ""
    for key, value in attributes.items():
        value, unit = value if isinstance(value, tuple) else (value, "none")
        text = str(value).lower() if isinstance(value, bool) else str(value)
        if isinstance(value, list):
            text = f"<array>{''.join(f'<c>{one}</c>' for one in value)}</array>"
        inside += f'<attribute id="{key}" unit="{unit}">{text}</attribute>'
    return f'<component id="{number}" type="{kind}" name={quoteattr(name)}>{inside}</component>'


def json_text(document):
    """The text of a .rexsj file."""
    model = {
        "version": document.version,
        "applicationId": "test",
        "relations": [
            {
                "id": number,
                "type": kind,
                "refs": [{"role": role, "id": target, "hint": "part"} for role, target in roles.items()],
            }
            for number, (kind, roles) in enumerate(document.relations, 1)
        ],
        "components": [_json_component(number, *one) for number, one in document.components.items()],
        "load_spectrum": {
            "id": 1,
            "load_cases": [
                {"id": number, "components": [_json_component(part, "", "", one) for part, one in parts.items()]}
                for number, parts in document.cases.items()
            ],
        },
    }
    return json.dumps({"model": model})


def _json_component(number, kind, name, attributes):
    found = []
    for key, value in attributes.items():
        value, unit = value if isinstance(value, tuple) else (value, "none")
        names = {bool: "boolean", int: "integer", float: "floating_point", str: "string", list: "floating_point_array"}
        found.append({"id": key, "unit": unit, names[type(value)]: value})
    return {"id": number, "type": kind, "name": name, "attributes": found}


def packed(name, text):
    """The bytes of a .rexsz file that holds one document."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, text)
    return buffer.getvalue()
