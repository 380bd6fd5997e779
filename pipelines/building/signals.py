"""Stage `response`: the trajectory as a labelled dataset."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from pipelines.scene import Scene

if TYPE_CHECKING:
    import xarray

    from fem.contact.law import MeshLaw
    from mbd.trajectory import Trajectory


@dataclass(frozen=True, kw_only=True)
class SignalsSpec:
    """The scene as far as labels need it: title and noise, beyond what the motion reads."""

    scene: Scene


def build(spec: SignalsSpec, trajectory: Trajectory, *laws: tuple[MeshLaw, MeshLaw]) -> xarray.Dataset:
    """The dataset of response.nc without provenance."""
    from pipelines.layout import lay_out
    from pipelines.machine import machine
    from pipelines.parts import mesh_inputs
    from pipelines.response import make_response

    layout = lay_out(spec.scene)
    train = machine(spec.scene, layout, mesh_inputs(spec.scene, layout, list(laws)))
    return make_response(spec.scene, train, trajectory)
