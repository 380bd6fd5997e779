"""Trajectory: result of a run, sampled at the output rate, with its energy balance and counters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fem.storage.large_array_file import StoredArray
from fem.storage.records import Record, array, names, scalar, text

TOTAL_LIMIT = 1e-6  # of all work of the sources
PART_LIMIT = 1e-3  # of the largest energy flow through a part of the machine, see `mbd.output.balance`
ROUND_OFF = 1e-10  # of all work of the sources, at least of 1 J, the order of the strain energy of machines at rest


@dataclass(frozen=True, eq=False, kw_only=True)
class Trajectory(Record):
    """Channels over time; ``values[i]`` is the channel ``channel_names[i]`` in ``channel_units[i]``.

    `values` is an array, or a `StoredArray` that reads the requested part. `motors` to `sensors` name the owners of the
    channels, see `mbd.parts.channels`.
    """

    integrator: str = text()
    time: np.ndarray = array("time", units="s")
    channel_names: tuple[str, ...] = names("channel")
    channel_units: tuple[str, ...] = names("channel")
    values: np.ndarray | StoredArray = array("channel", "time", units="per channel")
    motors: tuple[str, ...] = names("motor")
    sources: tuple[str, ...] = names("source")  # other torques from outside: loads, further motors
    shafts: tuple[str, ...] = names("shaft")
    meshes: tuple[str, ...] = names("mesh")
    bearings: tuple[str, ...] = names("bearing")
    sensors: tuple[str, ...] = names("sensor")
    step: float = scalar(units="s")
    step_error: float = scalar(units="1")  # error of the accelerations by the step, sample by sample; 0: not measured
    diverged_at: float = scalar(units="s")  # distance of a neighbouring motion half the signal; 0: never
    parting_rate: float = scalar(units="1/s")  # Lyapunov exponent: growth rate of the distance until then
    output_rate: float = scalar(units="Hz")
    pass_band: float = scalar(units="Hz")  # flat up to here; above output_rate - pass_band removed
    counter_names: tuple[str, ...] = names("counter")
    counters: np.ndarray = array("counter", units="1")
    energy_parts: tuple[str, ...] = names("part")
    energy_entries: tuple[str, ...] = names("entry")
    energies: np.ndarray = array("part", "entry", units="J")

    def channel(self, name: str) -> np.ndarray:
        """Values (time,) of one channel; KeyError with the known names if there is none of this name."""
        if name not in self.channel_names:
            raise KeyError(f"{name!r} is not a channel of this run; known: {', '.join(self.channel_names)}")
        return self.values[self.channel_names.index(name)]

    def counter(self, name: str) -> int:
        """One counter, e.g. ``"steps"``."""
        return int(self.counters[self.counter_names.index(name)])

    def energy(self, part: str, entry: str) -> float:
        """One entry (J) of the energy balance, e.g. ``("total", "residual")``."""
        return float(self.energies[self.energy_parts.index(part), self.energy_entries.index(entry)])

    def open_parts(self) -> tuple[str, ...]:
        """Parts, and the total, whose energy balance has too large a residual; none if the run is accurate.

        The residual of a part is compared with the energy flow through the machine, not through the part: a shaft that
        dissipates a millijoule has no effect on the motion.
        """
        floor = ROUND_OFF * max(1.0, self.energy("total", "scale"))
        _, flow = self._largest_flow()
        limits = dict.fromkeys(self.energy_parts, PART_LIMIT * flow)
        limits["total"] = TOTAL_LIMIT * self.energy("total", "scale")
        return tuple(
            part for part in self.energy_parts if abs(self.energy(part, "residual")) > max(limits[part], floor)
        )

    def unbalanced(self) -> tuple[str, ...]:
        """One sentence on the largest residual of `open_parts`; empty if there is none."""
        parts = self.open_parts()
        if not parts:
            return ()
        worst = max(parts, key=lambda part: abs(self.energy(part, "residual")))
        left = f"energy balance: {abs(self.energy(worst, 'residual')):.2g} J of {worst} are unaccounted for"
        if worst == "total":
            limit = f"{TOTAL_LIMIT:g} of the {self.energy('total', 'scale'):.2g} J of work of the sources"
        else:
            name, flow = self._largest_flow()
            limit = f"{PART_LIMIT:g} of the {flow:.2g} J that flow through {name}"
        more = f"; {len(parts) - 1} more are beyond it" if len(parts) > 1 else ""
        return (f"{left}; the limit is {limit}{more}.",)

    def _largest_flow(self) -> tuple[str, float]:
        """The part with the largest energy stored, dissipated, received or of parametric work, and this energy in J."""
        flows = {
            part: max(abs(self.energy(part, entry)) for entry in ("stored", "dissipated", "received", "parametric"))
            for part in self.energy_parts
            if part != "total"
        }
        name = max(flows, key=lambda part: flows[part])
        return name, flows[name]
