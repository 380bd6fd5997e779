"""The errors of gearcase: each says what is wrong, where, and what to do."""

from pipelines.io.errors import InputError, SceneError, WorkError

__all__ = ["InputError", "SceneError", "WorkError"]
