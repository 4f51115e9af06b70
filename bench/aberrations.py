"""Aberrated lenses: ``python -m bench.aberrations random|speed|auto|large|round|steep|rim [COUNT]``.

random : random wavefronts at random tolerances, against the Fourier engine, which takes the lens as a whole
speed  : the paper's square at f/4 behind a perfect lens and behind 0.1 wave of defocus and 0.05 of coma
auto   : the engine that ``auto`` takes against the quicker one, and expected against measured seconds
large  : 3008 × 2000 photosites and 100 squares; a knife edge that leaves the frame; pupils of other shapes
round  : defocused lenses by curves of frequencies against patterns on lattices
steep  : nodes of a square cut into panels against as many all over as its corners ask for
rim    : the light of a pupil's rim at few places of a frame, at those of every photosite, and all at once

Seconds are CPU seconds of one process, all threads added up, so that a busy machine measures the same.
"""

from __future__ import annotations

import argparse
import functools
import multiprocessing
import resource
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

import camsim
from camsim.errors import CamsimError
from camsim.optics import OpticalSystem, Pupil, Wavefront, difference, panels
from camsim.optics import wavefront as wavefront_module
from camsim.optics.chords import chords_of
from camsim.optics.follow import Turns
from camsim.optics.rays import rays_of
from camsim.rendering.fourier import apart
from camsim.rendering.fourier.rim import RimLight
from camsim.rendering.render import plan_render, render_channels
from camsim.rendering.running import carry_out

PITCH_UM, NM = 4.88, 550.0
BENT = Wavefront(f_number=4.0, zernike_waves={4: 0.1, 8: 0.05})
PERFECT = camsim.Airy(f_number=4.0)
FEWEST, REFERENCE = 1e-11, 0.02  # the finest tolerance of a reference, and its part of the tolerance


def polygon(rng: np.random.Generator, size: float) -> np.ndarray:
    """Return corners (n, 2) in pitches, some of them outside a frame of ``size``."""
    corners = int(rng.integers(3, 8))
    angle = (np.arange(corners) + rng.uniform(0.1, 0.9, corners)) * 2.0 * np.pi / corners
    radius = rng.uniform(0.2, 0.9) * size
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1) + rng.uniform(-0.4, 0.4, 2) * size


def wavefront(rng: np.random.Generator, f_number: float) -> Wavefront:
    """Return a lens of up to 1.5 waves rms in a few Zernike terms, one in three with an obstruction."""
    indices = rng.choice(np.arange(1, 22), int(rng.integers(1, 6)), replace=False)
    waves = rng.normal(size=indices.size)
    waves *= rng.uniform(0.0, 1.5) / np.hypot.reduce(waves)
    obstruction = float(rng.choice([0.0, 0.0, rng.uniform(0.1, 0.6)]))
    pairs = dict(zip(indices.tolist(), waves.tolist(), strict=True))
    return Wavefront(f_number=f_number, zernike_waves=pairs, pupil=Pupil(obstruction=obstruction))


def random_case(seed: int) -> tuple[Any, ...]:
    """Render one random case by both roads; return what it was, errors over the tolerance, and seconds."""
    rng = np.random.default_rng(seed)
    f_number = float(np.exp(rng.uniform(np.log(1.4), np.log(32.0))))
    ratio = float(np.exp(rng.uniform(np.log(0.1), np.log(10.0))))
    pitch_um = f_number * NM * 1e-3 / ratio
    size = int(rng.integers(12, 40))
    tolerance = float(10.0 ** -rng.integers(2, 9))
    lens = wavefront(rng, f_number)
    stages: list[Any] = [lens, camsim.SquarePhotosite(side_um=float(rng.choice([0.0, 0.7, 1.0])) * pitch_um)]
    if rng.random() < 0.3:
        stages.append(camsim.FourSpotOlpf(split_um=0.7 * pitch_um))
    shapes = [
        camsim.Polygon(points_um=polygon(rng, size) * pitch_um, reflectance=float(rng.random())) for _ in range(2)
    ]
    scene = camsim.Scene(background=1.0, shapes=shapes)
    grid = camsim.Grid(rows=size, cols=size, pitch_um=pitch_um)

    def render(method: str, tolerance: float) -> tuple[camsim.Rendering, float]:
        begin = time.process_time()
        found = camsim.render(scene, stages, grid, wavelength_nm=NM, tolerance=tolerance, method=method)
        return found, time.process_time() - begin

    name = f"f/{f_number:.3g} λN/p {ratio:.2g} {np.hypot.reduce([c for _, c in lens._pairs]):.2f} waves {tolerance:g}"
    try:
        found, seconds = render("boundary", tolerance)
        reference, _ = render("fourier", max(REFERENCE * tolerance, FEWEST))
    except CamsimError as error:
        return seed, name, None, None, None, str(error)
    error = float(np.abs(found.image - reference.image).max()) / tolerance
    return seed, name, error, found.error_estimate / tolerance, seconds, ""


def random(count: int) -> None:
    """Print the worst of random cases."""
    worst = []
    for seed in range(count):
        _, name, error, estimate, seconds, refused = random_case(seed)
        if error is None:
            print(f"{seed:3d} {name}: {refused}", flush=True)
            continue
        worst.append(error)
        print(
            f"{seed:3d} {name}: error {error:.2f} of the tolerance, check {estimate:.2f}, {seconds:.2f} s", flush=True
        )
    print(f"{len(worst)} cases, at most {max(worst):.2f} of the tolerance, median {np.median(worst):.2f}")


def square(size_px: float = 250.0, turn_deg: float = 4.0, centre_px: tuple[float, float] = (0.0, 0.0)) -> Any:
    """Return a black square."""
    half, turn = 0.5 * size_px * PITCH_UM, np.radians(turn_deg)
    corners = half * np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    turned = corners @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    return camsim.Polygon(points_um=turned + PITCH_UM * np.array(centre_px), reflectance=0.0)


def best_of(run: Callable[[], Any], times: int = 4) -> tuple[float, Any]:
    """Return the least CPU seconds of several runs, and what the last gave."""
    least, found = np.inf, None
    for _ in range(times):
        begin = time.process_time()
        found = run()
        least = min(least, time.process_time() - begin)
    return float(least), found


def speed() -> None:
    """Print what the paper's square takes behind a perfect lens and behind an aberrated one."""
    scene = camsim.Scene(background=1.0, shapes=[square()])
    grid = camsim.Grid(rows=446, cols=446, pitch_um=PITCH_UM)
    photosite = camsim.SquarePhotosite(side_um=PITCH_UM)
    for tolerance in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7):
        seconds = []
        for lens in (PERFECT, BENT):
            stages = [lens, photosite]
            taken, found = best_of(
                lambda stages=stages, tolerance=tolerance: camsim.render(
                    scene, stages, grid, wavelength_nm=NM, tolerance=tolerance
                )
            )
            seconds.append(taken)
        print(
            f"one wavelength, {tolerance:g}: perfect {seconds[0]:.3f} s, aberrated {seconds[1]:.3f} s "
            f"({found.method}), {seconds[1] / seconds[0]:.1f} times",
            flush=True,
        )
    camera = camsim.Camera.from_yaml("d40-like", lens=PERFECT)
    light = camsim.Light("D55", illuminance_lux=5000)
    for tolerance in (1e-3, 1e-4, 1e-5):
        seconds = []
        for lens in (PERFECT, BENT):
            own = camera.replace(lens=lens)
            taken, _ = best_of(
                lambda own=own, tolerance=tolerance: own.expose(
                    scene,
                    light=light,
                    exposure=camsim.Exposure(time_s=0.01, iso=200),
                    region=camsim.Region(rows=446, cols=446),
                    tolerance=tolerance,
                )
            )
            seconds.append(taken)
        print(
            f"D55, Bayer, OLPF, whole captures, {tolerance:g}: perfect {seconds[0]:.3f} s, "
            f"aberrated {seconds[1]:.3f} s, {seconds[1] / seconds[0]:.1f} times",
            flush=True,
        )
    print(f"peak of this process: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6:.2f} GB")


def auto_cases() -> Iterator[tuple[str, Any, list[Any], Any, float]]:
    """Yield 20 scenes of several kinds."""
    rng = np.random.default_rng(20)
    for number in range(20):
        size = int(rng.choice([40, 120, 300]))
        f_number = float(rng.choice([2.0, 4.0, 8.0, 16.0]))
        tolerance = float(10.0 ** -rng.integers(2, 7))
        shapes: list[Any]
        if number % 4 == 0:
            shapes = [square(0.6 * size, rng.uniform(0, 45))]
        elif number % 4 == 1:
            shapes = [camsim.Disc(radius_um=0.3 * size * PITCH_UM, reflectance=0.1)]
        elif number % 4 == 2:
            places = rng.uniform(-0.5, 0.5, (30, 2)) * size
            shapes = [square(0.1 * size, rng.uniform(0, 45), (float(x), float(y))) for x, y in places]
        else:
            shapes = [camsim.Polygon(points_um=polygon(rng, size) * PITCH_UM, reflectance=0.3)]
        lens = Wavefront(f_number=f_number, zernike_waves={4: float(rng.normal(0, 0.2)), 7: 0.1, 12: 0.05})
        name = f"{number:2d} {type(shapes[0]).__name__} {len(shapes)} f/{f_number:g} {size} px {tolerance:g}"
        grid = camsim.Grid(rows=size, cols=size, pitch_um=PITCH_UM)
        yield (
            name,
            camsim.Scene(background=1.0, shapes=shapes),
            [lens, camsim.SquarePhotosite(side_um=4.5)],
            grid,
            tolerance,
        )


def auto() -> None:
    """Print both engines' expected and measured seconds, and which one is taken."""
    good, within = 0, 0
    for name, scene, stages, grid, tolerance in auto_cases():
        system, channel = OpticalSystem.of(stages), np.zeros((grid.rows, grid.cols), np.uint8)
        measured, expected = {}, {}

        def planned(method: str, s: Any = (scene, system, grid, tolerance)) -> Any:
            response, nm = np.ones((1, 1)), np.array([NM])
            return plan_render(*s[:3], response=response, wavelength_nm=nm, tolerance=s[3], method=method)

        taken = planned("auto").method
        for method in ("boundary", "fourier"):
            expected[method] = planned(method).cost.seconds
            if expected[method] < 60.0:
                measured[method] = best_of(lambda p=planned, m=method, c=channel: carry_out(p(m), c), 2)[0]
            else:
                measured[method] = expected[method]
        ratio = measured[taken] / min(measured.values())
        good += ratio <= 1.5
        within += 0.5 <= expected[taken] / measured[taken] <= 2.0
        print(
            f"{name}: {taken}; boundary {measured['boundary']:.3f} s ({expected['boundary']:.3f} expected), "
            f"fourier {measured['fourier']:.3f} s ({expected['fourier']:.3f} expected), {ratio:.2f} of the quicker",
            flush=True,
        )
    print(f"auto within 1.5 of the quicker in {good} of 20; expected within a factor of 2 in {within} of 20")


def _large(name: str) -> str:
    grid = camsim.Grid(rows=446, cols=446, pitch_um=PITCH_UM)
    stages: list[Any] = [BENT, camsim.SquarePhotosite(side_um=PITCH_UM)]
    small = camsim.Grid(rows=24, cols=24, pitch_um=PITCH_UM)
    camsim.render(camsim.Scene(background=1.0, shapes=[square(10)]), stages, small, wavelength_nm=NM, tolerance=1e-3)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    begin, wall = time.process_time(), time.perf_counter()
    if name == "100 squares":
        rng = np.random.default_rng(1)
        places = [(300.0 * (k % 10) - 1350.0, 200.0 * (k // 10) - 900.0) for k in range(100)]
        scene = camsim.Scene(background=1.0, shapes=[square(120.0, rng.uniform(0, 45), place) for place in places])
        camera = camsim.Camera.from_yaml("d40-like", lens=BENT)
        light, exposure = camsim.Light("D55", illuminance_lux=5000), camsim.Exposure(time_s=0.01, iso=200)
        frame = camera.expose(scene, light=light, exposure=exposure, tolerance=1e-5)
        found = f"{frame.mosaic.shape}, error {frame.report.error_estimate:.2g}"
    elif name == "knife edge":
        corners = [(0.0, -1e6), (1e6, -1e6), (9e5, 1e6), (8.0, 1e6)]
        scene = camsim.Scene(background=1.0, shapes=[camsim.Polygon(points_um=corners, reflectance=0.0)])
        found = repr(camsim.render(scene, stages, grid, wavelength_nm=NM, tolerance=1e-5))
    else:
        shape, f_number, tolerance = name.split()
        pupil = Pupil(shape="bladed", blades=7) if shape == "bladed" else Pupil(shape="square")
        stages[0] = Wavefront(f_number=float(f_number), zernike_waves={4: 0.1}, pupil=pupil)
        scene = camsim.Scene(background=1.0, shapes=[square()])
        found = repr(camsim.render(scene, stages, grid, wavelength_nm=NM, tolerance=float(tolerance)))
    seconds, wall = time.process_time() - begin, time.perf_counter() - wall
    bytes_ = 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
    return f"{name}: {seconds:.2f} s CPU, {wall:.2f} s, {bytes_ / 1e9:.2f} GB more than before; {found}"


def large() -> None:
    """Print what large frames, long edges and other pupils take, each in a process of its own."""
    for name in (
        "knife edge",
        "100 squares",
        "bladed 16 1e-4",
        "square 5.6 1e-4",
        "bladed 2.8 1e-4",
        "square 2.8 1e-6",
    ):
        with multiprocessing.get_context("spawn").Pool(1) as pool:
            print(pool.apply(_large, (name,)), flush=True)


def defocused() -> None:
    """Print what a defocused lens takes by a curve, and with its pattern on a lattice at every wavelength."""
    scene = camsim.Scene(background=1.0, shapes=[square(48.0)])
    grid = camsim.Grid(rows=96, cols=96, pitch_um=PITCH_UM)
    channel = np.zeros((96, 96), np.uint8)
    for f_number, waves, count, tolerance in (
        (4.0, 0.4, 40, 1e-3), (4.0, 2.0, 40, 1e-5), (1.4, 0.4, 150, 1e-7), (11.0, 0.4, 5, 1e-9),
    ):  # fmt: skip
        lens = Wavefront(f_number=f_number, zernike_waves={4: waves}, pupil=Pupil(obstruction=0.3))
        system = OpticalSystem.of([lens, camsim.SquarePhotosite(side_um=PITCH_UM)])
        seconds, images = [], []
        for kind in (difference.RoundDifference, difference.Difference):
            wavefront_module.RoundDifference = kind
            plan = functools.partial(
                render_channels, scene, system, grid, response=np.full((1, count), 1.0 / count),
                wavelength_nm=np.linspace(450.0, 650.0, count), channel=channel, tolerance=tolerance, method="fourier",
            )  # fmt: skip
            taken, found = best_of(plan, 3)
            seconds.append(taken)
            images.append(found.image)
        wavefront_module.RoundDifference = difference.RoundDifference
        print(
            f"f/{f_number:g}, {waves:g} waves, {count} wavelengths, {tolerance:g}: curve {seconds[0]:.2f} s, lattice "
            f"{seconds[1]:.2f} s, {seconds[1] / seconds[0]:.1f} times; they differ by "
            f"{np.abs(images[0] - images[1]).max() / tolerance:.1g} of the tolerance"
        )


def steep() -> None:
    """Print nodes of squares for waves that turn by 30 radians, cut and uncut."""
    turns, most = Turns(30.0, 30.0), panels.MOST_SPARE
    for terms in ({24: 1.5}, {16: 0.03, 35: 0.05, 41: 0.17}, {24: -0.12, 34: 0.23, 40: 0.27}, {47: 0.11, 51: -0.16}):
        lens = Wavefront(f_number=4.0, zernike_waves=terms, pupil=Pupil(shape="square"))
        for rule_of in (chords_of, rays_of):
            rules = []
            for panels.MOST_SPARE in (most, 1e5):
                panels.panels_of.cache_clear()
                rules.append(rule_of(lens, NM, turns))
            cut, uncut = rules
            name = rule_of.__name__.removesuffix("_of")
            print(
                f"{terms}, {name}: {len(cut.panels.which)} panels, {cut.total:.3g} nodes "
                f"in place of {uncut.total:.3g}, {uncut.total / cut.total:.0f} times fewer"
            )
    panels.MOST_SPARE = most


def rim() -> None:
    """Print what 96 × 96 photosites take in daylight, far scenery by the light of the rim and all at once."""
    lens = Wavefront(f_number=4.0, zernike_waves={6: 0.1, 8: 0.1})
    system = OpticalSystem.of([lens, camsim.FourSpotOlpf(split_um=3.66), camsim.SquarePhotosite(side_um=PITCH_UM)])
    scene, grid = (
        camsim.Scene(background=0.9, shapes=[square(2000.0, centre_px=(1000.0, 30.0))]),
        camsim.Grid(rows=96, cols=96, pitch_um=PITCH_UM),
    )
    size, hems = RimLight._size, apart.rim_hems
    for tolerance in (1e-4, 1e-5):
        plan = functools.partial(
            render_channels, scene, system, grid, response=np.full((1, 46), 1.0 / 46.0),
            wavelength_nm=np.linspace(420.0, 680.0, 46), channel=np.zeros((96, 96), np.uint8), tolerance=tolerance,
            method="fourier",
        )  # fmt: skip
        seconds, images = [], []
        for own in (False, True):
            RimLight._size = (lambda self, shape: (0, float(np.prod(shape) * len(self._offsets)))) if own else size
            taken, found = best_of(plan, 3)
            seconds.append(taken)
            images.append(found.image)
        RimLight._size, apart.rim_hems = size, lambda *task: []
        taken, found = best_of(plan, 1)
        apart.rim_hems = hems
        print(
            f"{tolerance:g}: few places {seconds[0]:.2f} s, every photosite's {seconds[1] / seconds[0]:.1f} times, "
            f"all at once {taken / seconds[0]:.1f} times; they differ by "
            f"{max(np.abs(image - found.image).max() for image in images) / tolerance:.1g} of the tolerance"
        )


def main() -> None:
    """Run what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("random", "speed", "auto", "large", "round", "steep", "rim"))
    parser.add_argument("count", nargs="?", type=int, default=50)
    given = parser.parse_args()
    if given.what == "random":
        random(given.count)
    else:
        {"speed": speed, "auto": auto, "large": large, "round": defocused, "steep": steep, "rim": rim}[given.what]()


if __name__ == "__main__":
    main()
