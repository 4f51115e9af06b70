"""A lens of one pupil as the check knows it: its amplitude summed by the rule that the engines do not take.

They sum along chords of polygons and along rays from the middle of circles; here it is the other way round.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

from camsim.arrays import F64
from camsim.optics.chords import chords_of
from camsim.optics.difference import Difference, Split
from camsim.optics.follow import Turns
from camsim.optics.of_pupil import OfPupil
from camsim.optics.panels import PanelRule
from camsim.optics.protocols import OpticalStage, Splits
from camsim.optics.pupil import Pupil
from camsim.optics.rays import Rays, rays_of

FARTHER = 1.3  # times as far as an image: of light that falls as 1/r² the check sees four tenths of what it leaves out


@dataclass(frozen=True, kw_only=True)
class Otherwise(OfPupil):
    """A lens whose pattern is summed over its pupil by another rule."""

    place: ClassVar[str] = "lens"

    lens: OfPupil
    f_number: float
    pupil: Pupil

    @classmethod
    def of(cls, lens: OfPupil) -> Otherwise:
        """Return a lens's."""
        return cls(lens=lens, f_number=lens.f_number, pupil=lens.pupil)

    def waves(self, x: F64, y: F64, wavelength_nm: float) -> F64:
        """As the lens's."""
        return self.lens.waves(x, y, wavelength_nm)

    @property
    def _symmetric(self) -> bool:
        return self.lens._symmetric

    def split(self) -> Split | None:
        """Return the lens's parts, the difference's pattern summed likewise."""
        parts: Split | None = self.lens.split() if isinstance(self.lens, Splits) else None
        return parts if parts is None or parts.rest is None else parts._replace(rest=_of_difference(parts.rest))

    def _rule(self, wavelength_nm: float, turns: Turns) -> PanelRule | Rays:
        return (rays_of if self.pupil.sides > 1 else chords_of)(self, wavelength_nm, turns)

    def _line_rule(self, wavelength_nm: float, turns: Turns) -> PanelRule | Rays:
        return rays_of(self, wavelength_nm, turns)


def summed_otherwise(lens: OpticalStage) -> OpticalStage:
    """Return a lens with its pattern summed by another rule, where it is summed over a pupil; any other as it is."""
    if isinstance(lens, OfPupil):
        return Otherwise.of(lens)
    return _of_difference(lens) if isinstance(lens, Difference) else lens


def _of_difference(rest: Difference) -> Difference:
    own = replace(rest, lens=Otherwise.of(rest.lens)) if isinstance(rest.lens, OfPupil) else rest
    return replace(own, scale=FARTHER)
