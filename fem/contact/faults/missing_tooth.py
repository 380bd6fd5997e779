"""A tooth broken off at the root: no contact; the change of its neighbours' compliance (about 1 %) is neglected.

The number of the tooth is a key of the scene (`pipelines.scene.tables.faults`), which becomes a clearance in
`pipelines.machine.tooth_terms`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from fem.contact.faults.tooth_fault import ToothFault


@dataclass(frozen=True, kw_only=True)
class MissingTooth(ToothFault):
    """A tooth broken off at the root.

    It is represented by an infinite clearance; the law of the pair is unchanged.
    """

    changes_flank: ClassVar[bool] = False
    clearance: ClassVar[float] = math.inf
