"""The footprint: photosite ⊗ OLPF spots, in pitches, with its moments and its transfer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camsim.core.arrays import F64
from camsim.core.cached import cached_property
from camsim.errors import UnsupportedError
from camsim.numerics.quadrature import gauss_legendre
from camsim.optics import OpticalStage, OpticalSystem, RoundLens
from camsim.optics.pattern import Pattern
from camsim.optics.protocols import Rectangular

BEYOND = (8, 10, 12, 14, 16)  # powers of the harmonic moments that the far form leaves out
_SAME = 1e-13  # of the farthest spot: offsets this close are equal


@dataclass(frozen=True, kw_only=True, eq=False)
class Footprint:
    """A rectangle with sides along x and y at every spot of an OLPF, symmetric about its centre.

    width, height : pitches; 0 is a point
    spots  : (n, 2) offsets, pitches
    mirrored : whether it is symmetric under reflection, left to right
    square   : whether it is also symmetric under a quarter turn
    sigma2 : ½⟨|ζ|²⟩; m22 = ⟨|ζ|⁴⟩, m66 = ⟨|ζ|⁶⟩; m2 = ⟨ζ²⟩, m31 = ⟨ζ³ζ̄⟩, m4, m6 = ⟨ζ⁴⟩, ⟨ζ⁶⟩
    beyond : sizes of ⟨ζ⁸⟩, ⟨ζ¹⁰⟩ … ⟨ζ¹⁶⟩
    """

    width: float
    height: float
    spots: F64
    mirrored: bool
    square: bool
    sigma2: float
    m22: float
    m66: float
    m2: complex
    m31: complex
    m4: complex
    m6: complex
    beyond: tuple[float, ...]

    @classmethod
    def of(cls, system: OpticalSystem, pitch_um: float) -> Footprint:
        """Measure the system's footprint in pitches."""
        if not isinstance(system.photosite, Rectangular):
            raise UnsupportedError(
                f"the boundary engine knows rectangles, not {type(system.photosite).__name__}; use fourier",
                key="photosite",
            )
        if system.more:
            raise UnsupportedError(
                f"the boundary engine takes a lens, an OLPF and a photosite, not "
                f"{type(system.more[0]).__name__} besides; use fourier",
                key="optics",
            )
        width, height = (side / pitch_um for side in system.photosite.sides_um)
        return cls.measured(width, height, system.spots_um() / pitch_um)

    @classmethod
    def measured(cls, width: float, height: float, spots: F64) -> Footprint:
        """Compute the moments of a rectangle at every spot, pitches; a 9-point Gauss rule is exact for all of them."""
        zeta, weight = footprint_rule(width, height, spots, 9)
        z = zeta[:, 0] + 1j * zeta[:, 1]
        size2 = np.abs(z) ** 2
        mirrored = _same_spots(spots, spots * [-1.0, 1.0])

        def mean(values: np.ndarray) -> complex:
            """Average over the footprint; moments that vanish by symmetry are set to 0, free of rounding."""
            value = complex(weight @ values)
            size = 1e-13 * float(weight @ np.abs(values))
            return complex(value.real if abs(value.real) > size else 0.0, value.imag if abs(value.imag) > size else 0.0)

        return cls(
            width=width,
            height=height,
            spots=spots,
            mirrored=mirrored,
            square=mirrored and width == height and _same_spots(spots, spots[:, ::-1]),
            sigma2=0.5 * float(weight @ size2),
            m22=float(weight @ size2**2),
            m66=float(weight @ size2**3),
            m2=mean(z**2),
            m31=mean(z**2 * size2),
            m4=mean(z**4),
            m6=mean(z**6),
            beyond=tuple(abs(mean(z**n)) for n in BEYOND),
        )

    def otf(self, fx: F64, fy: F64) -> F64:
        """Transfer, signed, at (fx, fy) cycles/pitch."""
        otf: F64 = np.sinc(self.width * fx) * np.sinc(self.height * fy)
        if self.spots.any():
            otf *= np.mean([np.cos(2 * np.pi * (fx * sx + fy * sy)) for sx, sy in self.spots], axis=0)
        return otf

    @property
    def plain(self) -> bool:
        """Whether the moments vanish that do so if it has the symmetry of a quarter turn."""
        return self.m2 == self.m31 == self.m6 == 0.0

    @property
    def side(self) -> float:
        """The longer side, pitches."""
        return max(self.width, self.height)

    @cached_property
    def extent(self) -> float:
        """Distance of the footprint's farthest point from its centre, pitches."""
        return float(np.hypot(*(np.abs(self.spots) + 0.5 * np.array([self.width, self.height])).T).max())

    @cached_property
    def grid(self) -> tuple[F64, F64, F64]:
        """The spots as x (a,) × y (b,) about each of c centres (c, 2); c is 1 if they form a grid."""
        if len(self.spots) == 1:
            return self.spots[:, 0], self.spots[:, 1], np.zeros((1, 2))
        x, y = (_distinct(axis) for axis in self.spots.T)
        if _same_spots(self.spots, np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)):
            return x, y, np.zeros((1, 2))
        return np.zeros(1), np.zeros(1), self.spots

    def folded(self, ways: F64) -> F64:
        """Return directions (n, 2) mapped to a fundamental domain of the footprint's symmetries.

        The result has x ≥ 0; if mirrored also y ≥ 0, and if square also x ≤ y.
        """
        folded = ways * np.where((ways[:, :1] < 0.0) | ((ways[:, :1] == 0.0) & (ways[:, 1:] < 0.0)), -1.0, 1.0)
        if self.mirrored:
            folded = np.abs(folded)
        return np.sort(folded, axis=1) if self.square else folded

    def angles(self, frequencies: int) -> F64:
        """Return evenly spaced angles, descending from a quarter turn, that cover all ``folded`` directions."""
        if self.extent == 0.0:
            return np.array([0.5, -0.5]) * np.pi  # all directions are the same
        # A footprint many λN wide has narrow lobes at one wavelength; a spectrum smooths them.
        octants = 1 if self.square else 2 if self.mirrored else 4
        return 0.5 * np.pi - np.linspace(0.0, octants * np.pi / 4, octants * (32 if frequencies == 1 else 8) + 1)

    def transfer(self, frequency: F64) -> F64:
        """OTF (directions, n), signed, at each radial frequency (cycles/pitch) in the directions of ``angles``."""
        angle = self.angles(frequency.size)
        return self.otf(np.outer(np.cos(angle), frequency), np.outer(np.sin(angle), frequency))


def pattern_of(lens: OpticalStage) -> Pattern:
    """Return a lens's pattern; raises UnsupportedError for a lens that is not rotationally symmetric."""
    if not isinstance(lens, RoundLens):
        raise UnsupportedError(
            "takes round lenses (Airy, AnnularAiry, Gaussian, RadialOtf, or one that tells its pattern), not "
            f"{type(lens).__name__}; auto or fourier takes it",
            key="lens",
        )
    return lens.pattern()


def _same_spots(a: F64, b: F64) -> bool:
    """Return whether two lists hold the same offsets in any order."""
    if a.shape != b.shape:
        return False
    apart = np.abs(a[:, None] - b).max(axis=2)
    farthest = max(float(apart.min(axis=0).max()), float(apart.min(axis=1).max()))
    return farthest <= 4.0 * _SAME * float(np.abs(a).max())


def _distinct(offsets: F64) -> F64:
    """Return the distinct offsets along an axis: means over those that differ only by rounding."""
    values = np.sort(offsets)
    groups = np.split(values, np.flatnonzero(np.diff(values) > _SAME * np.abs(values).max()) + 1)
    return np.array([group.mean() for group in groups])


def footprint_rule(width: float, height: float, spots: F64, order: int) -> tuple[F64, F64]:
    """Return nodes (m, 2) and weights (m,) of a Gauss product rule over the rectangle at every spot."""
    x, wx = _side_rule(width, order)
    y, wy = _side_rule(height, order)
    nodes = np.empty((len(spots), x.size, y.size, 2))
    nodes[..., 0] = spots[:, :1, None] + x[:, None]
    nodes[..., 1] = spots[:, 1:, None] + y
    return nodes.reshape(-1, 2), np.concatenate([np.outer(wx, wy).ravel() / len(spots)] * len(spots))


def _side_rule(side: float, order: int) -> tuple[F64, F64]:
    x, w = gauss_legendre(order if side > 0.0 else 1)
    return 0.5 * side * x, 0.5 * w
