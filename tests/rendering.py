"""What the renderer answered: a picture, or the one reason for which a test may do without."""

from __future__ import annotations

import pytest

from pipelines.report.figures.render_failures import PACKAGES
from pipelines.report.figures.views import LeftOut


def drawn(found):
    """The picture; a machine without libraries for off-screen rendering skips the test, any other reason fails it."""
    if not isinstance(found, LeftOut):
        return found
    if "without EGL" in found.reason or any(library in found.reason for library in PACKAGES):
        pytest.skip(found.reason)
    raise AssertionError(found.reason)
