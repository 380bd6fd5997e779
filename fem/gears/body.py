"""The body under the teeth: bore, rim and web, and the checks that keep it whole."""

from __future__ import annotations

from fem.gears.rack import require

THINNEST_RIM = 1.2  # modules: least backup ratio; ISO 6336-1 and the FE of a tooth on a ring mean nothing below


def check_body(
    label: str,
    *,
    normal_module: float,
    face_width: float,
    root_radius: float,
    bore_radius: float,
    rim_thickness: float | None,
    web_thickness: float | None,
    web_offset: float,
) -> None:
    """Refuse a bore in the root, a rim below 1.2 m_n, a web that leaves the face.

    Parameters
    ----------
    label : name of the gear in messages
    normal_module, face_width, root_radius, bore_radius : m
    rim_thickness : m, from the root circle inwards; None for a solid body
    web_thickness : m, or None for that of the face
    web_offset : m, middle of the web from mid face along the axis

    Raises
    ------
    GeometryError : with the numbers
    """
    rim_inner_radius = bore_radius if rim_thickness is None else root_radius - rim_thickness
    require(
        bore_radius < root_radius,
        f"{label}: bore_radius {bore_radius:.6g} m reaches the root circle; the limit is r_f = "
        f"{root_radius:.6g} m: reduce the bore or raise teeth or module",
    )
    rim = root_radius - max(rim_inner_radius, bore_radius)
    least = THINNEST_RIM * normal_module
    source = "bore_radius" if rim_thickness is None else "rim_thickness"
    require(
        rim >= least * (1.0 - 1e-9),
        f"{label}: {source} leaves a rim of {rim:.6g} m below the root circle r_f = {root_radius:.6g} m, "
        f"{rim / normal_module:.3g} m_n; the limit is {THINNEST_RIM} m_n = {least:.6g} m: "
        + ("reduce the bore" if rim_thickness is None else "thicken the rim"),
    )
    if rim_thickness is None:
        require(
            web_thickness is None and web_offset == 0.0,
            f"{label}: web_thickness or web_offset is given without rim_thickness; a solid body has no web: give the "
            "rim_thickness too",
        )
        return
    require(
        rim_inner_radius > bore_radius,
        f"{label}: rim_thickness {rim_thickness:.6g} m reaches down to radius {rim_inner_radius:.6g} m, "
        f"inside the bore {bore_radius:.6g} m: there is no web; leave rim_thickness out or reduce it",
    )
    web = face_width if web_thickness is None else web_thickness
    require(
        0.1 * face_width <= web <= 1.2 * face_width,
        f"{label}: web_thickness {web:.6g} m; give a value in [0.1, 1.2] face widths, [{0.1 * face_width:.6g}, "
        f"{1.2 * face_width:.6g}] m",
    )
    reach = max(0.0, (face_width - web) / 2.0)
    require(
        abs(web_offset) <= reach * (1.0 + 1e-9),
        f"{label}: web_offset {web_offset:.6g} m carries the web out of the face; the limit is {reach:.6g} m with "
        f"a web of {web:.6g} m on a face of {face_width:.6g} m",
    )
