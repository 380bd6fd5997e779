"""Scenes in, results out: ``from pipelines import run``."""

from typing import Any

__all__ = ["run"]


def __getattr__(name: str) -> Any:
    if name == "run":  # imported late: importing the package must stay cheap
        from pipelines.runs.run import run

        return run
    raise AttributeError(f"module 'pipelines' has no attribute {name!r}")
