"""OpenEXR: electrons as 32-bit floating-point numbers, ZIP-compressed, with the description as attributes.

Half floats are not sufficient: they have steps of 16 e⁻ at 30 000 and end at 65 504.
"""

from __future__ import annotations

import dataclasses
import errno
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from camsim.camera.frame import Frame
from camsim.core.arrays import F32, F64
from camsim.errors import InputError
from camsim.files.describe import description_hash, error_text, exif_datetime, record_json, software
from camsim.files.exr_reader import end_of_chunks, read_header
from camsim.files.exr_stream import write_exr


def write_truth(frame: Frame, path: Path) -> None:
    """Write the mean electrons of every channel at every photosite, one plane per channel."""
    assert frame.truth is not None
    planes = {name: frame.truth[:, :, index] for index, name in enumerate(frame.channels)}
    _write(frame, "truth", planes, path)


def write_electrons(frame: Frame, path: Path) -> None:
    """Write the electrons of each photosite: layer ``mean`` before noise, layer ``noisy`` after."""
    _write(frame, "electrons", {"mean.Y": frame.mean_electrons, "noisy.Y": frame.electrons}, path)


def write_spectral(frame: Frame, path: Path) -> None:
    """Write the scene's radiance, a channel for each wavelength, in the layout of Fichet, Pacanowski and Wilkie (2021).

    Each wavelength is rendered band by band into an anonymous temporary file; then all are written scan line by scan
    line. Memory never holds a whole plane.
    """
    cube = frame.spectral
    assert cube is not None
    rows, cols = frame.shape
    names = [channel_name(wavelength_nm) for wavelength_nm in cube.wavelength_nm]
    # Sorted by name, as the format requires: 1000 nm comes before 400 nm.
    order = sorted(range(len(names)), key=names.__getitem__)
    count, plane_bytes, error = len(names), 4 * rows * cols, 0.0
    with tempfile.TemporaryFile(dir=path.parent) as aside:

        def put_aside(band: F32) -> None:
            aside.write(np.ascontiguousarray(band, dtype="<f4").data)

        for k in range(count):
            error = max(error, cube.bands(k, put_aside))
        aside.flush()

        def block(first: int, height: int) -> F32:
            lines = np.empty((count, height, cols), dtype="<f4")
            for line, k in zip(lines, order, strict=True):
                aside.seek(k * plane_bytes + 4 * first * cols)
                aside.readinto(line.data.cast("B"))
            return lines

        write_exr(
            path,
            rows=rows,
            cols=cols,
            channels=[names[k] for k in order],
            attributes={
                "spectralLayoutVersion": "1.0",
                "emissiveUnits": cube.units,
                **_attributes(_with_error(frame, error), "spectral", cube.units),
            },
            block=block,
        )


def channel_name(wavelength_nm: float) -> str:
    """Return the layout's name of an emissive channel: first Stokes component, decimal comma.

    >>> channel_name(550.0), channel_name(632.8)
    ('S0.550,000000nm', 'S0.632,800000nm')
    """
    return f"S0.{wavelength_nm:.6f}nm".replace(".", ",").replace("S0,", "S0.")


def _with_error(frame: Frame, error: float) -> Frame:
    report = dataclasses.replace(frame.report, error_estimate=error)
    return dataclasses.replace(frame, report=report)


def _attributes(frame: Frame, product: str, units: str) -> dict[str, str | float]:
    return {
        "capDate": exif_datetime(frame),
        "expTime": float(frame.time_s),
        "isoSpeed": float(frame.iso),
        **({"aperture": float(frame.f_number)} if frame.f_number else {}),
        "software": software(),
        # As text, because OpenEXR's integers have 32 bits and its floats single precision.
        "camsim:seed": str(frame.seed),
        "camsim:errorEstimate": error_text(frame, product),
        "camsim:units": units,
        "camsim:product": product,
        "camsim:descriptionSHA256": description_hash(frame),
        "camsim:record": record_json(frame, product),
    }


def _write(frame: Frame, product: str, planes: Mapping[str, F32 | F64], path: Path) -> None:
    import OpenEXR

    header = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        **_attributes(frame, product, "electrons"),
    }
    channels = {name: np.ascontiguousarray(plane, dtype=np.float32) for name, plane in planes.items()}
    try:
        OpenEXR.File(header, channels).write(str(path))
    except RuntimeError as error:
        code = next((code for code in errno.errorcode if os.strerror(code) in str(error)), errno.EIO)
        raise OSError(code, os.strerror(code)) from error
    _refuse_short(path)


def _refuse_short(path: Path) -> None:
    """Raise OSError if the file is shorter than its table of chunks requires.

    The library ignores errors when it closes a file, so a small one on a full disk is truncated without an
    error.
    """
    with path.open("rb") as file:
        size = file.seek(0, os.SEEK_END)
        try:
            whole = end_of_chunks(file, read_header(file, size, size)) == size
        except InputError:
            whole = False
    if not whole:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
