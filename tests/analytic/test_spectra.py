"""Curves and named spectra against published values and closed forms."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from camsim.errors import InvalidValueError
from camsim.sensor.quantum_efficiency import QuantumEfficiency
from camsim.spectra import pca
from camsim.spectra.curve import Curve, spectrum_at
from camsim.spectra.light import Light
from camsim.spectra.named import (
    illuminant,
    illuminant_names,
    photopic_observer,
    reflectance,
    reflectance_names,
    sensitivities,
    sensitivity_names,
)


def test_a_curve_is_straight_between_its_points() -> None:
    curve = Curve((400.0, 500.0, 520.0), (0.0, 1.0, 0.2))
    np.testing.assert_allclose(curve.at(np.array([425.0, 500.0, 505.0])), [0.25, 1.0, 0.8], rtol=1e-15)


@pytest.mark.parametrize(("outside", "expected"), [("zero", [0.0, 0.0]), ("hold", [0.3, 0.7])])
def test_beyond_its_table_a_curve_is_zero_or_held(outside: str, expected: list[float]) -> None:
    curve = Curve((400.0, 500.0), (0.3, 0.7), outside=outside)  # type: ignore[arg-type]
    np.testing.assert_array_equal(curve.at(np.array([399.9, 500.1])), expected)
    np.testing.assert_array_equal(curve.at(np.array([400.0, 500.0])), [0.3, 0.7])


def test_a_number_is_the_same_at_every_wavelength() -> None:
    np.testing.assert_array_equal(spectrum_at(0.18, np.array([300.0, 900.0])), [0.18, 0.18])


def test_lists_and_arrays_become_tuples_so_that_curves_can_be_compared() -> None:
    assert Curve([400, 500], np.array([0.0, 1.0])) == Curve((400.0, 500.0), (0.0, 1.0))  # type: ignore[arg-type]


def test_published_values_of_illuminants_and_of_the_eye() -> None:
    assert illuminant("D65").at(np.array([450.0, 560.0])).tolist() == [117.008, 100.0]
    assert illuminant("D55").at(np.array([560.0])).tolist() == [100.0]
    assert illuminant("FL2").at(np.array([435.0])).tolist() == [34.98]
    assert illuminant("E").at(np.array([380.0, 700.0])).tolist() == [100.0, 100.0]
    assert photopic_observer().at(np.array([510.0, 555.0, 610.0])).tolist() == [0.503, 1.0, 0.503]


def test_daylight_goes_on_to_830_nm_as_cie_15_prints_it() -> None:
    """Table T.1 of CIE 15 has D65 to 830 nm; the table that names are looked up in ends at 780 nm."""
    printed = {785.0: 63.8434, 790.0: 64.3040, 800.0: 59.4519, 810.0: 51.9590, 820.0: 57.4406, 830.0: 60.3125}
    found = illuminant("D65").at(np.array(list(printed)))
    np.testing.assert_allclose(found, list(printed.values()), rtol=1e-5)
    np.testing.assert_array_equal(illuminant("D65").at(np.array([299.9, 830.1])), 0.0)


def test_fluorescent_lamps_go_by_both_of_their_names() -> None:
    assert illuminant("F11") == illuminant("FL11")
    assert illuminant("F3.1") == illuminant("FL3.1")


def test_the_24_patches_come_in_the_order_of_the_chart() -> None:
    names = reflectance_names()[:24]
    assert (names[0], names[5], names[18], names[23]) == ("dark skin", "bluish green", "white 9.5", "black 2")
    greys = [reflectance(name).at(np.array([550.0]))[0] for name in names[18:]]
    # Munsell value 9.5 … 2 by the luminance factors of ASTM D1535, relative to a perfect diffuser.
    np.testing.assert_allclose(greys, [0.900, 0.591, 0.362, 0.198, 0.090, 0.031], atol=0.015)


def test_every_named_reflectance_is_a_fraction() -> None:
    for name in reflectance_names():
        assert 0.0 <= min(reflectance(name).values) <= max(reflectance(name).values) <= 1.0, name


def test_every_illuminant_has_light_that_the_eye_sees() -> None:
    assert len(illuminant_names()) > 40
    nm = np.arange(360.0, 831.0)
    for name in illuminant_names():
        assert np.sum(illuminant(name).at(nm) * photopic_observer().at(nm)) > 0.0, name


def test_every_camera_has_red_green_and_blue_where_they_belong() -> None:
    assert "Nikon 5100 (NPL)" in sensitivity_names()
    nm = np.arange(380.0, 781.0)
    for name in sensitivity_names():
        curves = sensitivities(name)
        centres = [np.average(nm, weights=curves[letter].at(nm)) for letter in "BGR"]
        assert centres == sorted(centres), name


def test_colour_science_is_loaded_late() -> None:
    modules = "camsim.spectra.light, camsim.spectra.named, camsim.sensor.chain, camsim.sensor.exposure"
    code = f"import sys, {modules}; sys.exit('colour' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_colour_science_leaves_no_trace_in_numpy_or_in_the_warnings() -> None:
    code = (
        "import warnings, numpy as np\n"
        "warnings.simplefilter('error')\n"
        "before = np.get_printoptions(), np.geterr(), list(warnings.filters)\n"
        "from camsim.spectra.colour_science import colour_science; colour_science()\n"
        "assert before == (np.get_printoptions(), np.geterr(), list(warnings.filters))\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_illuminant_a_follows_the_formula_that_defines_it() -> None:
    """CIE 15: a Planckian radiator with c2 = 1.435e7 nm K at 2848 K, 100 at 560 nm; it goes on to 1100 nm."""
    nm = np.arange(300.0, 1101.0, 5.0)
    planck = (560.0 / nm) ** 5 * np.expm1(1.435e7 / (2848 * 560.0)) / np.expm1(1.435e7 / (2848 * nm))
    np.testing.assert_allclose(illuminant("A").at(nm), 100.0 * planck, rtol=2e-5)


RELATIVE = (("R", Curve((500.0, 600.0, 700.0), (0.0, 3.0, 0.0))), ("B", Curve((400.0, 500.0), (2.4, 0.0))))


def test_curves_per_energy_are_divided_by_the_wavelength() -> None:
    """Per photon the blue curve is the higher one: 2.4/400 = 6e-3 against 3/600 = 5e-3."""
    efficiency = QuantumEfficiency(RELATIVE, per="energy", peak=0.6)
    np.testing.assert_allclose(
        efficiency.at(np.array([400.0, 600.0, 650.0])),
        [[0.0, 0.5, 0.6 * (1.5 / 650) / 6e-3], [0.6, 0.0, 0.0]],
        rtol=1e-12,
    )


def test_curves_per_photon_are_only_scaled() -> None:
    efficiency = QuantumEfficiency(RELATIVE, per="photon", peak=0.6)
    np.testing.assert_allclose(efficiency.at(np.array([400.0, 600.0])), [[0.0, 0.6], [0.48, 0.0]], rtol=1e-12)


@pytest.mark.parametrize("per", ["energy", "photon"])
@pytest.mark.parametrize("name", ["Nikon 5100 (NPL)", "Sigma SDMerill (NPL)"])
def test_the_peak_is_reached_and_never_passed(name: str, per: str) -> None:
    curves = tuple(sensitivities(name).items())
    fine = QuantumEfficiency(curves, per=per, peak=0.42).at(np.linspace(380.0, 780.0, 40_001))  # type: ignore[arg-type]
    assert fine.max() == pytest.approx(0.42, rel=1e-12)


@pytest.mark.parametrize("chosen", ["BR", "R", "G", "B"])
def test_a_selection_of_channels_keeps_its_scale(chosen: str) -> None:
    """Whether the channel that has the peak is among them or not."""
    nm = np.linspace(400.0, 700.0, 31)
    whole = QuantumEfficiency.named("Nikon 5100 (NPL)", peak=0.42)
    part = whole.select(tuple(chosen))
    assert part.channels == tuple(chosen)
    np.testing.assert_allclose(part.at(nm), whole.at(nm)[["RGB".index(letter) for letter in chosen]], rtol=1e-12)
    with pytest.raises(InvalidValueError, match="no curve for Y; there are R, G, B"):
        whole.select(("Y",))


def test_a_cube_of_two_spectra_is_two_planes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever its size: its samples are taken in parts."""
    monkeypatch.setattr(pca, "_PART", 7)
    rng, nm = np.random.default_rng(5), np.array([450.0, 500.0, 600.0, 700.0])
    cube = np.einsum("rck,kb->rcb", rng.random((4, 5, 2)), 0.5 * rng.random((2, 4)))
    for error, count in ((1e-9, 2), (0.0, 4)):
        planes, components = pca.planes_of_cube(cube, nm, error=error)
        assert planes.shape == (count, 4, 5)
        spectra = [component.at(nm) for component in components]
        np.testing.assert_allclose(np.einsum("prc,pb->rcb", planes, spectra), cube, atol=1e-9)
    black_and_white = cube.copy()
    black_and_white[0, 0], black_and_white[3, 4] = 0.0, 1.0
    planes, components = pca.planes_of_cube(black_and_white, nm, error=0.0)
    spectra = [component.at(nm) for component in components]
    np.testing.assert_allclose(np.einsum("prc,pb->rcb", planes, spectra), black_and_white, atol=1e-12)
    for sample, said in ((1.5, "not 1.5"), (-0.1, "not -0.1")):
        wrong = cube.copy()
        wrong[1, 2, 3] = sample
        with pytest.raises(InvalidValueError, match=f"must be reflectances from 0 to 1, {said}; divide"):
            pca.planes_of_cube(wrong, nm, error=1e-3)


def test_a_line_is_at_most_a_fifth_as_wide_as_its_wavelength() -> None:
    assert Light(line_nm=500.0, width_nm=100.0, illuminance_lux=1.0).width_nm == 100.0
    with pytest.raises(InvalidValueError, match="must be at most 100 nm, a fifth of line_nm, not 101"):
        Light(line_nm=500.0, width_nm=101.0, illuminance_lux=1.0)
