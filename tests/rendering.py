"""What the renderer answered: a picture, or the one reason for which a test may do without; volumes of surfaces."""

from __future__ import annotations

import numpy as np
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


def enclosed_volume(points, quads):
    """Volume inside a closed surface, m3, by the divergence theorem over two triangles per quad."""
    total = 0.0
    for corners in (quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]):
        a, b, c = (points[corners[:, i]] for i in range(3))
        total += float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6
    return total
