"""What a progress function is told."""

from pipelines.engine.progress import ProgressFunction, StepProgress

__all__ = ["ProgressFunction", "StepProgress"]
