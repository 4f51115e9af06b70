"""Light on the sensor given as an array with a unit, and its conversion to electrons of each channel."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

import numpy as np
from annotated_types import Ge, Le
from numpy.typing import NDArray

from camsim.camera.body import Body
from camsim.core.arrays import F64, is_masked
from camsim.core.cached import Caching, cached_property
from camsim.core.number_kinds import LARGEST, array_of
from camsim.core.typed import Number, Several, Whole, refusal, validate
from camsim.spectra.curve import Curve, Wavelength, spectrum_at
from camsim.spectra.light import Light, photons_per_um2_per_j_m2
from camsim.spectra.rgb import depth_of_codes, linear_colours, rgb_basis, whole_codes

Unit: TypeAlias = Literal["electrons", "photons", "irradiance", "reflectance", "srgb"]
CHARGES, RELATIVE = ("electrons", "photons"), ("reflectance", "srgb")
"""Units whose samples a photosite sums instead of averaging; and units that need an illuminant."""

MOST_SAMPLES = 64


@dataclass(frozen=True, kw_only=True, eq=False)
class GivenLight(Caching):
    """Light on a sensor as an array, before any stage of the sensor has acted.

    samples       : (rows, cols), or (rows, cols, n): finite; must not change during exposure
    unit          : of the samples, for the whole exposure. "electrons": mean charge, one per photosite or a plane per
                    channel; "photons": on a photosite's light-sensitive area, at each of ``wavelength_nm``;
                    "irradiance": W/m²/nm, linear between ``wavelength_nm`` and 0 outside (of one wavelength: W/m², a
                    line); "reflectance": fractions of a perfect diffuser's light, grey, linear sRGB or bands of
                    ``wavelength_nm``, which may exceed 1; "srgb": the same, sRGB-encoded
    wavelength_nm : wavelengths of the n planes, increasing
    per_photosite : samples along the side of a photosite, which integrates them
    source, read  : the file that it was read from, and how to read it again
    sha256        : hash of samples, type and shape

    >>> light = GivenLight(samples=np.full((4, 6, 3), 0.5), unit="reflectance")
    >>> light.rows, light.cols, light.unit
    (4, 6, 'reflectance')
    """

    samples: Any = field(repr=False)
    unit: Unit
    wavelength_nm: Several[Wavelength] | None = None
    per_photosite: Annotated[int, Ge(1), Le(MOST_SAMPLES)] = 1
    source: str = ""
    read: Mapping[str, Any] | None = field(default=None, metadata={"described": "if any"})

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            samples: Any,
            unit: Unit,
            wavelength_nm: Several[Number] | None = None,
            per_photosite: Whole = 1,
            source: str = "",
            read: Mapping[str, Any] | None = None,
        ) -> None: ...

    def __post_init__(self) -> None:
        validate(self)
        if is_masked(self.samples):
            raise refusal(self, "samples", "has masked numbers; fill them, in numpy by .filled(…)")
        samples = array_of(self.samples, "samples", type(self).__name__)
        if samples.dtype.kind not in "fiu":
            raise refusal(self, "samples", f"must be numbers, not {samples.dtype}")
        if samples.ndim not in (2, 3) or not samples.size:
            message = f"must be (rows, cols) or (rows, cols, n), not an array of shape {samples.shape}"
            raise refusal(self, "samples", message)
        low, high = float(samples.min()), float(samples.max())
        if not np.isfinite((low, high)).all():  # a NaN makes both NaN
            place = np.argwhere(~np.isfinite(samples))[0].tolist()
            raise refusal(self, "samples", f"holds {samples[tuple(place)]} at {place}, which is no light")
        if high > LARGEST or low < -LARGEST:
            raise refusal(self, "samples", f"holds {max(high, -low):g}; no light is more than {LARGEST:g}")
        if low < 0.0 and self.unit not in RELATIVE:
            place = [int(index) for index in np.unravel_index(samples.argmin(), samples.shape)]
            message = f"holds {low:g} {self.unit} at {place}; light is 0 or more: clip it, or take its black off before"
            raise refusal(self, "samples", message)
        if self.unit == "srgb" and whole_codes(samples):
            raise refusal(self, "samples", "holds whole numbers, codes of a picture; give .astype(np.uint8) of it")
        nodes_nm = self.wavelength_nm
        bands = 1 if samples.ndim == 2 else samples.shape[2]
        if nodes_nm is not None:
            if len(nodes_nm) != bands:
                message = f"{len(nodes_nm)} for {bands} planes; give one for each{self._planes_last(len(nodes_nm))}"
                raise refusal(self, "wavelength_nm", message)
            if any(after <= before for before, after in pairwise(nodes_nm)):
                raise refusal(self, "wavelength_nm", "wavelengths must increase, each given once")
            if self.unit in ("electrons", "srgb"):
                raise refusal(self, "wavelength_nm", f"{self.unit} have no wavelengths; leave them out")
        elif self.unit in ("photons", "irradiance"):
            raise refusal(self, "wavelength_nm", f"must be given with {self.unit}, one for each plane")
        object.__setattr__(self, "samples", samples.astype(np.float32) if samples.dtype == np.float16 else samples)

    @cached_property
    def seems_encoded(self) -> bool:
        """Whether reflectances look like the codes of a picture, which are rarely linear."""
        if self.unit != "reflectance" or self.wavelength_nm is not None:
            return False
        return self.samples.dtype.kind in "iu" or depth_of_codes(self.samples) > 0

    @property
    def rows(self) -> int:
        """Number of photosites from top to bottom."""
        return int(self.samples.shape[0]) // self.per_photosite

    @property
    def cols(self) -> int:
        """Number of photosites from left to right."""
        return int(self.samples.shape[1]) // self.per_photosite

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of the samples, type and shape."""
        stated = hashlib.sha256(f"{self.samples.dtype.str} {self.samples.shape}".encode())
        stated.update(np.ascontiguousarray(self.samples).data)
        return stated.hexdigest()

    @property
    def spectrum(self) -> Light:
        """Light of equal energy at all of its wavelengths; a line if it has only one."""
        nodes_nm = tuple(self.wavelength_nm or ())
        if len(nodes_nm) == 1:
            return Light(line_nm=nodes_nm[0], irradiance_w_per_m2=1.0, at="sensor")
        return Light(Curve(nodes_nm, (1.0,) * len(nodes_nm)), irradiance_w_per_m2=1.0, at="sensor")

    def settled(self, frame: tuple[int, int]) -> GivenLight:
        """Return the light for a frame (rows, cols); if it has a whole multiple of samples, ``per_photosite`` follows.

        Raises InvalidValueError if its shape does not fit a frame of that size.
        """
        shape = (int(self.samples.shape[0]), int(self.samples.shape[1]))
        if self.per_photosite > 1 or all(size <= most for size, most in zip(shape, frame, strict=True)):
            if any(size % self.per_photosite for size in shape):
                message = f"{self.per_photosite} divides no {shape[0]} × {shape[1]} samples; crop them"
                raise refusal(self, "per_photosite", message)
            if self.rows > frame[0] or self.cols > frame[1]:
                raise refusal(self, "samples", _too_large((self.rows, self.cols), frame))
            return self
        times = shape[0] // frame[0]
        if times > MOST_SAMPLES or shape != (times * frame[0], times * frame[1]):
            raise refusal(self, "samples", _too_large(shape, frame))
        return dataclasses.replace(self, per_photosite=times)

    def per_channel(self, camera: Body, light: Light, time_s: float) -> F64 | None:
        """Return (channels, n): the mean electrons that a photosite of each channel gets for a 1 in each plane.

        None where the samples are already electrons of each photosite. ``light``: of a perfect diffuser, on the sensor.
        """
        bands = 1 if self.samples.ndim == 2 else int(self.samples.shape[2])
        channels = camera.cfa.channels
        if self.unit == "electrons":
            if self.samples.ndim == 2:
                return None if len(channels) > 1 else np.ones((1, 1))
            if bands != len(channels):
                message = f"has {bands} planes; give one for each of {', '.join(channels)}, or (rows, cols) of a mosaic"
                raise refusal(self, "samples", message + self._planes_last(len(channels)))
            return np.eye(bands)
        if self.unit in RELATIVE:
            return self._of_diffuser(camera, light, time_s, bands)
        nodes_nm = np.asarray(self.wavelength_nm, float)
        if self.unit == "photons":
            return _electrons_per_photon(camera, nodes_nm)
        samples = camera.samples(self.spectrum)
        photons_per_um2 = samples.weight_nm * photons_per_um2_per_j_m2(samples.wavelength_nm) * time_s
        seen = _electrons_per_photon(camera, samples.wavelength_nm) * photons_per_um2 * camera.photosite.area_um2
        electrons: F64 = np.einsum("cm,nm->cn", seen, _straight(nodes_nm, samples.wavelength_nm))
        return electrons

    def _of_diffuser(self, camera: Body, light: Light, time_s: float, bands: int) -> F64:
        if self.wavelength_nm is not None:
            stated = tuple(self.wavelength_nm)
            bends = Curve(stated if bands > 1 else (stated[0], stated[0] + 1.0), (1.0,) * max(bands, 2), outside="hold")
            samples = camera.samples(light, (bends,))
            shares = _straight(np.asarray(stated), samples.wavelength_nm)
        elif bands == 3:
            basis = rgb_basis()
            bends = Curve(tuple(basis.wavelength_nm.tolist()), tuple(basis.values[0].tolist()), outside="hold")
            samples = camera.samples(light, (bends,))
            shares = np.stack([np.interp(samples.wavelength_nm, basis.wavelength_nm, part) for part in basis.values])
        elif bands == 1:
            samples = camera.samples(light)
            shares = np.ones((1, samples.wavelength_nm.size))
        else:
            way_out = "; without its opacity it is [..., :3]" if bands == 4 else self._planes_last(3)
            message = f"has {bands} planes; give grey, linear sRGB of 3, or wavelength_nm of each{way_out}"
            raise refusal(self, "samples", message)
        electrons: F64 = np.einsum("cm,nm->cn", camera.electrons_per_reflectance(samples, time_s), shares)
        return electrons

    def _planes_last(self, planes: int) -> str:
        """Return what to do with samples whose planes come first."""
        first = self.samples.ndim == 3 and self.samples.shape[0] == planes
        return "; planes come last: give np.moveaxis(…, 0, 2)" if first else ""

    def linear(self) -> NDArray[np.floating]:
        """Return samples proportional to light; integer codes of pictures as fractions of the largest code."""
        samples = self.samples
        if self.unit == "srgb" or (self.unit == "reflectance" and samples.dtype.kind in "iu"):
            encoding: Literal["srgb", "linear"] = "srgb" if self.unit == "srgb" else "linear"
            return linear_colours(samples, encoding, "samples", type(self).__name__)
        floats: NDArray[np.floating] = samples
        return floats

    def on_photosites(self) -> NDArray[np.floating]:
        """Return (rows, cols) or (rows, cols, n), one value per photosite: sums for charges, means otherwise."""
        linear, side = self.linear(), self.per_photosite
        if side == 1:
            return linear
        cells = linear.reshape(self.rows, side, self.cols, side, *linear.shape[2:])
        total: F64 = cells.sum(axis=(1, 3), dtype=np.float64)
        return total if self.unit in CHARGES else total / side**2


def _too_large(shape: tuple[int, int], frame: tuple[int, int]) -> str:
    return (
        f"is {shape[0]} × {shape[1]}, and the sensor has {frame[0]} × {frame[1]} photosites; crop it, give "
        "per_photosite for samples finer than photosites, or a larger sensor (--set sensor.frame.rows=…)"
    )


def _electrons_per_photon(camera: Body, wavelength_nm: F64) -> F64:
    """Return (channels, n) electrons per photon on the sensor: filters times quantum efficiency."""
    electrons = camera.quantum_efficiency.select(camera.cfa.channels).at(wavelength_nm)
    for passes in camera.filters:
        electrons = electrons * spectrum_at(passes, wavelength_nm)
    return electrons


def _straight(nodes_nm: F64, at_nm: F64) -> F64:
    """Return (n, m) linear interpolation weights of the nodes at wavelengths; constant extrapolation."""
    return np.stack([np.interp(at_nm, nodes_nm, one) for one in np.eye(nodes_nm.size)])
