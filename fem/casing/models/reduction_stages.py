"""Stage `casing modes` and related stages: a meshed casing on its ground, factorised and reduced."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from fem.casing.models.stage import CasingError, PlannedStage, Stage

if TYPE_CHECKING:
    from fem.casing.mesh.mesh import CasingMesh
    from fem.casing.models.body_stages import Recovery
    from fem.casing.parts.bolted_joint import BoltedJoint
    from fem.casing.parts.casing_choices import Attachment, Ground
    from fem.casing.parts.regions import Region
    from fem.casing.reduced.casing_modes import CasingModes
    from fem.casing.reduced.checkup import CheckUp
    from fem.casing.reduced.grounded import AssembledCasing, ForcedPoint
    from fem.casing.reduced.reduced_body import ReducedBody
    from fem.casing.reduced.reduction import Reduction
    from fem.casing.reduced.reduction_error import ErrorStatement
    from fem.casing.uncertainty.extrapolation import LowestModes
    from fem.elements.materials import Material

_SPARSE = ("numpy", "scipy", "pymetis", "scikit-fem")


@dataclass(frozen=True, kw_only=True)
class Holding:
    """Supports of a meshed casing; `interfaces` are the axes along which every bearing loads it, all by default."""

    material: Material
    interfaces: Mapping[str, Sequence[str]] | None
    ground: Ground
    attachment: Attachment
    joint: BoltedJoint | None


@dataclass(frozen=True, kw_only=True)
class CasingReduction(Stage):
    """Factorise and reduce a casing.

    The stiffness of `regions` is stored separately; external forces act on `forced` points.

    `quadratic` adds the lowest modes without the cubic displacements of the elements, for the discretisation error.
    """

    kind: ClassVar[str] = "casing-modes"
    libraries: ClassVar[tuple[str, ...]] = _SPARSE
    compiles: ClassVar[Mapping[str, float]] = {"fem.numerics.multifrontal.": 5.0}
    static: ClassVar[bool]  # whether inertia is condensed too
    held: Holding
    regions: tuple[Region, ...]
    forced: tuple[ForcedPoint, ...]
    quadratic: bool = False

    def assembled(self, mesh: CasingMesh, *, divided: bool) -> AssembledCasing:
        """The meshed casing on its ground; `divided` as in `assembled_casing`."""
        from fem.casing.reduced.grounded import assembled_casing

        return assembled_casing(mesh, forced=self.forced, regions=self.regions, divided=divided, **vars(self.held))

    def build(self, *, mesh: CasingMesh) -> tuple[CasingModes, CheckUp] | tuple[CasingModes, CheckUp, LowestModes]:
        """The reduced matrices with their check-up, and the quadratic modes where requested.

        Raises
        ------
        CasingError : items of the check-up fail
        EigenError : the number of modes differs from the Sturm-sequence count
        """
        from threadpoolctl import threadpool_limits

        from fem.casing.reduced.checkup import check_up
        from fem.casing.uncertainty.extrapolation import quadratic_modes

        with threadpool_limits(1):  # the expensive steps run in two parallel halves
            casing = self.assembled(mesh, divided=True)
            modes, reduction = self.reduced(casing)
            found = check_up(casing, reduction)
            if found.failures:
                raise CasingError(
                    f"casing: the reduced body fails the checks {', '.join(found.failures)}. Use a finer "
                    f"casing.element_size_mm, or another casing model.\n{found.report()}"
                )
            if not self.quadratic:
                return modes, found
            cubic, casing = casing.cubic, casing.quadratic()  # the larger matrices are freed
            return modes, found, quadratic_modes(casing, cubic, reduction, static=self.static)

    @abstractmethod
    def reduced(self, casing: AssembledCasing) -> tuple[CasingModes, Reduction]:
        """The stored part of a reduction, and the reduction."""

    def lowest(self, name: str, mesh: PlannedStage, *, quadratic: bool = False) -> PlannedStage:
        """The stage of this name with the lowest modes on a mesh."""
        stage = LowestReduction(held=self.held, static=self.static, quadratic=quadratic)
        return PlannedStage(name=name, stage=stage, takes={"mesh": mesh.name}, seconds=0.9 * mesh.seconds)


@dataclass(frozen=True, kw_only=True)
class LowestReduction(Stage):
    """Natural modes for the extrapolation of a casing; `quadratic`: without the cubic displacements of the elements."""

    kind: ClassVar[str] = "casing-coarser"
    libraries: ClassVar[tuple[str, ...]] = _SPARSE
    held: Holding
    static: bool
    quadratic: bool

    def build(self, *, mesh: CasingMesh) -> LowestModes:
        """The lowest modes."""
        from fem.casing.reduced.grounded import assembled_casing
        from fem.casing.uncertainty.extrapolation import lowest_modes

        mesh = replace(mesh, cubic=0) if self.quadratic else mesh
        return lowest_modes(assembled_casing(mesh, divided=True, **vars(self.held)), static=self.static)


@dataclass(frozen=True, kw_only=True)
class QuadraticModes(Stage):
    """The quadratic modes among the results of a `CasingReduction`."""

    kind: ClassVar[str] = "casing-coarser"

    def build(self, *, modes: tuple[CasingModes, CheckUp, LowestModes]) -> LowestModes:
        """The lowest modes."""
        return modes[2]


@dataclass(frozen=True, kw_only=True)
class ErrorCheck(Stage):
    """Comparison of a reduced casing with its full model up to a band (Hz), with the same stiffness factor."""

    kind: ClassVar[str] = "casing-error"
    libraries: ClassVar[tuple[str, ...]] = _SPARSE
    reduction: CasingReduction
    recovery: Recovery
    band: float

    def build(self, *, mesh: CasingMesh, modes: tuple[CasingModes, CheckUp], body: ReducedBody) -> ErrorStatement:
        """The error statement.

        Parameters
        ----------
        mesh, modes, body : results of the other stages
        """
        from fem.casing.reduced.reduction_error import state_error

        held, recovery = self.reduction.held, self.recovery
        iron = replace(held.material, elastic_modulus=body.stiffness_factor * held.material.elastic_modulus)
        return state_error(
            replace(self.reduction, held=replace(held, material=iron)).assembled(mesh, divided=False),
            body,
            band=self.band,
            sensors=recovery.sensors,
            damping=recovery.damping,
            loss_factors=recovery.loss_factors,
            springs=modes[0].springs(recovery.mounts),
        )
