"""MeshModel: base of the mesh models, frozen classes of options that compute the mesh laws of a gear pair."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from fem.contact.law import MeshLaw
from fem.contact.slice_frame import FLANKS, ModelError
from fem.gears.geometry import GearPair
from fem.gears.modifications import PairModifications
from fem.options import check_options, option

if TYPE_CHECKING:
    from fem.contact.wheels.crack_surface import CrackSurfaceSpec


@dataclass(frozen=True, kw_only=True)
class MeshModel(ABC):
    """Options of a mesh model as fields, checked on creation.

    A field ``line_load`` (N/m) or None is set from the load of the pair; all others are options of the user. `seconds`
    is the approximate time for the laws of one pair. `libraries` are those on which its results depend. `places_webs`
    is True if the position of a web along the face is modelled, not only its thickness.
    """

    seconds: ClassVar[float] = 0.0
    libraries: ClassVar[tuple[str, ...]] = ("numpy", "scipy")
    places_webs: ClassVar[bool] = False
    slices: int = option(15, ge=1, le=101, text="number of slices along the face")

    def __post_init__(self) -> None:
        check_options(self, ModelError)

    @abstractmethod
    def laws(self, pair: GearPair) -> tuple[MeshLaw, MeshLaw]:
        """The laws of drive and coast flank.

        Raises
        ------
        ModelError, GeometryError : the pair is outside the range of the model
        """

    def law(self, pair: GearPair, flank: str = "drive") -> MeshLaw:
        """The law of one flank, "drive" or "coast"."""
        if flank not in FLANKS:
            raise ModelError(f"{pair.label}: flank is {flank!r}; choose one of {', '.join(FLANKS)}")
        return self.laws(pair)[FLANKS.index(flank)]

    def check(self, pair: GearPair) -> None:
        """Raise the errors of `laws` before any expensive computation."""
        self.laws(pair)

    def crack_surface(self, pair: GearPair, gear: str, angle: float) -> CrackSurfaceSpec | None:
        """Crack surface of the teeth of "pinion" or "wheel"; None: a plane crack in every slice."""
        return None

    def warnings(self, modifications: PairModifications) -> Iterable[str]:
        """Warnings about limits of the model for these flanks; none for most models."""
        return ()


@dataclass(frozen=True, kw_only=True)
class LawSpec:
    """A gear pair without its backlash, and the model of its laws."""

    pair: GearPair
    mesh: MeshModel

    def laws(self) -> tuple[MeshLaw, MeshLaw]:
        """The laws of drive and coast flank."""
        return self.mesh.laws(self.pair)
