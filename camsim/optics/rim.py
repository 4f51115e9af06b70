"""The wavefront on the rim of a round pupil, which is all that a pattern's far light knows of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple, Protocol

import numpy as np
import scipy

from camsim.arrays import F64
from camsim.optics.protocols import Span

RIM_POINTS, DIRECTIONS, INSIDE = 240, 24, 12  # on a rim, and circles of the pupil on which slopes are looked for
STEP = 1e-4  # of a slope's difference, in radii
CORNER = 1.5  # lines that a corner nearby is taken for (``aberrated.settings.sighted``)


class Bent(Protocol):
    """A lens of one pupil whose wavefront is known."""

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64: ...  # noqa: D102

    def waves(self, x: F64, y: F64, wavelength_nm: float) -> F64: ...  # noqa: D102

    def waves_across(self, wavelength_nm: float) -> float: ...  # noqa: D102

    def waves_turned(self, low_nm: float, high_nm: float) -> float: ...  # noqa: D102

    def blur_um(self, wavelength_nm: float) -> float: ...  # noqa: D102

    def cutoff_per_um(self, wavelength_nm: float) -> float: ...  # noqa: D102

    def point_spread_rows(  # noqa: D102
        self, x_um: F64, y_um: F64, wavelength_nm: float, precision: float
    ) -> Iterator[tuple[slice, F64]]: ...

    def point_spread_round(self, r_um: F64, wavelength_nm: float) -> F64: ...  # noqa: D102

    def line_nodes(self, r_um: float, wavelength_nm: float) -> float: ...  # noqa: D102

    def pupil_nodes(self, wavelength_nm: float) -> Callable[[Span, Span], float]: ...  # noqa: D102


class Rim(NamedTuple):
    """Slopes on a pupil's rim or rims, waves per radius at one wavelength.

    move_waves  : (2,) what slopes are taken about: the mean, as far as it is one direction's, or what was given
    slope_waves : (directions, points) about it, along each direction;  share: of each point, 1 in all
    steepest_waves, inside_waves : the largest slope about it, of the rim and of all of the pupil
    ahead_waves : what is gained beyond x λN on one side of an edge through a photosite is at most the first over x² and
                  the second over x³; see ``_ahead``
    rings_rad   : how far the phases of opposite points of the rim differ, the move apart
    """

    move_waves: F64
    slope_waves: F64
    share: F64
    steepest_waves: float
    inside_waves: float
    ahead_waves: tuple[float, float]
    rings_rad: float


def rim_of(lens: Bent, obstruction: float, wavelength_nm: float, moved_waves: F64 | None = None) -> Rim:
    """Measure the wavefront on the rim of a round pupil, on that of its obstruction, and between.

    moved_waves : (2,) the slope that others are taken about; None: the mean
    """
    angle = 2.0 * np.pi * np.arange(RIM_POINTS) / RIM_POINTS
    normal = np.stack([np.cos(angle), np.sin(angle)])
    direction = normal[:, :: RIM_POINTS // DIRECTIONS].T
    rims = [1.0, obstruction] if obstruction else [1.0]

    def slopes(radius: F64) -> F64:
        x, y = np.multiply.outer(radius, normal).swapaxes(0, 1)
        gx = lens.waves(x + STEP, y, wavelength_nm) - lens.waves(x - STEP, y, wavelength_nm)
        gy = lens.waves(x, y + STEP, wavelength_nm) - lens.waves(x, y - STEP, wavelength_nm)
        return np.stack([gx, gy], axis=1) / (2.0 * STEP)

    everywhere = slopes(np.concatenate([rims, np.linspace(obstruction, 1.0, INSIDE)]))
    slope = np.concatenate([*everywhere[: len(rims)]], axis=1)
    # Sums in an order of their own: what a BLAS adds up depends on the number of its threads.
    across = np.abs(np.einsum("da,ap->dp", direction, normal))
    weight = np.concatenate([radius * across for radius in rims], axis=1)
    weight = weight / weight.sum(axis=1, keepdims=True)
    mean = np.einsum("dp,da,ap->d", weight, direction, slope)
    own: F64 = 2.0 * np.einsum("d,da->a", mean, direction) / DIRECTIONS
    move = own if moved_waves is None else moved_waves
    about = slope - move[:, None]
    plane = np.einsum("a,ap->p", move, normal)
    odd = [lens.waves(radius * normal[0], radius * normal[1], wavelength_nm) - radius * plane for radius in rims]
    return Rim(
        move_waves=move,
        slope_waves=np.einsum("da,ap->dp", direction, about),
        share=weight,
        steepest_waves=float(np.hypot(*about).max()),
        inside_waves=float(np.hypot(*(everywhere - move[:, None]).transpose(1, 0, 2)).max()),
        ahead_waves=_ahead(about.reshape(2, len(rims), RIM_POINTS).swapaxes(0, 1), normal, np.array(rims)),
        rings_rad=2.0 * math.pi * max(float(np.abs(w - np.roll(w, RIM_POINTS // 2)).max()) for w in odd),
    )


def _ahead(slope_waves: F64, normal: F64, radius: F64) -> tuple[float, float]:
    """Return how much more light a half-plane may get beyond x than of a round lens: over 1/x², and over 1/x³.

    slope_waves : (rims, 2, points);  normal: (2, points) of even points;  radius: of each rim

    A point θ of the rim throws c·dρ/ρ² along its normal either way, c = r/2π³(1 − ε²), from o = 2·slope. Beyond x
    between two directions of the image that gives, by Stokes' theorem on c/ρ·dθ and up to the square of o/x,

        c·(∫o_n − ½[o_t])/x² + c·(∫(o_n² + ½o_t²) − ⅔[o_n·o_t] + ⅓[o_t·∂o_t])/x³

    more than without o, where [ ] is what is at the second direction less what is at the first. In the first sum even
    aberrations of opposite points cancel; of odd ones o_t is what counts most, what is thrown along an edge to its one
    side. Half way round the second is half of its integral; of wedges [ ] is left, and a corner is ``CORNER`` lines.
    """
    step, half = 2.0 * math.pi / normal.shape[1], normal.shape[1] // 2
    moved, tangent = 2.0 * slope_waves, np.stack([-normal[1], normal[0]])
    first, second = np.zeros(normal.shape[1]), 0.0
    ends = np.zeros(normal.shape[1])
    for times, own in zip((radius / (2.0 * math.pi**3)).tolist(), moved, strict=True):
        for there in (own, np.roll(own, half, axis=1)):
            along, across = np.sum(normal * there, axis=0), np.sum(tangent * there, axis=0)
            turned = scipy.fft.irfft(1j * np.arange(half + 1) * scipy.fft.rfft(across))
            first += times * (step * np.cumsum(along) - 0.5 * (step * along + across))
            second += times * step * float(np.sum(along**2 + 0.5 * across**2))
            ends += times * across * (turned - 2.0 * along) / 3.0
    lost = 1.0 - (radius[1] ** 2 if radius.size > 1 else 0.0)
    return float(np.ptp(first)) / lost, (0.5 * second + float(np.ptp(ends)) / CORNER) / lost
