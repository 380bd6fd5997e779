"""The body under the teeth: bore, rim and web, and the checks that keep it whole."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fem.gears.rack import require

if TYPE_CHECKING:
    from fem.gears.gear import Gear

THINNEST_RIM = 1.2  # modules: least backup ratio; ISO 6336-1 and the FE of a tooth on a ring mean nothing below


def check_body(gear: Gear, label: str) -> None:
    """Refuse a bore in the root, a rim below 1.2 m_n, a web that leaves the face.

    Raises
    ------
    GeometryError : with the numbers
    """
    require(
        gear.bore_radius < gear.root_radius,
        f"{label}: bore_radius {gear.bore_radius:.6g} m reaches the root circle; the limit is r_f = "
        f"{gear.root_radius:.6g} m: reduce the bore or raise teeth or module",
    )
    rim = gear.root_radius - max(gear.rim_inner_radius, gear.bore_radius)
    least = THINNEST_RIM * gear.normal_module
    source = "bore_radius" if gear.rim_thickness is None else "rim_thickness"
    require(
        rim >= least * (1.0 - 1e-9),
        f"{label}: {source} leaves a rim of {rim:.6g} m below the root circle r_f = {gear.root_radius:.6g} m, "
        f"{rim / gear.normal_module:.3g} m_n; the limit is {THINNEST_RIM} m_n = {least:.6g} m: "
        + ("reduce the bore" if gear.rim_thickness is None else "thicken the rim"),
    )
    if gear.rim_thickness is None:
        require(
            gear.web_thickness is None and gear.web_offset == 0.0,
            f"{label}: web_thickness or web_offset is given without rim_thickness; a solid body has no web: give the "
            "rim_thickness too",
        )
        return
    require(
        gear.rim_inner_radius > gear.bore_radius,
        f"{label}: rim_thickness {gear.rim_thickness:.6g} m reaches down to radius {gear.rim_inner_radius:.6g} m, "
        f"inside the bore {gear.bore_radius:.6g} m: there is no web; leave rim_thickness out or reduce it",
    )
    web = gear.face_width if gear.web_thickness is None else gear.web_thickness
    require(
        0.1 * gear.face_width <= web <= 1.2 * gear.face_width,
        f"{label}: web_thickness {web:.6g} m; give a value in [0.1, 1.2] face widths, [{0.1 * gear.face_width:.6g}, "
        f"{1.2 * gear.face_width:.6g}] m",
    )
    reach = max(0.0, (gear.face_width - web) / 2.0)
    require(
        abs(gear.web_offset) <= reach * (1.0 + 1e-9),
        f"{label}: web_offset {gear.web_offset:.6g} m carries the web out of the face; the limit is {reach:.6g} m with "
        f"a web of {web:.6g} m on a face of {gear.face_width:.6g} m",
    )
