"""Trade-off of a scene: cost and accuracy of every choice against the reference, and the Pareto front."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from fem.storage import shown_html
from pipelines.engine.run_graph import Work
from pipelines.io.errors import InputError, SceneError
from pipelines.machine.layout import lay_out
from pipelines.scene.load_scene import LoadedScene, changed
from pipelines.studies.trade.line_uncertainty import line_uncertainty
from pipelines.studies.trade.measured_variants import Measured, measure, step_costs
from pipelines.studies.trade.probes import DECIBEL, PROBES
from pipelines.studies.trade.tradeoff_choices import PRESET, Choice, choices

JUDGE = "signals"  # probe whose error ranks the choices
LINES = "lines"  # probe whose levels are a further criterion of the Pareto front, if the scene has a fault


@dataclass(frozen=True, kw_only=True)
class Priced:
    """A choice with its cost and its largest errors against the reference by probe: of levels in dB, else relative."""

    choice: Choice
    measured: Measured
    errors: Mapping[str, float]
    dominated: bool

    @property
    def seconds(self) -> float:
        """Computing time of all steps of the choice without the cache, s."""
        return self.measured.total_seconds

    @property
    def error(self) -> float:
        """Relative error of the sensor rms, by which choices are ranked; NaN for a choice without these signals."""
        return self.errors.get(JUDGE, math.nan)


@dataclass(frozen=True, kw_only=True)
class Tradeoff:
    """Result of a trade-off: all choices, the reference first; `refused` maps the others to the reason.

    `known` states the numerical uncertainty of the lines of the fault in the reference, "" without a fault.
    """

    name: str
    priced: tuple[Priced, ...]
    refused: Mapping[str, str]
    known: str

    def __repr__(self) -> str:
        return f"<Tradeoff: {len(self.priced)} choices of {self.name}, {len(self.refused)} refused>"

    def _repr_html_(self) -> str:
        """Table of the choices with cost and error, for a notebook."""
        rows = [(one.choice.name, one.seconds, 100 * one.error, "" if one.dominated else "yes") for one in self.priced]
        head = ("choice", "s", "error of the sensor rms, %", "nothing is faster and better")
        return shown_html.table(f"Choices of {self.name}", head, rows)

    @property
    def front(self) -> tuple[Priced, ...]:
        """Choices on the Pareto front of time, error and lines of the fault, the fastest first."""
        return tuple(sorted((p for p in self.priced if not p.dominated), key=lambda p: p.seconds))

    def cheapest(self, error: float) -> Priced | None:
        """The fastest choice within a relative error of the sensor rms; None if there is none."""
        return min((p for p in self.priced if p.error <= error), key=lambda p: p.seconds, default=None)

    def most_accurate(self, seconds: float) -> Priced | None:
        """The choice with the least error within a time (s); None if there is none."""
        return min((p for p in self.front if p.seconds <= seconds), key=lambda p: p.error, default=None)


def trade(loaded: LoadedScene, work: Work) -> Tradeoff:
    """Run every choice of a scene and compare it with the reference.

    A choice is not run if its estimated motion alone takes longer than all steps of the reference.

    Raises
    ------
    InputError : the machine has no load, about which it could be linearised
    WorkError : a step failed
    """
    if not any(lay_out(loaded.scene, loaded.name).resisting_torques):
        raise InputError(
            f"{loaded.name}: tradeoff compares natural frequencies, which need a load. Set one, such as --set "
            "load.torque_N_m=50."
        )
    found, scenes, refused = _variants(loaded)
    costs = step_costs(scenes.values(), work)
    first, best = next(iter(scenes.items()))
    whole = measure({first: best}, list(PROBES), work)[first].total_seconds
    for name, variant in list(scenes.items())[1:]:
        settings = variant.scene.simulation.made()
        motion = costs[settings.integrator] * settings.steps
        if motion > whole:
            del scenes[name]
            refused[name] = (
                f"its motion alone would take about {motion:.0f} s; all steps of the reference take {whole:.0f} s"
            )
    measured, failed = _measured(scenes, work)
    refused |= failed
    reference = measured[first]
    errors = {name: differences(one, reference) for name, one in measured.items()}
    places = {
        name: (one.total_seconds, errors[name].get(JUDGE, math.nan), errors[name].get(LINES, 0.0))
        for name, one in measured.items()
    }
    priced = tuple(
        Priced(
            choice=found[name],
            measured=one,
            errors=errors[name],
            dominated=_beaten(places[name], places.values()),
        )
        for name, one in measured.items()
    )
    return Tradeoff(name=loaded.name, priced=priced, refused=refused, known=line_uncertainty(best, work))


def _variants(loaded: LoadedScene) -> tuple[dict[str, Choice], dict[str, LoadedScene], dict[str, str]]:
    """Choices and scenes by name, each different scene once and all presets; reasons of the refused ones by name."""
    found: dict[str, Choice] = {}
    scenes: dict[str, LoadedScene] = {}
    refused: dict[str, str] = {}
    for choice in choices(loaded.scene):
        try:
            variant = changed(loaded, choice.settings)
        except SceneError as error:
            refused[choice.name] = " ".join(str(error).split())
            continue
        if choice.effect == PRESET or all(variant.scene != other.scene for other in scenes.values()):
            scenes[choice.name], found[choice.name] = variant, choice
    return found, scenes, refused


def _measured(scenes: dict[str, LoadedScene], work: Work) -> tuple[dict[str, Measured], dict[str, str]]:
    """Measurements of all scenes by name, and the reasons of those that failed.

    All scenes are measured at once. If a step fails, they are measured one by one with the finished steps.
    """
    probes = list(PROBES)
    try:
        return measure(scenes, probes, work), {}
    except (ValueError, RuntimeError):
        measured: dict[str, Measured] = {}
        failed: dict[str, str] = {}
        for name, loaded in scenes.items():
            try:
                measured |= measure({name: loaded}, probes, work)
            except (ValueError, RuntimeError) as error:
                failed[name] = " ".join(str(error).split())
        return measured, failed


def differences(one: Measured, reference: Measured) -> dict[str, float]:
    """Largest difference over the common values by probe: of levels in dB, of all others relative to the reference."""
    known = {value.name: value.value for value in one.values}
    errors: dict[str, float] = {}
    for probe, values in reference.by_probe.items():
        for value in values:
            if value.firm and value.name in known:
                scale = 1.0 if value.unit == DECIBEL else abs(value.value) or 1.0
                errors[probe] = max(errors.get(probe, 0.0), abs(known[value.name] - value.value) / scale)
    return errors


def _beaten(place: tuple[float, ...], places: Iterable[tuple[float, ...]]) -> bool:
    """Whether a choice is dominated: another one is no worse in all criteria and better in one, or its error is NaN."""
    if any(math.isnan(value) for value in place):
        return True
    return any(all(o <= own for o, own in zip(other, place, strict=True)) and other != place for other in places)
