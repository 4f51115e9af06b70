"""strict: an error above the tolerance is a failure that says where; without it a warning in the report."""

import dataclasses

import numpy as np
import pytest
from examples import OPTICS, PICTURE, TOLERANCE, WAVELENGTH_NM, grid_of, scene_of, worst

import camsim
from camsim.errors import AccuracyError
from camsim.optics import OpticalSystem
from camsim.rendering.boundary import engine as boundary_engine
from camsim.rendering.render import plan_render, render_channels
from camsim.rendering.waves.image import FrequencyImage


def rendered(method, *, optics=OPTICS["f/8"], tolerance=TOLERANCE, strict=False, samples=None, **window):
    return camsim.render(
        scene_of(PICTURE),
        optics,
        grid_of(24, 24, **window),
        wavelength_nm=WAVELENGTH_NM,
        method=method,
        tolerance=tolerance,
        strict=strict,
        samples=samples,
    )


@pytest.mark.parametrize("method", ["area", "uniform", "uniform-pixel", "importance"])
def test_a_method_that_is_not_accurate_enough_fails(method):
    found = rendered(method)
    assert found.error_estimate > TOLERANCE
    with pytest.raises(
        AccuracyError, match=r"photosite \[\d+, \d+\] is off by .*tolerance is 1e-06 \(method"
    ) as raised:
        rendered(method, strict=True)
    assert "use method boundary, or allow more" in str(raised.value)
    assert f"{found.error_estimate:.2g}" in str(raised.value)


@pytest.mark.parametrize("method", ["boundary", "fourier", "auto"])
def test_an_accurate_one_does_not(method):
    assert worst(rendered(method, strict=True).image, rendered(method).image) == 0.0


def test_the_place_is_where_the_error_is(monkeypatch):
    """One photosite of the frame is corrupted: it is the one that is named, in the frame's own rows and columns."""
    row, col = corrupt(monkeypatch, 1e-3, lambda channel: True)
    place = rf"photosite \[{row + 100}, {col + 50}\] is off by 0.001,"
    with pytest.raises(AccuracyError, match=place):
        rendered("boundary", strict=True, origin=(100, 50), frame=(224, 124))


@pytest.mark.parametrize("off", [0.5, 2.0])
def test_what_is_beyond_the_tolerance_is_refused_and_no_more(monkeypatch, off):
    corrupt(monkeypatch, off * 1e-3, lambda channel: True)
    if off < 1.0:
        assert rendered("boundary", tolerance=1e-3, strict=True).error_estimate == pytest.approx(off * 1e-3, rel=0.1)
    else:
        with pytest.raises(AccuracyError, match=r"is off by 0\.002, and the tolerance is 0\.001"):
            rendered("boundary", tolerance=1e-3, strict=True)


@pytest.mark.parametrize("every_channel", [False, True])
def test_strict_looks_at_every_plane_that_is_asked_for(monkeypatch, every_channel):
    """Only the second channel's plane is corrupted, at a photosite that is the first channel's."""
    channel = np.zeros((24, 24), np.uint8)
    channel[0, 0] = 1
    corrupt(monkeypatch, 1e-3, lambda channel: (channel == 1).all())

    def rendered_channels():
        return render_channels(
            scene_of(PICTURE),
            OpticalSystem.of(OPTICS["f/8"]),
            grid_of(24, 24),
            response=np.ones((2, 1)),
            wavelength_nm=np.array([WAVELENGTH_NM]),
            channel=channel,
            tolerance=TOLERANCE,
            method="boundary",
            every_channel=every_channel,
            strict=True,
        )

    if every_channel:
        with pytest.raises(AccuracyError, match=r"is off by 0\.001"):
            rendered_channels()
    else:
        assert rendered_channels().error_estimate <= TOLERANCE


def corrupt(monkeypatch, by, where):
    """Raise one of the photosites that are checked, in images of which ``where`` says so of the channels."""
    run = boundary_engine.BoundaryPlan
    true_bands = run.bands
    row, col = (int(i[0]) for i in camsim_hardest())

    def corrupted(self, channel, progress):
        for band in true_bands(self, channel, progress):
            band[row, col] += by if where(channel) else 0.0
            yield band

    monkeypatch.setattr(run, "bands", corrupted)
    return row, col


def camsim_hardest():
    """Rows and columns that are checked of the 24 × 24 window, from a job of the same scene."""
    choice = plan_render(
        scene_of(PICTURE),
        OpticalSystem.of(OPTICS["f/8"]),
        grid_of(24, 24, origin=(100, 50), frame=(224, 124)),
        response=np.ones((1, 1)),
        wavelength_nm=np.array([WAVELENGTH_NM]),
        tolerance=TOLERANCE,
        method="boundary",
    )
    return choice.checker.hardest(choice.plan)


def test_a_capture_warns_or_fails(monkeypatch):
    plan = boundary_engine.plan_boundary

    def careless(*args, **kwargs):
        return dataclasses.replace(plan(*args, **kwargs), field_step=1.5, panel=4.0)

    monkeypatch.setattr(boundary_engine, "plan_boundary", careless)
    camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=8.0))
    pitch = camera.pitch_um
    scene = camsim.Scene(
        background=0.9, shapes=[camsim.Rectangle(width_um=6 * pitch, height_um=7 * pitch, reflectance=0.1)]
    )
    how = {
        "light": camsim.Light("D55", illuminance_lux=1000.0),
        "exposure": camsim.Exposure(time_s=0.01, iso=100.0),
        "region": camsim.Region(rows=20, cols=20),
    }
    warned = camera.expose(scene, **how).report
    assert warned.error_estimate > warned.tolerance
    assert warned.notes[0].code == "error-above-tolerance"
    with pytest.raises(AccuracyError, match="report this as a bug of camsim, or allow more"):
        camera.expose(scene, strict=True, **how)


def test_importance_says_what_chance_has_left():
    """A quarter of the spread for sixteen times the samples; about the error that is really there."""
    few, many = (rendered("importance", samples=n) for n in (500, 8000))
    assert few.standard_error / many.standard_error == pytest.approx(4.0, rel=0.1)
    assert 0.02 * few.standard_error < few.error_estimate < 4.0 * few.standard_error
    for method in ("area", "uniform", "boundary", "fourier"):
        assert rendered(method).standard_error is None


class Coma:
    """A lens of the user's own: an Airy pattern, smeared to one side."""

    place = "lens"

    def otf(self, fx_per_um, fy_per_um, wavelength_nm):
        blur = np.exp(-2j * np.pi * 1.5 * fx_per_um) * 0.3 + 0.7
        return camsim.Airy(f_number=8.0).otf(fx_per_um, fy_per_um, wavelength_nm) * blur

    def cutoff_per_um(self, wavelength_nm):
        return camsim.Airy(f_number=8.0).cutoff_per_um(wavelength_nm)


def test_fourier_judges_itself_where_nothing_else_can(monkeypatch):
    """A lens that is not round: photosites of its own, by other periods and levels; a corrupted image is seen."""
    optics = [Coma(), camsim.SquarePhotosite(side_um=4.0)]
    honest = rendered("auto", optics=optics, tolerance=1e-8)
    assert honest.method == "fourier"
    assert honest.error_estimate <= 1e-8
    assert honest.checked_photosites >= 4
    true_planes = FrequencyImage.planes

    def corrupted(self, first, shape):
        for row, col, light in true_planes(self, first, shape):
            yield row, col, light * (1.0 + 1e-5) if shape == (24, 24) else light

    monkeypatch.setattr(FrequencyImage, "planes", corrupted)
    assert rendered("auto", optics=optics, tolerance=1e-8).error_estimate > 1e-6


def test_what_checks_pictures_hears_all_of_what_is_far_away():
    """A hundredth of the light of a picture of 400 pitches comes from beyond 20: summed by middles of its samples."""
    square = {"width_um": 1600.0, "centre_um": (3.0, -2.0), "rotate_deg": 7.0}
    picture = camsim.Picture(planes=np.full((100, 100), 0.9), **square)
    drawn = camsim.Rectangle(height_um=1600.0, reflectance=0.9, **square)
    grid, tolerance = grid_of(9, 11), 1e-3
    right = camsim.render(
        camsim.Scene(background=0.0, shapes=[drawn]),
        OPTICS["f/8"],
        grid,
        wavelength_nm=WAVELENGTH_NM,
        tolerance=1e-8,
        method="boundary",
    ).image
    choice = plan_render(
        camsim.Scene(background=0.0, shapes=[picture]),
        OpticalSystem.of(OPTICS["f/8"]),
        grid,
        response=np.ones((1, 1)),
        wavelength_nm=np.array([WAVELENGTH_NM]),
        tolerance=tolerance,
        method="fourier",
    )
    rows, cols = np.array([0, 5, 8]), np.array([0, 5, 2])
    found = choice.checker.values(rows, cols, np.zeros(3, np.uint8))
    assert worst(found, right[rows, cols]) <= tolerance / 40.0
