"""What a frame sees of edges, and what throws the light of those beyond a taper."""

from __future__ import annotations

from dataclasses import dataclass

from camsim.arrays import F64
from camsim.kept import cached_property
from camsim.optics import OpticalSystem
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.edges import Edges
from camsim.rendering.fourier.loudness import distances
from camsim.rendering.fourier.spread import Kernel
from camsim.rendering.fourier.taper import Hem
from camsim.rendering.hearing import Heard, Hearing


@dataclass(frozen=True, kw_only=True, eq=False)
class Sight:
    """Edges as a frame sees them through a system; lengths in pitches.

    edges   : seen from the frame's first photosite;  shape: of the frame
    kernel  : what is known of the lens
    hearing : what tells which sides are heard
    """

    system: OpticalSystem
    kernel: Kernel
    wavelength_nm: F64
    pitch_um: float
    edges: Edges
    shape: tuple[int, int]
    tolerance: float
    hearing: Hearing

    @cached_property
    def distances(self) -> tuple[F64, float]:
        """How far every side is from the frame, at least, and how far one may be from a photosite."""
        return distances(self.edges, self.shape)

    @property
    def extent(self) -> float:
        """How far a photosite reaches."""
        return self.system.extent_um / self.pitch_um

    @property
    def longest(self) -> float:
        """The lens's own length at the longest wavelength."""
        return float(self.system.blurs_um(self.wavelength_nm).max()) / self.pitch_um

    @property
    def of_tapers(self) -> float:
        """What tapers may leave of the image."""
        return ErrorBudget(self.tolerance).allowed("taper") / self.kernel.tapers

    def heard(self, longest: float, slowest: float) -> Heard:
        """Return which sides are heard, of rings of such wavelengths."""
        return self.hearing(self.edges, self.shape, self.extent, longest, slowest)


@dataclass(frozen=True, kw_only=True, eq=False)
class FarLight:
    """The light from beyond a taper, thrown by a system from regions.

    density : (spectra, channels, j) what each spectrum gives each channel at each wavelength
    """

    edges: Edges
    density: F64
    wavelength_nm: F64
    system: OpticalSystem
    pitch_um: float
    hem: Hem
