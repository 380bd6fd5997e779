"""Table [simulation], time integration and output; `mbd.integrators.settings` has its keys."""

from __future__ import annotations

from typing import TypeAlias

from mbd.integrators.settings import MotionSettings
from pipelines.scene.tables.derived import table

SimulationTable: TypeAlias = table(MotionSettings)
