"""Windows that hold whole turns of every shaft."""

import numpy as np

from pipelines.signals.orders.kinematics import Shaft, needed_seconds
from pipelines.signals.orders.revolutions import revolutions
from pipelines.signals.orders.rotation import Rotation

TRAIN = (Shaft(name="input", ratio=1.0), Shaft(name="output", ratio=0.1))


def test_a_window_of_the_needed_length_holds_the_turns_wherever_it_begins():
    time = np.arange(80_000) / 4000.0
    rotation = Rotation(angle=2 * np.pi * 20.0 * time, source="exact", error=0.0, absolute=True)
    for shaft in TRAIN:
        seconds = needed_seconds(TRAIN, 20.0, 3)[shaft.name]
        for start in np.linspace(1.0, 1.5, 7):
            found = revolutions(time, time, rotation, shaft.ratio, 64, (start, start + 1.001 * seconds))
            assert len(found) in (3, 4)
