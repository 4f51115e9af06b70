"""A field-varying lens: wavefront, distortion, lateral colour and relative illumination over the frame."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from annotated_types import Ge, Le

from camsim.core.arrays import F64, is_masked
from camsim.core.typed import Fraction, NonNegative, Number, Positive, Several, Whole, refusal, validate
from camsim.numerics.splines import mirrored_spline, spline
from camsim.numerics.zernike import LARGEST_INDEX, orders
from camsim.optics.airy import NM_PER_UM, Airy, DiffractionLimit
from camsim.optics.placed import PlacedLens, defocus_nm
from camsim.optics.pupil import Pupil
from camsim.optics.wavefront import MOST_WAVES, check_focus
from camsim.spectra.curve import NumberOrCurve, Transmission, Wavelength

POWERS_HOLD = 2.0  # largest height, over the last one, to which a distortion's polynomial is used
FOLD_POINTS = 1024  # along a radius, at which distortion is tested for folding
TILT, DEFOCUS = 2, 4  # OSA indices
BEYOND = 1.0 + 1e-9  # allows for the rounding of a corner's radius


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldLens(DiffractionLimit):
    """A lens whose PSF changes over the frame.

    The PSF at each photosite is that of its place. A lens of revolution is given along one radius, by ``height_um``;
    any other on a grid of places, by ``x_um`` and ``y_um``.

    f_number      : f-number on the axis, used at every place
    wavelength_nm : (w,) increasing. Path differences are interpolated by a spline; with one wavelength they are the
                    same lengths at every wavelength
    zernike       : (k,) OSA/ANSI indices. For a lens of revolution only those with cosines, for the field along +x; at
                    other places they are rotated
    waves         : (w, heights, k), or (w, y, x, k): root mean square over the pupil, waves at each wavelength; signs
                    as in ``Wavefront``
    height_um     : image heights from the axis, the first 0, increasing, to the rim of the image circle
    x_um, y_um    : coordinates of places, increasing
    distortion    : (heights,) an ideal height is imaged at height·(1 + distortion); linear extrapolation beyond the
                    last height
    distortion_height_um : heights of ``distortion``, the first 0, increasing, in place of ``height_um``
    distortion_powers : instead of ``distortion``: k₁, k₂ … of k₁·u² + k₂·u⁴ + …, u the height over the last one; used
                    beyond it until the slope of the mapping has halved, at most to u = 2, and linear from there
    lateral_colour_um : (w, heights) radial displacement of each wavelength away from the axis, µm
    relative_illumination : (heights,) light relative to that on the axis, fractions, the first 1
    focus_um      : focus shift of sensor against lens, as ``Wavefront.defocus_um``
    transmission  : fraction of the light that passes, a number or a curve over wavelength

    Cubic splines interpolate between heights and places, even or odd about the axis as each Zernike is. ``otf`` is that
    on the axis.

    >>> lens = FieldLens(
    ...     f_number=4.0, wavelength_nm=[550.0], zernike=[4], waves=[[[0.0], [0.1]]], height_um=[0.0, 5000.0]
    ... )
    >>> round(lens.at(5000.0, 0.0).waves(np.array(1.0), np.array(0.0), 550.0).item(), 4)  # √3·0.1
    0.1732
    """

    place: ClassVar[str] = "lens"

    f_number: Positive
    wavelength_nm: Several[Wavelength]
    zernike: Several[Annotated[int, Ge(0), Le(LARGEST_INDEX)]]
    waves: Any
    height_um: Several[NonNegative] = ()
    x_um: Several[float] = ()
    y_um: Several[float] = ()
    distortion: Several[float] = ()
    distortion_height_um: Several[NonNegative] = ()
    distortion_powers: Several[float] = ()
    lateral_colour_um: Several[Several[float]] = ()
    relative_illumination: Several[Fraction] = ()
    focus_um: float = 0.0
    transmission: Transmission = 1.0

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            f_number: Number,
            wavelength_nm: Several[Number],
            zernike: Several[Whole],
            waves: Any,
            height_um: Several[Number] = (),
            x_um: Several[Number] = (),
            y_um: Several[Number] = (),
            distortion: Several[Number] = (),
            distortion_height_um: Several[Number] = (),
            distortion_powers: Several[Number] = (),
            lateral_colour_um: Several[Several[Number]] = (),
            relative_illumination: Several[Number] = (),
            focus_um: Number = 0.0,
            transmission: NumberOrCurve = 1.0,
        ) -> None: ...

    def __repr__(self) -> str:
        return self.stated_briefly

    @property
    def stated_briefly(self) -> str:
        """Description in one line, without its tables."""
        low, high, count = self.wavelength_nm[0], self.wavelength_nm[-1], len(self.wavelength_nm)
        colours = f"{count} wavelengths, {low:g} to {high:g} nm" if count > 1 else f"{low:g} nm"
        heights = f"{len(self.height_um)} heights to {self.height_um[-1] / 1e3:g} mm" if self.height_um else ""
        places = heights or f"{len(self.x_um)} × {len(self.y_um)} places"
        focus = f", focus_um={self.focus_um:g}" if self.focus_um else ""
        return f"FieldLens(f_number={self.f_number:g}, {colours}, {places}, {len(self.zernike)} Zernikes{focus})"

    def __post_init__(self) -> None:
        validate(self)
        self._validate_places()
        if len(set(self.zernike)) < len(self.zernike):
            raise refusal(self, "zernike", "an index is given twice; give each once")
        check_focus(self, "focus_um", self.focus_um, self.f_number)
        shape = (len(self.wavelength_nm), *self._places, len(self.zernike))
        try:
            waves = _numbers(self.waves)
        except (TypeError, ValueError):
            raise refusal(self, "waves", "must be a table of numbers whose rows are equally long") from None
        if waves.shape != shape:
            named = "wavelengths × heights × Zernikes" if self.turns else "wavelengths × y × x × Zernikes"
            raise refusal(self, "waves", f"must be {_size(shape)}: {named}, not {_size(waves.shape)}")
        if not np.all(np.abs(waves) <= MOST_WAVES):
            raise refusal(self, "waves", f"must be numbers from {-MOST_WAVES:g} to {MOST_WAVES:g}")
        object.__setattr__(self, "waves", _tuples(waves.tolist()))
        if self.turns:
            self._validate_revolution(waves)
        self._validate_tables()

    def _validate_places(self) -> None:
        radii = [("height_um", self.height_um), ("distortion_height_um", self.distortion_height_um)]
        for key, places in (("wavelength_nm", self.wavelength_nm), ("x_um", self.x_um), ("y_um", self.y_um), *radii):
            if any(after <= before for before, after in pairwise(places)):
                raise refusal(self, key, f"{list(places)}; must increase")
        if not self.wavelength_nm:
            raise refusal(self, "wavelength_nm", "is empty; give one or more")
        if bool(self.x_um) != bool(self.y_um):
            key = "y_um" if self.x_um else "x_um"
            raise refusal(self, key, "missing; places have both x and y")
        if not self.x_um and not self.height_um:
            raise refusal(self, "height_um", "missing; give heights of a lens of revolution, or x_um and y_um")
        for key, places in radii:
            if places and (len(places) < 2 or places[0] != 0.0):
                raise refusal(self, key, f"{list(places)}; give two or more, the first 0")

    def _validate_revolution(self, waves: F64) -> None:
        for k, index in enumerate(self.zernike):
            m = orders(index)[1]
            if m < 0:
                raise refusal(
                    self, "zernike", f"{index} is a sine; a lens of revolution has cosines only, or give x_um and y_um"
                )
            if m > 0 and waves[:, 0, k].any():
                raise refusal(self, "waves", f"Zernike {index} on the axis must be 0 of a lens of revolution")

    def _validate_tables(self) -> None:
        heights = len(self.height_um)
        if self.distortion_height_um and not self.distortion:
            raise refusal(self, "distortion", "missing; distortion_height_um are its heights")
        of_distortion = "distortion_height_um" if self.distortion_height_um else "height_um"
        for key, table, places in (
            ("distortion", self.distortion, of_distortion),
            ("relative_illumination", self.relative_illumination, "height_um"),
        ):
            if table and len(table) != len(getattr(self, places)):
                raise refusal(self, key, f"{len(table)} for {len(getattr(self, places))} of {places}; give as many")
        colours = {len(self.lateral_colour_um), *(heights - len(row) for row in self.lateral_colour_um)}
        if self.lateral_colour_um and colours != {len(self.wavelength_nm), 0}:
            raise refusal(
                self, "lateral_colour_um", f"give {len(self.wavelength_nm)} × {heights}: wavelengths × heights"
            )
        if any(row[0] for row in self.lateral_colour_um):
            raise refusal(self, "lateral_colour_um", "must be 0 on the axis, where every colour falls alike")
        if self.relative_illumination and self.relative_illumination[0] != 1.0:
            raise refusal(self, "relative_illumination", "must begin with 1, the light on the axis")
        if self.distortion and self.distortion_powers:
            raise refusal(self, "distortion_powers", "given together with 'distortion'; leave one of the two out")
        if self.distortion_powers and not heights:
            raise refusal(self, "distortion_powers", "needs height_um, whose last is the height that they are of")
        if self.distorts:
            ideal = np.linspace(0.0, (self.distortion_height_um or self.height_um)[-1], FOLD_POINTS)
            steps = np.diff(_radially(self, ideal))
            if steps.min() <= 0.0:
                raise refusal(
                    self,
                    "distortion" if self.distortion else "distortion_powers",
                    f"folds at {ideal[int(np.argmax(steps <= 0.0))]:.4g} µm from the axis: "
                    "what lies farther out must fall farther out",
                )

    @property
    def turns(self) -> bool:
        """Whether it is a lens of revolution."""
        return not self.x_um

    @property
    def _places(self) -> tuple[int, ...]:
        return (len(self.height_um),) if self.turns else (len(self.y_um), len(self.x_um))

    @property
    def distorts(self) -> bool:
        """Whether it has distortion."""
        return any(self.distortion) or any(self.distortion_powers)

    def lacks(self, wavelength_nm: F64, corners_um: F64) -> str:
        """Return why the lens does not cover a frame with corners (n, 2) at these wavelengths; "" if it does."""
        known, low, high = self.wavelength_nm, float(wavelength_nm.min()), float(wavelength_nm.max())
        if len(known) > 1 and not (known[0] <= low and high <= known[-1]):
            return (
                f"is known from {known[0]:g} to {known[-1]:g} nm, and light of {low:g} to {high:g} nm is seen; "
                "give it more wavelengths, or put a filter before it"
            )
        farthest_um = float(np.hypot(corners_um[:, 0], corners_um[:, 1]).max())
        if self.height_um and farthest_um > BEYOND * self.height_um[-1]:
            return (
                f"has an image circle of {self.height_um[-1] / 1e3:.4g} mm about the axis, and the picture's corner "
                f"lies {farthest_um / 1e3:.4g} mm from it; take a smaller sensor, or a region"
            )
        for axis, places in (("x", self.x_um), ("y", self.y_um)):
            item = corners_um[:, int(axis == "y")]
            if len(places) > 1 and not (BEYOND * places[0] <= item.min() and item.max() <= BEYOND * places[-1]):
                return (
                    f"is known from {places[0]:g} to {places[-1]:g} µm along {axis}, and the picture goes from "
                    f"{item.min():g} to {item.max():g}; take a smaller sensor, or a region"
                )
        return ""

    def at(self, x_um: float, y_um: float) -> PlacedLens:
        """Return the lens for a photosite at a place."""
        height, angle = math.hypot(x_um, y_um), math.atan2(y_um, x_um)
        paths = dict(zip(self.zernike, _table(self)(x_um, y_um), strict=True))
        if self.lateral_colour_um:
            moved = _lateral(self)(height) * NM_PER_UM / (4.0 * self.f_number)
            if self.turns:
                paths[TILT] = paths.get(TILT, 0.0) + moved
            else:
                for index, part in ((TILT, math.cos(angle)), (TILT - 1, math.sin(angle))):
                    paths[index] = paths.get(index, 0.0) + part * moved
        if self.turns:
            paths = {index: path for item, path in paths.items() for index, path in _turned(item, path, angle)}
        if self.focus_um:
            shift = np.full(len(self.wavelength_nm), defocus_nm(self.focus_um, self.f_number))
            paths[DEFOCUS] = paths.get(DEFOCUS, 0.0) + shift
        return PlacedLens(
            f_number=self.f_number,
            wavelength_nm=tuple(self.wavelength_nm),
            zernike=tuple(paths),
            path_nm=_tuples(np.stack([*paths.values()], axis=1).tolist()) if paths else ((),) * len(self.wavelength_nm),
            pupil=Pupil(),
        )

    def distorted(self, points_um: F64) -> F64:
        """Return the distorted positions of points (n, 2), given by their ideal positions on the sensor, µm."""
        height = np.hypot(points_um[:, 0], points_um[:, 1])
        there = height > 0.0
        scale = np.ones_like(height)
        scale[there] = _radially(self, height[there]) / height[there]
        return points_um * scale[:, None]

    def illumination(self, radius_um: F64) -> F64:
        """Return the light at distances from the axis, relative to that on the axis."""
        if not self.relative_illumination:
            return np.ones_like(radius_um)
        displayed: F64 = mirrored_spline(self.height_um, np.array(self.relative_illumination))(
            np.minimum(radius_um, self.height_um[-1])
        )
        return np.clip(displayed, 0.0, None)

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Transfer on the axis at (fx, fy) cycles/µm."""
        return self.at(0.0, 0.0).otf(fx_per_um, fy_per_um, wavelength_nm)

    def otf_size(self, frequency_per_um: F64, direction: tuple[float, float], wavelength_nm: float) -> F64:
        """Return a bound of the transfer anywhere in the frame: the transfer without aberrations."""
        return Airy(f_number=self.f_number).otf(
            frequency_per_um * direction[0], frequency_per_um * direction[1], wavelength_nm
        )


def _numbers(table: Any) -> F64:
    """Return a table as an array; raises TypeError or ValueError if it holds texts, truth values or uneven rows."""
    listed = np.asarray(table, object)
    if any(isinstance(value, str | bytes | bool | np.bool_) for value in listed.flat) or is_masked(table):
        raise TypeError
    return np.asarray(listed, float)


def _size(shape: tuple[int, ...]) -> str:
    return " × ".join(map(str, shape)) or "one number"


def _tuples(rows: Any) -> Any:
    return tuple(map(_tuples, rows)) if isinstance(rows, list) else rows


def _turned(index: int, path: F64, angle: float) -> list[tuple[int, F64]]:
    """Return a Zernike with a cosine about a field angle φ as a cosine and a sine about x: cos m(θ − φ)."""
    n, m = orders(index)
    if m == 0:
        return [(index, path)]
    sine = (n * (n + 2) - m) // 2
    return [(index, math.cos(m * angle) * path), (sine, math.sin(m * angle) * path)]


@functools.lru_cache(maxsize=64)
def _table(lens: FieldLens) -> Callable[[float, float], F64]:
    """Return path differences (k, w) as a function of x and y: waves times wavelength, by splines."""
    nm = np.array(lens.wavelength_nm)
    path = np.asarray(lens.waves) * nm.reshape(-1, *(1,) * (len(lens._places) + 1))
    if not lens.turns:
        down = np.moveaxis(path, (1, 2, 3, 0), (0, 1, 2, 3))  # (y, x, k, w)
        rows = spline(tuple(lens.x_um), np.moveaxis(down, 1, 0))
        return lambda x_um, y_um: spline(tuple(lens.y_um), rows(x_um))(y_um)
    each = [_about_axis(lens.height_um, path[:, :, k].T, orders(index)[1]) for k, index in enumerate(lens.zernike)]
    return lambda x_um, y_um: np.array([one(math.hypot(x_um, y_um)) for one in each])


@functools.lru_cache(maxsize=64)
def _lateral(lens: FieldLens) -> Callable[[float], F64]:
    return mirrored_spline(lens.height_um, np.array(lens.lateral_colour_um).T, 1)


def _about_axis(heights: Any, values: F64, m: int) -> Callable[..., F64]:
    """Return a harmonic of order m as a function of height, smooth on the axis: it must begin with the m-th power.

    An even or odd spline begins with the power 0 or 1. For higher orders, the values over the square of the height are
    interpolated, so that they begin with the power 3 or 4: as smooth as a cubic spline.
    """
    if m < 3:
        return mirrored_spline(heights, values, m)
    square = np.square(np.array(heights, float))[:, None]
    over = mirrored_spline(heights, np.divide(values, square, out=np.zeros_like(values), where=square > 0.0), m)
    return lambda h: over(h) * h**2


def _radially(lens: FieldLens, ideal_um: F64) -> F64:
    """Return the distorted heights, with linear extrapolation beyond the end of the table or polynomial."""
    moved, last_um, slope = _moved(lens)
    inside = np.minimum(ideal_um, last_um)
    fallen: F64 = moved(inside) + slope * (ideal_um - inside)
    return fallen


@functools.lru_cache(maxsize=64)
def _moved(lens: FieldLens) -> tuple[Callable[[F64], F64], float, float]:
    """Return the distorted height as a function up to a last height, this height, and the slope there.

    A table ends at its last height. A polynomial is used farther, since barrel distortion images scenery from beyond
    the frame: until its slope is half of that at the last height, as it may fold beyond, and at most to twice the
    height.
    """
    heights = lens.distortion_height_um or lens.height_um
    last = heights[-1]
    if lens.distortion:
        fraction = mirrored_spline(heights, np.array(lens.distortion))
        steeper = float(fraction(last, 1)) if len(heights) > 1 else 0.0
        return lambda h: h * (1.0 + fraction(h)), last, 1.0 + lens.distortion[-1] + last * steeper
    powers = (1.0, *lens.distortion_powers)
    slope = np.polynomial.Polynomial([(2 * n + 1) * k for n, k in enumerate(powers)])  # of u²
    half = (slope - 0.5 * slope(1.0)).roots()
    ends = half.real[np.isreal(half) & (half.real > 1.0)]
    square = float(ends.min(initial=POWERS_HOLD**2))
    return lambda h: h * np.polyval(powers[::-1], (h / last) ** 2), last * math.sqrt(square), float(slope(square))
