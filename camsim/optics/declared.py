"""Validation of the capabilities that a custom optical stage declares, against its transfer function.

Engines use declared capabilities instead of ``otf``, since they are faster. A wrong declaration (a cut-off in
cycles/mm, a PSF scaled to its peak, spots at half of their distances, an ``otf`` that does not match an inherited
pattern) makes a wrong image, and a check that uses the same declaration cannot detect it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import scipy

from camsim.core.arrays import F64, distinct
from camsim.core.custom import is_custom, refused
from camsim.core.typed import NonNegative, Positive, check
from camsim.errors import CamsimError
from camsim.numerics.quadrature import gauss_legendre
from camsim.optics.custom import check_extent, disc_of_frequencies
from camsim.optics.pattern import Pattern
from camsim.optics.protocols import (
    KnowsBlur,
    KnowsCutoff,
    KnowsEnergy,
    KnowsWavelengths,
    Rectangular,
    Round,
    RoundLens,
    Separable,
)
from camsim.optics.system import OpticalSystem

_ROUNDING = 1e-9
_ALIKE = 1e-6  # largest difference of transfers that should be equal
_NEARLY = 1e-3  # relative to a PSF's peak, or to all light: accuracy of a sum over few frequencies
_NODES = 120
_RADII = np.array([0.0, 0.4, 0.9, 1.6])  # over the last frequency
_BEYOND = np.array([1.001, 1.02, 1.1, 1.3, 1.7, 2.5])  # cut-offs
_DIRECTIONS = np.pi * (np.arange(8) + 0.3) / 8.0
_SHARES = np.arange(1, 17) / 17.0

Transfer = Callable[[Any, Any], Any]


def check_lengths(system: OpticalSystem, wavelength_nm: F64) -> None:
    """Refuse a custom lens with an invalid cut-off or blur at the first or the last of these wavelengths."""
    lens, ends_nm = system.lens, wavelength_nm[[0, -1]].tolist()
    for said, known in (("cutoff_per_um", isinstance(lens, KnowsCutoff)), ("blur_um", isinstance(lens, KnowsBlur))):
        if known and is_custom(lens):
            for nm in ends_nm:
                _Declared(lens).number(said, nm)


def check_declared(system: OpticalSystem, wavelength_nm: F64, tolerance: float) -> None:
    """Refuse custom stages whose declared capabilities contradict their transfer.

    wavelength_nm : (n,) of which the shortest and the longest are tested
    tolerance     : a transfer below this counts as zero
    """
    each_nm = distinct(wavelength_nm[[0, -1]]).tolist()
    highest_per_um = system.highest_per_um(wavelength_nm)
    if is_custom(system.lens):
        _Declared(system.lens).check_lens(system, each_nm, tolerance)
    if is_custom(system.olpf):
        _Declared(system.olpf).check_low_pass(each_nm, highest_per_um)
    if is_custom(system.photosite):
        _Declared(system.photosite).check_photosite(each_nm, highest_per_um)


class _Declared:
    """Access to a stage's declarations; an exception in one becomes an error about the stage."""

    def __init__(self, stage: Any) -> None:
        self.stage, self.name = stage, type(stage).__name__
        self.key = getattr(stage, "place", "lens")

    def refuse(self, message: str) -> None:
        """Raise the error that begins with the stage's name."""
        raise refused(self.key, f"{self.name}{message}")

    def asked(self, said: str) -> Any:
        """Return an attribute of the stage."""
        return self._guarded(said, lambda: getattr(self.stage, said))

    def called(self, verb: str, *given: Any) -> Any:
        """Return the result of a method for copies of the arguments."""
        copies = [part.copy() if isinstance(part, np.ndarray) else part for part in given]
        return self._guarded(verb, lambda: getattr(self.stage, verb)(*copies))

    def _guarded(self, said: str, ask: Callable[[], Any]) -> Any:
        try:
            return ask()
        except CamsimError:
            raise
        except Exception as error:
            raise refused(self.key, f"{self.name}.{said} failed: {error!r}") from error

    def number(self, verb: str, wavelength_nm: float) -> float:
        """Return a length or a frequency at a wavelength."""
        stated = self.called(verb, wavelength_nm)
        check(stated, Positive, f"{verb}({wavelength_nm:g})", self.name)
        return float(stated)

    def transfer(self, wavelength_nm: float) -> Transfer:
        """Return the stage's transfer at a wavelength."""
        return lambda fx, fy: np.asarray(self.called("otf", fx, fy, wavelength_nm))

    def compare(self, said: str, fx: F64, fy: F64, otf: Any, other: Any, way_out: str) -> None:
        """Refuse a transfer that differs from the one implied by another declaration."""
        off = np.abs(otf - other)
        if off.max() > _ALIKE:
            worst = int(off.argmax())
            at = f"({fx[worst]:.4g}, {fy[worst]:.4g}) cycles/µm"
            self.refuse(f".otf is {_plain(otf[worst])} at {at}, and {_plain(other[worst])} by its {said}; {way_out}")

    def check_lens(self, system: OpticalSystem, each_nm: list[float], tolerance: float) -> None:
        """Refuse a lens whose cut-off, pattern, energy or independence of wavelength contradicts its transfer."""
        for nm in each_nm:
            otf = self.transfer(nm)
            if isinstance(self.stage, KnowsCutoff):
                self._check_cutoff(otf, nm, tolerance)
            top = system.cutoff_per_um(nm)
            if isinstance(self.stage, Round | KnowsEnergy):
                self._check_round(otf, top, nm)
            if isinstance(self.stage, RoundLens):
                self._check_pattern(otf, nm)
        if isinstance(self.stage, KnowsWavelengths) and not self.asked("chromatic"):
            fx, fy = disc_of_frequencies(system.cutoff_per_um(each_nm[0]))
            first, last = (self.transfer(nm)(fx, fy) for nm in (each_nm[0], each_nm[-1]))
            said = f"chromatic False (the same at {each_nm[0]:g} nm)"
            self.compare(said, fx, fy, last, first, "leave chromatic out, or make it True")

    def _check_cutoff(self, otf: Transfer, nm: float, tolerance: float) -> None:
        cutoff = self.number("cutoff_per_um", nm)
        radius, angle = (part.ravel() for part in np.meshgrid(cutoff * _BEYOND, _DIRECTIONS))
        passes = np.abs(otf(radius * np.cos(angle), radius * np.sin(angle)))
        if passes.max() > max(tolerance, _ROUNDING):
            worst = int(passes.argmax())
            self.refuse(
                f".cutoff_per_um says that nothing passes from {cutoff:.4g} cycles/µm on at {nm:g} nm, and its otf is "
                f"{passes[worst]:.3g} at {radius[worst]:.4g}; give the end of the transfer, in cycles/µm"
            )

    def _check_round(self, otf: Transfer, top: float, nm: float) -> None:
        """Refuse a pattern, or encircled energy, that is not the transform of the transfer."""
        radius, angle = (part.ravel() for part in np.meshgrid(top * _SHARES, _DIRECTIONS))
        fx, fy = radius * np.cos(angle), radius * np.sin(angle)
        said = "point_spread" if isinstance(self.stage, Round) else "encircled_energy"
        along_x = f"{said}, which makes it round (as along x)"
        self.compare(along_x, fx, fy, otf(fx, fy), otf(radius, np.zeros_like(radius)), f"leave {said} out")
        r = _RADII / top
        (coarse, _), (light, energy) = (_of_transfer(otf, top, r, count) for count in (_NODES // 2, _NODES))
        if np.abs(light - coarse).max() > 0.1 * _NEARLY * light[0]:
            return  # too few frequencies to decide
        for verb, right, scale in (("point_spread", light, light[0]), ("encircled_energy", energy, 1.0)):
            if not hasattr(self.stage, verb):
                continue
            stated = self.called(verb, r, nm)
            array = np.asarray(stated)
            if array.shape != r.shape or array.dtype.kind not in "fiu":
                self.refuse(f".{verb} gives {stated!r} for {r.size} radii; give a number for each")
            off = np.abs(array - right)
            if not off.max() <= _NEARLY * scale:
                worst = int(off.argmax())
                unit = " per µm² of unit power" if verb == "point_spread" else ""
                self.refuse(
                    f".{verb} is {array[worst]:.6g}{unit} at {r[worst]:.4g} µm and {nm:g} nm, and by its otf "
                    f"{right[worst]:.6g}; one of the two is another lens's, or in another unit"
                )

    def _check_pattern(self, otf: Transfer, nm: float) -> None:
        """Refuse a pattern for the boundary engine that contradicts the transfer or the encircled energy."""
        try:
            hash(self.stage)
        except TypeError as error:
            message = f"{self.name} has a pattern, and tables are kept by such a lens, which has no hash ({error})"
            raise refused(self.key, f"{message}; give its fields tuples in place of lists and tables") from error
        pattern, blur_um = self.called("pattern"), self.number("blur_um", nm)
        if not isinstance(pattern, Pattern):
            self.refuse(f".pattern() gives a {type(pattern).__name__}; give a camsim.optics.pattern.Pattern")
        u, zero = 1.1 * pattern.breaks[-1] * _SHARES, np.zeros(_SHARES.size)
        way_out = "both are of the same lens, u in cycles per blur_um"
        self.compare("pattern()", u / blur_um, zero, otf(u / blur_um, zero), pattern.otf(u), way_out)
        rho = 0.5 + 3.0 * _SHARES
        energy, item = np.asarray(self.called("encircled_energy", rho * blur_um, nm)), pattern.energy(rho)
        if np.abs(energy - item).max() > _ALIKE:
            worst = int(np.abs(energy - item).argmax())
            self.refuse(
                f".encircled_energy is {energy[worst]:.6g} at {rho[worst] * blur_um:.4g} µm, and {item[worst]:.6g} "
                "by its pattern(); both are of the same lens, ρ in blurs"
            )

    def check_low_pass(self, each_nm: list[float], highest_per_um: float) -> None:
        """Refuse an OLPF whose spots contradict its transfer."""
        fx, fy = disc_of_frequencies(highest_per_um)
        otf = self._footprint(each_nm, fx, fy, highest_per_um)
        spots = self.called("spots_um")
        fits = isinstance(spots, np.ndarray) and spots.ndim == 2 and spots.shape[1] == 2 and len(spots)
        if not fits or spots.dtype.kind not in "fiu" or not np.isfinite(spots).all():
            self.refuse(f".spots_um() gives {spots!r}; give an array (n, 2) of offsets x, y in µm")
        waves = np.exp(-2j * np.pi * (np.outer(fx, spots[:, 0]) + np.outer(fy, spots[:, 1]))).mean(axis=1)
        way_out = "they are offsets from the middle, in µm: a split is the full distance of two"
        self.compare("spots_um()", fx, fy, otf, waves, way_out)
        alone = np.abs(spots[:, None] + spots).max(axis=2).min(axis=1)
        if alone.max() > _ROUNDING * np.abs(spots).max():
            spot = tuple(spots[alone.argmax()].tolist())
            message = f".spots_um() has one at {spot} and none opposite it, which engines and check take to be there"
            self.refuse(f"{message}; give such a filter as a blur besides the lens (extra_optics), by its otf alone")

    def check_photosite(self, each_nm: list[float], highest_per_um: float) -> None:
        """Refuse a photosite whose sides, extent or area contradict its transfer."""
        check_extent(self.stage)
        half = np.array(self.stage.half_extent_um, float)
        fx, fy = disc_of_frequencies(highest_per_um)
        otf = self._footprint(each_nm, fx, fy, highest_per_um)
        if isinstance(self.stage, Rectangular):
            width, height = check(self.asked("sides_um"), tuple[NonNegative, NonNegative], "sides_um", self.name)
            self.compare("sides_um", fx, fy, otf, np.sinc(width * fx) * np.sinc(height * fy), "width and height, in µm")
        # An aperture within h of the centre passes at least cos(2πfh) of a wave no shorter than 2h.
        for axis, reach in zip("xy", half.tolist(), strict=True):
            f = np.array([min(highest_per_um, 0.25 / reach if reach else math.inf)])
            passes = self.transfer(0.0)(*((f, 0.0 * f) if axis == "x" else (0.0 * f, f))).real[0]
            if passes < math.cos(2.0 * math.pi * f[0] * reach) - _ALIKE:
                self.refuse(
                    f".half_extent_um is {reach:g} µm along {axis}, and by its otf it is larger; give all of it"
                )

    def _footprint(self, each_nm: list[float], fx: F64, fy: F64, highest_per_um: float) -> Any:
        """Return the transfer of a photosite or an OLPF; refuse dependence on wavelength, or a lack of broadcasting."""
        same = "put what depends on the wavelength into a blur besides (extra_optics)"
        otf = self.transfer(0.0)(fx, fy)
        for nm in each_nm:
            one = f"being a {self.key}, asked without a wavelength, at 0 nm (this is at {nm:g})"
            self.compare(one, fx, fy, self.transfer(nm)(fx, fy), otf, same)
        rows = highest_per_um * np.linspace(-1.0, 0.7, 6)[:, None]
        cols = highest_per_um * np.linspace(-0.6, 0.9, 5)[None, :]
        lattice = np.broadcast_to(self.transfer(0.0)(cols, rows), (6, 5)).ravel()
        x, y = (part.ravel() for part in np.broadcast_arrays(cols, rows))
        each = self.transfer(0.0)(x, y)
        self.compare("values on rows and columns, (m, 1) and (1, n)", x, y, each, lattice, "broadcast them")
        if isinstance(self.stage, Separable) and self.asked("separable"):
            factors = self.transfer(0.0)(x, 0.0 * x) * self.transfer(0.0)(0.0 * y, y)
            self.compare("factors (separable True)", x, y, each, factors, "leave separable out")
        return otf


def _plain(value: Any) -> str:
    """Return a number as text, without a negligible imaginary part."""
    return f"{value.real if abs(value.imag) < _ROUNDING else value:.6g}"


def _of_transfer(otf: Transfer, top: float, r: F64, count: int) -> tuple[F64, F64]:
    """Return the PSF at radii, 1/µm², and the encircled energy, of a symmetric transfer that ends at ``top``."""
    x, w = gauss_legendre(count)
    f = 0.5 * top * (1.0 + x)
    weighted = math.pi * top * w * otf(f, np.zeros_like(f)).real
    phase = 2.0 * np.pi * np.outer(r, f)
    return (weighted * f * scipy.special.j0(phase)).sum(axis=1), r * (weighted * scipy.special.j1(phase)).sum(axis=1)
