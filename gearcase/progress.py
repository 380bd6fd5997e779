"""Types of a progress callback: `StepProgress` is what a `ProgressFunction` is called with at every step."""

from pipelines.engine.progress import ProgressFunction, StepProgress

__all__ = ["ProgressFunction", "StepProgress"]
