"""What the renderer answered: a picture, or the one reason for which a test may do without; volumes of surfaces."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.report.figures.render_failures import PACKAGES
from pipelines.report.figures.views import NotRendered


def drawn(render, *given):
    """What it renders; a machine without libraries for off-screen rendering skips the test, other reasons fail it."""
    try:
        return render(*given)
    except NotRendered as left_out:
        if "without EGL" in str(left_out) or any(library in str(left_out) for library in PACKAGES):
            pytest.skip(str(left_out))
        raise


def enclosed_volume(points, quads):
    """Volume inside a closed surface, m3, by the divergence theorem over two triangles per quad."""
    total = 0.0
    for corners in (quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]):
        a, b, c = (points[corners[:, i]] for i in range(3))
        total += float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6
    return total
