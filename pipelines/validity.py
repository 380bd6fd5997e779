"""A scene that can be built: gears that work, parts that do not collide, a housing that holds together."""

from __future__ import annotations

from pipelines.collisions import find_collisions
from pipelines.errors import Problem, SceneError
from pipelines.layout import Layout, lay_out
from pipelines.scene import FlexibleBase, Scene


def checked_layout(scene: Scene, source: str) -> Layout:
    """The layout of a scene after every check that needs no computation.

    Raises
    ------
    SceneError : everything that does not fit, at once
    """
    layout = lay_out(scene, source)
    problems: list[Problem] = list(find_collisions(scene, layout))
    if isinstance(scene.casing, FlexibleBase):
        from pipelines.housing import housing

        try:
            housing(scene, scene.casing.housing, layout, source)
        except SceneError as error:
            problems += error.problems
    if problems:
        raise SceneError(source, problems)
    return layout
