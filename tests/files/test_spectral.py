"""The spectral cube: radiance by its definition, electrons that follow from it, and the file that holds it."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import OpenEXR
import pytest

import camsim
from camsim.camera.frame import Frame
from camsim.errors import OutputError, UnsupportedError
from camsim.files import save
from camsim.files.exr_stream import write_exr
from camsim.spectra.colour_science import colour_science

PLANCK_J_S, LIGHT_M_PER_S = 6.62607015e-34, 299_792_458.0
LINE = camsim.Light(line_nm=550.0, illuminance_lux=5000.0)
DAYLIGHT = camsim.Light("D55", illuminance_lux=5000.0)


def camera() -> camsim.Camera:
    return camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8.0, transmission=0.9))


def scene() -> camsim.Scene:
    shape = camsim.Rectangle(width_um=30.0, height_um=22.0, centre_um=(3.0, 1.0), rotate_deg=9.0, reflectance=0.1)
    return camsim.Scene(background=camsim.reflectance("orange"), shapes=[shape])


def exposed(light: camsim.Light, **how: object) -> Frame:
    settings: dict[str, object] = {
        "exposure": camsim.Exposure(time_s=0.01, iso=200.0),
        "region": camsim.Region(rows=19, cols=12),
        "products": ("mosaic", "truth", "spectral"),
        "noise": False,
    }
    return camera().expose(scene(), light=light, **{**settings, **how})


def read(path: Path) -> tuple[Mapping[str, object], dict[str, np.ndarray]]:
    file = OpenEXR.File(str(path), separate_channels=True)
    return file.header(), {name: channel.pixels for name, channel in file.channels().items()}


def electrons_of(frame: Frame, wavelength_nm: np.ndarray, radiance: np.ndarray, width_nm: float) -> np.ndarray:
    """Integrate radiance (n, rows, cols) to electrons: π/(4N²), transmission, photons, efficiency, area, time."""
    body = camera()
    efficiency = body.quantum_efficiency.select(frame.channels).at(wavelength_nm)
    photons_per_j = wavelength_nm * 1e-9 / (PLANCK_J_S * LIGHT_M_PER_S)
    area_m2 = body.photosite.area_um2 * 1e-12
    weight = efficiency * photons_per_j * 0.9 * np.pi / (4 * 8.0**2) * area_m2 * 0.01 * width_nm
    return np.einsum("cn,nrk->rkc", weight, radiance)


def test_electrons_follow_from_the_radiance_of_a_line(tmp_path: Path) -> None:
    frame = exposed(LINE)
    save(frame, tmp_path / "a.exr", product="spectral")
    header, planes = read(tmp_path / "a.exr")
    assert set(planes) == {"S0.550,000000nm"}
    assert header["emissiveUnits"] == "W.m^-2.sr^-1"
    found = electrons_of(frame, np.array([550.0]), planes["S0.550,000000nm"][None], 1.0)
    assert frame.truth is not None
    np.testing.assert_allclose(found, frame.truth, rtol=1e-4, atol=2e-6 * frame.truth.max() * 10)


def test_electrons_follow_from_the_radiance_of_daylight(tmp_path: Path) -> None:
    nodes = np.arange(300.0, 831.0, 10.0)
    frame = exposed(DAYLIGHT, spectral_nm=tuple(nodes), tolerance=1e-4)
    save(frame, tmp_path / "a.exr", product="spectral")
    _, planes = read(tmp_path / "a.exr")
    radiance = np.stack([planes[f"S0.{w:.0f},000000nm"] for w in nodes])
    found = electrons_of(frame, nodes, radiance, 10.0)
    # Curves every 5 nm and daylight's lines, sampled every 10.
    np.testing.assert_allclose(found, frame.truth, rtol=0.02)


def test_the_layout_is_that_of_fichet_and_others(tmp_path: Path) -> None:
    frame = exposed(DAYLIGHT)
    save(frame, tmp_path / "a.exr", product="spectral")
    header, planes = read(tmp_path / "a.exr")
    assert header["spectralLayoutVersion"] == "1.0"
    assert header["emissiveUnits"] == "W.m^-2.sr^-1.nm^-1"
    assert header["camsim:product"] == "spectral"
    assert sorted(planes) == [f"S0.{w},000000nm" for w in range(400, 701, 10)]
    assert frame.spectral is not None
    for k, wavelength_nm in enumerate(frame.spectral.wavelength_nm):
        plane, _ = frame.spectral.plane(k)
        np.testing.assert_array_equal(planes[f"S0.{wavelength_nm:.0f},000000nm"], plane)


def test_a_flat_diffuser_has_the_radiance_of_its_light() -> None:
    frame = camera().expose(
        camsim.Scene(background=0.5, shapes=[]),
        light=DAYLIGHT,
        exposure=camsim.Exposure(time_s=0.01, iso=200.0),
        region=camsim.Region(rows=2, cols=2),
        products=("spectral",),
        spectral_nm=(560.0,),
    )
    assert frame.spectral is not None
    plane, error = frame.spectral.plane(0)
    # Watts of the light by the eye's own sum, every nanometre; D55 is 100 at 560 nm.
    colour, nm = colour_science(), np.arange(360.0, 781.0)
    power, eye = colour.SDS_ILLUMINANTS["D55"], colour.SDS_LEFS["CIE 1924 Photopic Standard Observer"]
    weighed = np.interp(nm, power.wavelengths, power.values) @ np.interp(nm, eye.wavelengths, eye.values)
    irradiance = 100.0 * 5000.0 / (683.002 * weighed)
    np.testing.assert_allclose(plane, np.full((2, 2), 0.5 * irradiance / np.pi), rtol=2e-5)
    assert error == 0


def test_a_cube_goes_through_an_ideal_sensor_and_comes_out_the_same(tmp_path: Path) -> None:
    """A capture's radiance in a file, that file as the scene: photosites within a sample that see nothing else."""
    bands = (420.0, 500.0, 560.0, 580.0, 610.0, 700.0)
    taken = exposed(DAYLIGHT, region=camsim.Region(rows=8, cols=8), spectral_nm=bands)
    save(taken, tmp_path / "cube.exr", product="spectral")
    body = camera().replace(
        olpf=None, lens=camsim.Gaussian(sigma_um=0.4), photosite=camsim.SquarePhotosite(side_um=1.0)
    )
    picture = camsim.read_picture(
        tmp_path / "cube.exr", width_um=8 * body.pitch_um, light=DAYLIGHT, tolerance=0.0, interpolation="squares"
    )
    again = body.expose(
        camsim.Scene(background=0.0, shapes=[picture]),
        light=DAYLIGHT,
        exposure=camsim.Exposure(time_s=0.01, iso=200.0),
        region=camsim.Region(rows=8, cols=8),
        products=("spectral",),
        spectral_nm=bands,
        noise=False,
        tolerance=1e-7,
    )
    assert taken.spectral is not None
    assert again.spectral is not None
    for band in range(len(bands)):
        right, found = taken.spectral.plane(band)[0], again.spectral.plane(band)[0]
        assert np.ptp(right) > 0.02 * right.max()
        np.testing.assert_allclose(found, right, rtol=0.0, atol=1e-6 * right.max())


@pytest.mark.parametrize(("rows", "cols"), [(1, 1), (16, 5), (17, 33), (50, 3)])
def test_the_streamed_file_reads_back_exactly(tmp_path: Path, rows: int, cols: int) -> None:
    rng = np.random.default_rng(rows)
    planes = rng.normal(size=(3, rows, cols)).astype(np.float32)
    planes[1] = 0.25
    planes[2, ::2] = np.float32(np.inf)
    write_exr(
        tmp_path / "a.exr",
        rows=rows,
        cols=cols,
        channels=["A", "b", "c.d"],
        attributes={"software": "µ", "one": 1.5},
        block=lambda first, height: planes[:, first : first + height],
    )
    header, found = read(tmp_path / "a.exr")
    for name, plane in zip(("A", "b", "c.d"), planes, strict=True):
        np.testing.assert_array_equal(found[name], plane)
    assert header["software"] == "µ"
    assert header["one"] == 1.5
    assert (tuple(header["screenWindowCenter"]), header["screenWindowWidth"]) == ((0.0, 0.0), 1.0)
    assert header["pixelAspectRatio"] == 1.0


def test_wavelengths_of_four_digits_are_in_their_place(tmp_path: Path) -> None:
    frame = exposed(camsim.Light(blackbody_k=3000.0, irradiance_w_per_m2=100.0), spectral_nm=(500.0, 1000.0))
    save(frame, tmp_path / "a.exr", product="spectral")
    _, planes = read(tmp_path / "a.exr")
    assert frame.spectral is not None
    for k, name in enumerate(("S0.500,000000nm", "S0.1000,000000nm")):
        np.testing.assert_array_equal(planes[name], frame.spectral.plane(k)[0])


def test_mistakes_in_the_light() -> None:
    with pytest.raises(UnsupportedError, match="the light's level is given on the sensor"):
        exposed(camsim.Light("D55", illuminance_lux=10.0, at="sensor"))


def test_a_cube_that_was_not_asked_for(tmp_path: Path, frame: Frame) -> None:
    bare = dataclasses.replace(frame, spectral=None)
    with pytest.raises(OutputError, match=r"the capture holds no spectral; ask for products=\('spectral',\)"):
        save(bare, tmp_path / "a.exr", product="spectral")
