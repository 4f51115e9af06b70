"""A picture for the frequency sums: B-splines on its samples, in pitches, and the outline of its visible part."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from camsim.core.arrays import F64
from camsim.core.cached import cached_property
from camsim.scene.raster import DEGREES, Raster
from camsim.spectra.curve import Spectrum

Rings = tuple[F64, F64]
SETTLED = 32  # samples beyond which a cubic spline does not depend on another sample, to the last digit


@dataclass(frozen=True, kw_only=True, eq=False)
class Layer:
    """One picture minus the background that it hides.

    The field is Σ coefficients × B-splines over sample coordinates: u along the picture's rows, v down the columns,
    integers at the sides of the samples' squares.

    picture : the samples
    offset  : (planes,) subtracted from every plane: the background, if the planes' spectra can represent it
    ones    : whether a plane of ones follows, for the background's spectrum
    step    : spacing of samples, pitches
    corner  : (2,) position of u = v = 0, pitches from the optical axis;  axes: (2, 2) unit vectors along u and v
    outline : (start, end), each (n, 2) in u and v, of the visible part, inside where cross(end − start, x − start) > 0;
              None if nothing hides the picture
    """

    picture: Raster
    offset: F64
    ones: bool
    step: float
    corner: F64
    axes: F64
    outline: Rings | None

    @classmethod
    def of(cls, picture: Raster, background: Spectrum, pitch_um: float, outline_um: Rings | None) -> Layer:
        """Place a picture; ``outline_um``: edges (start, end) of its visible part, µm; None: all of it."""
        rows, cols = picture.shape
        axes, step_um = picture.axes, picture.step_um
        corner_um = np.array(picture.centre_um) - 0.5 * step_um * np.einsum("a,ax->x", np.array([cols, rows]), axes)
        grey = background if isinstance(background, float | int) else None
        flat = None if grey is None else picture.flat
        planes = len(picture.planes)
        outline = None
        if outline_um is not None:
            start, end = (np.einsum("nx,ax->na", (part - corner_um) / step_um, axes) for part in outline_um)
            outline = start, end
        return cls(
            picture=picture,
            offset=np.zeros(planes) if flat is None or grey is None else grey * flat,
            ones=flat is None,
            step=step_um / pitch_um,
            corner=corner_um / pitch_um,
            axes=axes,
            outline=outline,
        )

    @property
    def degree(self) -> int:
        """Degree of the splines."""
        return DEGREES[self.picture.interpolation]

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of samples."""
        return self.picture.shape

    @property
    def planes(self) -> int:
        """Number of planes, the ones included."""
        return len(self.picture.planes) + self.ones

    @property
    def kind(self) -> str:
        """Name of the kind of picture in explanations."""
        return self.picture.kind

    @property
    def sides(self) -> int:
        """Number of sides of the outline."""
        return 4 if self.outline is None else len(self.outline[0])

    @property
    def said(self) -> tuple[str, str]:
        """What ``camsim explain`` says of the layer, and the reason."""
        rows, cols = self.shape
        turned = f", turned by {self.picture.rotate_deg:g}°" if self.picture.rotate_deg % 360.0 else ""
        seen = "all of it seen" if self.outline is None else "what outlines cut of it is integrated"
        return (
            f"{rows} × {cols} samples, {self.planes} plane{'s' if self.planes != 1 else ''}",
            f"{self.picture.interpolation}, {self.step:.3g} photosites a sample{turned}; {seen}",
        )

    @property
    def upright(self) -> bool:
        """Whether rows of samples are exactly parallel to rows or columns of photosites."""
        return bool((self.axes == np.rint(self.axes)).all())

    @property
    def corners(self) -> F64:
        """Corners (4, 2) of the box of the visible part, along the picture's axes, pitches."""
        (left, top), (right, bottom) = (0.0, 0.0), self.shape[::-1]
        if self.outline is not None:
            seen = np.concatenate(self.outline)
            (left, top), (right, bottom) = seen.min(axis=0), seen.max(axis=0)
        return self.places(np.array([[left, top], [right, top], [right, bottom], [left, bottom]]))

    def places(self, samples: F64) -> F64:
        """Return the positions (n, 2), pitches, of sample coordinates (n, 2)."""
        placed: F64 = self.corner + self.step * np.einsum("na,ax->nx", samples, self.axes)
        return placed

    def within(self, low: F64, high: F64) -> list[tuple[float, float]]:
        """Return the least and the greatest u, and v, of a box (low, high), pitches."""
        corners = np.array([[x, y] for x in (low[0], high[0]) for y in (low[1], high[1])]) - self.corner
        u, v = np.einsum("nx,ax->an", corners / self.step, self.axes)
        return [(float(one.min()), float(one.max())) for one in (u, v)]

    @cached_property
    def splines(self) -> F64:
        """Spline coefficients (planes, rows, cols) of the picture, without offset and ones."""
        planes: F64 = self.picture.planes
        if self.degree < 2:
            return planes
        beside = SETTLED if min(self.shape) < SETTLED else 0  # SciPy's filter is only right of long lines
        planes = np.pad(planes, ((0, 0), (beside, beside), (beside, beside)), mode="symmetric") if beside else planes
        down = scipy.ndimage.spline_filter1d(planes, 3, axis=1, mode="reflect")
        across: F64 = scipy.ndimage.spline_filter1d(down, 3, axis=2, mode="reflect")
        return across[:, beside : beside + self.shape[0], beside : beside + self.shape[1]]

    def all_coefficients(self, turned: bool) -> F64:
        """Return all coefficients (planes, rows, cols); if ``turned``, with rows and columns exchanged."""
        whole = self.coefficients(range(self.shape[0]), range(self.shape[1]))
        return whole.transpose(0, 2, 1) if turned else whole

    def coefficients(self, rows: range, cols: range) -> F64:
        """Return coefficients (planes, rows, cols) of a window of samples; beyond the picture they are mirrored."""
        if rows.start >= 0 and rows.stop <= self.shape[0] and cols.start >= 0 and cols.stop <= self.shape[1]:
            one = self.splines[:, rows.start : rows.stop, cols.start : cols.stop]
        else:
            down, across = mirrored(rows, self.shape[0]), mirrored(cols, self.shape[1])
            one = self.splines[:, down[:, None], across[None, :]]
        out = np.empty((self.planes, len(rows), len(cols)))
        np.subtract(one, self.offset[:, None, None], out=out[: len(one)])
        out[len(one) :] = 1.0
        return out


def mirrored(wanted: range, count: int) -> np.ndarray:
    """Return the indices of ``count`` samples for any integers, by reflection: d c b a | a b c d | d c b a.

    >>> mirrored(range(-2, 5), 3).tolist()
    [1, 0, 0, 1, 2, 2, 1]
    """
    place = np.arange(wanted.start, wanted.stop) % (2 * count)
    return np.where(place < count, place, 2 * count - 1 - place)


def refined(coefficients: F64, degree: int, times: int) -> F64:
    """Return the coefficients of the same spline on a lattice ``times`` (odd) as fine; the outermost ones are invalid.

    A B-spline is a sum of narrower ones, with the weights of the convolution of ``degree + 1`` boxes.

    >>> refined(np.array([[[0.0, 0.0, 3.0, 3.0, 3.0]]]).repeat(5, 1), 1, 3)[0, 7, 4:10].tolist()
    [0.0, 1.0, 2.0, 3.0, 3.0, 3.0]
    """
    if times == 1:
        return coefficients
    mask = np.ones(1)
    for _ in range(degree + 1):
        mask = np.convolve(mask, np.ones(times))
    mask /= float(times) ** degree
    for axis in (1, 2):
        shape = list(coefficients.shape)
        shape[axis] *= times
        wide = np.zeros(shape)
        middle = [slice(None)] * 3
        middle[axis] = slice(times // 2, None, times)
        wide[tuple(middle)] = coefficients
        coefficients = scipy.ndimage.correlate1d(wide, mask, axis=axis, mode="constant")
    return coefficients


def basis(degree: int, t: F64) -> F64:
    """Return the values (degree + 1, …) of the B-splines that are not 0 between two knots, at 0 ≤ t ≤ 1, in order."""
    if degree == 0:
        return np.ones((1, *t.shape))
    if degree == 1:
        return np.stack([1.0 - t, t])
    s = 1.0 - t
    cubes = s * s * s / 6.0, t * t * t / 6.0
    return np.stack([cubes[0], 2.0 / 3.0 - t * t + 3.0 * cubes[1], 2.0 / 3.0 - s * s + 3.0 * cubes[0], cubes[1]])
