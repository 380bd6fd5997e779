"""Progress of the work: the argument of a progress function."""

from pipelines.engine.progress import ProgressFunction, StepProgress

__all__ = ["ProgressFunction", "StepProgress"]
