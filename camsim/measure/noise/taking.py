"""Flats and darks of a camera, as taken in a laboratory: uniform light at several levels, without a lens."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from typing import Annotated, TypeAlias

import numpy as np
from annotated_types import Ge, Le

from camsim.camera.camera import Camera
from camsim.camera.capture import Capture
from camsim.camera.frame import Frame
from camsim.core.typed import check
from camsim.core.words import both
from camsim.errors import UnsupportedError
from camsim.measure.noise.shots import Group, Kind, Shots
from camsim.measure.picture import mosaic_planes
from camsim.scene import Scene
from camsim.sensor.exposure import Exposure
from camsim.spectra.light import Light

TIME_S = 0.01
DARK_TIMES_S = (0.001, 3.0, 10.0, 20.0, 30.0)
LEVELS = (0.04, 0.08, 0.15, 0.22, 0.3, 0.38, 0.46, 0.54, 0.62, 0.7, 0.8, 0.9)
"""Levels relative to saturation in the most responsive channel."""

_FAINTEST = 1e-6
"""Response relative to the most responsive channel below which a channel has no electrons."""

_APART = 1_000_000
Side: TypeAlias = Annotated[int, Ge(32), Le(4000)]
Frames: TypeAlias = Annotated[int, Ge(2), Le(1000)]
_Key = tuple[Kind, float, float]


def take_shots(
    camera: Camera,
    *,
    side: int = 400,
    frames: int = 16,
    iso: float | None = None,
    temperature_c: float | None = None,
    seed: int = 0,
) -> Shots:
    """Take flats at 12 levels and darks from 1 ms to 30 s of a window of ``side`` squared photosites.

    side   : 32 … 4000
    frames : number at each level, 2 … 1000; two give the noise, more separate fixed patterns from it
    iso    : the sensor's base ISO when None
    temperature_c : temperature of the sensor; None: the one for which its dark current is given
    seed   : seed of the temporal noise; fixed patterns depend on the sensor only
    """
    taken = frames_of(camera, side=side, frames=frames, iso=iso, temperature_c=temperature_c, seed=seed)
    groups = {key: list(each) for key, each in taken}
    # The two greens of a Bayer array are separate, as in all measurements.
    planes = mosaic_planes(np.zeros((side, side)), list(camera.cfa.pattern))
    channels = tuple(dict.fromkeys(plane.name for plane in planes))
    index = np.zeros((side, side), np.uint8)
    for plane in planes:
        where = slice(plane.first[0], None, plane.step[0]), slice(plane.first[1], None, plane.step[1])
        index[where] = channels.index(plane.name)
    return Shots(
        name=camera.name,
        channels=channels,
        channel_index=index,
        groups=tuple(
            Group(kind=kind, exposure=exposure, time_s=time_s, codes=[frame.linear_dn for frame in each])
            for (kind, exposure, time_s), each in groups.items()
        ),
    )


def frames_of(
    camera: Camera,
    *,
    side: int,
    frames: int,
    iso: float | None = None,
    temperature_c: float | None = None,
    seed: int = 0,
) -> Iterator[tuple[_Key, Sequence[Frame]]]:
    """Yield kind, exposure (relative to saturation) and time of every group, and its frames."""
    check(camera, Camera, "camera")
    check(side, Side, "side")
    check(frames, Frames, "frames")
    exposure = exposure_of(camera, iso=iso, temperature_c=temperature_c)
    if camera.shot_noise is None:
        raise UnsupportedError("has no photon noise: nothing tells its gain", stage=camera.name)
    ready = _bench_camera(camera, side)
    per_watt = ready.diffuser_electrons(even_light(1.0), TIME_S)
    faint = [c for c, e in zip(ready.cfa.channels, per_watt, strict=True) if not e > _FAINTEST * per_watt.max()]
    if faint:
        raise UnsupportedError(
            f"{both(faint)} {'sees' if len(faint) == 1 else 'see'} nothing of even light (E): flats tell nothing of "
            "it; give a quantum efficiency above 0 in the visible",
            stage=camera.name,
        )
    brightest = ready.charge_at_e(1.0, exposure.iso) / float(per_watt.max())

    def taken(level: float, time_s: float, group: int, count: int) -> list[Frame]:
        flat = Capture(
            camera=ready,
            scene=Scene(background=1.0 if level else 0.0),
            light=even_light(brightest * (level or 1.0)),
            exposure=dataclasses.replace(exposure, time_s=time_s),
            seed=seed,
            frame_number=group * _APART,  # so that no two frames are equal
            tolerance=1e-2,
            scene_name=f"flat at {level:g}" if level else "dark",
        )
        return list(flat.frames(count))

    for number, level in enumerate(LEVELS):
        yield ("flat", level, TIME_S), taken(level, TIME_S, 100 + number, frames)
    yield ("dark", 0.0, TIME_S), taken(0.0, TIME_S, 1, 2 * frames)
    for number, time_s in enumerate(DARK_TIMES_S):
        yield ("dark", 0.0, time_s), taken(0.0, time_s, 10 + number, frames)
    full = 4.0 * float(per_watt.max() / per_watt.min())
    yield ("clipped", full, TIME_S), taken(full, TIME_S, 2, 2)


def exposure_of(camera: Camera, *, iso: float | None, temperature_c: float | None) -> Exposure:
    """Return the exposure of flats, at the base ISO when ``iso`` is None."""
    return Exposure(time_s=TIME_S, iso=camera.converter.base_iso if iso is None else iso, temperature_c=temperature_c)


def _bench_camera(camera: Camera, side: int) -> Camera:
    # Patterns do not depend on the format; a smaller frame avoids drawing those of unused photosites.
    defects = camera.defects
    if defects is not None:
        hot = [(row, col, e_per_s) for row, col, e_per_s in defects.hot if max(row, col) < side]
        dead = [(row, col) for row, col in defects.dead if max(row, col) < side]
        defects = dataclasses.replace(defects, hot=hot, dead=dead)
    return camera.replace(rows=side, cols=side, olpf=None, defects=defects)


def even_light(watts: float) -> Light:
    """Return the light of flats, ``watts`` W/m² on the sensor."""
    return Light("E", irradiance_w_per_m2=watts, at="sensor")
