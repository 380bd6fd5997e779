"""A tooth broken off at the root: nothing touches it; the compliance of its neighbours changes by about 1 %."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from fem.contact.faults.tooth_fault import ToothFault


@dataclass(frozen=True, kw_only=True)
class MissingTooth(ToothFault):
    """A tooth broken off at the root.

    It is a clearance that nothing bridges; the law of the pair stays.
    """

    changes_flank: ClassVar[bool] = False
    clearance: ClassVar[float] = math.inf
