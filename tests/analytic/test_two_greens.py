"""Two greens: channels of their own behind filters of one colour, which files and previews show as Bayer's."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import rawpy

import camsim
from camsim.errors import CamsimError
from camsim.files.preview import develop

NM = (400.0, 500.0, 600.0, 700.0)
CURVES = {
    "R": (0.0, 0.05, 0.6, 0.3),
    "Gr": (0.05, 0.5, 0.3, 0.05),
    "Gb": (0.05, 0.45, 0.24, 0.02),
    "B": (0.5, 0.25, 0.02, 0.0),
}
LIGHT = camsim.Light(camsim.Curve((400.0, 700.0), (1.0, 1.0)), illuminance_lux=800.0)


def camera(pattern: str = "RGGB", **curves: tuple[float, ...]) -> camsim.Camera:
    given = [(name, camsim.Curve(NM, values, outside="zero")) for name, values in (CURVES | curves).items()]
    whole = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=4.0))
    efficiency = camsim.QuantumEfficiency(given, per="photon", peak="as given")
    return whole.replace(
        cfa=camsim.Cfa.bayer(pattern), quantum_efficiency=efficiency, filters=(), olpf=None, prnu=None, crosstalk=None
    )


def taken(of: camsim.Camera, **how: object) -> camsim.Frame:
    return of.expose(
        camsim.Scene(background=0.6),
        light=LIGHT,
        exposure=camsim.Exposure(time_s="auto", iso=200),
        region=camsim.Region(rows=64, cols=64),
        tolerance=1e-4,
        products=("mosaic", "truth"),
        **how,  # type: ignore[arg-type]
    )


@pytest.mark.parametrize("pattern", ["RGGB", "BGGR", "GRBG", "GBRG"])
def test_each_green_has_the_electrons_of_its_own_curve(pattern: str) -> None:
    frame = taken(camera(pattern), noise=False)
    assert frame.channels == ("R", "G", "B", "g")
    # Photons of an even light are in proportion to the wavelength: by the trapezoids' integrals of curve times λ.
    nm = np.linspace(400.0, 700.0, 30_001)
    wanted = {name: np.trapezoid(nm * np.interp(nm, NM, values), nm) for name, values in CURVES.items()}
    for row in range(2):
        for col in range(2):
            letter, in_row = pattern[2 * row + col], pattern[2 * row : 2 * row + 2]
            name = letter if letter != "G" else "Gr" if "R" in in_row else "Gb"
            share = frame.mean_electrons[row, col] / frame.mean_electrons.max()
            assert share == pytest.approx(wanted[name] / max(wanted.values()), rel=1e-6)
    assert frame.truth is not None
    assert frame.truth.shape == (64, 64, 4)


def test_a_sensors_file_says_the_same(tmp_path: Path) -> None:
    curves = ", ".join(f"{name}: {{wavelength_nm: {list(NM)}, values: {list(v)}}}" for name, v in CURVES.items())
    changes = [
        "light={table: {wavelength_nm: [400, 700], values: [1, 1]}, illuminance_lux: 800}",
        f"sensor.quantum_efficiency={{curves: {{{curves}}}, per: photon, peak: as given}}",
        *("sensor.filters=[]", "sensor.olpf=null", "sensor.charge.prnu=null", "exposure={time_s: auto, iso: 200}"),
        *("region={rows: 64, cols: 64}", "render.tolerance=1e-4", "noise.seed=3", "scene.background.reflectance=0.6"),
        *("lens={kind: airy, f_number: 4}", "scene.shapes=[]"),
    ]
    frame = camsim.capture("flat-field", sensor="d40-like", overrides=changes)
    assert frame.cfa_pattern == ("RG", "gB")
    assert np.array_equal(frame.mosaic, taken(camera(), seed=3).mosaic)
    with pytest.raises(CamsimError, match=r"curves: has G beside Gr, or g beside Gb, which are one"):
        camsim.capture("flat-field", overrides=[*changes, f"sensor.quantum_efficiency.curves={{G: 1, {curves}}}"])


def test_raw_programs_see_a_bayer_array(tmp_path: Path) -> None:
    """In the colours of the mean green; what the greens differ by is in the codes, as of a real camera."""
    frame = taken(camera(), noise=False)
    camsim.save(frame, tmp_path / "a.dng")
    with rawpy.imread(str(tmp_path / "a.dng")) as raw:
        assert raw.num_colors == 3
        assert raw.color_desc == b"RGBG"
        assert raw.raw_pattern.tolist() in ([[0, 1], [3, 2]], [[0, 1], [1, 2]])
        assert np.array_equal(raw.raw_image, frame.mosaic)
        balance = np.array(raw.camera_whitebalance[:3])
    red, (first, second), blue = (
        frame.signal_dn[0, 0], (frame.signal_dn[0, 1], frame.signal_dn[1, 0]), frame.signal_dn[1, 1]
    )  # fmt: skip
    assert first > 1.1 * second
    neutral = np.array([red, (first + second) / 2, blue])
    np.testing.assert_allclose(balance / balance[1], neutral[1] / neutral, rtol=2e-3)
    grey = develop(frame)[8:-8, 8:-8].astype(float).mean(axis=(0, 1))
    assert np.ptp(grey) <= 3.0
    again = camsim.measure.picture_of_frame(frame)
    assert sorted({plane.name for plane in again.planes}) == ["B", "G", "R", "g"]


def test_equal_greens_are_one(tmp_path: Path) -> None:
    equal = taken(camera(Gb=CURVES["Gr"]), seed=5)
    one = camera().replace(
        quantum_efficiency=camsim.QuantumEfficiency(
            [(n[0], camsim.Curve(NM, v, outside="zero")) for n, v in CURVES.items() if n != "Gb"],
            per="photon",
            peak="as given",
        ),
        cfa=camsim.Cfa.bayer("RGGB"),
    )
    usual = taken(one, seed=5)
    assert np.array_equal(equal.mosaic, usual.mosaic)
    assert np.array_equal(develop(equal), develop(usual))


def test_greens_without_rows_of_their_own_are_refused() -> None:
    with pytest.raises(CamsimError, match=r"curves of Gr and Gb, and no row of the cfa has green and blue without red"):
        camera().replace(cfa=camsim.Cfa(("RGB",)))
