"""Lenses that change over the frame, given to a system in place of its own: tables at random, a sensor anywhere."""

import math

import numpy as np

from tests.attack.moved import moved
from tests.truth import field_lens

BLUR = 0.3, 4.0  # λN that sums over a place's pupil take a moment for
MOST = 16  # rows and columns
DIGITS = 2.0, 5.0
DAYLIGHT_NM = (430.0, 660.0)
LIKELY = 0.3  # one of distortion, lateral colour, illumination, a mosaic


def add_field_lens(rng, system, curves):
    """Give a system such a lens, a place for its window and now and then the colours of daylight.

    curves : what draws a list of curved shapes
    """
    blur = float(10.0 ** rng.uniform(*np.log10(BLUR)))
    grid, shapes = system["grid"], system["shapes"]
    rows, cols = grid["rows"], grid["cols"] = min(grid["rows"], MOST), min(grid["cols"], MOST)
    size = max(rows, cols, 4)
    if rng.random() < 0.5:
        system["photosite"] = {"kind": "square", "side": float(rng.choice([1.0, 0.9, rng.uniform(0.3, 1.0)]))}
    if rng.random() < 0.2:
        _daylight(rng, system)
    half = size * 10.0 ** rng.uniform(0.3, 3.0)
    frame = [max(2 * math.ceil(half * rng.uniform(0.5, 1.0)), n) for n in (rows, cols)]
    origin = [int(rng.integers(0, n - one + 1)) for n, one in zip(frame, (rows, cols), strict=True)]
    if rng.random() < 0.2:
        origin = [(n - one) // 2 for n, one in zip(frame, (rows, cols), strict=True)]  # the axis in its middle
    grid |= {"frame": frame, "origin": origin}
    system["tolerance"] = float(10.0 ** -rng.uniform(*DIGITS))
    nm = _known_at(rng, system["wavelength_nm"])
    zernike, strength = _zernikes(rng)
    on_grid = rng.random() < 0.2
    lens = _on_grid if on_grid else _of_revolution
    lens = {"blur": blur, "wavelength_nm": nm, **lens(rng, frame, len(nm), zernike, strength)}
    system["lens"] = {"kind": "field grid" if on_grid else "field"} | lens
    middle = np.array([origin[1] + 0.5 * cols - 0.5 * frame[1], origin[0] + 0.5 * rows - 0.5 * frame[0]])
    if rng.random() < 0.4:
        shapes = shapes[: int(rng.integers(0, 3))] + curves(rng, size)
    if system["method"] == "boundary":
        system["method"] = "auto"
    system["shapes"] = [moved(shape, _before_distortion(system["lens"], middle)) for shape in shapes]


def _daylight(rng, system):
    """Many wavelengths behind three broad filters, or one."""
    nm = np.linspace(*DAYLIGHT_NM, int(rng.choice([8, 16])))
    peaks = np.exp(-np.square((nm - np.array([[600.0], [540.0], [465.0]])) / rng.uniform(25.0, 60.0)))
    mosaic = rng.random() < LIKELY
    system["wavelength_nm"] = nm.tolist()
    system["response"] = (100.0 * (peaks if mosaic else peaks[1:2])).tolist()
    system["layout"] = [0, 1, 1, 2] if mosaic else [0, 0, 0, 0]


def _known_at(rng, wavelength_nm):
    """Wavelengths of the tables."""
    low, high = min(wavelength_nm), max(wavelength_nm)
    count = int(rng.choice([1, 2, 3, 5]))
    if count == 1:
        return [float(rng.choice([550.0, rng.uniform(400.0, 700.0)]))]
    return np.linspace(low - rng.uniform(1.0, 60.0), high + rng.uniform(1.0, 60.0), count).tolist()


def _zernikes(rng):
    """Indices of cosines, some of orders to 8, and the waves that they have at most, about."""
    cosines = [4, 5, 8, 9, 12, 13, 14, 18, 24, 40]
    count = int(rng.choice([1, 2, 4, 6]))
    return sorted(rng.choice(cosines, count, replace=False).tolist()), float(10.0 ** rng.uniform(-2.0, 0.0))


def _table(rng, places, count, strength):
    """Waves (places, count): at random, or growing with the place as aberrations of third order do."""
    noise = rng.normal(size=(len(places), count)) * strength / math.sqrt(count)
    if rng.random() < 0.5:
        return noise
    return noise[-1] * (np.array(places) / places[-1])[:, None] ** 2 + rng.choice([0.0, 0.1]) * noise


def _of_revolution(rng, frame, colours, zernike, strength):
    """Tables along a radius, at even distances or any."""
    radius = 0.5 * math.hypot(*frame) * rng.uniform(1.0, 1.3)
    count = int(rng.integers(2, 8))
    # Uneven ones too, but not so that a spline swings between them by many times what it goes through.
    inner = np.linspace(0.0, 1.0, count)[1:-1] + rng.choice([0.0, 0.2]) * rng.uniform(-1.0, 1.0, count - 2) / count
    heights = radius * np.array([0.0, *inner, 1.0])
    turns = np.array([field_lens.order(index) == 0 for index in zernike])
    one = _table(rng, heights, len(zernike), strength)
    one[0, ~turns] = 0.0
    times = 1.0 + rng.choice([0.0, 0.3]) * rng.normal(size=(colours, 1, 1))
    lens = {"zernike": zernike, "heights": heights.tolist(), "waves": (times * one).tolist()}
    u = heights / radius
    if rng.random() < LIKELY:
        lens["distortion"] = (rng.uniform(-0.1, 0.1) * u**2 + 0.01 * rng.normal() * u**4).tolist()
    elif rng.random() < LIKELY:
        powers = np.arange(1, int(rng.integers(2, 5)))
        lens["distortion_powers"] = (rng.uniform(-0.1, 0.1, powers.size) / powers**2).tolist()  # none that folds
    if rng.random() < LIKELY:
        lens["lateral"] = (rng.uniform(-1.0, 1.0, (colours, 1)) * u * rng.uniform(0.5, 1.0, u.size)).tolist()
    if rng.random() < LIKELY:
        lens["illumination"] = (1.0 - rng.uniform(0.0, 0.6) * u**2).tolist()
    return lens


def _on_grid(rng, frame, colours, zernike, strength):
    """Tables at places across the frame; sines are taken as well."""
    zernike = sorted({index - int(rng.integers(0, 2)) * field_lens.order(index) for index in zernike})
    x, y = (np.linspace(-0.51, 0.51, int(rng.integers(1, 5))) * n for n in (frame[1], frame[0]))
    waves = strength / math.sqrt(len(zernike)) * rng.normal(size=(1, y.size, x.size, len(zernike)))
    waves = waves * (1.0 + rng.choice([0.0, 0.3]) * rng.normal(size=(colours, 1, 1, 1)))
    return {"zernike": zernike, "x": x.tolist(), "y": y.tolist(), "waves": waves.tolist()}


def _before_distortion(lens, place):
    """What falls at a place, by halving; the nearest quarter pitch."""
    if "heights" not in lens or not math.hypot(*place):
        return place
    low, high = 0.0, 4.0 * lens["heights"][-1]
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if field_lens.falls(lens, middle)[0] < math.hypot(*place) else (low, middle)
    return np.round(4.0 * place * low / math.hypot(*place)) / 4.0
