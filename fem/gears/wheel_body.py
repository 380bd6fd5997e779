"""The gear body under the teeth: bore, rim and web, and the checks of their dimensions."""

from __future__ import annotations

from fem.gears.gear_checks import require

THINNEST_RIM = 1.2  # modules: least backup ratio, limit of ISO 6336-1 and of finite elements of a tooth on a ring


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
    """Refuse a bore beyond the root circle, a rim below 1.2 m_n, a web beyond the face.

    Parameters
    ----------
    label : name of the gear in messages
    normal_module, face_width, root_radius, bore_radius : m
    rim_thickness : m, from the root circle inwards; None for a solid body
    web_thickness : m, or None for the face width
    web_offset : m, middle of the web from mid face along the axis

    Raises
    ------
    GeometryError : with the values
    """
    require(
        face_width >= 0.5 * normal_module,
        f"{label}: face_width_mm = {1000 * face_width:.6g} is less than half a module. Set at least "
        f"{500 * normal_module:.6g}; write it in mm",
    )
    rim_inner_radius = bore_radius if rim_thickness is None else root_radius - rim_thickness
    require(
        bore_radius < root_radius,
        f"{label}: the bore of {2000 * bore_radius:.6g} mm reaches the root circle of {2000 * root_radius:.6g} mm. "
        "Reduce the bore, or raise the number of teeth or the module",
    )
    rim = root_radius - max(rim_inner_radius, bore_radius)
    least = THINNEST_RIM * normal_module
    require(
        rim >= least * (1.0 - 1e-9),
        f"{label}: the rim below the root circle of {2000 * root_radius:.6g} mm is {1000 * rim:.4g} mm thick; at least "
        f"{THINNEST_RIM} modules, {1000 * least:.4g} mm, are needed. "
        + ("Reduce the bore" if rim_thickness is None else "Raise rim_thickness_mm"),
    )
    if rim_thickness is None:
        require(
            web_thickness is None and web_offset == 0.0,
            f"{label}: web_thickness_mm or web_offset_mm is set without rim_thickness_mm, and a solid body has no web. "
            "Set rim_thickness_mm too, or delete them",
        )
        return
    require(
        rim_inner_radius > bore_radius,
        f"{label}: rim_thickness_mm = {1000 * rim_thickness:.6g} reaches the bore of {2000 * bore_radius:.6g} mm, so "
        f"that there is no web. Set less than {1000 * (root_radius - bore_radius):.6g}, or delete it for a solid body",
    )
    web = face_width if web_thickness is None else web_thickness
    require(
        0.1 * face_width <= web <= 1.2 * face_width,
        f"{label}: web_thickness_mm = {1000 * web:.6g} is not between 0.1 and 1.2 face widths. Set "
        f"{100 * face_width:.6g} to {1200 * face_width:.6g}",
    )
    reach = max(0.0, (face_width - web) / 2.0)
    require(
        abs(web_offset) <= reach * (1.0 + 1e-9),
        f"{label}: web_offset_mm = {1000 * web_offset:.6g} moves the web of {1000 * web:.6g} mm out of the face of "
        f"{1000 * face_width:.6g} mm. Set {-1000 * reach:.6g} to {1000 * reach:.6g}",
    )
