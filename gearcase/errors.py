"""Errors of gearcase: each message gives the cause, the key or argument, and the remedy."""

from pipelines.io.errors import InputError, SceneError, WorkError

__all__ = ["InputError", "SceneError", "WorkError"]
