"""A ColorChecker as any camera would record it, made directly from reflectance × light × sensitivity.

No optics and no noise, the perfect diffuser at 80 % of black..white: what is left is the file and the program that
reads it. Reference: XYZ of each patch (CIE 1931 2°, sums every 5 nm) taken from the light's white to D65 (Bradford).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from camsim.camera.frame import ChannelSignal, Frame, Report
from camsim.sensor.cfa import Cfa
from camsim.sensor.colour_matrix import ColourResponse, MatrixOf
from camsim.sensor.quantum_efficiency import QuantumEfficiency
from camsim.spectra.colour_science import colour_science
from camsim.spectra.curve import Curve
from camsim.spectra.light import Light
from tests.colour_data import aligned, patches, white_xyz

PATCH_ROWS, PATCH_COLS = 4, 6
WHITE = 0.8
NODES_NM = np.arange(380.0, 781.0, 5.0)
X_TRANS = ("GBGGRG", "RGRBGB", "GBGGRG", "GRGGBG", "BGBRGR", "GRGGBG")
QUAD = ("RRGG", "RRGG", "GGBB", "GGBB")
RGBW = ("RGBW", "BWRG")

_MOST_WITH_TRUTH = 10**7


def reference_xyz(light: str) -> np.ndarray:
    """Return (24, 3): the patches as seen, adapted from the light's white to D65."""
    observer = aligned("observer", "CIE 1931 2 Degree Standard Observer")
    power = aligned("light", light)
    seen = (patches() * power) @ observer / (power @ observer[:, 1])
    adapted = colour_science().adaptation.matrix_chromatic_adaptation_VonKries(
        white_xyz(light), white_xyz("D65"), "Bradford"
    )
    return seen @ adapted.T


def patch_number(rows: int, cols: int) -> np.ndarray:
    """Return (rows, cols): which of the 24 patches lies there."""
    row = np.arange(rows) * PATCH_ROWS // rows
    col = np.arange(cols) * PATCH_COLS // cols
    return row[:, None] * PATCH_COLS + col


def patch_means(image: np.ndarray, rows: int, cols: int) -> np.ndarray:
    """Return (24, channels) means of the inner halves; ``image`` may lack the same border on opposite sides."""
    top, left = (rows - image.shape[0]) // 2, (cols - image.shape[1]) // 2
    means = []
    for k in range(24):
        row, col = divmod(k, PATCH_COLS)
        first = (4 * row + 1) * rows // (4 * PATCH_ROWS) - top, (4 * col + 1) * cols // (4 * PATCH_COLS) - left
        last = (4 * row + 3) * rows // (4 * PATCH_ROWS) - top, (4 * col + 3) * cols // (4 * PATCH_COLS) - left
        means.append(image[first[0] : last[0], first[1] : last[1]].mean(axis=(0, 1), dtype=np.float64))
    return np.array(means)


def delta_e(light: str, found_xyz: np.ndarray) -> np.ndarray:
    """Return (24,) ΔE2000 of XYZ relative to D65, Y = ``WHITE`` for the perfect diffuser."""
    colour = colour_science()
    white = colour.XYZ_to_xy(white_xyz("D65"))
    found = colour.XYZ_to_Lab(found_xyz / WHITE, white)
    return np.asarray(colour.delta_E(colour.XYZ_to_Lab(reference_xyz(light), white), found, method="CIE 2000"))


def chart(
    rows: int = 446,
    cols: int = 446,
    pattern: tuple[str, ...] = ("RG", "GB"),
    origin: tuple[int, int] = (0, 0),
    light: str = "D65",
    matrix: MatrixOf = "standard",
    bit_depth: int = 12,
    black_dn: int = 128,
    white_dn: int = 4023,
    offsets_dn: tuple[tuple[int, ...], ...] = ((0,),),
    **changes: Any,
) -> Frame:
    """Return the frame that a sensor of that pattern records in the window at ``origin``."""
    cfa = Cfa(pattern)
    nikon = aligned("camera", "Nikon 5100 (NPL)").T
    curves = {"R": nikon[0], "G": nikon[1], "B": nikon[2], "W": nikon.max(axis=0), "Y": nikon[1]}
    sensitivity = np.array([curves[letter] for letter in cfa.channels])
    exposed = (patches() * aligned("light", light)) @ sensitivity.T
    exposed /= (sensitivity @ aligned("light", light)).max()
    index = cfa.channel_index(rows, cols, origin)
    patch_e, patch = 10.0 * WHITE * (white_dn - black_dn) * exposed, patch_number(rows, cols)
    electrons = patch_e[patch, index]
    repeats = rows // len(offsets_dn) + 1, cols // len(offsets_dn[0]) + 1
    offset = np.tile(np.array(offsets_dn), repeats)[:rows, :cols]
    values: dict[str, Any] = {
        "mosaic": (np.rint(black_dn + electrons / 10) + offset).astype(np.uint16),
        "black_offsets_dn": offsets_dn,
        "mean_electrons": electrons,
        "electrons": electrons,
        "truth": None if rows * cols > _MOST_WITH_TRUTH else patch_e.astype(np.float32)[patch],
        "channel_index": index,
        "channels": cfa.channels,
        "cfa_pattern": cfa.window_pattern(origin),
        "pitch_um": 4.88,
        "bit_depth": bit_depth,
        "black_level_dn": black_dn,
        "white_level_dn": white_dn,
        "electrons_per_dn": 10.0,
        "read_noise_e": 9.0,
        "camera_name": "ColorChecker, 4.88 µm",
        "serial": 17,
        "f_number": 5.6,
        "time_s": 0.01,
        "iso": 200.0,
        "datetime": "2021-03-04 05:06:07",
        "seed": 2**40 + 1,
        "colour": ColourResponse(
            quantum_efficiency=QuantumEfficiency(
                tuple((letter, Curve(NODES_NM, np.maximum(curves[letter], 0.0))) for letter in cfa.channels),
                per="energy",
                peak=0.5,
            ),
            light=Light(Curve(NODES_NM, aligned("light", light)), illuminance_lux=1.0),
            matrix=matrix,
        ),
        "description": {"sensor": {"name": "ColorChecker, 4.88 µm", "cfa": list(pattern)}, "note": '<&"]]> \u0001 ü'},
        "report": Report(
            scene="ColorChecker",
            optics=(),
            wavelengths="",
            method="by hand",
            tolerance=1e-6,
            error_estimate=3.2e-7,
            truth_error_estimate=4.5e-7,
            checked_photosites=0,
            signal=tuple(
                ChannelSignal(name=name, mean_e=1, max_e=1, mean_dn=1, clipped_photosites=0, photosites=1)
                for name in cfa.channels
            ),
        ),
    }
    return Frame(**{**values, **changes})
