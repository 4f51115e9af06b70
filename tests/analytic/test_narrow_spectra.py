"""Narrow lines, etalons and steps: every channel's electrons against adaptive quadrature, written here from scratch.

The truth knows the curves by their tables alone: straight lines by bisection, a Gaussian by its formula, Planck's law,
and an integral that is halved between any two points until it stands still (Gauss–Kronrod, scipy's).
"""

from __future__ import annotations

import bisect
import itertools
import math
import random
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
import scipy.constants
import scipy.integrate

import camsim
from camsim.config.library import shipped
from camsim.spectra.colour_science import colour_science
from camsim.spectra.integral import LUMPED, lumped
from camsim.spectra.light import Light

Function = Callable[[float], float]
Table = tuple[Sequence[float], Sequence[float]]
HC = scipy.constants.h * scipy.constants.c
SENSORS = sorted(set(shipped("sensor")) - {"paper-488"})
TIME_S, F_NUMBER = 0.02, 4.0


def line_through(table: Table, *, held: bool = False) -> Function:
    nm, values = list(table[0]), list(table[1])

    def at(wavelength_nm: float) -> float:
        if not nm[0] <= wavelength_nm <= nm[-1]:
            return (values[0] if wavelength_nm < nm[0] else values[-1]) if held else 0.0
        k = min(bisect.bisect_right(nm, wavelength_nm), len(nm) - 1)
        share = (wavelength_nm - nm[k - 1]) / (nm[k] - nm[k - 1])
        return values[k - 1] + share * (values[k] - values[k - 1])

    return at


def integral(of: Callable[[float], Any], points: set[float], low: float, high: float) -> Any:
    """Adaptive between any two points that lie within low … high."""
    ends = sorted({low, high, *(p for p in points if low < p < high)})
    # The rule never asks at the ends, where tables jump.
    parts = [scipy.integrate.quad_vec(of, a, b, epsrel=1e-10, limit=200)[0] for a, b in itertools.pairwise(ends)]
    return np.sum(parts, axis=0)


def of_curve(curve: camsim.Curve) -> Table:
    return curve.wavelength_nm, curve.values


def expected_electrons(
    camera: camsim.Camera, power: Function, ends: tuple[float, float], points: set[float], *, level: float, lux: bool
) -> Callable[[camsim.Curve], Any]:
    """Return what a surface gives every channel: light to a level, diffuser, lens, filters, photons, efficiency."""
    eye = colour_science().SDS_LEFS["CIE 1924 Photopic Standard Observer"]
    seen, eye_nm = line_through((eye.wavelengths, eye.values)), set(map(float, eye.wavelengths))
    if lux:
        weighed = 683.002 * integral(lambda nm: power(nm) * seen(nm), points | eye_nm, *ends)
    else:
        weighed = integral(power, points, *ends)
    given = camera.quantum_efficiency
    tables = dict(given.curves)
    per: Function = (lambda nm: nm) if given.per == "energy" else (lambda nm: 1.0)
    highest = max(v / per(w) for curve in tables.values() for w, v in zip(*of_curve(curve), strict=True))
    channels = [tables[letter] for letter in camera.cfa.channels]
    curves = [line_through(of_curve(curve), held=curve.outside == "hold") for curve in channels]
    stages = [*camera.filters, camera.lens.transmission]
    passing = [line_through(of_curve(f), held=f.outside == "hold") for f in stages if isinstance(f, camsim.Curve)]
    fixed = math.prod(f for f in stages if isinstance(f, float))
    kinks = {w for curve in (*channels, *stages) if isinstance(curve, camsim.Curve) for w in curve.wavelength_nm}
    area_m2 = camera.photosite.area_um2 * 1e-12

    def of(surface: camsim.Curve) -> Any:
        reflects = line_through(of_curve(surface), held=surface.outside == "hold")

        def per_nm(nm: float) -> Any:
            light = power(nm) * level / weighed * reflects(nm) / (4 * F_NUMBER**2) * nm * 1e-9 / HC
            light *= fixed * math.prod(f(nm) for f in passing)
            return np.array([curve(nm) / per(nm) for curve in curves]) * light

        electrons = integral(per_nm, points | kinks | set(surface.wavelength_nm), *ends)
        return electrons * given.peak / highest * area_m2 * TIME_S

    return of


def etalon(draw: random.Random) -> camsim.Curve:
    """Peaks of 0.05 to 0.5 nm, some nm apart, each of five points; almost dark in between."""
    nm, values, at = [], [], draw.uniform(410.0, 460.0)
    while at < 680.0:
        half = 0.5 * draw.uniform(0.05, 0.5)
        nm += [at - 2 * half, at - half, at, at + half, at + 2 * half]
        values += [0.001, 0.5, draw.uniform(0.7, 1.0), 0.5, 0.001]
        at += draw.uniform(3.0, 30.0)
    return camsim.Curve(tuple(nm), tuple(values), outside=draw.choice(["zero", "hold"]))  # type: ignore[arg-type]


def step(draw: random.Random) -> camsim.Curve:
    """A flank of 1 pm to 2 nm anywhere, up or down; half a nanometre is met, too."""
    at = draw.choice([549.5, draw.uniform(480.0, 620.0)])
    low, high = draw.uniform(0.0, 0.3), draw.uniform(0.6, 1.0)
    first, last = draw.choice([(low, high), (high, low)])
    flank = draw.choice([0.001, draw.uniform(0.01, 2.0)])
    return camsim.Curve((300.0, at, at + flank, 1200.0), (first, first, last, last))


def light_of(draw: random.Random, **level: float) -> tuple[Light, Function, tuple[float, float], set[float]]:
    kind = draw.choice(["line", "line", "lines", "D65", "blackbody", "LED-B3"])
    if kind == "line":
        width = math.exp(draw.uniform(math.log(0.01), math.log(5.0)))
        centre = draw.uniform(440.0, 660.0)
        sigma = width / 2.3548200450309493
        light = Light(line_nm=centre, width_nm=width, **level)
        ends = centre - 8 * sigma, centre + 8 * sigma
        points = {centre + k * sigma for k in range(-7, 8)}
        return light, lambda nm: math.exp(-((nm - centre) ** 2) / (2 * sigma**2)), ends, points
    if kind == "blackbody":
        kelvin = draw.uniform(1500.0, 9000.0)
        c2_nm = HC / scipy.constants.k * 1e9
        light = Light(blackbody_k=kelvin, **level)
        return light, lambda nm: (500.0 / nm) ** 5 / math.expm1(c2_nm / (nm * kelvin)), (300.0, 1100.0), set()
    if kind == "lines":
        nm, values = [], []
        for centre in (draw.uniform(440.0, 470.0), draw.uniform(520.0, 550.0), draw.uniform(620.0, 650.0)):
            half = draw.uniform(0.005, 0.1)
            nm += [centre - half, centre, centre + half]
            values += [0.0, draw.uniform(0.3, 1.0), 0.0]
        table: Table = (nm, values)
        light = Light(camsim.Curve(tuple(nm), tuple(values)), **level)
    else:
        data = colour_science().SDS_ILLUMINANTS[kind]
        keep = slice(None) if kind == "LED-B3" else slice(0, 80)
        table = tuple(map(float, data.wavelengths[keep])), tuple(map(float, data.values[keep]))
        light = Light(camsim.Curve(*map(tuple, table)), **level)  # type: ignore[arg-type]
    return light, line_through(table), (table[0][0], table[0][-1]), set(table[0])


@pytest.mark.parametrize("seed", range(8))
def test_random_lines_etalons_and_steps(seed: int) -> None:
    """Through the whole camera; lens, filters and surface each an etalon or a step, every channel to 1e-6."""
    draw = random.Random(seed)
    lux = draw.random() < 0.5
    level = draw.uniform(100.0, 2000.0) if lux else draw.uniform(0.5, 5.0)
    light, power, ends, points = light_of(draw, **{"illuminance_lux" if lux else "irradiance_w_per_m2": level})
    surface, transmission, *filters = (draw.choice([etalon, step])(draw) for _ in range(2 + draw.randrange(3)))
    lens = camsim.Airy(f_number=F_NUMBER, transmission=draw.choice([transmission, 0.8]))
    camera = camsim.Camera.from_yaml(draw.choice(SENSORS), lens=lens)
    camera = camera.replace(filters=(*camera.filters, *filters, 0.9), crosstalk=None)
    frame = camera.expose(
        camsim.Scene(background=surface),
        light=light,
        exposure=camsim.Exposure(time_s=TIME_S, iso=camera.adc.base_iso),
        region=camsim.Region(rows=6, cols=6),
        noise=False,
    )
    expected = expected_electrons(camera, power, ends, points, level=level, lux=lux)(surface)
    found = [np.unique(frame.mean_electrons[frame.channel_index == k]) for k in range(len(frame.channels))]
    assert [values.size for values in found] == [1] * len(found)
    np.testing.assert_allclose(np.concatenate(found), expected, rtol=1e-6)


# Steps and lines by hand --------------------------------------------------------------------------------------------

FLAT = camsim.Curve((300.0, 1100.0), (1.0, 1.0))


def mono(**stages: Any) -> camsim.Camera:
    return camsim.Camera(
        rows=8,
        cols=8,
        pitch_um=2.0,
        lens=camsim.Airy(f_number=1.0),
        photosite=camsim.SquarePhotosite(side_um=2.0),
        cfa=camsim.Cfa(("Y",)),
        quantum_efficiency=camsim.QuantumEfficiency((("Y", FLAT),), per="photon", peak=1.0),
        adc=camsim.Adc(bit_depth=14, black_level_dn=100, electrons_per_dn=1.0, base_iso=100.0),
    ).replace(**stages)


def photons_per_w_m2(low_nm: float, high_nm: float) -> float:
    """1 W/m² per nm over low … high, per 4 µm² and second, a quarter of it through f/1: ∫ λ/hc."""
    return 0.25 * (high_nm**2 - low_nm**2) / 2 * 1e-9 / HC * 4e-12


@pytest.mark.parametrize("filters", [0, 3, 6])
def test_ramps_that_multiply_are_a_polynomial(filters: int) -> None:
    """Light, surface and filters all rise from 0 to 1 within 0.8 nm: ∫ x^n·λ dx, to rounding however many there are."""
    ramp, width_nm = camsim.Curve((500.1, 500.9), (0.0, 1.0)), 0.8
    light = Light(ramp, irradiance_w_per_m2=0.5 * width_nm)
    camera = mono(filters=(ramp,) * filters)
    samples = camera.samples(light, [ramp])
    found = camera.electrons_per_reflectance(samples, 1.0)[0] @ ramp.at(samples.wavelength_nm)
    n = filters + 2
    expected = width_nm * (500.1 / (n + 1) + width_nm / (n + 2)) * 0.25 * 1e-9 / HC * 4e-12
    assert found == pytest.approx(expected, rel=1e-11)


def test_a_light_ends_where_its_table_ends() -> None:
    """A flat table from 500.3 to 599.8 nm has 99.5 nm, and photons of no other wavelength."""
    light = Light(camsim.Curve((500.3, 599.8), (7.0, 7.0)), irradiance_w_per_m2=99.5)
    assert mono().diffuser_electrons(light, 1.0)[0] == pytest.approx(photons_per_w_m2(500.3, 599.8), rel=1e-12)
    np.testing.assert_array_equal(light.irradiance_at(np.array([500.2, 599.9])), 0.0)
    np.testing.assert_allclose(light.irradiance_at(np.array([500.3, 550.0, 599.8])), 1.0, rtol=1e-12)
    first, last = camsim.Curve((100.0, 500.4), (1.0, 1.0)), camsim.Curve((599.6, 900.0), (1.0, 1.0))
    for band, ends in ((first, (500.3, 500.4)), (last, (599.6, 599.8))):
        found = mono(filters=(band,)).diffuser_electrons(light, 1.0)[0]
        assert found == pytest.approx(photons_per_w_m2(*ends), rel=1e-9)


def test_a_table_that_is_held_lights_all_of_the_visible() -> None:
    """CIE 018: 360 to 830 nm."""
    light = Light(camsim.Curve((400.0, 500.0), (2.0, 2.0), outside="hold"), irradiance_w_per_m2=470.0)
    assert mono().diffuser_electrons(light, 1.0)[0] == pytest.approx(photons_per_w_m2(360.0, 830.0), rel=1e-12)


def test_a_blackbody_shines_from_300_to_1100_nm() -> None:
    light = Light(blackbody_k=2856.0, irradiance_w_per_m2=1.0)
    ends = np.array([299.999, 300.0, 1100.0, 1100.001])
    assert (light.irradiance_at(ends) > 0.0).tolist() == [False, True, True, False]


def test_a_line_meets_the_curves_at_its_wavelength() -> None:
    ramp = camsim.Curve((500.0, 600.0), (0.0, 1.0))
    line = Light(line_nm=532.25, irradiance_w_per_m2=2.0)
    expected = 0.3225 * 2.0 * 0.25 * 532.25e-9 / HC * 4e-12
    assert mono(filters=(ramp,)).diffuser_electrons(line, 1.0)[0] == pytest.approx(expected, rel=1e-12)
    narrow = Light(line_nm=532.25, width_nm=1e-7, irradiance_w_per_m2=2.0)
    assert mono(filters=(ramp,)).diffuser_electrons(narrow, 1.0)[0] == pytest.approx(expected, rel=1e-12)


# Fewer nodes --------------------------------------------------------------------------------------------------------


def test_a_wide_spectrum_is_met_about_once_a_nanometre() -> None:
    """Curves every 5 nm: 106 panels of six nodes, so that a capture in daylight takes no longer than by whole ones."""
    camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8.0))
    samples = camera.samples(Light("D55", illuminance_lux=1.0), [camsim.reflectance("orange")])
    assert samples.wavelength_nm.size == 6 * 106
    assert lumped(samples.wavelength_nm, samples.weight_nm)[0].size == samples.wavelength_nm.size


def measured_finely() -> camsim.Curve:
    """A reflectance of 10 000 points: 0.04 nm apart, noisy."""
    rng = np.random.default_rng(1)
    nm = np.linspace(380.0, 780.0, 10_000)
    return camsim.Curve(
        tuple(nm), tuple(0.5 + 0.3 * np.sin(nm / 7.0) + 0.1 * rng.uniform(-1, 1, nm.size)), outside="zero"
    )


def test_ten_thousand_points_are_lumped_to_six_a_nanometre_with_all_their_moments() -> None:
    camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8.0))
    surface = measured_finely()
    samples = camera.samples(Light("D55", illuminance_lux=1.0), [surface])
    density = camera.electrons_per_reflectance(samples, 1.0) * surface.at(samples.wavelength_nm)
    nodes, lumps = lumped(samples.wavelength_nm, density)
    assert samples.wavelength_nm.size > 20_000
    assert nodes.size <= LUMPED * 400 + 200
    assert (np.diff(nodes) > 0.0).all()
    for power in range(LUMPED):
        whole, part = density @ (samples.wavelength_nm / 550) ** power, lumps @ (nodes / 550) ** power
        np.testing.assert_allclose(part, whole, rtol=1e-12)


def test_an_edge_in_a_fine_spectrum() -> None:
    """A half-plane of 10 000 points: Airy's and the photosite's transfer, transformed every half a nanometre."""
    surface, pitch_um, f_number, edge_um = measured_finely(), 3.45, 8.0, 0.3
    camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=f_number))
    light, far_um = Light("E", illuminance_lux=1000.0), 4e6
    half_plane = camsim.Rectangle(
        width_um=far_um, height_um=far_um, centre_um=(0.5 * far_um + edge_um, 0.0), reflectance=surface
    )
    frame = camera.expose(
        camsim.Scene(background=0.0, shapes=[half_plane]),
        light=light,
        exposure=camsim.Exposure(time_s=0.01, iso=100.0),
        region=camsim.Region(rows=1, cols=6),
        noise=False,
        tolerance=1e-6,
    )
    samples = camera.samples(light, [surface])
    weight = camera.electrons_per_reflectance(samples, 0.01)[0] * surface.at(samples.wavelength_nm)
    _, band = np.unique(np.floor(2.0 * samples.wavelength_nm), return_inverse=True)
    total = np.bincount(band, weight)
    nm = np.bincount(band, weight * samples.wavelength_nm)[total > 0.0] / total[total > 0.0]
    blur_um, x_um = nm * 1e-3 * f_number, (np.arange(6) - 2.5) * pitch_um - edge_um
    nodes, weights = np.polynomial.legendre.leggauss(300)
    s = 0.5 * (1.0 + nodes)
    otf = 2.0 / np.pi * (np.arccos(s) - s * np.sqrt(1.0 - s * s))
    transfer = 0.5 * weights * otf * np.sinc(s * camera.photosite.area_um2**0.5 / blur_um[:, None]) / s
    turns = np.sin(2.0 * np.pi * s * x_um[:, None, None] / blur_um[:, None])
    expected = (0.5 + np.einsum("xws,ws->xw", turns, transfer) / np.pi) @ total[total > 0.0]
    np.testing.assert_allclose(frame.mean_electrons[0], expected, atol=2e-6 * weight.sum())
