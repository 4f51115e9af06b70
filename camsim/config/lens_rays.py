"""Rays through a lens of revolution: from far away, through its stop, to its image plane and its reference sphere."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from camsim.core.arrays import F64

NEWTON = 40  # steps to a surface that is not a conic, and to a point of the stop
MET = 1e-12  # of a stop's radius or a ray's length, mm: met
NEAR_AXIS = 1e-4  # field angle of rays that represent paraxial ones, radians
FAR_PUPIL = 1e6  # focal lengths: largest distance of the exit pupil
HALVINGS = 8  # of a step of the field, where rays are not found at once

Index = Callable[[F64], F64]  # of refraction, at wavelengths, nm


@dataclass(frozen=True, kw_only=True)
class Surface:
    """A surface of revolution, and the medium behind it.

    curvature_per_mm : 1/radius, positive where its centre lies behind it
    conic            : 0: a sphere, −1: a paraboloid
    powers           : (k, a) of terms a·r^k of the sag, mm
    thickness_mm     : distance to the next surface
    index            : refractive index of the glass behind it; None for air
    mirror           : whether it reflects
    rim_mm           : half of its clear diameter
    stop             : whether it is the aperture stop
    """

    curvature_per_mm: float = 0.0
    conic: float = 0.0
    powers: tuple[tuple[int, float], ...] = ()
    thickness_mm: float = 0.0
    index: Index | None = None
    mirror: bool = False
    rim_mm: float = math.inf
    stop: bool = False


class Traced(NamedTuple):
    """Rays at the image: places and directions (3, …), path lengths in mm, places in the stop (2, …), nearness to rims.

    share : distance of a ray from the axis over the rim's radius, at the rim that stops it first; up to 1 it passes
    """

    place_mm: F64
    direction: F64
    path_mm: F64
    stop_mm: F64
    share: F64


class Beam(NamedTuple):
    """Light of one field, by wavelength and ray: rays on the image around the chief ray, and on its reference sphere.

    fallen_mm : (2, w, n) where rays fall, from the axis
    chief_mm  : (w,) where the chief ray falls along x
    pupil     : (2, w, n) direction cosines of places on the sphere, from its centre
    path_mm   : (w, n) path lengths to the sphere, over the chief ray's
    share     : (w, n) of a rim's radius, of the rim that stops a ray first: up to 1 it passes; not of the stop
    entry_mm  : (2, w, n) where they cross the first vertex's plane
    """

    fallen_mm: F64
    chief_mm: F64
    pupil: F64
    path_mm: F64
    share: F64
    entry_mm: F64

    @property
    def passes(self) -> npt.NDArray[np.bool_]:
        """Mask of rays (w, n) that no rim stops."""
        found: npt.NDArray[np.bool_] = self.share <= 1.0
        return found


@dataclass(frozen=True, kw_only=True)
class Prescription:
    """A lens as prescribed, used with its object far away.

    surfaces    : in order, without object and image
    aperture    : "EPD", diameter of the entrance pupil, mm; "FNO", the f-number with the object far away; or "stop",
                  the stop's radius, mm
    aim         : whether rays are aimed at the real stop; else they fill the paraxial entrance pupil
    middle_nm   : wavelength of pupil and focal length
    vignetting  : (angle from the axis in radians, shift along the radius, compression along it and across it) of the
                  pupil, in its radii; linear between angles, which increase from 0
    """

    surfaces: tuple[Surface, ...]
    aperture: tuple[str, float]
    aim: bool = True
    middle_nm: float = 550.0
    vignetting: tuple[tuple[float, float, float, float], ...] = ()

    def of_wavelengths(self, wavelength_nm: Sequence[float]) -> Lens:
        """Return the lens with its indices at these wavelengths."""
        return Lens.of(self, np.array(wavelength_nm, float))


@dataclass(frozen=True, kw_only=True)
class Lens:
    """A prescription with its indices at some wavelengths, through which rays are traced."""

    surfaces: tuple[Surface, ...]
    index: tuple[F64, ...]  # behind each surface, (w, 1)
    stop: int
    focal_mm: float
    entrance_mm: float  # from the first surface to the entrance pupil
    radius_mm: float  # of the entrance pupil
    stop_mm: float  # radius of the stop
    sphere_mm: float  # radius of reference spheres
    aim: bool
    vignetting: tuple[tuple[float, float, float, float], ...] = ()

    @classmethod
    def of(cls, stated: Prescription, nm: F64) -> Lens:
        """Return the lens at wavelengths, with its first-order quantities, from paraxial rays."""

        def at(some: F64) -> tuple[F64, ...]:
            behind = np.ones((some.size, 1))
            rows = []
            for surface in stated.surfaces:
                if not surface.mirror:
                    behind = np.ones((some.size, 1)) if surface.index is None else surface.index(some).reshape(-1, 1)
                rows.append(behind)
            return tuple(rows)

        stop = next((k for k, one in enumerate(stated.surfaces) if one.stop), 0)
        bare = tuple(replace(one, rim_mm=math.inf) for one in stated.surfaces)
        lens = cls(
            surfaces=bare,
            index=at(np.array([stated.middle_nm])),
            stop=stop,
            focal_mm=1.0,
            entrance_mm=0.0,
            radius_mm=1.0,
            stop_mm=1.0,
            sphere_mm=1.0,
            aim=False,
        )
        scale = 1e-6 * max(1.0, sum(abs(one.thickness_mm) for one in stated.surfaces))
        marginal = lens.trace(0.0, np.array([[[scale]], [[0.0]]]))
        slope = (marginal.direction[0] / marginal.direction[2]).item()
        focal_mm = -scale / slope * math.copysign(1.0, marginal.direction[2].item())
        to_stop = marginal.stop_mm[0].item() / scale
        through = lens.trace(NEAR_AXIS, np.zeros((2, 1, 1)))
        entrance_mm = through.stop_mm[0].item() / to_stop / NEAR_AXIS
        kind, value = stated.aperture
        radius_mm = {"EPD": 0.5 * value, "FNO": 0.5 * abs(focal_mm) / value, "stop": abs(value / to_stop)}[kind]
        lens = replace(lens, focal_mm=focal_mm, entrance_mm=entrance_mm, radius_mm=radius_mm)
        real = lens.trace(0.0, np.array([[[radius_mm]], [[0.0]]])).stop_mm[0].item()
        stop_mm = value if kind == "stop" else abs(real)
        chief = lens.trace(NEAR_AXIS, np.array([[[-entrance_mm * math.tan(NEAR_AXIS)]], [[0.0]]]))
        slope = (chief.direction[0] / np.abs(chief.direction[2])).item()
        most_mm = FAR_PUPIL * abs(focal_mm)
        sphere_mm = min(abs(chief.place_mm[0].item() / slope), most_mm) if slope else most_mm
        return replace(
            lens,
            surfaces=stated.surfaces,
            index=at(nm),
            stop_mm=stop_mm,
            sphere_mm=max(sphere_mm, 0.1 * abs(focal_mm)),
            aim=stated.aim,
            vignetting=stated.vignetting,
        )

    def trace(self, angle_rad: float, entry_mm: F64) -> Traced:
        """Trace rays of a field along +x that cross the first vertex's plane at places (2, w, n)."""
        x, y = (np.array(one) for one in entry_mm)
        z = np.zeros_like(x)
        across, along = math.sin(angle_rad), math.cos(angle_rad)
        dx, dy, dz = np.full_like(x, across), np.zeros_like(x), np.full_like(x, along)
        path, share = across * x, np.zeros(x.shape)
        before: F64 = np.ones((1, 1))
        stop = np.zeros((2, *x.shape))
        for k, (surface, behind) in enumerate(zip(self.surfaces, self.index, strict=True)):
            far = -z / dz
            x, y = x + far * dx, y + far * dy
            length, slope_x, slope_y = _met(surface, x, y, dx, dy, dz)
            x, y, z = x + length * dx, y + length * dy, length * dz
            path = path + before * (far + length)
            # The normal, along z.
            size = np.sqrt(1.0 + slope_x**2 + slope_y**2)
            gx, gy, gz = -slope_x / size, -slope_y / size, 1.0 / size
            cos = gx * dx + gy * dy + gz * dz
            if surface.mirror:
                dx, dy, dz = dx - 2.0 * cos * gx, dy - 2.0 * cos * gy, dz - 2.0 * cos * gz
            else:
                ratio = before / behind
                turned = np.copysign(np.sqrt(1.0 - ratio**2 * (1.0 - cos**2)), cos) - ratio * cos
                dx, dy, dz = ratio * dx + turned * gx, ratio * dy + turned * gy, ratio * dz + turned * gz
            share = np.fmax(share, np.hypot(x, y) / surface.rim_mm)
            if k == self.stop:
                stop = np.stack([x, y])
            z, before = z - surface.thickness_mm, behind
        far = -z / dz
        x, y, path = x + far * dx, y + far * dy, path + before * far
        share = np.where(np.isfinite(x + y + path), share, np.inf)
        return Traced(np.stack([x, y, np.zeros_like(x)]), np.stack([dx, dy, dz]), path, stop, share)

    def beams(self, angles_rad: Iterable[float], places: F64) -> list[Beam]:
        """Return the light of fields, increasing from 0: rays through places (2, n) of the pupil's unit circle."""
        with np.errstate(all="ignore"):
            return self._beams(angles_rad, np.concatenate([np.zeros((2, 1)), places], axis=1))

    def entry_area(self, angle_rad: float, entry_mm: F64) -> F64:
        """Return the area in the plane of the first vertex per area of the pupil, at the pupil's places (w, n)."""
        _, along, across = self.vignetted(angle_rad)
        if not self.aim:
            return np.full(entry_mm.shape[1:], along * across * self.radius_mm**2)
        with np.errstate(all="ignore"):
            _, (a, c), (b, d) = self._slopes(angle_rad, entry_mm)
        area: F64 = along * across * self.stop_mm**2 / np.abs(a * d - b * c)
        return area

    def vignetted(self, angle_rad: float) -> tuple[float, float, float]:
        """Return the vignetted pupil of a field: its centre along the radius, and half widths along and across it."""
        if not self.vignetting:
            return 0.0, 1.0, 1.0
        at, *columns = np.array(self.vignetting).T
        moved, along, across = (float(np.interp(angle_rad, at, column)) for column in columns)
        return moved, 1.0 - along, 1.0 - across

    def _slopes(self, angle: float, entry: F64) -> tuple[F64, F64, F64]:
        """Return places in the stop, and their derivatives by the place of entry along x and along y."""
        step = 1e-6 * self.radius_mm
        here = self.trace(angle, entry).stop_mm
        sides = np.array([[step, 0.0], [0.0, step]])[:, :, None, None]
        along_x, along_y = ((self.trace(angle, entry + side).stop_mm - here) / step for side in sides)
        return here, along_x, along_y

    def _beams(self, angles_rad: Iterable[float], places: F64) -> list[Beam]:
        shape = (2, self.index[0].shape[0], places.shape[1])
        entry, before, moved = self.radius_mm * np.broadcast_to(places[:, None, :], shape), 0.0, np.zeros(shape)
        beams = []
        for angle in angles_rad:
            middle, along, across = self.vignetted(angle)
            one = np.stack([middle + along * places[0], across * places[1]])
            one[:, 0] = 0.0  # the chief ray, which factors leave alone
            wanted = np.broadcast_to(one[:, None, :], shape)
            if self.aim:
                found = self._aimed(before, angle, entry, moved, self.stop_mm * wanted)
                if angle > before:
                    moved = (found - entry) / (angle - before)
                entry, before = found, angle
            else:
                entry = self.radius_mm * wanted - np.array([self.entrance_mm * math.tan(angle), 0.0])[:, None, None]
            beams.append(self._beam(self.trace(angle, entry), entry))
        return beams

    def _aimed(self, before: float, angle: float, entry: F64, moved: F64, wanted: F64, depth: int = 0) -> F64:
        """Return where rays enter that meet places of the stop; found by smaller steps of the field if needed."""
        found = self._met_stop(angle, entry + moved * (angle - before), wanted)
        lost = ~np.isfinite(found[0])
        if not lost.any() or depth == HALVINGS or angle == before:
            return np.where(lost, entry, found)
        middle = 0.5 * (before + angle)
        half = self._aimed(before, middle, entry, moved, wanted, depth + 1)
        return self._aimed(middle, angle, half, (half - entry) / (middle - before), wanted, depth + 1)

    def _met_stop(self, angle: float, entry: F64, wanted: F64) -> F64:
        for _ in range(NEWTON):
            here, (a, c), (b, d) = self._slopes(angle, entry)
            missed = wanted - here
            if np.nanmax(np.abs(missed), initial=0.0) < 1e-10 * self.stop_mm:
                break
            entry = entry + np.stack([d * missed[0] - b * missed[1], a * missed[1] - c * missed[0]]) / (a * d - b * c)
        met: F64 = np.where(np.abs(wanted - here).max(axis=0) < 1e-6 * self.stop_mm, entry, np.nan)
        return met

    def _beam(self, rays: Traced, entry: F64) -> Beam:
        """Return rays on the sphere about the place where the first of them, the chief one, falls."""
        off = rays.place_mm - rays.place_mm[..., :1]
        along = (off * rays.direction).sum(axis=0)
        back = along + np.sqrt(np.maximum(along**2 - (off**2).sum(axis=0) + self.sphere_mm**2, 0.0))
        on_sphere = (off - back * rays.direction) / self.sphere_mm
        path = rays.path_mm - self.index[-1] * back
        return Beam(
            fallen_mm=rays.place_mm[:2, :, 1:],
            chief_mm=rays.place_mm[0, :, 0],
            pupil=on_sphere[:2, :, 1:],
            path_mm=(path - path[:, :1])[:, 1:],
            share=rays.share[:, 1:],
            entry_mm=entry[..., 1:],
        )


def _met(surface: Surface, x: F64, y: F64, dx: F64, dy: F64, dz: F64) -> tuple[F64, F64, F64]:
    """Return the distance along rays from the vertex's plane to a surface, and its slopes along x and y there."""
    c, k = surface.curvature_per_mm, surface.conic
    a, b = c * (1.0 + k * dz**2), c * (x * dx + y * dy) - dz
    length = c * (x**2 + y**2) / (np.copysign(np.sqrt(b**2 - a * c * (x**2 + y**2)), dz) - b)
    for _ in range(NEWTON):
        px, py = x + length * dx, y + length * dy
        square = px**2 + py**2
        root = np.sqrt(1.0 - (1.0 + k) * c**2 * square)
        sag, per_r = c * square / (1.0 + root), c / root  # slope over r
        for power, one in surface.powers:
            sag = sag + one * square ** (0.5 * power)
            per_r = per_r + power * one * square ** (0.5 * power - 1.0)
        slope_x, slope_y = per_r * px, per_r * py
        if not surface.powers:
            break
        missed = (length * dz - sag) / (dz - slope_x * dx - slope_y * dy)
        length = length - missed
        if not np.nanmax(np.abs(missed), initial=0.0) > MET:
            break
    return length, slope_x, slope_y


def or_aim(aim: bool) -> str:
    """Return the advice to aim rays at the stop, for lost chief rays; empty if they are aimed."""
    return "" if aim else "aim its rays at the stop (RAIM 0 2 in place of RAIM 0 0), or "
