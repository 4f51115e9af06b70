"""Every kind of lens, OLPF and photosite from YAML: what it builds, what its file keeps, and its faults."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from camsim.api import load
from camsim.camera.description import describe
from camsim.config.from_record import stages_from_record
from camsim.core.errors import ConfigError
from camsim.optics import (
    AnnularAiry,
    CircularPhotosite,
    EllipticalGaussian,
    FieldLens,
    FourSpotOlpf,
    Gaussian,
    MeasuredOtf,
    MeasuredPsf,
    PolygonPhotosite,
    Pupil,
    RadialOtf,
    RectangularPhotosite,
    RoundedPhotosite,
    TwoSpotOlpf,
    Wavefront,
)

LENSES = {
    "annular": ("{kind: annular-airy, f_number: 8, obstruction: 0.3}", AnnularAiry(f_number=8.0, obstruction=0.3)),
    "gaussian": ("{kind: gaussian, f_number: 4, sigma_um: 2}", Gaussian(sigma_um=2.0, f_number=4.0)),
    "gaussian by its MTF50": (
        "{kind: gaussian, f_number: 8, mtf50_per_um: 0.1}",
        Gaussian.from_mtf50(0.1),
    ),
    "gaussian ellipse": (
        "{kind: elliptical-gaussian, f_number: 8, sigma_um: 2, sigma_across_um: 1, rotate_deg: 90}",
        EllipticalGaussian.from_axes(sigma_um=2.0, sigma_across_um=1.0, rotate_deg=90.0),
    ),
    "wavefront": (
        "{kind: wavefront, f_number: 8, zernike_waves: [[4, 0.1], [8, -0.05]], reference_nm: 600, defocus_um: 3}",
        Wavefront(f_number=8.0, zernike_waves=((4, 0.1), (8, -0.05)), reference_nm=600.0, defocus_um=3.0),
    ),
    "field": (
        "{kind: field, file: perfect, focus_um: 90}",
        FieldLens(
            f_number=5.6, wavelength_nm=(550,), height_um=(0, 30000), zernike=(4,), waves=(((0,), (0,)),), focus_um=90
        ),
    ),
    "iris": (
        "{kind: wavefront, f_number: 8, pupil: {shape: bladed, blades: 6, obstruction: 0.2, rotate_deg: 15}}",
        Wavefront(f_number=8.0, pupil=Pupil(shape="bladed", blades=6, obstruction=0.2, rotate_deg=15.0)),
    ),
    "radial OTF": (
        "{kind: radial-otf, f_number: 8, freq_per_um: [0, 0.1, 0.2], values: [1, 0.3, 0]}",
        RadialOtf(freq_per_um=(0.0, 0.1, 0.2), values=(1.0, 0.3, 0.0)),
    ),
    "measured pattern": (
        "{kind: measured-psf, f_number: 8, irradiance: [[0, 1, 0], [1, 4, 1], [0, 1, 0]], spacing_um: 2}",
        MeasuredPsf(irradiance=((0, 1, 0), (1, 4, 1), (0, 1, 0)), spacing_um=2.0),
    ),
    "measured transfer": (
        "{kind: measured-otf, f_number: 8, values: [[0, 0, 0, 0, 0], [0, 0.2, 0.4, 0.2, 0], [0, 0.4, 1, 0.4, 0], "
        "[0, 0.2, 0.4, 0.2, 0], [0, 0, 0, 0, 0]], spacing_per_um: 0.1}",
        MeasuredOtf(
            values=np.array([[0, 0, 0, 0, 0], [0, 2, 4, 2, 0], [0, 4, 10, 4, 0], [0, 2, 4, 2, 0], [0, 0, 0, 0, 0]])
            / 10,
            spacing_per_um=0.1,
        ),
    ),
}
SENSORS = {
    "rectangle": (
        "photosite: {kind: rectangular, width_um: 3, height_um: 2}",
        "photosite",
        RectangularPhotosite(width_um=3.0, height_um=2.0),
    ),
    "disc": ("photosite: {kind: circular, diameter_um: 4}", "photosite", CircularPhotosite(diameter_um=4.0)),
    "rounded": (
        "photosite: {kind: rounded, width_um: 4, height_um: 3, radius_um: 1}",
        "photosite",
        RoundedPhotosite(width_um=4.0, height_um=3.0, radius_um=1.0),
    ),
    "L": (
        "photosite: {kind: polygon, points_um: [[-2, -2], [2, -2], [2, 0], [0, 0], [0, 2], [-2, 2]]}",
        "photosite",
        PolygonPhotosite(points_um=((-2, -2), (2, -2), (2, 0), (0, 0), (0, 2), (-2, 2))),
    ),
    "unequal splits": (
        "olpf: {kind: four-spot, split_um: 3, split_y_um: 2, rotate_deg: 10}",
        "olpf",
        FourSpotOlpf(split_um=3.0, split_y_um=2.0, rotate_deg=10.0),
    ),
    "one plate": (
        "olpf: {kind: two-spot, split_um: 3, rotate_deg: 90}",
        "olpf",
        TwoSpotOlpf(split_um=3.0, rotate_deg=90.0),
    ),
    "splits in pitches": (
        "olpf: {kind: four-spot, split_pitches: 0.75, split_y_pitches: 0.5}",
        "olpf",
        FourSpotOlpf.from_pitches(pitch_um=4.0, split_pitches=0.75, split_y_pitches=0.5),
    ),
    "one plate in pitches": (
        "olpf: {kind: two-spot, split_pitches: 0.75, rotate_deg: 45}",
        "olpf",
        TwoSpotOlpf.from_pitches(pitch_um=4.0, split_pitches=0.75, rotate_deg=45.0),
    ),
}
GOOD_LENS, GOOD_PHOTOSITE, GOOD_OLPF = (
    "{kind: airy, f_number: 8}",
    "photosite: {kind: square, fill_factor: 0.81}",
    "olpf: {kind: four-spot, split_um: 3.0}",
)


def kept(stage: object) -> object:
    """What a file would hold of a stage, read back."""
    return stages_from_record(json.loads(json.dumps(describe(stage))))


@pytest.mark.parametrize(("text", "lens"), LENSES.values(), ids=LENSES)
def test_a_kind_of_lens(edited: Callable[..., None], text: str, lens: object) -> None:
    edited(GOOD_LENS, text)
    assert load("scene.yaml").camera.lens == lens
    assert kept(lens) == lens


@pytest.mark.parametrize(("text", "place", "stage"), SENSORS.values(), ids=SENSORS)
def test_a_kind_of_stage_on_the_sensor(edited: Callable[..., None], text: str, place: str, stage: object) -> None:
    edited(GOOD_PHOTOSITE if place == "photosite" else GOOD_OLPF, text, sensor=True)
    assert getattr(load("good.yaml").camera, place) == stage
    assert kept(stage) == stage


@pytest.mark.parametrize("suffix", ["npy", "tiff", "exr"])
def test_a_pattern_from_a_file(folder: Path, edited: Callable[..., None], suffix: str) -> None:
    pattern = np.array([[0, 1, 0.5], [1, 4, 1], [0, 1, 0]], np.float32)
    write_image(folder / f"psf.{suffix}", {"Y": pattern})
    edited(GOOD_LENS, f"{{kind: measured-psf, f_number: 8, file: psf.{suffix}, spacing_um: 2}}")
    rows = tuple(tuple(row) for row in pattern.astype(float).tolist())
    assert load("scene.yaml").camera.lens == MeasuredPsf(irradiance=rows, spacing_um=2.0)


def test_a_complex_transfer_from_a_file(folder: Path, edited: Callable[..., None]) -> None:
    ramp = np.zeros((5, 5), complex)
    ramp[1:4, 1:4] = np.outer(np.ones(3), [0.5 + 0.2j, 1.0, 0.5 - 0.2j])
    ramp[2, 2] = 1.0
    write_image(folder / "otf.exr", {"re": ramp.real.astype(np.float32), "im": ramp.imag.astype(np.float32)})
    edited(GOOD_LENS, "{kind: measured-otf, f_number: 8, file: otf.exr, spacing_per_um: 0.1}")
    lens = load("scene.yaml").camera.lens
    expected = MeasuredOtf(values=ramp, spacing_per_um=0.1)
    np.testing.assert_allclose(lens.values, expected.values, rtol=0, atol=1e-7)  # type: ignore[attr-defined]


def write_image(path: Path, channels: dict[str, np.ndarray]) -> None:
    if path.suffix == ".npy":
        np.save(path, channels["Y"])
    elif path.suffix == ".tiff":
        import tifffile

        tifffile.imwrite(path, channels["Y"])
    else:
        import OpenEXR

        OpenEXR.File({"type": OpenEXR.scanlineimage}, channels).write(str(path))


FAULTS = {
    "no width": (
        "{kind: gaussian, f_number: 8}",
        ["scene.yaml:3:1: lens.sigma_um: missing; give sigma_um, or mtf50_per_um"],
    ),
    "two widths": (
        "{kind: gaussian, f_number: 8, sigma_um: 2, mtf50_per_um: 0.1}",
        [
            "scene.yaml:3:50: lens.mtf50_per_um: given together with 'sigma_um'; a Gaussian has one width, "
            "leave one of the two out"
        ],
    ),
    "a round pattern with two axes": (
        "{kind: gaussian, f_number: 8, sigma_um: 2, sigma_across_um: 1}",
        ["scene.yaml:3:50: lens.sigma_across_um: unknown key of this kind; it is one of kind elliptical-gaussian"],
    ),
    "an iris without blades": (
        "{kind: wavefront, f_number: 8, pupil: {shape: bladed}}",
        ["scene.yaml:3:38: lens.pupil.blades: missing; an iris has 3 blades or more"],
    ),
    "two blades": (
        "{kind: wavefront, f_number: 8, pupil: {shape: bladed, blades: 2}}",
        ["scene.yaml:3:69: lens.pupil.blades: must be 3 to 64 of an iris, not 2"],
    ),
    "too large an obstruction": (
        "{kind: wavefront, f_number: 8, pupil: {shape: bladed, blades: 4, obstruction: 0.7}}",
        [
            "scene.yaml:3:85: lens.pupil.obstruction: must be at most 0.672, "
            "what leaves an opening of this shape, not 0.7"
        ],
    ),
    "an index that is none": (
        "{kind: wavefront, f_number: 8, zernike_waves: [[-1, 0.1]]}",
        ["scene.yaml:3:53: lens.zernike_waves: item 0.0 must be a whole number from 0 to 230, not -1"],
    ),
    "an index twice": (
        "{kind: wavefront, f_number: 8, zernike_waves: [[4, 0.1], [4, 0.2]]}",
        ["scene.yaml:3:53: lens.zernike_waves: an index is given twice; add the two up"],
    ),
    "a transfer that does not end": (
        "{kind: radial-otf, f_number: 8, freq_per_um: [0, 0.1, 0.2], values: [1, 0.3, 0.1]}",
        [
            "scene.yaml:3:75: lens.values: the last is 0.1; go on to the frequency where nothing passes, "
            "and give 0 there"
        ],
    ),
    "rows of unequal length": (
        "{kind: measured-psf, f_number: 8, irradiance: [[1, 2], [1]], spacing_um: 2}",
        ["scene.yaml:3:7: lens: the rows are not all equally long; give a rectangle of numbers"],
    ),
    "a file that is not there": (
        "{kind: measured-psf, f_number: 8, file: psf.exr, spacing_um: 2}",
        ["scene.yaml:3:47: lens.file: no such file: 'psf.exr'"],
    ),
    "a file elsewhere": (
        "{kind: measured-psf, f_number: 8, file: ../psf.exr, spacing_um: 2}",
        ["scene.yaml:3:47: lens.file: '../psf.exr' lies outside this file's folder; put it there"],
    ),
    "no samples at all": (
        "{kind: measured-psf, f_number: 8, spacing_um: 2}",
        ["scene.yaml:3:1: lens.irradiance: missing; give irradiance, or a file"],
    ),
    "f-number that is none": (
        "{kind: annular-airy, f_number: 0, obstruction: 0.3}",
        [
            "scene.yaml:3:38: lens.f_number: must be a number from 0.5 to 10000, not 0 "
            "(focal length over aperture, as engraved on the lens)"
        ],
    ),
}


@pytest.mark.parametrize(("text", "expected"), FAULTS.values(), ids=FAULTS)
def test_a_fault_of_a_lens(edited: Callable[..., None], text: str, expected: list[str]) -> None:
    edited(GOOD_LENS, text)
    with pytest.raises(ConfigError) as caught:
        load("scene.yaml")
    assert str(caught.value).splitlines() == expected


SENSOR_FAULTS = {
    "wider than the pitch": (
        GOOD_PHOTOSITE,
        "photosite: {kind: circular, diameter_um: 5}",
        ["my.yaml:5:12: photosite: is 5 µm wide; photosites may not overlap, and the pitch is 4 µm"],
    ),
    "taller than the pitch": (
        GOOD_PHOTOSITE,
        "photosite: {kind: rectangular, width_um: 1, height_um: 5}",
        ["my.yaml:5:12: photosite: is 5 µm wide; photosites may not overlap, and the pitch is 4 µm"],
    ),
    "a kind unlike both that there are": (
        "olpf: {kind: four-spot,",
        "olpf: {kind: birefringent,",
        ["my.yaml:6:14: olpf.kind: must be four-spot or two-spot, not 'birefringent'"],
    ),
    "too round": (
        GOOD_PHOTOSITE,
        "photosite: {kind: rounded, width_um: 4, height_um: 3, radius_um: 2}",
        ["my.yaml:5:66: photosite.radius_um: must be at most 1.5, half the photosite's shorter side, not 2.0"],
    ),
    "a crossing outline": (
        GOOD_PHOTOSITE,
        "photosite: {kind: polygon, points_um: [[0, 0], [1, 1], [1, 0], [0, 1]]}",
        ["my.yaml:5:39: photosite.points_um: sides 1 and 3 cross; list the corners in order round the shape"],
    ),
    "no split": (
        GOOD_OLPF,
        "olpf: {kind: four-spot}",
        ["my.yaml:6:1: olpf.split_um: missing; give split_um, or split_pitches"],
    ),
    "two splits": (
        GOOD_OLPF,
        "olpf: {kind: four-spot, split_um: 3, split_y_um: 2, split_y_pitches: 0.5}",
        ["my.yaml:6:53: olpf.split_y_pitches: given together with 'split_y_um'; leave one of the two out"],
    ),
    "one plate without a split": (
        GOOD_OLPF,
        "olpf: {kind: two-spot, split_um: 0}",
        ["my.yaml:6:34: olpf.split_um: must be a number above 0, not 0 (full distance between the two spots, µm)"],
    ),
}


@pytest.mark.parametrize(("old", "new", "expected"), SENSOR_FAULTS.values(), ids=SENSOR_FAULTS)
def test_a_fault_of_a_stage(edited: Callable[..., None], old: str, new: str, expected: list[str]) -> None:
    edited(old, new, sensor=True)
    with pytest.raises(ConfigError) as caught:
        load("good.yaml")
    assert str(caught.value).splitlines() == expected


@pytest.mark.parametrize("text", [text for text, _ in LENSES.values()], ids=LENSES)
def test_a_picture_through_every_kind_of_lens(edited: Callable[..., None], text: str) -> None:
    """As bright as through a sharp lens as open, within the tolerance by its own check; the same from its record."""
    edited(GOOD_LENS, text)
    changes = ["noise.enabled=false", "render.strict=true"]
    capture = load("scene.yaml", overrides=changes)
    frame = capture.frame()
    sharp = load("good.yaml", overrides=[*changes, f"lens.f_number={frame.f_number}"]).frame()
    assert frame.report.error_estimate <= 1e-3
    opening = getattr(capture.camera.lens, "opening", 1.0)
    assert frame.mean_electrons.mean() == pytest.approx(opening * sharp.mean_electrons.mean(), rel=0.05)
    assert np.abs(frame.mean_electrons - sharp.mean_electrons).max() > 1e-3 * sharp.mean_electrons.max()
    again = dataclasses.replace(capture, camera=capture.camera.replace(lens=kept(capture.camera.lens))).frame()
    np.testing.assert_array_equal(again.mean_electrons, frame.mean_electrons)
