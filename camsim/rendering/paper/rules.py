"""The methods of van den Bergh's paper, by name, as a reference to which the boundary engine is compared.

F. van den Bergh, "On the rendering of synthetic images with specific point spread functions". The methods place a fixed
set of samples of the PSF around every photosite and weight the scene's mean over the footprint at each; ``strips``
integrates a Gaussian PSF instead, in closed form along x and adaptively along y.

area           the footprint alone, clipped exactly: no lens uniform-pixel  11 × 11 samples at integer pixels, weighted
               by the PSF
uniform        11 × 11 samples over the extent of the PSF (3 σ, or the third dark ring)
importance     N samples (default 2025) of the Halton sequence (2, 3), distributed as the PSF (Airy cut at 18 λN)
strips         Gaussian PSF of any covariance, point photosite

One deliberate difference from the paper: a photosite's rectangle and the OLPF's spots are clipped exactly at every
sample, for all methods.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from camsim.core.arrays import F64
from camsim.core.kernels import shared
from camsim.errors import InvalidValueError, UnsupportedError
from camsim.optics import Airy, EllipticalGaussian, Gaussian, OpticalSystem
from camsim.rendering.edges import Edges
from camsim.rendering.footprint import Footprint
from camsim.rendering.paper.kernels import Boxes, Steps, each_sample, strips, weighted

GRID = 11  # the paper's samples along a side
IMPORTANCE_SAMPLES = 2025  # the paper's
AIRY_CUT = 18.0  # λN, as in the paper
THIRD_DARK_RING = 3.2383  # λN


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rule:
    """The samples of a method for one lens and footprint; lengths in pitches.

    places, shares : (m, 2) centres of the footprint's rectangles about a photosite, and (m,) their weights
    width, height  : size of these rectangles
    whiten         : (2, 2) map that gives the Gaussian of ``strips`` σ = 1 in every direction; None for other methods
    random         : whether the samples can be treated as random draws from the PSF
    """

    places: F64
    shares: F64
    width: float = 0.0
    height: float = 0.0
    whiten: F64 | None = None
    random: bool = False

    @property
    def samples(self) -> int:
        """Number of samples per photosite."""
        return len(self.shares)

    def image(
        self, edges: Edges, contrast: F64, background: float, *, origin: tuple[float, float], shape: tuple[int, int]
    ) -> F64:
        """Render at one wavelength; ``contrast``: (n,) left minus right of edges;  origin: first photosite's."""
        image = np.empty(shape)
        if self.whiten is not None:
            whitened = Steps(edges.start @ self.whiten.T, edges.end @ self.whiten.T, contrast)
            rows = functools.partial(strips, *origin, whitened, background, self.whiten, image)
        else:
            steps = Steps(edges.start, edges.end, contrast)
            rows = functools.partial(weighted, *origin, steps, background, self._boxes, image)
        shared(len(image), rows)
        return image

    def standard_error(self, edges: Edges, contrast: F64, points: F64) -> float | None:
        """Return the largest standard error of the samples' mean at ``points`` (m, 2); None if they are not random."""
        if not self.random or self.samples < 2:
            return None
        worst, steps = 0.0, Steps(edges.start, edges.end, contrast)
        for x, y in points:
            values = each_sample(x, y, steps, self._boxes)
            worst = max(worst, float(values.std(ddof=1)) / math.sqrt(self.samples))
        return worst

    @property
    def _boxes(self) -> Boxes:
        return Boxes(self.width, self.height, self.places, self.shares)


def rule_of(method: str, system: OpticalSystem, *, blur: float, footprint: Footprint, samples: int | None) -> Rule:
    """Return the samples of a method.

    blur    : scale of the PSF (λN, or σ of a Gaussian), pitches
    samples : number of samples of ``importance``; None for its default
    """
    lens, spots = system.lens, footprint.spots
    if samples is not None and method != "importance":
        raise UnsupportedError(f"{method} has a fixed set of samples; only importance takes a number", key="samples")
    if method == "strips":
        if not isinstance(lens, Gaussian | EllipticalGaussian) or footprint.side > 0.0 or len(spots) > 1:
            raise UnsupportedError(
                "strips needs a Gaussian lens and a point photosite (side_um 0, no OLPF); "
                f"this is {type(lens).__name__} on {footprint.side:g} pitches: use boundary",
                key="method",
            )
        return Rule(places=np.zeros((1, 2)), shares=np.ones(1), whiten=_whitening(lens, blur))
    if not isinstance(lens, Airy | Gaussian):
        raise UnsupportedError(
            f"{method} knows Airy and Gaussian lenses; this is {type(lens).__name__}: use boundary", key="method"
        )
    offsets, weights = SAMPLES[method](lens, blur, samples)
    return Rule(
        places=(offsets[:, None, :] + spots[None]).reshape(-1, 2),
        shares=np.repeat(weights, len(spots)) / len(spots),
        width=footprint.width,
        height=footprint.height,
        random=method == "importance",
    )


def _whitening(lens: Gaussian | EllipticalGaussian, blur: float) -> F64:
    """Return the map from pitches to a plane in which the PSF has σ = 1 in every direction: covariance^(−½)."""
    if isinstance(lens, Gaussian):
        return np.eye(2) / blur
    size, axes = np.linalg.eigh(np.array(lens.covariance_um2) * (blur / lens.blur_um(0.0)) ** 2)
    matrix: F64 = (axes / np.sqrt(size)) @ axes.T
    return matrix


def _area(lens: Airy | Gaussian, blur: float, samples: int | None) -> tuple[F64, F64]:
    return np.zeros((1, 2)), np.ones(1)


def _uniform(lens: Airy | Gaussian, blur: float, samples: int | None) -> tuple[F64, F64]:
    reach = blur * (3.0 if isinstance(lens, Gaussian) else THIRD_DARK_RING)
    return _weigh_grid(lens, blur, np.linspace(-reach, reach, GRID, dtype=np.float64))


def _uniform_pixel(lens: Airy | Gaussian, blur: float, samples: int | None) -> tuple[F64, F64]:
    return _weigh_grid(lens, blur, np.arange(GRID, dtype=np.float64) - (GRID - 1) / 2.0)


def _weigh_grid(lens: Airy | Gaussian, blur: float, along: F64) -> tuple[F64, F64]:
    offsets = np.stack(np.meshgrid(along, along, indexing="xy"), axis=-1).reshape(-1, 2)
    rho = np.hypot(offsets[:, 0], offsets[:, 1]) / blur
    if isinstance(lens, Gaussian):
        weights = np.exp(-0.5 * rho * rho)
    else:
        x = np.pi * np.where(rho == 0.0, 1.0, rho)
        weights = np.where(rho == 0.0, 1.0, (2.0 * scipy.special.j1(x) / x) ** 2)
    shares: F64 = weights / weights.sum()
    return offsets, shares


def _importance(lens: Airy | Gaussian, blur: float, samples: int | None, cut: float = AIRY_CUT) -> tuple[F64, F64]:
    count = IMPORTANCE_SAMPLES if samples is None else samples
    if count < 1:
        raise InvalidValueError(f"{count} samples show nothing; give 1 or more", key="samples")

    # Skip the first point, the origin, at which the inverse distribution is infinite.
    u = scipy.stats.qmc.Halton(2, scramble=False).random(count + 1)[1:]
    if isinstance(lens, Gaussian):
        offsets = blur * scipy.special.ndtri(u)
    else:
        rho = np.linspace(0.0, cut, 1 << 16)
        energy = lens.pattern().energy(rho)
        radius = blur * np.interp(u[:, 0] * energy[-1], energy, rho)
        offsets = radius[:, None] * np.stack([np.cos(2 * np.pi * u[:, 1]), np.sin(2 * np.pi * u[:, 1])], axis=1)
    return offsets, np.full(count, 1.0 / count)


SAMPLES: dict[str, Callable[[Any, float, int | None], tuple[F64, F64]]] = {
    "area": _area,
    "uniform-pixel": _uniform_pixel,
    "uniform": _uniform,
    "importance": _importance,
}
METHODS = (*SAMPLES, "strips")
