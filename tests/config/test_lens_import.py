"""Lens files against rays and transfers of another trace (tests/truth/lens_rays.py)."""

import functools
import math
from pathlib import Path

import numpy as np
import pytest

import camsim
from camsim.config.lens_rays import Prescription, Surface
from camsim.config.lens_tables import lens_file
from camsim.errors import InputError
from tests.truth import lens_rays as truth

PER_MM = np.array([10.0, 20.0, 40.0])
OPEN = math.inf
# Textbook forms: a triplet whose sensor lies before the paraxial focus, a paraboloid, an aspheric singlet.
TRIPLET = [
    (1 / 22.01359, 0.0, {}, 3.25896, truth.N_SK16, OPEN),
    (-1 / 435.76044, 0.0, {}, 6.00755, truth.AIR, OPEN),
    (-1 / 22.21328, 0.0, {}, 0.99997, truth.F2, OPEN),
    (1 / 20.29192, 0.0, {}, 4.75041, truth.AIR, OPEN),
    (1 / 79.68360, 0.0, {}, 2.95208, truth.N_SK16, OPEN),
    (-1 / 18.39533, 0.0, {}, 42.10, truth.AIR, OPEN),
]
RIMS = [(*row[:5], rim) for row, rim in zip(TRIPLET, (7.1, 7.1, OPEN, OPEN, 5.9, 5.9), strict=True)]
MIRROR = [(-0.000625, -1.0, {}, -800.0, "mirror", OPEN)]
ASPHERE = [
    (0.02, -0.58, {4: 1e-8, 6: 1e-11}, 6.0, truth.N_BK7, OPEN),
    (0.0, 0.0, {4: 2e-8}, 92.4, truth.AIR, OPEN),
]
LENSES = {  # rows, the stop, half of the pupil's diameter, the field
    "triplet": (TRIPLET, 3, 5.0, 16.0),
    "rims": (RIMS, 3, 5.0, 12.0),
    "mirror": (MIRROR, 0, 50.0, 0.25),
    "asphere": (ASPHERE, 0, 6.0, 4.0),
}


def index_of(glass):
    return lambda nm: np.array([glass(float(one) / 1e3) for one in np.ravel(nm)])


@functools.cache
def made(name):
    rows, stop, radius, full_deg = LENSES[name]
    surfaces = tuple(
        Surface(
            curvature_per_mm=c,
            conic=k,
            powers=tuple(powers.items()),
            thickness_mm=thickness,
            index=None if glass in (truth.AIR, "mirror") else index_of(glass),
            mirror=glass == "mirror",
            rim_mm=rim,
            stop=number == stop,
        )
        for number, (c, k, powers, thickness, glass, rim) in enumerate(rows)
    )
    stated = Prescription(surfaces=surfaces, aperture=("EPD", 2.0 * radius))
    return lens_file(stated, math.radians(full_deg), name=name, source="a textbook")


def lens_of(name, folder: Path):
    file = folder / f"{name}.yaml"
    file.write_text(made(name).text, encoding="utf-8")
    return camsim.read_lens(file)


@pytest.mark.parametrize("name", LENSES)
def test_a_files_transfers_are_those_of_rays(name, tmp_path):
    rows, stop, radius, full_deg = LENSES[name]
    lens = lens_of(name, tmp_path)
    [in_stop] = truth.trace(rows, stop, 0.0, np.array([radius]), np.zeros(1), 0.55)[3][0]
    for share, nm in ((0.0, 550.0), (0.5, 460.0), (1.0, 460.0), (1.0, 640.0)):
        angle = math.radians(share * full_deg)
        _, height = truth.chief_mm(rows, stop, angle, 0.55)
        placed = lens.at(min(1e3 * abs(height), lens.height_um[-1]), 0.0)
        along, across = truth.mtf(rows, stop, abs(in_stop), angle, nm / 1e3, PER_MM)
        per_um, none = PER_MM / 1e3, 0.0 * PER_MM
        assert np.abs(np.abs(placed.otf(per_um, none, nm)) - along).max() <= 0.01, (share, nm)
        assert np.abs(np.abs(placed.otf(none, per_um, nm)) - across).max() <= 0.01, (share, nm)


@pytest.mark.parametrize("name", LENSES)
def test_heights_colours_and_distortion_are_those_of_chief_rays(name, tmp_path):
    """Of the scale that is left out, there is one: where the sensor lies off the focus it is not the focal length."""
    rows, stop, _, full_deg = LENSES[name]
    lens = lens_of(name, tmp_path)
    near = 1e-3
    scale = truth.chief_mm(rows, stop, near, 0.55)[1] / math.tan(near)
    for share in (0.21, 0.5, 0.77, 1.0):
        angle = math.radians(share * full_deg)
        ideal_um, right_um = 1e3 * abs(scale) * math.tan(angle), 1e3 * abs(truth.chief_mm(rows, stop, angle, 0.55)[1])
        fallen_um = math.hypot(*lens.distorted(np.array([[0.6 * ideal_um, 0.8 * ideal_um]]))[0])
        assert abs(fallen_um / right_um - 1.0) < 2e-5
    k, nm = 6, lens.wavelength_nm.index(440.0)
    angle = math.radians(full_deg * k / (len(lens.height_um) - 1))
    blue_um, green_um = (1e3 * abs(truth.chief_mm(rows, stop, angle, um)[1]) for um in (0.44, 0.55))
    assert lens.height_um[k] == pytest.approx(green_um, abs=0.01)
    assert lens.lateral_colour_um[nm][k] == pytest.approx(blue_um - green_um, abs=0.01)


def test_the_f_number_is_the_cones():
    """The sine of the angle of the rim's ray, seen from the axis's image; a paraboloid's by its sag at the rim."""
    cone = 50.0 / (800.0 + 50.0**2 * 0.000625 / 2.0 - 2.0 * 50.0**2 * 0.000625 / 2.0)
    n_of_mirror = 0.5 / math.sin(math.atan(cone))
    assert float(made("mirror").text.split("f_number: ")[1].split()[0]) == pytest.approx(n_of_mirror, rel=2e-5)


def test_the_residual_stands_in_the_file():
    for name in LENSES:
        text = made(name).text
        assert 0.0 < float(text.split("residual_waves: ")[1].split()[0]) <= 0.01
        assert float(text.split("residual_mtf: ")[1].split()[0]) <= 0.01


def counted(name, inner_mm, outer_mm):
    """The light of an even sky that falls into a ring of the sensor, ray by ray, over the ring's area."""
    rows, stop, radius, _ = LENSES[name]
    draws = np.random.default_rng(5)
    [in_stop] = truth.trace(rows, stop, 0.0, np.array([radius]), np.zeros(1), 0.55)[3][0]
    light = 0.0
    angles = np.linspace(max(0.0, inner_mm / 50.0 - 0.02), outer_mm / 49.0 + 0.02, 100)
    for angle in angles:
        entry, _ = truth.chief_mm(rows, stop, angle, 0.55)
        x, y = entry + 9.0 * (2.0 * draws.random(4000) - 1.0), 9.0 * (2.0 * draws.random(4000) - 1.0)
        with np.errstate(all="ignore"):
            at, _, _, place, met = truth.trace(rows, stop, angle, x, y, 0.55)
        fallen = np.hypot(at[0], at[1])
        taken = (met <= 1.0) & (np.hypot(*place) <= abs(in_stop)) & (fallen >= inner_mm) & (fallen < outer_mm)
        light += taken.mean() * math.sin(2.0 * angle)
    return light / (outer_mm**2 - inner_mm**2) * (angles[1] - angles[0])


def test_rims_take_light(tmp_path):
    lens = lens_of("rims", tmp_path)
    on_axis = counted("rims", 0.0, 1.2)
    for k in (6, 10):
        middle_mm = lens.height_um[k] / 1e3
        right = counted("rims", middle_mm - 0.5, middle_mm + 0.5) / on_axis
        assert lens.relative_illumination[k] == pytest.approx(right, rel=0.03)
    assert lens.relative_illumination[-1] < 0.99 * made_light("triplet", lens.height_um[-1], tmp_path)


def made_light(name, height_um, folder):
    return lens_of(name, folder).illumination(np.array([height_um]))[0]


def test_what_a_round_cone_cannot_show_is_refused_with_the_place():
    traced = made("rims")
    with pytest.raises(InputError, match=r"^'rims\.zmx' has no circle .* mm from the axis, .*--mtf-within 0\.0\d+"):
        traced.check_mtf(1e-4, "rims.zmx")
    traced.check_mtf(0.01, "rims.zmx")
