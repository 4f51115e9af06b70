"""Results of a measurement of colour."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, TypeAlias

import numpy as np

from camsim.measure.geometry import Roi

Lab: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class PatchColour:
    """One patch.

    name              : name of the patch's reflectance
    roi               : the bounding rectangle of its photosites
    photosites        : number used; a margin along its outline is left out
    lab, reference_lab : CIE L*, a*, b* under D50, measured and computed from spectra; a perfect diffuser is L* = 100
    delta_e_2000      : between the two;  delta_e_error: its standard error, from the photosites' scatter
    noise_lab         : standard deviation of L*, a* and b* of the developed photosites
    snr_db            : 20·log₁₀ of mean over standard deviation of the developed luminance
    """

    name: str
    roi: Roi
    photosites: int
    lab: Lab
    reference_lab: Lab
    delta_e_2000: float
    delta_e_error: float
    noise_lab: Lab
    snr_db: float


@dataclass(frozen=True, slots=True, kw_only=True)
class WhiteBalance:
    """How far the greys of a chart are from grey after the white balance that the file states.

    patches            : the greys used: reference chroma below 3
    r_over_g, b_over_g : balanced channels relative to those computed from the greys' spectra; 1 is ideal
    chroma             : mean C*ab between measured and reference greys
    """

    patches: tuple[str, ...]
    r_over_g: float
    b_over_g: float
    chroma: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ColourReport:
    """All patches of one picture.

    white_balance : None if there is no grey patch
    development   : development for the noise figures
    left_out      : a sentence on parts of the scene that could not be measured
    """

    file: str
    patches: tuple[PatchColour, ...]
    white_balance: WhiteBalance | None
    left_out: tuple[str, ...] = ()
    development: str = ""

    @property
    def delta_e_mean(self) -> float:
        """Mean CIEDE2000 of the patches."""
        return float(np.mean([patch.delta_e_2000 for patch in self.patches]))

    @property
    def delta_e_largest(self) -> float:
        """The largest CIEDE2000."""
        return max(patch.delta_e_2000 for patch in self.patches)

    def as_dict(self) -> dict[str, Any]:
        """Return the result as plain values for JSON."""
        return {
            "file": self.file,
            "development": self.development,
            "delta_e_2000_mean": self.delta_e_mean,
            "delta_e_2000_largest": self.delta_e_largest,
            "white_balance": None if self.white_balance is None else asdict(self.white_balance),
            "patches": [_finite(asdict(patch)) for patch in self.patches],
            "left_out": list(self.left_out),
        }


def _finite(tree: dict[str, Any]) -> dict[str, Any]:
    return {key: None if isinstance(value, float) and not np.isfinite(value) else value for key, value in tree.items()}
