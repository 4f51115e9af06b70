"""The transfer function that a camera should have across an edge: the product of its stages' OTFs."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from camsim.camera.body import Body
from camsim.camera.capture import Capture
from camsim.camera.window import Region
from camsim.core.annotations import Called
from camsim.core.arrays import C128, F64
from camsim.core.custom import is_custom
from camsim.core.typed import check, validate
from camsim.measure.full_frame import NYQUIST_OF_SENSOR_CYCLES_PER_PIXEL
from camsim.measure.geometry import EdgeLine
from camsim.measure.given import check_given
from camsim.measure.lens_places import scene_place_um, system_at
from camsim.measure.neighbours import neighbours, spread_otf
from camsim.numerics.quadrature import gauss_legendre
from camsim.optics.of_pupil import OfPupil
from camsim.optics.protocols import KnowsWaves, Varies
from camsim.optics.system import OpticalSystem
from camsim.scene import Scene
from camsim.scene.outlines import surface_at
from camsim.spectra.curve import Reflectance, Spectrum, spectrum_at
from camsim.spectra.integral import lagrange, lumped
from camsim.spectra.light import Light

_BESIDE_PIXEL = 3.0
_DIRECTIONS = 36
_FEW_DIRECTIONS, _FEW_FREQUENCIES = 6, 8
_NEAR_ZERO = 1e-4  # cycles per pixel: where the phase gives the centroid
_SEARCHED_PIXEL = np.linspace(-2.0, 2.0, 17)
_NEWTON_STEPS = 8
_NOTHING = 1e-30  # of the cube of a transfer
_NODES, _FEW_NODES = 40, 10
"""Wavelengths that stand for all within 1e-4, and within 3e-4 of a lens whose transfer is an integral over its pupil,
besides those that its path difference takes: frequencies that end between them leave the most."""

_UNSEEN = 5e-5
"""Negligible share of a channel's light at either end of the spectrum."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CameraOtf:
    """Lens, OLPF, photosite and crosstalk of a camera, for the light and the surfaces of a scene.

    At each wavelength the OTFs are multiplied; wavelengths are weighted by the edge's signal in the channel: light ×
    (bright − dark reflectance) × the lens's transmission × quantum efficiency × λ/hc. A subset of wavelengths is used:
    accurate to 1e-3 for a lens whose OTF is a pupil integral, to 1e-4 for others.

    region : the window of the frame that the picture shows, None for all of it

    For a field-varying lens the transfer function is that at the centre of an edge.
    """

    camera: Annotated[Body, Called("a Camera", "Camera.from_yaml of a sensor makes one")]
    scene: Scene
    light: Light
    region: Region | None = None

    def __post_init__(self) -> None:
        validate(self)
        object.__setattr__(self, "camera", self.camera.with_ends(self.light))

    @classmethod
    def of(cls, capture: Capture) -> CameraOtf:
        """Return the OTF of the camera of a capture."""
        check_given(capture=capture)
        return cls(camera=capture.camera, scene=capture.scene, light=capture.light, region=capture.region)

    @property
    def stages(self) -> tuple[str, ...]:
        """Names of the multiplied stages."""
        has = (("OLPF", self.camera.olpf), ("photosite", self.camera.photosite), ("crosstalk", self.camera.crosstalk))
        return "lens", *(name for name, stage in has if stage is not None)

    def along_normal(self, frequency_cycles_per_pixel: F64, *, channel: str, line: EdgeLine) -> F64 | None:
        """Transfer function across the edge; None for a channel that the camera lacks."""
        place_um = self._place_um(line, 0.0)
        moved = 0.0
        if not isinstance(self.camera.lens, Varies):  # a field-varying lens maps the scene
            x, y = _white_shift_pixel(self, channel)
            moved = x * math.cos(line.normal_rad) + y * math.sin(line.normal_rad)
        sides = [self._surface(self._place_um(line, side - moved)) for side in (-_BESIDE_PIXEL, _BESIDE_PIXEL)]
        fx, fy = (frequency_cycles_per_pixel * part for part in (math.cos(line.normal_rad), math.sin(line.normal_rad)))
        otf = self.at(fx, fy, channel, sides[0], sides[1], place_um=place_um)
        # For an asymmetric PSF the phase gives the apparent position of the edge, not its sharpness.
        if otf is None:
            return None
        mtf: F64 = np.abs(otf) if np.iscomplexobj(otf) else np.real(otf)
        return mtf

    def over_directions(
        self,
        frequency_cycles_per_pixel: F64,
        *,
        channel: str,
        dark: Spectrum,
        bright: Spectrum,
        place_um: tuple[float, float] = (0.0, 0.0),
        about_pixel: tuple[float, float] = (0.0, 0.0),
    ) -> F64 | None:
        """Mean over all directions of the transfer function, for a contrast between two surfaces.

        None for a channel that the camera lacks.

        about_pixel : assumed shift of the picture against the scene
        """
        fx, fy = _all_round(frequency_cycles_per_pixel, _DIRECTIONS)
        otf = self.at(fx, fy, channel, dark, bright, place_um=place_um)
        return None if otf is None else np.real(_moved(otf, fx, fy, about_pixel)).mean(axis=0)

    def shift_pixel(
        self,
        highest_cycles_per_pixel: float,
        *,
        channel: str,
        dark: Spectrum,
        bright: Spectrum,
        place_um: tuple[float, float] = (0.0, 0.0),
    ) -> tuple[float, float]:
        """Return the shift of a channel's picture against the scene, pixels right and down.

        A tilted wavefront, lateral colour, an asymmetric photosite or crosstalk shift it without blur. The shift makes
        the transfer function as real as possible: it maximises the power-weighted mean of the real part. (With coma
        this is not the centroid, about which the transfer function is less real.)
        """
        seen = functools.partial(self.at, channel=channel, dark=dark, bright=bright, place_um=place_um)
        return _shift_pixel(seen, highest_cycles_per_pixel)

    def at(
        self,
        fx: F64,
        fy: F64,
        channel: str,
        dark: Spectrum,
        bright: Spectrum,
        *,
        place_um: tuple[float, float] = (0.0, 0.0),
        lens_alone: bool = False,
    ) -> F64 | C128 | None:
        """Transfer function at frequencies in cycles per pixel, for a contrast between two surfaces.

        None for a channel that the camera lacks.

        place_um   : place on the sensor, from the optical axis, at which the lens is evaluated
        lens_alone : the lens only, without OLPF, photosite and crosstalk
        """
        camera = self.camera.replace(crosstalk=None) if lens_alone else self.camera
        shares = neighbours(camera, channel)
        if shares is None:
            return None
        dark, bright = (check(s, Reflectance, key, "CameraOtf") for key, s in (("dark", dark), ("bright", bright)))
        samples = camera.samples(self.light, (dark, bright))
        difference = spectrum_at(bright, samples.wavelength_nm) - spectrum_at(dark, samples.wavelength_nm)
        counted = shares.any(axis=(0, 1))
        # All channels have the same wavelengths, so that they share the lens's OTF.
        wavelength_nm, weight = lumped(samples.wavelength_nm, camera.image_per_reflectance(samples) * difference)
        exposed = _seen(weight)
        wavelength_nm, weight = wavelength_nm[exposed], weight[:, exposed]
        total = float(shares.sum(axis=(0, 1)) @ weight.sum(axis=1))
        if total == 0.0:
            return None
        system = system_at(camera, *place_um)
        if wavelength_nm.size > (count := _nodes(system, wavelength_nm)):
            x, w = gauss_legendre(count)
            low, high = wavelength_nm[0], wavelength_nm[-1]
            nodes_nm = 0.5 * (low + high) + 0.5 * (high - low) * x
            wavelength_nm, weight = nodes_nm, np.einsum("cn,nj->cj", weight, lagrange(wavelength_nm, nodes_nm, x, w))
        spread = spread_otf(shares[..., counted], fx, fy)
        fx, fy = fx / camera.pitch_um, fy / camera.pitch_um
        parts = np.tensordot(weight[counted].T, spread, axes=1)
        lens = sum(
            part * system.point_otf(fx, fy, nm, sampled=True)
            for nm, part in zip(wavelength_nm.tolist(), parts, strict=True)
        )
        otf: F64 | C128 = lens * (1.0 if lens_alone else system.footprint_otf(fx, fy)) / total
        return otf

    def _place_um(self, line: EdgeLine, distance_pixel: float) -> tuple[float, float]:
        """Return the place on the sensor at a distance from the edge's point, along its normal."""
        left, top = self.camera.grid(self.region).first_centre
        x = left - 0.5 + line.x_pixel + distance_pixel * math.cos(line.normal_rad)
        y = top - 0.5 + line.y_pixel + distance_pixel * math.sin(line.normal_rad)
        return x * self.camera.pitch_um, y * self.camera.pitch_um

    def _surface(self, place_um: tuple[float, float]) -> Spectrum:
        """Return the surface imaged to a place of the sensor."""
        x_um, y_um = scene_place_um(self.camera, np.array([place_um]))[0].tolist()
        return surface_at(self.scene, x_um, y_um)


def _nodes(system: OpticalSystem, wavelength_nm: F64) -> int:
    """Return the number of wavelength nodes.

    An OTF varies smoothly with the wavelength except at cut-off frequencies; each wave of path difference, a phase of
    π to either side, needs π more nodes. Nothing is known about custom stages.
    """
    if not system.chromatic:
        return 1
    lens = system.lens
    if system.more or is_custom(lens):
        return int(wavelength_nm.size)
    turned = lens.waves_turned(*wavelength_nm[[0, -1]].tolist()) if isinstance(lens, KnowsWaves) else 0.0
    return (_FEW_NODES if isinstance(lens, OfPupil) else _NODES) + math.ceil(math.pi * turned)


def _seen(weight: F64) -> slice:
    """Return the wavelengths without the ends of the spectrum that are negligible in all channels."""
    size = np.abs(weight).cumsum(axis=1)
    beyond = _UNSEEN * size[:, -1:]
    first = np.argmax((size > beyond).any(axis=0))
    last = np.argmax((size[:, -1:] - size <= beyond).all(axis=0))
    return slice(int(first), int(last) + 1)


@functools.lru_cache(maxsize=16)
def _white_shift_pixel(theory: CameraOtf, channel: str) -> tuple[float, float]:
    """Return the shift of a channel's picture of white on black against the scene, used for all edges."""
    return theory.shift_pixel(NYQUIST_OF_SENSOR_CYCLES_PER_PIXEL, channel=channel, dark=0.0, bright=1.0)


def _all_round(frequency: F64, directions: int) -> tuple[F64, F64]:
    """Return frequencies (directions, n) along x and y, uniform over half a turn."""
    turn = np.pi * (np.arange(directions) + 0.5) / directions
    fx, fy = (np.outer(part, frequency) for part in (np.cos(turn), np.sin(turn)))
    return fx, fy


def _shift_pixel(seen: Callable[[F64, F64], F64 | C128 | None], highest_cycles_per_pixel: float) -> tuple[float, float]:
    """Return the shift that makes a transfer function as real as possible; see ``CameraOtf.shift_pixel``."""
    f = highest_cycles_per_pixel * (np.arange(_FEW_FREQUENCIES) + 1.0) / _FEW_FREQUENCIES
    fx, fy = _all_round(f, _FEW_DIRECTIONS)
    near = np.array([_NEAR_ZERO, 0.0])
    fx, fy = (np.concatenate([axis, each.ravel()]) for axis, each in ((near, fx), (near[::-1], fy)))
    otf = seen(fx, fy)
    if otf is None or not np.iscomplexobj(otf):
        return 0.0, 0.0
    middle = -np.angle(otf[:2]) / (2.0 * np.pi * _NEAR_ZERO)
    fx, fy, otf = fx[2:], fy[2:], otf[2:] * np.abs(otf[2:]) ** 2
    if not np.abs(otf).max() > _NOTHING:  # the blur is too wide to pass anything there
        return float(middle[0]), float(middle[1])

    def reality(shift: F64) -> float:
        return float(np.sum(np.real(_moved(otf, fx, fy, shift))))

    from_middle = np.stack(np.meshgrid(_SEARCHED_PIXEL, _SEARCHED_PIXEL), axis=-1).reshape(-1, 2)
    begin = max(np.concatenate([from_middle + middle, from_middle]), key=reality)
    angular, shift = 2.0 * np.pi * np.stack([fx, fy]), begin
    for _ in range(_NEWTON_STEPS):
        moved = _moved(otf, fx, fy, shift)
        bend = np.einsum("in,jn,n->ij", angular, angular, np.real(moved))
        shift = shift - np.linalg.lstsq(bend, np.einsum("in,n->i", angular, np.imag(moved)), rcond=None)[0]
    x, y = shift if reality(shift) >= reality(begin) else begin
    return float(x), float(y)


def _moved(otf: F64 | C128, fx: F64, fy: F64, shift_pixel: Sequence[float] | F64) -> F64 | C128:
    """Return the transfer function of a picture after a shift is undone."""
    x, y = shift_pixel
    return otf if x == y == 0.0 else otf * np.exp(2j * np.pi * (fx * x + fy * y))
