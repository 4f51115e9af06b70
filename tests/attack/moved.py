"""Systems of three kinds that others seldom are: turned lenses, wide low-pass filters, fields far larger than frames.

A tilt of the wavefront moves the image and does nothing else, whatever other terms there are: the scene is moved the
other way, and the truth, which knows of neither, stays what it was.
"""

import math

import numpy as np

from tests.attack.fields import add_fields, limit

FIELD_SHARE = 0.5  # of the systems of each kind
WAVES = -1.0, 1.69  # powers of ten of a tilt's: 50 are what a lens may have of one term
SPLIT = math.log10(1.5), math.log10(15.0)  # powers of ten of pitches
LARGER = 0.3, 1.0  # powers of ten of the frame
CYCLES = 150.0  # of the finest wave that a lens passes, along a large field: its truth has as many nodes, squared
CYCLES_AT_ONCE = 40.0  # likewise of a lens that is not round: its truth has four times as many frequencies, squared
ROUND = "airy", "annular", "gaussian"


def add_tilt(rng, system, paint, curves):
    """Turn a wavefront, one with a term or two more, by up to 49 waves either way, and move the scene against it."""
    _add_fields(rng, system, paint, curves)
    lens = system["lens"]
    if lens["kind"] != "wavefront":
        pupil = {"shape": "circular", "obstruction": 0.0, "blades": 0, "rotate_deg": 0.0}
        lens = {"kind": "wavefront", "blur": lens["blur"], "pupil": pupil, "zernike_waves": [], "defocus_waves": 0.0}
        few = slice(0, 4)
        system |= {"lens": lens, "wavelength_nm": system["wavelength_nm"][few], "method": "auto"}
        system["response"] = [row[few] for row in system["response"]]
    if not lens["zernike_waves"]:
        index, strength = int(rng.integers(3, 15)), float(rng.choice([0.02, 0.1, 0.3, 1.0]))
        lens["zernike_waves"] = [[index, strength * float(rng.normal())]]
    lens["zernike_waves"] = [term for term in lens["zernike_waves"] if term[0] > 2]
    angle, waves = 2.0 * math.pi * float(rng.random()), 10.0 ** float(rng.uniform(*WAVES))
    along = [(1.0, 0.0), (0.0, -1.0), (math.cos(angle), math.sin(angle))][rng.integers(3)]
    lens["tilt_waves"] = [waves * along[0], waves * along[1]]


def add_wide_olpf(rng, system, paint, curves):
    """Give a system spots that lie up to 15 pitches apart, either way or both."""
    _add_fields(rng, system, paint, curves)
    split, other = (float(10.0 ** rng.uniform(*SPLIT)) for _ in range(2))
    if rng.random() < 0.3:
        split = max(round(2.0 * split), 3) / 2.0
    kind = str(rng.choice(["four", "unequal", "plate"]))
    other = {"four": split, "unequal": other, "plate": 0.0}[kind]
    turn = float(rng.choice([0.0, 45.0, rng.uniform(0.0, 180.0)]))
    system["olpf"] = {"split": split, "split_y": other, "rotate_deg": turn}


def add_large_field(rng, system, paint, curves):
    """Give a system a gradient, a grating or a picture that reaches far beyond its frame, behind shapes or alone."""
    limit(system)
    size = max(system["grid"]["rows"], system["grid"]["cols"], 4)
    cycles = CYCLES if system["lens"]["kind"] in ROUND else CYCLES_AT_ONCE
    largest = min(size * 10.0 ** float(rng.uniform(*LARGER)), cycles * system["lens"]["blur"])
    if largest <= size:
        return
    shapes = system["shapes"][: int(rng.integers(0, 3))] if rng.random() < 0.5 else []
    system["shapes"] = [_large(rng, size, largest, paint), *shapes]
    if rng.random() < 0.3:
        system["shapes"] += curves(rng, size)


def _add_fields(rng, system, paint, curves):
    if rng.random() < FIELD_SHARE:
        add_fields(rng, system, paint, curves)


def _large(rng, size, largest, paint):
    middle = rng.uniform(-0.5, 0.5, 2) * largest * float(rng.choice([0.0, 0.5, 1.0]))
    placed = {"centre": middle.tolist(), "rotate_deg": float(rng.choice([0.0, 90.0, 45.0, rng.uniform(0.0, 360.0)]))}
    kind = str(rng.choice(["rings", "picture", "linear-gradient", "radial-gradient", "sine-grating"]))
    if kind in ("rings", "picture"):
        count = int(rng.integers(2, 12))
        samples = rng.random((count, count))
        if kind == "rings":
            # About a photosite, rings of one step: they come there in step.
            place = np.arange(count) + 0.5 - 0.5 * count
            away = np.hypot(place, place[:, None]) * float(rng.uniform(0.3, 1.0))
            samples, placed["centre"] = 0.5 + 0.5 * np.cos(2.0 * math.pi * away), np.round(middle / size).tolist()
        interpolation = str(rng.choice(["squares", "linear", "cubic"]))
        one = {"samples": samples.tolist(), "step": largest / count, "interpolation": interpolation}
        return {"kind": "picture", **placed, **one, "reflectance": paint(rng)}
    low, high = rng.random(2).tolist()
    if kind == "radial-gradient":
        return {"kind": kind, **placed, "rotate_deg": 0.0, "radius": 0.5 * largest, "low": low, "high": high}
    one = {"width": largest, "height": largest * float(rng.uniform(0.1, 1.0)), "low": low, "high": high}
    if kind == "sine-grating":
        one["period"] = float(max(0.4, largest / rng.integers(1, 40)))
    return {"kind": kind, **placed, **one}


def moved(shape, by):
    """A shape of a system as it is when it is moved ``by`` (x, y); groups and repeats with all that is in them."""
    if shape["kind"] == "group":
        return shape | {"move": _sum(shape["move"], by)}
    one = dict(shape)
    if "centre" in one:
        one["centre"] = _sum(one["centre"], by)
    if "shapes" in one:
        one["shapes"] = [moved(each, by) for each in one["shapes"]]
    if "points" in one:
        one["points"] = [_sum(point, by) for point in one["points"]]
    if "holes" in one:
        one["holes"] = [[_sum(point, by) for point in hole] for hole in one["holes"]]
    if "outlines" in one:
        one["outlines"] = [
            [_sum(start, by), *([_sum(point, by) for point in segment] for segment in segments)]
            for start, *segments in one["outlines"]
        ]
    return one


def _sum(place, by):
    return [place[0] + by[0], place[1] + by[1]]
