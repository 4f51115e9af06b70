"""The list of stiff and extreme cases; how each is judged is in extremes.py."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np

import camsim
from bench.extremes.judging import (
    ASKED,
    CORNERS,
    SLANTED,
    ExtremeCase,
    Outcome,
    Picture,
    by_fourier,
    by_identity,
    by_quadrature,
    by_rays,
    mesh,
    metamers,
    refused,
    square,
    star,
)

Places = Sequence[tuple[int, int]]


def _quadrature(name: str, words: str, picture: Picture, places: Places = CORNERS) -> ExtremeCase:
    return ExtremeCase(name=name, input=words, run=lambda: by_quadrature(picture, places))


def _fourier(name: str, words: str, picture: Picture) -> ExtremeCase:
    return ExtremeCase(name=name, input=words, run=lambda: by_fourier(picture))


def _case(name: str, words: str, run: Callable[[], Outcome]) -> ExtremeCase:
    return ExtremeCase(name=name, input=words, run=run)


def _optics() -> Iterator[ExtremeCase]:
    for f_number in (0.5, 1.4, 8.0, 32.0, 128.0):
        lambda_n = 0.55 * f_number / 4.88
        picture = Picture(shapes=[(SLANTED, 1.0)], lambda_n=lambda_n, split=0.75, pitch_um=4.88, wavelength_nm=550.0)
        yield _quadrature(f"f/{f_number:g}", f"550 nm on 4.88 µm with OLPF, λN = {lambda_n:.3g} pitches", picture)
    for nm in (200.0, 2000.0):
        picture = Picture(shapes=[(SLANTED, 1.0)], lambda_n=8e-3 * nm / 4.0, wavelength_nm=nm)
        yield _quadrature(f"{nm:g} nm", f"f/8 on 4 µm, λN = {picture.lambda_n:g} pitches", picture)
    for pitch_um in (0.5, 50.0):
        picture = Picture(shapes=[(SLANTED, 1.0)], lambda_n=4.0 / pitch_um, pitch_um=pitch_um)
        words = f"f/8, 500 nm, λN = {picture.lambda_n:g} pitches"
        yield _quadrature(f"pitch {pitch_um:g} µm", words, picture, CORNERS[1:3])
    picture = Picture(shapes=[(SLANTED, 1.0)], lambda_n=0.002, side=0.0)
    yield _quadrature("λN = 0.002, points", "sharpest: point samples near a slanted square", picture)
    picture = Picture(shapes=[(square(1.7, centre=(0.1, 0.2), turn_deg=11.0), 1.0)], lambda_n=0.01, rows=4, cols=4)
    yield _fourier("λN = 0.01, photosites", "sharp: whole photosites, a slanted square of 1.7 pitches", picture)
    picture = Picture(shapes=[(square(300.0, turn_deg=17.0), 1.0)], lambda_n=512.0)
    yield _quadrature("λN = 512", "softest: a square of 300 pitches", picture)
    for tolerance in (1e-2, 1e-9):
        picture = Picture(shapes=[(SLANTED, 1.0)], tolerance=tolerance)
        yield _fourier(f"tolerance {tolerance:g}", "λN = 1 pitch, a slanted square", picture)


def _small_and_thin() -> Iterator[ExtremeCase]:
    sliver = [(-3.0, 0.2), (3.0, 0.9), (3.0, 0.9 + 1e-9), (-3.0, 0.2 + 1e-9)]
    yield _quadrature("sliver 1e-9", "1e-9 pitches wide, 6 long", Picture(shapes=[(sliver, 1.0)], tolerance=1e-9))
    tiny = [(0.3, 0.2), (0.3 + 1.4e-6, 0.2), (0.3, 0.2 + 1.4e-6)]
    yield _quadrature("area 1e-12", "a triangle of 1e-12 square pitches", Picture(shapes=[(tiny, 1.0)], tolerance=1e-9))
    again = [*SLANTED[:2], SLANTED[1], 0.5 * (SLANTED[1] + SLANTED[2]), *SLANTED[2:], SLANTED[3], SLANTED[0]]
    twice = Picture(shapes=[([tuple(p) for p in again], 1.0)])
    yield _case(
        "points twice, points in line",
        "a slanted square with corners given twice and a point on a side",
        lambda: by_quadrature(Picture(shapes=[(SLANTED, 1.0)]), CORNERS, render=twice.render),
    )


def _places() -> Iterator[ExtremeCase]:
    through = Picture(shapes=[(square(5.0, centre=(0.0, 0.0)), 1.0)])
    yield _quadrature("edges through centres", "sides through photosites' centres, corners on them", through)
    border = Picture(shapes=[(square(4.0), 1.0)])
    yield _quadrature("edges along borders", "sides along photosites' borders, corners on their corners", border)
    frame = Picture(shapes=[(square(8.0), 1.0)])
    yield _quadrature("corners on the frame's", "a square whose corners are the frame's", frame)
    diamond = Picture(shapes=[([(0.0, -4.0), (4.0, 0.0), (0.0, 4.0), (-4.0, 0.0)], 1.0)])
    yield _quadrature("corners on the frame's border", "a diamond inscribed in the frame", diamond)
    offset = np.array([2.0**20, -(2.0**20)])
    yield _case(
        "a million pitches away",
        "the slanted square and its window 2^20 pitches from the axis",
        lambda: _far_from_the_axis(offset),
    )
    one = Picture(shapes=[(SLANTED, 1.0)], rows=1, cols=1)
    yield _quadrature("1 × 1", "a frame of one photosite", one, [(0, 0)])
    line = Picture(shapes=[(SLANTED, 1.0)], rows=1, cols=500)
    yield _quadrature("1 × 500", "a frame of one row", line, [(0, 0), (0, 248), (0, 251), (0, 499)])


def _far_from_the_axis(offset: np.ndarray) -> Outcome:
    """The window moves with the shape: the grid is a part of an enormous frame."""
    picture = Picture(shapes=[(SLANTED + offset, 1.0)])
    size = 2**22

    def window() -> camsim.Rendering:
        origin = (size // 2 + int(offset[1]) - 4, size // 2 + int(offset[0]) - 4)
        grid = camsim.Grid(rows=8, cols=8, pitch_um=picture.pitch_um, origin=origin, frame=(size, size))
        return camsim.render(picture.scene, picture.optics, grid, wavelength_nm=500.0, tolerance=ASKED)

    return by_quadrature(Picture(shapes=[(SLANTED, 1.0)]), CORNERS, render=window)


def _scenes() -> Iterator[ExtremeCase]:
    hole = Picture(shapes=[(square(6.0), 1.0), (square(2.3, centre=(0.2, 0.3), turn_deg=30.0), 0.0)])
    yield _case("hole", "a square with a slanted hole", lambda: _hole(hole))
    plain = Picture(shapes=[(tile, 0.8) for tile in mesh(50, 40.0)], rows=48, cols=48)
    yield _case(
        "2500 tiles, one colour",
        "crooked tiles that share all edges",
        lambda: by_identity(
            plain,
            lambda: Picture(shapes=[(square(40.0), 0.8)], rows=48, cols=48, tolerance=1e-9).render().image,
            "their sum is the whole square",
        ),
    )
    chess = Picture(shapes=[(tile, (0.2, 0.5, 0.9)[n % 3]) for n, tile in enumerate(mesh(50, 40.0))], rows=48, cols=48)
    yield _fourier("2500 tiles, three colours", "crooked tiles that share all edges", chess)
    outline = star(10_000, 30.0)
    yield _quadrature(
        "10 000 corners",
        "one outline, in and out, across a frame of 64 × 64",
        Picture(shapes=[(outline, 1.0)], rows=64, cols=64),
        [(32, 2), (5, 40)],
    )
    empty = Picture(shapes=[], background=0.3)
    yield _case("empty scene", "a background", lambda: by_identity(empty, lambda: 0.3, "the background"))
    cover = Picture(shapes=[(square(1e7), 0.7)], background=0.1)
    yield _case(
        "all covered", "a square of 1e7 pitches", lambda: by_identity(cover, lambda: 0.7, "its own brightness, to 1e-7")
    )
    half = Picture(shapes=[([(0.4, -1e7), (2e7, -1e7), (2e7, 1e7), (0.4, 1e7)], 1.0)], side=0.0)
    yield _case("half-plane", "all to the right of a line, point samples", lambda: by_rays(half, 0.4, 1.0))
    dim = Picture(shapes=[(SLANTED, 1.0)], background=1e-6)
    yield _quadrature("contrast 1 : 1e-6", "white on a background of 1e-6", dim)
    dark = Picture(shapes=[(SLANTED, 1e-6)], background=1.0)
    yield _quadrature("contrast 1e-6 : 1", "a surface of 1e-6 on white", dark)
    yield _case("metameric neighbours", "alike to the channel, of two wavelengths; λN = 0.9 and 1.3", metamers)


def _hole(picture: Picture) -> Outcome:
    """The hole's light is the outer square's less the inner one's."""
    (rim, light), (hole, _) = picture.shapes
    return by_quadrature(Picture(shapes=[(rim, light), (hole, -light)]), CORNERS, render=picture.render)


def _refusals() -> Iterator[ExtremeCase]:
    good = Picture(shapes=[(SLANTED, 1.0)])

    def with_points(points: Sequence[tuple[float, float]]) -> Callable[[], object]:
        return lambda: camsim.Polygon(points_um=tuple(points), reflectance=0.0)

    yield refused("self-crossing", "a bow tie", with_points([(0, 0), (2, 2), (2, 0), (0, 2)]))
    yield refused("not a number", "a corner at nan", with_points([(0, 0), (math.nan, 2), (2, 0)]))
    yield refused("infinite", "a corner at infinity", with_points([(0, 0), (math.inf, 2), (2, 0)]))
    yield refused("beyond everything", "a corner at 1e300 µm", with_points([(0, 0), (1e300, 2), (2, 0)]))
    yield refused("two points", "a polygon of two points", with_points([(0, 0), (1, 2), (0, 0)]))
    yield refused("strips, Airy", "method strips with an Airy lens", lambda: good.render("strips"))
    yield refused("boundary below its limit", "tolerance 1e-12", lambda: good.render("boundary", 1e-12))
    yield refused("all below their limit", "tolerance 1e-13", lambda: good.render("auto", 1e-13))
    yield refused("unknown method", "method 'boundry'", lambda: good.render("boundry"))
    yield refused("no wavelength", "−1 nm", lambda: Picture(shapes=[], wavelength_nm=-1.0, lambda_n=-1.0).render())
    wide = Picture(shapes=[(SLANTED, 1.0)], lambda_n=20.0, tolerance=1e-11)
    yield refused("fourier, too much memory", "λN = 20 at 1e-11", lambda: wide.render("fourier"))
    for words, origin in (("partly", (1990, 0)), ("wholly", (5000, 0))):
        region = camsim.Region(rows=64, cols=64, origin=origin)
        at = f"64 × 64 at {list(origin)} of 2000 × 3008"
        yield refused(f"region {words} outside", at, functools.partial(_taken, region))


def _taken(region: camsim.Region) -> object:
    camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8.0))
    return camera.expose(
        camsim.Scene(background=0.5),
        light=camsim.Light("D55", illuminance_lux=1000.0),
        exposure=camsim.Exposure(time_s=0.01, iso=200.0),
        region=region,
    )


ALL: tuple[ExtremeCase, ...] = (*_optics(), *_small_and_thin(), *_places(), *_scenes(), *_refusals())
