"""Steps of a casing: each stores the result of one of its stages, see `fem.casing.models.stage`."""

from __future__ import annotations

from typing import Any

from fem.casing.models.stage import CasingError, CasingInputError, Stage
from pipelines.io.errors import InputError, WorkError


def build(stage: Stage, **taken: Any) -> Any:
    """The result of a stage."""
    try:
        return stage.build(**taken)
    except CasingInputError as error:
        raise InputError(str(error)) from error
    except CasingError as error:
        raise WorkError(str(error)) from error
