"""Pictures: fields of samples, planes of numbers each with a spectrum, placed among the shapes of a scene."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from camsim.core.annotations import After, Before, Called
from camsim.core.arrays import F64, distinct, is_masked
from camsim.core.number_kinds import array_of
from camsim.core.typed import Fraction, Number, Place, Point, Positive, Several, check, refusal, validate
from camsim.core.words import displayed
from camsim.errors import InvalidValueError
from camsim.scene.raster import Interpolation, Oblong, Raster
from camsim.spectra.component import Component
from camsim.spectra.curve import Curve, Spectrum, spectrum_at
from camsim.spectra.pca import planes_of_cube
from camsim.spectra.rgb import Encoding, linear_colours, rgb_basis, whole_codes

MOST_PLANES = 64
_ROUNDING = 1e-6  # of samples of reflectance in single precision
_AT_ONCE = 1 << 14  # samples examined at a time

_OneSpectrum: TypeAlias = Annotated[
    Fraction | Annotated[Curve, After(lambda curve: curve.going_on("hold"))] | Component,
    Called("a number from 0 to 1 or a Curve"),
]
_Spectra: TypeAlias = Annotated[
    tuple[_OneSpectrum, ...],
    Before(lambda given: given if isinstance(given, Sequence | np.ndarray) else (given,)),
]


@dataclass(frozen=True, slots=True, weakref_slot=True, kw_only=True, eq=False)
class Picture(Raster, Oblong):
    """A rectangle of samples in front of the camera, as it falls on the sensor.

    planes        : (planes, rows, cols) or (rows, cols) numbers, row 0 at the top
    spectra       : of every plane: the reflectance at a sample is the sum of plane × spectrum, from 0 to 1. Curves go
                    on beyond their tables as they end, unless they say otherwise
    width_um      : width of the whole picture; the height follows, as every sample stands for a square
    centre_um     : centre of the picture
    rotate_deg    : rotation, clockwise as displayed
    interpolation : between samples: "squares" (each is a square of one colour), "linear", or "cubic" (a spline through
                    the samples, which may swing beyond them). At its rim the picture ends sharply, half a sample beyond
                    the outermost ones, and goes on as its mirror image up to there
    source        : name of the picture in reports and files;  sha256: hash of samples and spectra, which no file holds
    read          : how ``read_picture`` read it from a file, so that it can be read again

    >>> picture = Picture.of_rgb(np.full((2, 3, 3), (0.5, 0.4, 0.3)), width_um=30.0)
    >>> picture.shape, picture.height_um, len(picture.spectra)
    ((2, 3), 20.0, 3)
    """

    planes: Any = field(repr=False)
    spectra: Any = field(default=(1.0,), repr=False)
    width_um: Positive
    centre_um: Point = (0.0, 0.0)
    rotate_deg: float = 0.0
    interpolation: Interpolation = "squares"
    source: str = ""
    read: Mapping[str, Any] | None = field(default=None, metadata={"described": "if any"})
    sha256: str = field(default="", init=False)

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            planes: Any,
            spectra: Any = (1.0,),
            width_um: Number,
            centre_um: Place = (0.0, 0.0),
            rotate_deg: Number = 0.0,
            interpolation: Interpolation = "squares",
            source: str = "",
            read: Mapping[str, Any] | None = None,
        ) -> None: ...

    def __post_init__(self) -> None:
        validate(self)
        planes = _all_given(self.planes, "planes", "Picture")
        if planes.dtype.kind not in "fui":
            raise refusal(self, "planes", f"must be numbers, not {planes.dtype}")
        if planes.ndim == 3 and planes.shape[2] in (3, 4) and len(planes) > 4:
            message = f"must be (planes, rows, cols), not {planes.shape}; Picture.of_rgb takes (rows, cols, 3)"
            raise refusal(self, "planes", message)
        whole = planes.dtype.kind in "ui"
        planes = np.array(planes, np.float32 if planes.dtype == np.float32 else np.float64, order="C")
        planes = planes[None] if planes.ndim == 2 else planes
        if planes.ndim != 3 or not planes.size:
            raise refusal(self, "planes", f"must be (planes, rows, cols), not an array of shape {planes.shape}")
        spectra: tuple[Spectrum | Component, ...] = check(self.spectra, _Spectra, "spectra", "Picture")
        if len(spectra) != len(planes) or len(planes) > MOST_PLANES:
            raise refusal(
                self, "spectra", f"{len(spectra)} for {len(planes)} planes; one each, at most {MOST_PLANES} of them"
            )
        if not np.isfinite(planes).all():
            raise refusal(self, "planes", f"{_first(~np.isfinite(planes))} is not a finite number")
        planes.flags.writeable = False
        object.__setattr__(self, "planes", planes)
        object.__setattr__(self, "spectra", spectra)
        if all(isinstance(spectrum, float | int | Curve) for spectrum in spectra):
            low, high = float(planes.min()), float(planes.max())
            if low < -_ROUNDING or high > 1.0 + _ROUNDING:
                raise refusal(
                    self,
                    "planes",
                    f"must be from 0 to 1, fractions of the light that come back, not {low if low < 0 else high:g}; "
                    "divide by the value that is to be a perfect diffuser's"
                    + (", or codes of a picture: Picture.of_rgb(…, encoding='srgb', width_um=…)" if whole else ""),
                )
            nodes, values = _tabulated(spectra)
            if (most := _brightest(planes, values)).max() > 1.0 + _ROUNDING:
                where = f"at {nodes[most.argmax()]:g} nm " if nodes.size > 1 else ""
                message = f"{where}the sum of planes × spectra comes to {most.max():g}; a reflectance is from 0 to 1"
                raise refusal(self, "spectra", message)
        content = hashlib.sha256(np.ascontiguousarray(planes).data)
        for spectrum in spectra:
            nodes = _nodes(spectrum)
            content.update(np.stack([nodes, spectrum_at(spectrum, nodes)]).tobytes())
        object.__setattr__(self, "sha256", content.hexdigest())

    @classmethod
    def of_rgb(
        cls,
        rgb: ArrayLike,
        *,
        encoding: Encoding | Number | None = None,
        width_um: Number,
        centre_um: Place = (0.0, 0.0),
        rotate_deg: Number = 0.0,
        interpolation: Interpolation = "squares",
        source: str = "",
        read: Mapping[str, Any] | None = None,
    ) -> Picture:
        """Return a picture of the colours of sRGB (rows, cols, 3), from 0 to 1; a grey one may be (rows, cols).

        encoding : "linear", for numbers in proportion to light; "srgb", as pictures on screens and in files are; or an
                   exponent such as 2.2. It may be left out for computed or measured light, which is linear, but not for
                   codes: uint8, uint16, or these divided by their largest

        Three planes with the spectra of Mallett & Yuksel (2019): smooth, from 0 to 1, of exactly that colour under D65,
        and flat where a sample is grey. The rest is as of the class.
        """
        samples = _of_colours(_all_given(rgb, "rgb", _OF_RGB))
        if whole_codes(samples):
            message = "holds whole numbers, codes of a picture; give .astype(np.uint8) of it, and encoding='srgb'"
            raise InvalidValueError(message, key="rgb", stage=_OF_RGB)
        samples = linear_colours(samples, encoding, "rgb", _OF_RGB)
        spectra: Sequence[Spectrum] = (1.0,)
        if samples.ndim == 3 and (samples == samples[..., :1]).all():
            samples = samples[..., 0]
        elif samples.ndim == 3:
            basis = rgb_basis()
            wavelength_nm = tuple(basis.wavelength_nm.tolist())
            spectra = [Curve(wavelength_nm, tuple(values.tolist()), outside="hold") for values in basis.values]
            samples = np.moveaxis(samples, 2, 0)
        return cls(
            planes=samples,
            spectra=spectra,
            width_um=width_um,
            centre_um=centre_um,
            rotate_deg=rotate_deg,
            interpolation=interpolation,
            source=source,
            read=read,
        )

    @classmethod
    def of_cube(
        cls,
        cube: ArrayLike,
        wavelength_nm: Several[Number],
        *,
        tolerance: float = 1e-4,
        width_um: Number,
        centre_um: Place = (0.0, 0.0),
        rotate_deg: Number = 0.0,
        interpolation: Interpolation = "squares",
        source: str = "",
        read: Mapping[str, Any] | None = None,
    ) -> Picture:
        """Return a picture of reflectance spectra (rows, cols, bands), from 0 to 1, straight between the wavelengths.

        tolerance : how far any sample may lie from the cube at any wavelength: it becomes as few planes as keep it
                    (principal components); 0 keeps every band
        """
        samples = _all_given(cube, "cube", "Picture.of_cube")
        bands_nm = np.asarray(check(wavelength_nm, tuple[float, ...], "wavelength_nm", "Picture"), float)
        planes, components = planes_of_cube(samples, bands_nm, error=tolerance)
        return cls(
            planes=planes,
            spectra=components,
            width_um=width_um,
            centre_um=centre_um,
            rotate_deg=rotate_deg,
            interpolation=interpolation,
            source=source,
            read=read,
        )

    @property
    def reflectance(self) -> Spectrum:
        """The mean of all samples, which stands for the picture where only outlines matter."""
        means = self.planes.mean(axis=(1, 2), dtype=np.float64)
        nodes, values = _tabulated(self.spectra)
        total = np.clip(np.einsum("p,pn->n", means, values), 0.0, 1.0)
        if nodes.size == 1:
            return float(total[0])
        return Curve(tuple(nodes.tolist()), tuple(total.tolist()), outside="hold")

    @property
    def surfaces(self) -> tuple[Spectrum, ...]:
        """Curves with every kink of the planes' spectra, for quadrature."""
        return tuple(s.size if isinstance(s, Component) else s for s in self.spectra)


def _tabulated(spectra: Sequence[Spectrum | Component]) -> tuple[F64, F64]:
    """Return the wavelengths (n,) where any of the spectra bends, nm, and all of them there (spectra, n)."""
    bent = [_nodes(spectrum) for spectrum in spectra if not isinstance(spectrum, float | int)]
    nodes = distinct(np.concatenate(bent)) if bent else np.ones(1)
    return nodes, np.stack([spectrum_at(spectrum, nodes) for spectrum in spectra])


def _brightest(planes: NDArray[np.floating], values: F64) -> F64:
    """Return (n,) the largest Σ plane × spectrum over samples, or an upper bound if that does not exceed 1."""
    bound: F64 = np.einsum("p,pn->n", planes.max(axis=(1, 2)).astype(np.float64), values)
    if bound.max() <= 1.0 + _ROUNDING:
        return bound
    samples, most = planes.reshape(len(planes), -1), np.zeros(values.shape[1])
    for first in range(0, samples.shape[1], _AT_ONCE):
        sums = np.einsum("pn,ps->ns", values, samples[:, first : first + _AT_ONCE], optimize=True)
        np.maximum(most, sums.max(axis=1), out=most)
    return most


def _nodes(spectrum: Spectrum | Component) -> F64:
    return np.array([1.0, 2.0]) if isinstance(spectrum, float | int) else np.asarray(spectrum.wavelength_nm, float)


_OF_RGB = "Picture.of_rgb"


def _all_given(samples: ArrayLike, key: str, stage: str) -> NDArray[Any]:
    """Return samples as an array; masked ones become NaN."""
    if is_masked(samples):
        message = "has masked samples; fill them (in numpy .filled(0.5)), or give a smaller picture"
        raise InvalidValueError(message, key=key, stage=stage)
    array = array_of(samples, key, stage)
    if array.dtype.kind == "U" and not array.ndim:
        name = displayed(samples)
        message = f"must be samples, not {name}; camsim.read_picture({name}, width_um=…) reads a file"
        raise InvalidValueError(message, key=key, stage=stage)
    return array


def _of_colours(samples: NDArray[Any]) -> NDArray[Any]:
    """Return samples that are (rows, cols) or (rows, cols, 3); of other axes say how they become so."""
    if samples.size and (samples.ndim == 2 or (samples.ndim == 3 and samples.shape[2] == 3)):
        return samples
    shape, way_out = samples.shape, ""
    if samples.ndim == 3 and shape[0] in (3, 4):
        way_out = "; give np.moveaxis(np.asarray(rgb)[:3], 0, 2)"
    elif samples.ndim == 3 and shape[2] == 4:
        way_out = "; without its opacity it is np.asarray(rgb)[..., :3]"
    elif samples.ndim == 3 and 1 in (shape[0], shape[2]):
        way_out = f"; a grey one is {'rgb[..., 0]' if shape[2] == 1 else 'rgb[0]'}"
    elif samples.ndim == 4:
        way_out = "; give one picture of several, rgb[0]"
    message = f"must be (rows, cols, 3), not an array of shape {shape}{way_out}"
    raise InvalidValueError(message, key="rgb", stage=_OF_RGB)


def _first(wrong: NDArray[np.bool_]) -> str:
    plane, row, col = np.argwhere(wrong)[0].tolist()
    return f"sample [{row}, {col}] of plane {plane}"
