"""``python -m tests.attack.captures``: random scene and sensor files, whole captures judged by first principles.

What lies round the engines: units, spectra, light levels, filters, efficiencies, glare, fall-off, windows, crosstalk,
wells, bent read-outs, codes; in every third capture noise and dark current, whose means and variances are told. Scenes
are rectangles along the axes behind Gaussians, or stripes behind a perfect lens. Everything comes from (seed, number).
Exit code 1 when anything is wrong.
"""

import argparse
import datetime
import functools
import math
import sys
import tempfile
import time
import traceback
from pathlib import Path

import colour
import numpy as np
import yaml

import camsim
from tests.truth.captures import captured, curve, dark_e, diffuser_e, filters_of, gain_e

TALL = 1e7  # pitches, of stripes that have no ends
SINGLE = 1.2e-7  # rounding of the truth's numbers
DEVIATIONS = 6.0  # of a variance or mean from what it should be: one of 10⁸ by chance
OWN = 1e-9  # what the truth itself is worth
MOST_DN, LEAST_DN2 = 50_000.0, 0.5  # signal and temporal variance that noise is judged at


def draw(seed, number):
    """A scene file and a sensor file, as tables."""
    rng = np.random.default_rng([seed, number])
    noisy = number % 3 == 2
    scene, sensor = _scene(rng, noisy), _sensor(rng, noisy)
    (_expose if noisy else _place)(rng, scene, sensor)
    return scene, sensor


def _curve(rng, top=1.0, outside=None):
    """A table: some points, a narrow band, or a step."""
    kind = rng.integers(3)
    if kind == 0:
        nm = np.sort(rng.uniform(360.0, 740.0, rng.integers(2, 7)).round(2))
        nm = nm + np.arange(nm.size) * 0.01
        values = rng.uniform(0.05, 1.0, nm.size)
    elif kind == 1:
        middle, half = rng.uniform(440.0, 660.0), rng.uniform(0.2, 15.0)
        nm = np.array([375.0, middle - half - 0.01, middle - half, middle + half, middle + half + 0.01, 745.0])
        values = np.array([0.02, 0.02, 1.0, 1.0, 0.02, 0.02])
    else:
        step = rng.uniform(420.0, 680.0)
        nm, values = np.array([370.0, step, step + 1e-3, 750.0]), rng.uniform(0.05, 1.0, 4)
    outside = outside or str(rng.choice(["zero", "hold"]))
    return {"wavelength_nm": nm.tolist(), "values": (values * top).tolist(), "outside": outside}


def _fraction(rng, top=1.0):
    return float(rng.uniform(0.02, top)) if rng.random() < 0.5 else _curve(rng, top)


def _light(rng):
    kind = rng.integers(4)
    if kind == 0:
        light = {"blackbody_k": float(rng.uniform(1500.0, 12000.0))}
    elif kind == 1:
        light = {"line_nm": float(rng.uniform(430.0, 670.0)), "width_nm": float(10.0 ** rng.uniform(-1.0, 1.3))}
    elif kind == 2:
        light = {"illuminant": str(rng.choice(["A", "D55", "D65", "E"]))}
    else:
        table = _curve(rng)
        light = {"table": {key: table[key] for key in ("wavelength_nm", "values")}}
    at = str(rng.choice(["scene", "scene", "sensor"]))
    level = rng.integers(3 if at == "scene" else 2)
    name, value = (
        ("illuminance_lux", 10.0 ** rng.uniform(0.0, 4.0)),
        ("irradiance_w_per_m2", 10.0 ** rng.uniform(-2.0, 1.0)),
        ("luminance_cd_per_m2", 10.0 ** rng.uniform(0.0, 3.5)),
    )[level]
    return light | {name: float(value), "at": at}


def _scene(rng, noisy):
    lens = {"f_number": float(rng.uniform(1.2, 11.0)), "transmission": _fraction(rng)}
    kind = str(rng.choice(["airy", "annular-airy", "gaussian", "elliptical-gaussian", "wavefront"]))
    lens["kind"] = kind
    if rng.random() < 0.4:
        lens["magnification"] = float(rng.uniform(0.0, 1.5))
    if kind == "annular-airy":
        lens["obstruction"] = float(rng.uniform(0.05, 0.6))
    if rng.random() < 0.5:
        lens["veiling_glare"] = _fraction(rng, 0.4)
    if rng.random() < 0.4:
        lens["filters"] = [_fraction(rng) for _ in range(rng.integers(1, 3))]
    if not noisy and rng.random() < 0.5:
        radius = np.sort(rng.uniform(0.01, 0.4, 3))
        lens["falloff"] = (
            {"kind": "cos4", "exit_pupil_mm": float(10.0 ** rng.uniform(-1.0, 1.5))}
            if rng.random() < 0.5
            else {"kind": "radial", "radius_mm": [0.0, *radius.tolist()], "values": [1.0, 0.9, 0.6, 0.5]}
        )
    if kind == "wavefront":
        lens["pupil"] = {"shape": str(rng.choice(["circular", "square", "bladed"])), "rotate_deg": 20.0}
        lens["pupil"] |= {"obstruction": float(rng.uniform(0.01, 0.4)), "blades": int(rng.integers(3, 9))}
        if lens["pupil"]["shape"] != "bladed":
            del lens["pupil"]["blades"]
    if kind in ("gaussian", "elliptical-gaussian"):
        lens |= {"sigma_um": 2.0} if kind == "gaussian" else {"sigma_um": 2.0, "sigma_across_um": 2.0}
    exposure = {"time_s": float(10.0 ** rng.uniform(-4.0, 0.0)), "iso": float(rng.choice([50, 100, 320, 1600]))}
    if rng.random() < 0.5:
        exposure["temperature_c"] = float(rng.uniform(-20.0, 60.0))
    return {
        "camsim": "scene/1",
        "sensor": "sensor.yaml",
        "lens": lens,
        "light": _light(rng),
        "exposure": exposure,
        "scene": {"unit": "pixel", "background": {"reflectance": _fraction(rng)}, "shapes": []},
        "render": {"tolerance": float(10.0 ** rng.uniform(-6.0, -3.0))},
        "noise": {"enabled": bool(noisy), "seed": int(rng.integers(1 << 40))},
    }


def _sensor(rng, noisy):
    pitch_um = float(rng.choice([0.8, 2.4, 3.45, 4.88, 9.0]))
    cfa = (
        {"kind": "mono"},
        {"kind": "bayer", "pattern": str(rng.choice(["RGGB", "BGGR", "GRBG", "GBRG"]))},
        {"kind": "quad-bayer", "pattern": str(rng.choice(["RGGB", "GBRG"])), "group": int(rng.integers(2, 4))},
        {"kind": "letters", "pattern": ["RGB", "BYR"]},
        {"kind": "letters", "pattern": ["RG", "WB", "GR"]},
    )[rng.integers(5)]
    letters, _ = filters_of(cfa)
    per = str(rng.choice(["energy", "photon"]))
    top = 0.1 if per == "energy" else 0.9  # A/W that no photon's worth of charge is over
    outside = "zero" if per == "energy" else None  # held on to shorter wavelengths it has no peak
    curves = {letter: _curve(rng, top * 10.0 ** rng.uniform(-1.0, 0.0), outside) for letter in letters}
    peak = float(rng.uniform(0.1, 1.0)) if rng.random() < 0.7 else "as given"
    sensor = {
        "camsim": "sensor/1",
        "name": "Drawn",
        "serial": int(rng.integers(1, 1 << 30)),
        "frame": {"rows": int(rng.integers(30, 60)), "cols": int(rng.integers(30, 60)), "pitch_um": pitch_um},
        "cfa": cfa,
        "quantum_efficiency": {"curves": curves, "per": per, "peak": peak},
        "charge": {"shot_noise": True},
        "readout": {
            "bit_depth": int(rng.choice([8, 12, 14, 16])),
            "black_level_dn": int(rng.integers(4, 200)) if noisy else int(rng.integers(0, 100)),
            "base_iso": float(rng.choice([80, 100, 200])),
            "electrons_per_dn": float(10.0 ** rng.uniform(-1.0, 1.5)),
        },
    }
    if rng.random() < 0.5:
        sensor["photosite"] = (
            {"kind": "square", "fill_factor": float(rng.uniform(0.2, 1.0))}
            if rng.random() < 0.5
            else {
                "kind": "rectangular",
                "width_um": 0.6 * pitch_um,
                "height_um": float(rng.uniform(0.3, 1.0)) * pitch_um,
            }
        )
    if rng.random() < 0.5:
        sensor["filters"] = [_fraction(rng) for _ in range(rng.integers(1, 3))]
    if rng.random() < 0.6:
        sensor["olpf"] = {"rotate_deg": float(rng.choice([0.0, 45.0, rng.uniform(-90.0, 90.0)]))}
        sensor["olpf"] |= (
            {"kind": "two-spot", "split_um": float(rng.uniform(0.2, 1.2)) * pitch_um}
            if rng.random() < 0.5
            else {"kind": "four-spot", "split_pitches": float(rng.uniform(0.2, 1.2)), "split_y_pitches": 0.7}
        )
    (_add_noise if noisy else _add_bends)(rng, sensor)
    return sensor


def _add_bends(rng, sensor):
    """What changes codes without chance."""
    charge, readout = sensor["charge"], sensor["readout"]
    if rng.random() < 0.5:
        kernel = rng.uniform(0.0, 0.08, (3, 3))
        kernel[1, 1] = rng.uniform(0.3, 0.36)
        charge["crosstalk"] = kernel.tolist()
    well = float(10.0 ** rng.uniform(2.5, 4.5))
    charge["full_well_e"] = well
    if rng.random() < 0.4:
        inside, outside = (np.array(shares) * well for shares in ([0.0, 0.3, 0.7, 1.0], [0.0, 0.28, 0.7, 0.9]))
        charge["nonlinearity"] = (
            {"kind": "polynomial", "coefficients": rng.uniform(-0.15, 0.15, 2).tolist(), "scale_e": well}
            if rng.random() < 0.5
            else {"kind": "table", "electrons_in": inside.tolist(), "electrons_out": outside.tolist()}
        )
    if rng.random() < 0.5:
        offsets = rng.integers(0, 5, (2, 3))
        readout["black_offsets_dn"] = (offsets - offsets.min()).tolist()
    if rng.random() < 0.4:
        readout["dual_gain"] = {"from_iso": 300.0, "full_well_e": 0.5 * well}


def _add_dark(rng, charge):
    charge["dark_current_e_per_s"] = float(10.0 ** rng.uniform(1.0, 3.5))
    if rng.random() < 0.5:
        charge["dark_current_at_c"] = float(rng.uniform(0.0, 40.0))
        charge["dark_current_doubles_every_c"] = float(rng.uniform(5.0, 9.0))


def _add_noise(rng, sensor):
    """Noise of every kind, in codes so wide that nothing is clipped."""
    charge, readout = sensor["charge"], sensor["readout"]
    sensor["frame"] |= {"rows": 180, "cols": 180}
    readout |= {"bit_depth": 16, "black_level_dn": 3000}
    for name, largest, stated in (("prnu", 0.03, charge), ("dsnu_e", 8.0, charge), ("column_noise_e", 6.0, readout)):
        if rng.random() < 0.5:
            stated[name] = float(rng.uniform(0.1, 1.0)) * largest
    largest_of = {"read_noise_e": 12.0, "reset_noise_e": 8.0, "row_noise_e": 5.0, "output_noise_dn": 4.0}
    for name, largest in largest_of.items():
        if rng.random() < 0.6:
            readout[name] = float(rng.uniform(0.1, 1.0)) * largest
    if rng.random() < 0.5:
        _add_dark(rng, charge)
        charge["dcnu"] = float(rng.uniform(0.0, 0.3))
    charge["shot_noise"] = bool(rng.random() < 0.8)


def _place(rng, scene, sensor):
    """A window of the frame, and shapes that fall in it."""
    frame, lens = sensor["frame"], scene["lens"]
    rows, cols = (int(rng.integers(8, 20)) for _ in range(2))
    origin = [int(rng.integers(0, frame[axis] - size + 1)) for axis, size in (("rows", rows), ("cols", cols))]
    scene["region"] = {"rows": rows, "cols": cols, "origin": origin}
    x, y = origin[1] + 0.5 * (cols - frame["cols"]), origin[0] + 0.5 * (rows - frame["rows"])
    pitch_um, shapes = frame["pitch_um"], scene["scene"]["shapes"]
    if lens["kind"] == "wavefront":
        return  # of an even surface only its opening tells
    stripes = lens["kind"] in ("airy", "annular-airy")
    if stripes:
        lens["f_number"] = max(0.8, float(rng.uniform(0.3, 2.0)) * pitch_um / 0.55)
    elif lens["kind"] == "gaussian" and rng.random() < 0.5:
        lens["mtf50_per_um"] = float(rng.uniform(0.1, 0.4)) / pitch_um
        del lens["sigma_um"]
    else:
        lens["sigma_um"] = float(rng.uniform(0.3, 2.0)) * pitch_um
    if lens["kind"] == "elliptical-gaussian":
        lens["sigma_across_um"] = float(rng.uniform(0.3, 2.0)) * pitch_um
        lens["rotate_deg"] = float(rng.choice([0.0, 90.0]))
    for _ in range(rng.integers(0, 5)):
        width, height = (float(size) for size in 10.0 ** rng.uniform(-0.5, 1.5, 2))
        place = [float(x + rng.uniform(-8.0, 8.0)), float(y + rng.uniform(-8.0, 8.0))]
        shapes.append({"kind": "rectangle", "width": width, "height": height, "centre": place})
        if stripes:
            shapes[-1] |= {"height": TALL, "centre": [place[0], 0.0]}
        shapes[-1]["reflectance"] = _fraction(rng)
    unit, each = (("pixel", 1.0), ("um", pitch_um), ("mm", pitch_um / 1e3))[rng.integers(3)]
    scene["scene"]["unit"] = unit
    for shape in shapes:
        shape |= {key: shape[key] * each for key in ("width", "height")}
        shape["centre"] = [item * each for item in shape["centre"]]


@functools.cache
def observer():
    """The photopic observer of 1924: (nm, values)."""
    stated = colour.SDS_LEFS["CIE 1924 Photopic Standard Observer"]
    return stated.wavelengths, stated.values


def _expose(rng, scene, sensor):
    """As long as gives the brightest channel some of what codes hold."""
    wanted_e = float(10.0 ** rng.uniform(-2.5, -0.05)) * MOST_DN * gain_e(scene, sensor)
    per_s = _signal(scene, sensor).max() / scene["exposure"]["time_s"]
    scene["exposure"]["time_s"] = float(np.clip(wanted_e / max(per_s, 1e-300), 1e-8, 1e4))


def _signal(scene, sensor):
    """Electrons of light of each channel, of an even surface."""
    nm, white = diffuser_e(scene, sensor, observer())
    return white @ curve(scene["scene"]["background"]["reflectance"], nm)


def judged(seed, number):
    """What is wrong with a capture, in words; nothing where nothing is."""
    scene, sensor = draw(seed, number)
    with tempfile.TemporaryDirectory() as folder:
        for name, stated in (("scene.yaml", scene), ("sensor.yaml", sensor)):
            (Path(folder) / name).write_text(yaml.safe_dump(stated, sort_keys=False), encoding="utf-8")
        capture = camsim.load(Path(folder) / "scene.yaml")
    return (_noise if scene["noise"]["enabled"] else _numbers)(scene, sensor, capture)


def _numbers(scene, sensor, capture):
    """Every photosite's electrons, truth and code, as shares of what is allowed."""
    right = captured(scene, sensor, observer())
    frame = capture.frame(products=("mosaic", "truth"))
    brightest = max(right.diffuser.max(), sys.float_info.min)
    allowed = capture.tolerance * right.diffuser + OWN * brightest
    truth = frame.truth[..., [frame.channels.index(letter) for letter in right.letters]]
    of_truth = capture.tolerance * brightest + SINGLE * np.abs(right.truth)
    # A response is bent by no more than half: a code is off by what its charge is, and what rounds is no error.
    off = np.maximum(np.abs(frame.mosaic - right.code) - 0.5, 0.0)
    found = {
        "mean_electrons": (np.abs(frame.mean_electrons - right.mean_electrons) / allowed).max(),
        "truth": (np.abs(truth - right.truth) / of_truth).max(),
        "codes": (off / (1.5 * allowed / gain_e(scene, sensor) + OWN)).max(),
    }
    return found, [f"{name} {value:.3g} × what is allowed" for name, value in found.items() if value > 1.0]


def _noise(scene, sensor, capture):
    """Means and variances of two frames of an even surface, as deviations from what they should be."""
    letters, places = filters_of(sensor["cfa"])
    signal = _signal(scene, sensor)
    most_e = signal.max() + dark_e(scene, sensor) * (1.0 + 5.0 * sensor["charge"].get("dcnu", 0.0))
    if most_e / gain_e(scene, sensor) > MOST_DN:
        return {}, []
    frames = [frame.mosaic.astype(float) for frame in capture.frames(2)]
    seen = capture.frame()
    words, worst = [], {}
    for letter, level in zip(letters, signal, strict=True):
        # One lattice of the channel's: all in it differ by whole periods.
        top, left = np.argwhere(seen.channel_index == seen.channels.index(letter))[0]
        pair = [frame[top :: len(places), left :: len(places[0])] for frame in frames]
        found = _deviations(pair, level, scene, sensor)
        worst |= {name: max(abs(value), worst.get(name, 0.0)) for name, value in found.items()}
        words += [f"{letter}'s {name} {z:.3g} deviations off" for name, z in found.items() if abs(z) > DEVIATIONS]
    return worst, words


def _deviations(pair, level, scene, sensor):
    """How many standard errors off a channel's figures are; ``level``: its electrons of light."""
    charge, readout = sensor["charge"], sensor["readout"]
    gain, dark = gain_e(scene, sensor), dark_e(scene, sensor)
    white = (level + dark) * charge["shot_noise"]
    white += sum(readout.get(name, 0.0) ** 2 for name in ("read_noise_e", "reset_noise_e"))
    white = white / gain**2 + readout.get("output_noise_dn", 0.0) ** 2 + 1.0 / 12.0
    if white < LEAST_DN2:  # rounding is a noise of its own only where codes are strewn
        return {}
    fixed = (charge.get("prnu", 0.0) * level) ** 2 + (charge.get("dcnu", 0.0) * dark) ** 2
    fixed = (fixed + charge.get("dsnu_e", 0.0) ** 2) / gain**2
    row, column = ((readout.get(name, 0.0) / gain) ** 2 for name in ("row_noise_e", "column_noise_e"))
    one, two = pair
    high, wide = one.shape
    plain = [item - item.mean(1, keepdims=True) - item.mean(0) + item.mean() for item in pair]
    free = (high - 1) * (wide - 1)
    # Poisson's fourth moment, and variances that are as unequal as the dark currents.
    uneven = charge.get("dcnu", 0.0) * dark / max(level + dark, 1.0)
    skew = 1.0 + 1.0 / max(level + dark, 1.0) + uneven**2
    mean = readout["black_level_dn"] + (level + dark) / gain
    of_mean = math.sqrt((0.5 * white + fixed) / one.size + 0.5 * row / high + column / wide)
    of_rows, of_columns = row + white / wide, column + (fixed + 0.5 * white) / high
    return {
        "mean": (0.5 * (one + two).mean() - mean) / of_mean,
        "temporal": (0.5 * ((plain[0] - plain[1]) ** 2).sum() / free / white - 1.0) / math.sqrt(2.0 * skew / free),
        "fixed": ((plain[0] * plain[1]).sum() / free - fixed)
        / math.sqrt(((white + fixed) ** 2 + skew * fixed**2) / free),
        "rows": (0.5 * (one - two).mean(1).var(ddof=1) / of_rows - 1.0) / math.sqrt(2.0 / (high - 1)),
        "columns": ((0.5 * (one + two)).mean(0).var(ddof=1) / of_columns - 1.0) / math.sqrt(2.0 / (wide - 1)),
    }


def main(arguments=None):
    """Run; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tests.attack.captures", description=__doc__)
    parser.add_argument("--seed", type=int, default=int(datetime.date.today().strftime("%Y%m%d")))
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--seconds", type=float, default=math.inf, help="stop after so long, whatever the count")
    parser.add_argument("--case", metavar="SEED:NUMBER", help="judge this one and print its files")
    options = parser.parse_args(arguments)
    if options.case:
        seed, number = map(int, options.case.split(":"))
        print("\n---\n".join(yaml.safe_dump(item, sort_keys=False) for item in draw(seed, number)))
        found, words = judged(seed, number)
        print(found, words)
        return int(bool(words))
    begin, wrong, refused, count, worst = time.perf_counter(), 0, 0, 0, {}
    for number in range(options.first, options.first + options.count):
        if time.perf_counter() - begin > options.seconds:
            break
        count += 1
        try:
            found, words = judged(options.seed, number)
        except camsim.CamsimError as error:
            refused += 1
            print(f"{options.seed}:{number} refused: {error}")
            continue
        except Exception:  # a crash is a finding, and the next one is drawn
            found, words = {}, [traceback.format_exc()]
        worst = {name: max(abs(value), worst.get(name, 0.0)) for name, value in (worst | found).items()}
        wrong += bool(words)
        if words:
            print(f"{options.seed}:{number} {'; '.join(words)}", flush=True)
    print(f"{count} captures, {refused} refused, {wrong} wrong; worst: {worst}")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
