"""A capture that hands its codes over as they are finished is the capture that holds them."""

import dataclasses

import numpy as np
import pytest

import camsim
from camsim.errors import InvalidValueError, OutputError
from camsim.files import save, writing_rows
from camsim.rendering.boundary import image as boundary_image
from camsim.rendering.waves.plan import WavesPlan

SCENE = camsim.Scene(
    background=0.9,
    shapes=[camsim.Rectangle(width_um=250.0, height_um=250.0, rotate_deg=4.0, reflectance=0.05)],
)
HOW = {
    "light": camsim.Light("D55", illuminance_lux=5000.0),
    "exposure": camsim.Exposure(time_s=0.01, iso=200.0),
    "region": camsim.Region(rows=301, cols=60, origin=(701, 1203)),
    "seed": 7,
    "frame_number": 3,
}


@pytest.fixture(autouse=True)
def small_bands(monkeypatch):
    monkeypatch.setattr(boundary_image, "BAND_PHOTOSITES", 1000)


def everything(camera):
    """A camera with every stage that knows of rows."""
    return camera.replace(
        crosstalk=camsim.Crosstalk(((0.005, 0.01, 0.0), (0.02, 0.94, 0.005), (0.01, 0.01, 0.0))),
        flicker_rows=camsim.FlickerRows(sigma_e=4.0),
        row_noise=camsim.RowNoise(sigma_e=3.0),
        column_noise=camsim.ColumnNoise(sigma_e=3.0),
        falloff=camsim.Cos4Falloff(exit_pupil_mm=30.0),
        veiling_glare=0.05,
        defects=camsim.Defects(hot_fraction=0.01, hot_e_per_s=1e5, dead_fraction=0.01),
        adc=dataclasses.replace(camera.adc, black_offsets_dn=((0, 3), (5, 7), (9, 11))),
    )


@pytest.mark.parametrize("kind", ["d40-like", "everything", "blooming", "mono-345", "flat", "clean"])
def test_the_rows_are_those_of_the_frame(kind):
    camera = camsim.Camera.from_yaml("mono-345" if kind == "mono-345" else "d40-like", lens=camsim.Airy(f_number=8.0))
    how = dict(HOW)
    if kind in ("everything", "blooming"):
        camera = everything(camera)
    if kind == "blooming":
        camera = camera.replace(full_well=camsim.FullWell(20_000.0), blooming=camsim.Blooming(spill=0.5))
    if kind == "clean":
        how["noise"] = False
    scene = camsim.Scene(background=0.5) if kind == "flat" else SCENE
    whole = camera.expose(scene, **how)
    rows = []
    frame = camsim.Capture(camera=camera, scene=scene, **how).rows(rows.append)
    np.testing.assert_array_equal(np.concatenate(rows), whole.mosaic)
    assert len(rows) == {"blooming": 1, "flat": 2}.get(kind, 5)
    assert frame.shape == whole.shape == (301, 60)
    assert frame.mosaic.shape == frame.electrons.shape == frame.mean_electrons.shape == (0, 60)
    assert frame.description == whole.description
    assert frame.report.error_estimate == whole.report.error_estimate
    for got, want in zip(frame.report.signal, whole.report.signal, strict=True):
        assert dataclasses.asdict(got) == pytest.approx(dataclasses.asdict(want))


def test_bands_are_the_image_that_is_made_at_once(monkeypatch):
    grid = camsim.Grid(rows=70, cols=9, pitch_um=4.88)
    optics = [camsim.Airy(f_number=8.0), camsim.SquarePhotosite(side_um=4.88)]
    images = []
    for photosites in (1 << 20, 1):
        monkeypatch.setattr(boundary_image, "BAND_PHOTOSITES", photosites)
        images.append(camsim.render(SCENE, optics, grid, wavelength_nm=550.0, tolerance=1e-4, method="boundary").image)
    assert np.ptp(images[0]) > 0.2
    np.testing.assert_allclose(images[1], images[0], atol=1e-12)


def test_rows_of_a_picture_come_tile_by_tile(monkeypatch):
    """With edges in front of it."""
    camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8.0))
    samples = np.random.default_rng(1).uniform(0.1, 0.9, (12, 12))
    picture = camsim.Picture(planes=[samples], spectra=[1.0], width_um=500.0)
    disc = camsim.Disc(radius_um=40.0, reflectance=0.0)
    scene = camsim.Scene(background=0.5, shapes=[picture, disc])
    how = HOW | {"region": camsim.Region(rows=1400, cols=20)}
    capture = camsim.Capture(camera=camera, scene=scene, **how, noise=False, tolerance=1e-3)
    whole = capture.frame().mosaic
    bands = []
    carried = WavesPlan.bands
    monkeypatch.setattr(
        WavesPlan,
        "bands",
        lambda self, *given: (bands.append(len(band)) or band for band in carried(self, *given)),
    )
    rows = []
    capture.rows(rows.append)
    assert len(bands) == 3
    assert sum(bands) == 1400
    full_dn = float(whole.max())
    np.testing.assert_allclose(np.concatenate(rows).astype(float), whole, atol=1.0 + 2e-3 * full_dn)


def test_the_truth_does_not_come_row_by_row():
    camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8.0))
    with pytest.raises(InvalidValueError, match="products: truth; row by row there are mosaic and spectral"):
        camsim.Capture(camera=camera, scene=SCENE, **HOW).rows(print, products=("truth",))


@pytest.mark.parametrize(("sensor", "compress"), [("d40-like", True), ("mono-345", False)])
def test_a_file_written_row_by_row_has_the_same_bytes(tmp_path, sensor, compress):
    camera = camsim.Camera.from_yaml(sensor, lens=camsim.Airy(f_number=8.0))
    save(camera.expose(SCENE, **HOW), tmp_path / "whole.dng", compress=compress)
    with writing_rows(tmp_path / "rows.dng", camera=camera, region=HOW["region"], compress=compress) as writer:
        writer.finish(camsim.Capture(camera=camera, scene=SCENE, **HOW).rows(writer.take))
    assert (tmp_path / "rows.dng").read_bytes() == (tmp_path / "whole.dng").read_bytes()


def test_a_file_that_is_there_stays_unless_forced(tmp_path):
    camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8.0))
    (tmp_path / "a.dng").write_bytes(b"old")
    with (
        pytest.raises(OutputError, match="it exists; overwrite it with force=True"),
        writing_rows(tmp_path / "a.dng", camera=camera, region=HOW["region"]),
    ):
        pass
    assert (tmp_path / "a.dng").read_bytes() == b"old"


def test_a_capture_that_fails_half_way_leaves_the_old_file(tmp_path):
    camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8.0))
    (tmp_path / "a.dng").write_bytes(b"old")

    def one_band_then_stop():
        with writing_rows(tmp_path / "a.dng", camera=camera, region=HOW["region"], force=True) as writer:
            writer.take(np.zeros((64, 60), np.uint16))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        one_band_then_stop()
    assert (tmp_path / "a.dng").read_bytes() == b"old"
    assert [path.name for path in tmp_path.iterdir()] == ["a.dng"]
