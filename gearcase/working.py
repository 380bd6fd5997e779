"""What a progress function is told."""

from pipelines.engine.progress import ProgressFunction, Step

__all__ = ["ProgressFunction", "Step"]
