"""What ``camsim measure mtf`` is worth: accuracy against theory, honesty of its errors, speed.

python bench/mtf_study.py accuracy            # f/2.8–f/32, 2°–43° and mirrored, OLPF on and off, mono and Bayer
python bench/mtf_study.py accuracy --size 48  # smaller regions
python bench/mtf_study.py closed-form         # Gaussian edges that no renderer made
python bench/mtf_study.py noise --draws 200
python bench/mtf_study.py small --draws 5000  # sharp edges in up to 48 px of a Bayer channel: right, or refused
python bench/mtf_study.py drawn --draws 900   # blocks of 25 px and more, near neighbours, tilted light: 4 errors
python bench/mtf_study.py aberrated           # what coma and spherical aberration throw beyond a region
python bench/mtf_study.py speed
"""

from __future__ import annotations

import argparse
import functools
import math
import os
import sys
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import numpy as np
from drawn_edges import drawn_edge_of_a_chart
from edges import ABERRATED, drawn_edge, gaussian_edge, gaussian_mtf, gaussian_sigma, pupil_edge

import camsim
from camsim.errors import UnsupportedError
from camsim.measure import CameraOtf, Picture, Plane, Roi, measure_edge, measure_mtf, picture_of_frame
from camsim.optics import OpticalSystem

F_NUMBERS = (2.8, 4.0, 5.6, 8.0, 11.0, 16.0, 22.0, 32.0)
ANGLES_DEG = (2.0, 3.0, 5.0, 8.0, 11.0, 17.0, 24.0, 30.0, 38.0, 43.0)


def edge_scene(angle_deg: float, *, turned: bool = False) -> camsim.Scene:
    """A half-plane, as good as: its other sides are 1e5 µm away."""
    far, angle = 1e5, math.radians(angle_deg + (90.0 if turned else 0.0))
    centre = (0.5 * far * math.cos(angle) + 1.0, 0.5 * far * math.sin(angle) + 0.4)
    plane = camsim.Rectangle(
        width_um=far, height_um=4 * far, rotate_deg=math.degrees(angle), centre_um=centre, reflectance=0.9
    )
    return camsim.Scene(background=0.05, shapes=[plane])


def accuracy(size: int, f_numbers: tuple[float, ...] = F_NUMBERS, angles_deg: tuple[float, ...] = ANGLES_DEG) -> dict:
    """Measure noise-free captures; return the largest errors."""
    worst = {"edges": 0, "mtf": 0.0, "mtf50": 0.0, "refused": 0}
    light, region = camsim.Light("D55", illuminance_lux=5000), camsim.Region(rows=size, cols=size)
    for sensor in ("mono-345", "d40-like"):
        for f_number in f_numbers:
            errors = []
            for olpf in (False, True):
                camera = camsim.Camera.from_yaml(sensor, lens=camsim.Airy(f_number=f_number))
                split = camsim.FourSpotOlpf(split_um=0.75 * camera.pitch_um)
                camera = camera.replace(olpf=split if olpf else None)
                for number, angle in enumerate((*angles_deg, *(-a for a in angles_deg))):
                    scene = edge_scene(angle, turned=number % 3 == 2)
                    frame = camera.expose(
                        scene,
                        light=light,
                        exposure=camsim.Exposure(time_s=0.01, iso=200),
                        region=region,
                        noise=False,
                    )
                    theory = CameraOtf(camera=camera, scene=scene, light=light, region=region)
                    for plane in picture_of_frame(frame, "mean_electrons").planes:
                        try:
                            edge = measure_edge(plane, Roi(0, 0, size, size), theory=theory)
                        except UnsupportedError as error:
                            worst["refused"] += 1
                            print(f"  refused: f/{f_number:g}, {angle:g}°: {error}")
                            continue
                        assert edge.theory is not None
                        ratio = edge.figures.mtf50_cycles_per_pixel / edge.theory.mtf50_cycles_per_pixel
                        errors.append((edge.theory.difference_to_nyquist, abs(ratio - 1.0)))
            table = np.array(errors)
            print(
                f"{sensor:9} f/{f_number:<4g} {len(errors):4d} edges of {size} px: largest |ΔMTF| to Nyquist "
                f"{table[:, 0].max():.1e} (median {np.median(table[:, 0]):.0e}), MTF50 off by "
                f"{100 * np.nanmax(table[:, 1]):.4f} % at most (median {100 * np.nanmedian(table[:, 1]):.4f} %)",
                flush=True,
            )
            worst["edges"] += len(errors)
            worst["mtf"] = max(worst["mtf"], float(table[:, 0].max()))
            worst["mtf50"] = max(worst["mtf50"], float(np.nanmax(table[:, 1])))
    return worst


def closed_form(mtf50s: tuple[float, ...] = (0.10, 0.15, 0.20, 0.25, 0.30, 0.35, 0.40), shifts: int = 25) -> None:
    """Gaussian edges in closed form over sub-pixel shifts: mean and largest error of MTF50, rounded to 16 bits."""
    print("MTF50 c/px   mean |error| %   largest %   largest |ΔMTF| to Nyquist   (5°, 25 shifts, 16 bits)")
    for mtf50 in mtf50s:
        sigma, errors, curves = gaussian_sigma(mtf50), [], []
        for k in range(shifts):
            image = gaussian_edge(128, 128, 5.0, sigma, shift_px=(k + 0.5) / shifts - 0.5)
            codes = np.rint(65535 * image).astype(np.uint16)
            edge = measure_edge(Plane(name="Y", samples=codes), Roi(0, 0, 128, 128))
            errors.append(abs(edge.figures.mtf50_cycles_per_pixel / mtf50 - 1.0))
            f = edge.frequency_cycles_per_pixel
            curves.append(np.abs(edge.mtf - gaussian_mtf(f, sigma))[f <= 0.5].max())
        print(
            f"{mtf50:6.2f}   {100 * np.mean(errors):12.5f}   {100 * max(errors):9.5f}   {max(curves):12.1e}", flush=True
        )


def noise(draws: int) -> None:
    """Even noise on closed-form edges: bias and spread of MTF50, and reported over true standard error."""
    names = ("mtf50_cycles_per_pixel", "mtf30_cycles_per_pixel", "mtf_at_nyquist", "rise_10_90_pixel", "angle_deg")
    print(f"region, step, angle, MTF50, SNR: MTF50 bias and spread; reported / true error of {', '.join(names)}")
    rng = np.random.default_rng(1)
    for size, step, angle, mtf50 in ((64, 1, 5, 0.25), (64, 2, 5, 0.2), (64, 1, 30, 0.12), (128, 2, -10, 0.3)):
        image = gaussian_edge(size, size, angle, gaussian_sigma(mtf50), step=step)
        for snr in (100, 30):
            values, errors = [], []
            for _ in range(draws):
                samples = image + rng.normal(0.0, 0.8 / snr, image.shape)
                edge = measure_edge(Plane(name="Y", samples=samples, step=(step, step)), Roi(0, 0, size, size))
                values.append([getattr(edge.figures, name) for name in names])
                errors.append([getattr(edge.standard_error, name) for name in names])
            value, error = np.array(values), np.array(errors)
            ratio = np.sqrt(np.mean(error**2, axis=0)) / value.std(axis=0)
            print(
                f"{size:3d} px, every {step}, {angle:3d}°, {mtf50:.2f}, {snr:3d}: bias "
                f"{100 * (value[:, 0].mean() / mtf50 - 1):+.2f} %, spread {100 * value[:, 0].std() / mtf50:.2f} %; "
                + "  ".join(f"{r:.2f}" for r in ratio),
                flush=True,
            )


def small(draws: int, seed: int = 1) -> list[str]:
    """Count what is off by more than four of its own standard errors; return a line for each."""
    rng = np.random.default_rng(seed)
    wrong, refused = [], {}
    for number in range(draws):
        samples, first, (rows, cols), truth = drawn_edge(rng)
        plane, roi = Plane(name="R", samples=samples, step=(2, 2), first=first), Roi(0, 0, rows, cols)
        try:
            edge = measure_edge(plane, roi)
        except UnsupportedError as error:
            kind = " ".join(str(error).split(": ", 1)[-1].split()[:6])
            refused[kind] = refused.get(kind, 0) + 1
            continue
        for name in ("angle_deg", "mtf50_cycles_per_pixel", "rise_10_90_pixel"):
            found, error = getattr(edge.figures, name), getattr(edge.standard_error, name)
            if math.isfinite(found) and not abs(found - truth[name]) <= 4.0 * error:
                wrong.append(
                    f"{number}: {roi.rows} × {roi.cols}, {truth['angle_deg']:.2f}°, MTF50 "
                    f"{truth['mtf50_cycles_per_pixel']:.3f}, SNR {truth['snr']:.0f}: {name} {found:.4f} ± {error:.2g}, "
                    f"true {truth[name]:.4f}"
                )
                print(wrong[-1], flush=True)
    print(f"{draws} drawn, {sum(refused.values())} refused, {len(wrong)} figures off by more than 4 standard errors")
    for kind, count in sorted(refused.items(), key=lambda item: -item[1])[:12]:
        print(f"  {count:5d} {kind} …")
    return wrong


def drawn(draws: int) -> list[str]:
    """Measure edges as charts have them; return a line for each MTF50 or angle off by more than four of its errors."""
    wrong, refused, off = [], 0, {"without noise": [], "with noise": []}
    for number in range(draws):
        edge_drawn = drawn_edge_of_a_chart(np.random.default_rng(number))
        try:
            edge = measure_edge(edge_drawn.plane, edge_drawn.roi)
        except UnsupportedError:
            refused += 1
            continue
        for name in ("mtf50_cycles_per_pixel", "angle_deg"):
            true, found, error = (getattr(each, name) for each in (edge_drawn, edge.figures, edge.standard_error))
            if math.isnan(found):
                continue
            if name.startswith("mtf50"):
                kind = "without noise" if "inf e" in edge_drawn.how else "with noise"
                off[kind].append((abs(found / true - 1.0), error / true, abs(found - true) / error))
            if not abs(found - true) <= 4.0 * error:
                wrong.append(f"{number}: {edge_drawn.how}: {name} {found:.5f} ± {error:.2g}, true {true:.5f}")
                print(wrong[-1], flush=True)
    for kind, rows in off.items():
        share, error, ratio = np.array(rows).T
        print(
            f"{len(rows)} edges {kind}: MTF50 off by {100 * np.median(share):.3f} % (median), "
            f"error {100 * np.median(error):.3f} %; off / error {np.sqrt(np.mean(ratio**2)):.2f} (rms), "
            f"{ratio.max():.1f} at most"
        )
    print(f"{draws} drawn, {refused} refused, {len(wrong)} figures off by more than 4 standard errors")
    return wrong


def _along(system: OpticalSystem, x: float, y: float, frequency: np.ndarray) -> np.ndarray:
    return system.otf(x * frequency, y * frequency, 550.0)


def aberrated(f_number: float = 5.6, pitch_um: float = 3.45, angle_deg: float = 5.3) -> None:
    """Noise-free edges behind aberrations: MTF50 off, and the smaller stated error of the two sides, in per cent."""
    turn = math.radians(angle_deg)
    for name, waves in ABERRATED.items():
        lens = camsim.Wavefront(f_number=f_number, zernike_waves=waves)
        system = OpticalSystem.of([lens, camsim.SquarePhotosite(side_um=pitch_um)])
        stated = []
        for size in (48, 64, 128):
            both = []
            for side in (1.0 / pitch_um, -1.0 / pitch_um):
                along = functools.partial(_along, system, side * math.cos(turn), side * math.sin(turn))
                image, true = pupil_edge(size, angle_deg, along, pitch_um * system.cutoff_per_um(550.0))
                edge = measure_edge(Plane(name="Y", samples=image), Roi(0, 0, size, size))
                found, error = (one.mtf50_cycles_per_pixel / true for one in (edge.figures, edge.standard_error))
                both.append((100.0 * error, 100.0 * (found - 1.0)))
            stated.append("{1:+.2f}({0:.2f}) %".format(*min(both)))
        print(f"{name}: rise {edge.figures.rise_10_90_pixel:.1f} px; {', '.join(stated)}", flush=True)


def speed() -> None:
    """A region of a megapixel, and 24 megapixels with 50 edges, kernels compiled before."""
    big = gaussian_edge(1000, 1000, 5.0, 0.8)
    big += np.random.default_rng(1).normal(0, 0.008, big.shape)
    plane, roi = Plane(name="Y", samples=big), Roi(0, 0, 1000, 1000)
    measure_edge(plane, roi)
    laps = []
    for _ in range(5):
        wall, cpu = time.perf_counter(), time.process_time()
        measure_edge(plane, roi)
        laps.append((time.perf_counter() - wall, time.process_time() - cpu))
    print("1 MP region: wall {:.3f} s, CPU {:.3f} s (the best of 5)".format(*np.min(laps, axis=0)))
    frame = np.full((4000, 6000), 3000.0)
    for row in range(4):
        for col in range(7):
            left, right = (gaussian_edge(400, 300, 5.0 + row, 0.8, shift_px=shift) for shift in (-60, 60))
            band = left - right
            frame[200 + 900 * row : 600 + 900 * row, 200 + 800 * col : 500 + 800 * col] -= 2500.0 * band
    frame += np.random.default_rng(2).normal(0, 20, frame.shape)
    codes = np.clip(np.rint(frame), 0, 65535).astype(np.uint16)
    picture = Picture(name="24 MP", shape=codes.shape, planes=(Plane(name="Y", samples=codes),))
    wall, cpu = time.perf_counter(), time.process_time()
    report = measure_mtf(picture)
    print(
        f"24 MP: {len(report.edges)} edges found and measured: wall {time.perf_counter() - wall:.2f} s, "
        f"CPU {time.process_time() - cpu:.2f} s"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["accuracy", "closed-form", "noise", "small", "drawn", "aberrated", "speed"])
    parser.add_argument("--size", type=int, default=64)
    parser.add_argument("--draws", type=int, default=200)
    arguments = parser.parse_args()
    if arguments.what == "accuracy":
        print(accuracy(arguments.size))
    elif arguments.what == "closed-form":
        closed_form()
    elif arguments.what == "noise":
        noise(arguments.draws)
    elif arguments.what == "small":
        small(arguments.draws)
    elif arguments.what == "drawn":
        drawn(arguments.draws)
    elif arguments.what == "aberrated":
        aberrated()
    else:
        speed()


if __name__ == "__main__":
    main()
