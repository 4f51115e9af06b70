"""Pictures: what of sRGB comes back through a camera, and seconds and memory of large ones.

python bench/pictures.py [colours] [512] [1024] [6mp] [cube] [24mp]

Seconds of all cores together are beside those of the clock: the latter mean something on an idle machine only. Peaks
are those of the process so far, the samples' own array included: one size a run.
"""

from __future__ import annotations

import resource
import sys
import time

import numpy as np
from scipy import ndimage

import camsim
from camsim.sensor.colour_matrix import fit, fit_white
from camsim.spectra.colour_science import colour_science
from camsim.spectra.rgb import linear_of_srgb

LENS = camsim.Airy(f_number=8.0)
LIGHT = camsim.Light("D65", illuminance_lux=1000.0)
EXPOSURE = camsim.Exposure(time_s=0.01, iso=200.0)


def frame_of(picture: camsim.Picture, rows: int, cols: int, background: float, tolerance: float) -> camsim.Frame:
    camera = camsim.Camera.from_yaml("d40-like", lens=LENS).replace(olpf=None)
    return camera.expose(
        camsim.Scene(background=background, shapes=[picture]),
        light=LIGHT,
        exposure=EXPOSURE,
        region=camsim.Region(rows=rows, cols=cols),
        tolerance=tolerance,
        noise=False,
        products=("mosaic", "truth"),
    )


def colours() -> None:
    """sRGB from a lattice of 6³ colours → D65 → D40-like, no noise → its matrix for D65 → ΔE2000."""
    side = np.linspace(0.0, 1.0, 6)
    encoded = np.stack(np.meshgrid(side, side, side, indexing="ij"), axis=-1).reshape(-1, 3)
    rgb = linear_of_srgb(encoded)
    camera = camsim.Camera.from_yaml("d40-like", lens=LENS).replace(olpf=None)
    to_xyz = fit(camera.colour_response(LIGHT, "standard"), "D65").camera_to_xyz
    # Light is linear in the components: the primaries, each a picture of its own, are all that is to be captured.
    seen = []
    for primary in np.eye(3):
        frame = frame_of(camsim.Picture.of_rgb(np.full((1, 1, 3), primary), width_um=400.0), 2, 2, 0.0, 1e-3)
        assert frame.truth is not None
        seen.append(frame.truth.mean(axis=(0, 1)))
    channels = np.einsum("np,pc->nc", rgb, np.array(seen)) / np.sum(seen, axis=0).max()
    colour = colour_science()
    d65 = colour.XYZ_to_xy(fit_white("D65"))
    found = colour.XYZ_to_Lab(np.einsum("xc,nc->nx", to_xyz, channels), d65)
    right = colour.XYZ_to_Lab(colour.sRGB_to_XYZ(encoded), d65)
    delta = colour.delta_E(right, found, method="CIE 2000")
    print(f"ΔE2000 of {len(rgb)} colours: mean {delta.mean():.2f}, 95 % {np.percentile(delta, 95):.2f}")


def speed(name: str, rows: int, cols: int, bands: int = 3, of: int = 1) -> None:
    """Expose a picture of ``rows``/``of`` × ``cols``/``of`` samples on rows × cols photosites."""
    rng = np.random.default_rng(1)
    samples = np.empty((rows // of, cols // of, bands), np.float32)
    for band in range(bands):
        samples[..., band] = ndimage.gaussian_filter(rng.random(samples.shape[:2], np.float32), 1.5)
    samples -= samples.min()
    samples /= samples.max()
    camera = camsim.Camera.from_yaml("d40-like", lens=LENS)
    camera = camera.replace(rows=max(rows, camera.rows), cols=max(cols, camera.cols))
    placed = {"width_um": 0.97 * cols * camera.pitch_um}
    if bands == 3:
        picture = camsim.Picture.of_rgb(samples, **placed)
    else:
        picture = camsim.Picture.of_cube(samples, np.linspace(400, 700, bands).tolist(), tolerance=0.05, **placed)
    for _ in range(2):
        began, worked = time.perf_counter(), time.process_time()
        frame = camera.expose(
            camsim.Scene(background=0.2, shapes=[picture]),
            light=LIGHT,
            exposure=EXPOSURE,
            region=camsim.Region(rows=rows, cols=cols),
            tolerance=1e-4,
        )
        seconds, worked = time.perf_counter() - began, time.process_time() - worked
        report = frame.report
        del frame  # or the second would be held on top of the first
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(
        f"{name}: {seconds:.1f} s, {worked:.1f} s of all cores "
        f"({report.seconds['render']:.1f} s rendering and check), {peak:.2f} GB, "
        f"{len(picture.planes)} planes, error {report.error_estimate:.1e}"
    )


WHAT = {
    "colours": colours,
    "512": lambda: speed("512² on 512²", 512, 512),
    "1024": lambda: speed("1024² on 1024²", 1024, 1024),
    "6mp": lambda: speed("3008 × 2000", 2000, 3008),
    "cube": lambda: speed("31 bands of 512² on 1024²", 1024, 1024, 31, 2),
    "24mp": lambda: speed("6000 × 4000", 4000, 6000),
}

if __name__ == "__main__":
    for chosen in sys.argv[1:] or WHAT:
        WHAT[chosen]()
