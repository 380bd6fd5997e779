"""Public interface of gearcase in Python: a `Scene`, and functions that compute from it.

    scene = gearcase.Scene.from_file("minimal")    check laws casing modes simulate run tradeoff converge design
    gearcase.reduce(K, M, points, nodes=...)       matrices of another program; Point
    gearcase.open_run("minimal")                   a finished run; diagnose error_bars spectrum
    gearcase.open_recording("r.csv", "bench.toml") a measured file; features judge compare
    gearcase.open_dataset("campaigns/plan")        a data set of many runs; pieces

All numbers are SI unless a name ends in a unit. No function prints; `progress=` takes a function that is called for
every step of the work. Other names are internal and may change.
"""

import importlib
import logging
from typing import TYPE_CHECKING, Any

from gearcase.shadowed_packages import refuse_shadowed

if TYPE_CHECKING:
    from gearcase.campaigns import Finished as Finished
    from gearcase.campaigns import campaign as campaign
    from gearcase.casings import Casing as Casing
    from gearcase.casings import casing as casing
    from gearcase.datasets import open_dataset as open_dataset
    from gearcase.datasets import pieces as pieces
    from gearcase.errors import InputError as InputError
    from gearcase.errors import SceneError as SceneError
    from gearcase.errors import WorkError as WorkError
    from gearcase.machines import LinearModes as LinearModes
    from gearcase.machines import modes as modes
    from gearcase.machines import simulate as simulate
    from gearcase.pair_laws import PairLaws as PairLaws
    from gearcase.pair_laws import laws as laws
    from gearcase.progress import StepProgress as StepProgress
    from gearcase.recordings import Verdict as Verdict
    from gearcase.recordings import compare as compare
    from gearcase.recordings import features as features
    from gearcase.recordings import judge as judge
    from gearcase.recordings import open_recording as open_recording
    from gearcase.reduction import Point as Point
    from gearcase.reduction import ReducedMatrices as ReducedMatrices
    from gearcase.reduction import reduce as reduce
    from gearcase.results import Diagnosis as Diagnosis
    from gearcase.results import LineBars as LineBars
    from gearcase.results import diagnose as diagnose
    from gearcase.results import error_bars as error_bars
    from gearcase.results import open_run as open_run
    from gearcase.results import run as run
    from gearcase.results import spectrum as spectrum
    from gearcase.scenes import Checked as Checked
    from gearcase.scenes import Scene as Scene
    from gearcase.scenes import check as check
    from gearcase.studies import DesignStudy as DesignStudy
    from gearcase.studies import FeatureSpread as FeatureSpread
    from gearcase.studies import RefinementStudy as RefinementStudy
    from gearcase.studies import Tradeoff as Tradeoff
    from gearcase.studies import converge as converge
    from gearcase.studies import design as design
    from gearcase.studies import spread as spread
    from gearcase.studies import tradeoff as tradeoff

_PLACES = {
    "campaigns": ("Finished", "campaign"),
    "casings": ("Casing", "casing"),
    "datasets": ("open_dataset", "pieces"),
    "errors": ("InputError", "SceneError", "WorkError"),
    "machines": ("LinearModes", "modes", "simulate"),
    "pair_laws": ("PairLaws", "laws"),
    "progress": ("StepProgress",),
    "recordings": ("Verdict", "compare", "features", "judge", "open_recording"),
    "reduction": ("Point", "ReducedMatrices", "reduce"),
    "results": ("Diagnosis", "LineBars", "diagnose", "error_bars", "open_run", "run", "spectrum"),
    "scenes": ("Checked", "Scene", "check"),
    "studies": (
        "DesignStudy",
        "FeatureSpread",
        "RefinementStudy",
        "Tradeoff",
        "converge",
        "design",
        "spread",
        "tradeoff",
    ),
}
_PLACE_OF = {name: place for place, names in _PLACES.items() for name in names}
__all__ = sorted(_PLACE_OF)

refuse_shadowed()
for _package in ("fem", "mbd", "pipelines"):
    logging.getLogger(_package).addHandler(logging.NullHandler())  # silent unless the caller configures logging


def __getattr__(name: str) -> Any:
    """Import a public name at its first use, so that `import gearcase` itself imports no libraries."""
    if name not in _PLACE_OF:
        raise AttributeError(f"module 'gearcase' has no attribute {name!r}")
    found = getattr(importlib.import_module(f"gearcase.{_PLACE_OF[name]}"), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return __all__
