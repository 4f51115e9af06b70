"""Lens, OLPF and photosite of YAML files to stages: as in ``build`` and ``build_sensor``."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from camsim.config import library, schema
from camsim.config.lens_files import locate_lens, read_lens_file
from camsim.config.tree import KeyPath
from camsim.config.validated import Validated
from camsim.errors import InvalidValueError
from camsim.optics import (
    Airy,
    AnnularAiry,
    CircularPhotosite,
    EllipticalGaussian,
    FourSpotOlpf,
    Gaussian,
    Lens,
    LowPass,
    MeasuredOtf,
    MeasuredPsf,
    PhotositeShape,
    PolygonPhotosite,
    Pupil,
    RadialOtf,
    RectangularPhotosite,
    RoundedPhotosite,
    SquarePhotosite,
    TwoSpotOlpf,
    Wavefront,
)
from camsim.spectra.curve import Spectrum


def lens(scene: Validated[schema.SceneFile], table: schema.MountTable, transmission: Spectrum) -> Lens | None:
    """Make the lens at ``lens`` of a scene; None when it is wrong (the document has the faults)."""
    path: KeyPath = ("lens",)
    if any(type(table).contradictions(scene.value(path))):
        return None
    if isinstance(table, schema.WavefrontLens) and any(
        schema.Pupil.contradictions(scene.value((*path, "pupil")) or {})
    ):
        return None
    if isinstance(table, schema.FieldLens):
        name, focus_um = table.file, table.focus_um
        located = scene.build((*path, "file"), lambda: locate_lens(name, scene))
        if located is None:
            return None
        return scene.build(
            (*path, "file"), lambda: read_lens_file(located, focus_um=focus_um, transmission=transmission)
        )
    assert isinstance(table, schema.LensTable)
    common: dict[str, Any] = {"f_number": table.f_number, "transmission": transmission}
    if isinstance(table, schema.MeasuredPsfLens | schema.MeasuredOtfLens) and table.file is not None:
        name = table.file
        planes = scene.build((*path, "file"), lambda: _planes(name, scene.document.folder))
        return None if planes is None else scene.build((*path, "file"), lambda: _measured(table, planes, common))
    if isinstance(table, schema.WavefrontLens):
        pupil = scene.build((*path, "pupil"), lambda: _pupil(table.pupil))
        return None if pupil is None else scene.build(path, lambda: _wavefront(table, pupil, common))
    return scene.build(path, lambda: _LENSES[type(table)](table, common))


def _gaussian(table: schema.GaussianLens, common: dict[str, Any]) -> Lens:
    if table.mtf50_per_um is not None:
        return Gaussian(sigma_um=Gaussian.from_mtf50(table.mtf50_per_um).sigma_um, **common)
    assert table.sigma_um is not None
    return Gaussian(sigma_um=table.sigma_um, **common)


def _pupil(table: schema.Pupil) -> Pupil:
    return Pupil(shape=table.shape, obstruction=table.obstruction, blades=table.blades, rotate_deg=table.rotate_deg)


def _wavefront(table: schema.WavefrontLens, pupil: Pupil, common: dict[str, Any]) -> Lens:
    return Wavefront(
        zernike_waves=tuple(table.zernike_waves),
        reference_nm=table.reference_nm,
        defocus_um=table.defocus_um,
        pupil=pupil,
        **common,
    )


def _measured(
    table: schema.MeasuredPsfLens | schema.MeasuredOtfLens, planes: dict[str, Any], common: dict[str, Any]
) -> Lens:
    """Make a lens of the channels of a file, or of the rows in the table."""
    if isinstance(table, schema.MeasuredPsfLens):
        if len(planes) != 1:
            raise InvalidValueError(f"the image has channels {', '.join(planes)}; a pattern has one")
        (rows,) = planes.values()
        irradiance = tuple(tuple(row) for row in np.asarray(rows, float).tolist())
        return MeasuredPsf(irradiance=irradiance, spacing_um=table.spacing_um, **common)
    if set(planes) == {"re", "im"}:
        values = np.asarray(planes["re"], float) + 1j * np.asarray(planes["im"], float)
    elif len(planes) == 1:
        (values,) = planes.values()
    else:
        raise InvalidValueError(f"the image has channels {', '.join(planes)}; a transfer has one, or re and im")
    return MeasuredOtf(values=values, spacing_per_um=table.spacing_per_um, **common)


def _planes(name: str, folder: Path) -> dict[str, Any]:
    """Read the channels of an image that a scene names; it must be under the scene's folder."""
    from camsim.measure.reading import read_picture

    return {plane.name: plane.samples for plane in read_picture(library.in_folder(folder, name)).planes}


_LENSES: dict[type[schema.Table], Callable[[Any, dict[str, Any]], Lens]] = {
    schema.AiryLens: lambda table, common: Airy(**common),
    schema.AnnularLens: lambda table, common: AnnularAiry(obstruction=table.obstruction, **common),
    schema.GaussianLens: _gaussian,
    schema.EllipticalGaussianLens: lambda table, common: EllipticalGaussian.from_axes(
        sigma_um=table.sigma_um, sigma_across_um=table.sigma_across_um, rotate_deg=table.rotate_deg, **common
    ),
    schema.RadialOtfLens: lambda table, common: RadialOtf(
        freq_per_um=tuple(table.freq_per_um), values=tuple(table.values), **common
    ),
    schema.MeasuredPsfLens: lambda table, common: _measured(table, {"irradiance": _rows(table.irradiance)}, common),
    schema.MeasuredOtfLens: lambda table, common: _measured(table, {"values": _rows(table.values)}, common),
}


def _rows(rows: list[list[float]]) -> Any:
    """Return rows as an array; raises unless they form a rectangle."""
    if len({len(row) for row in rows}) != 1 or not rows[0]:
        raise InvalidValueError("the rows are not all equally long; give a rectangle of numbers")
    return np.array(rows)


def photosite(sensor: Validated[schema.SensorFile]) -> PhotositeShape | None:
    """Make the photosite of a sensor; None when it is wrong."""
    model = sensor.model
    if model is None:
        return None
    table, pitch_um = model.photosite, model.frame.pitch_um
    return sensor.build(("photosite",), lambda: _photosite(table, pitch_um))


def _photosite(table: schema.Table, pitch_um: float) -> PhotositeShape:
    if isinstance(table, schema.RectangularPhotosite):
        return RectangularPhotosite(width_um=table.width_um, height_um=table.height_um)
    if isinstance(table, schema.CircularPhotosite):
        return CircularPhotosite(diameter_um=table.diameter_um)
    if isinstance(table, schema.RoundedPhotosite):
        return RoundedPhotosite(width_um=table.width_um, height_um=table.height_um, radius_um=table.radius_um)
    if isinstance(table, schema.PolygonPhotosite):
        return PolygonPhotosite(points_um=tuple(table.points_um))
    assert isinstance(table, schema.SquarePhotosite)
    return SquarePhotosite.from_fill_factor(pitch_um=pitch_um, fill_factor=table.fill_factor)


def olpf(sensor: Validated[schema.SensorFile]) -> LowPass | None:
    """Make the low-pass filter of a sensor; None without one, or when it is wrong."""
    model, path = sensor.model, ("olpf",)
    if model is None or model.olpf is None or any(type(model.olpf).contradictions(sensor.value(path))):
        return None
    table, pitch_um = model.olpf, model.frame.pitch_um
    return sensor.build(path, lambda: _olpf(table, pitch_um))


def _olpf(table: schema.FourSpotOlpf | schema.TwoSpotOlpf, pitch_um: float) -> LowPass:
    def in_um(split_um: float | None, split_pitches: float | None) -> Any:
        return split_pitches * pitch_um if split_pitches is not None else split_um

    split_um = in_um(table.split_um, table.split_pitches)
    if isinstance(table, schema.TwoSpotOlpf):
        return TwoSpotOlpf(split_um=split_um, rotate_deg=table.rotate_deg)
    split_y_um = in_um(table.split_y_um, table.split_y_pitches)
    return FourSpotOlpf(split_um=split_um, split_y_um=split_y_um, rotate_deg=table.rotate_deg)
