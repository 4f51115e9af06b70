"""Scenery in islands, and to one side: each through its own part of a pattern, against closed forms and all at once."""

import dataclasses

import numpy as np
import pytest
import scipy

import camsim
from camsim.optics import Airy, Gaussian, OpticalSystem, Pupil, SquarePhotosite, TwoSpotOlpf, Wavefront
from camsim.rendering.edges import Edges
from camsim.rendering.fourier import window
from camsim.rendering.fourier.apart import by_place
from camsim.rendering.fourier.image import FourierImage
from camsim.rendering.fourier.islands import islands
from camsim.rendering.render import plan_render
from tests.own_optics import Blurred

ORIGIN, SHAPE = (-2.0, -1.5), (4, 5)
BOXES = [(-1.3, -0.7, 1.1, 2.4), (31.0, 5.0, 35.5, 7.2), (-26.0, -41.0, -21.0, -36.5)]  # x0, y0, x1, y1
BLUR = 0.21
RULE = scipy.special.roots_legendre(3000)


def edges_of(outlines, spectra=None):
    """Edges of closed outlines, each with a spectrum of its own unless told."""
    spectra = range(1, 1 + len(outlines)) if spectra is None else spectra
    start = np.concatenate(outlines)
    end = np.concatenate([np.roll(one, -1, axis=0) for one in outlines])
    left = np.concatenate([np.full(len(one), k) for one, k in zip(outlines, spectra, strict=True)])
    return Edges(start=start, end=end, left=left, right=np.zeros_like(left))


def box(x0, y0, x1, y1):
    return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], float)


def image_of(outlines, lens, tolerance, *, side=0.8, extra=()):
    edges = edges_of(outlines)
    levels = 1.0 - 0.2 * np.arange(len(outlines))
    return FourierImage(
        edges=edges,
        density=np.concatenate([np.zeros((1, 1, 1)), levels[:, None, None]]),
        base=np.zeros(1),
        wavelength_nm=np.array([550.0]),
        system=OpticalSystem.of([lens, *extra, SquarePhotosite(side_um=side)]),
        pitch_um=1.0,
        tolerance=tolerance,
        memory_limit_bytes=4e9,
    )


def lens_of(shape="square", waves=(), **pupil):
    return Wavefront(f_number=BLUR / 0.55, pupil=Pupil(shape=shape, **pupil), zernike_waves=waves)


def along(places, low, high, side):
    """A strip behind a slit's pattern, sinc², and a photosite: its transform is a triangle to 1/λN."""
    t, w = RULE
    f, w = 0.5 / BLUR * (1.0 + t), 0.5 / BLUR * w
    spectrum = (1.0 - f * BLUR) * (high - low) * np.sinc(f * (high - low)) * np.sinc(f * side) * w
    return 2.0 * np.cos(2.0 * np.pi * np.multiply.outer(places - 0.5 * (low + high), f)) @ spectrum


def boxes_behind_a_square(side):
    x, y = ORIGIN[0] + np.arange(SHAPE[1]), ORIGIN[1] + np.arange(SHAPE[0])
    each = [
        (1.0 - 0.2 * k) * np.multiply.outer(along(y, y0, y1, side), along(x, x0, x1, side))
        for k, (x0, y0, x1, y1) in enumerate(BOXES)
    ]
    return sum(each)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8, 1e-10])
def test_islands_behind_a_square_pupil_are_products_of_strips(tolerance):
    image = image_of([box(*one) for one in BOXES], lens_of(), tolerance)
    parts = by_place(image, ORIGIN, SHAPE)
    assert len(parts) == 3
    found = sum(part.rendered(ORIGIN, np.zeros(SHAPE, np.uint8)) for part in parts)
    assert np.abs(found - boxes_behind_a_square(0.8)).max() <= 0.3 * tolerance


LENSES = {
    "square, turned": lens_of(rotate_deg=20.0, waves={7: 0.1, 4: 0.2}),
    "five blades": lens_of("bladed", blades=5, waves={8: 0.15, 5: -0.1}),
    "a hole": lens_of(obstruction=0.4, waves={12: 0.1}),
    "coma": lens_of("circular", waves={8: 0.2}),
    "a ring and three leaves": lens_of("circular", obstruction=0.5, waves={6: 0.2}),
    "a lens of one's own": Blurred(sigma_um=0.02, f_number=BLUR / 0.55),
}


@pytest.mark.parametrize("tolerance", [1e-3, 1e-9])
@pytest.mark.parametrize("lens", LENSES)
def test_islands_are_what_all_at_once_is(lens, tolerance):
    outlines = [box(*one) for one in BOXES] + [np.array([(33.0, 30.0), (40.0, 31.0), (36.0, 37.0)])]
    image = image_of(outlines, LENSES[lens], tolerance, extra=[TwoSpotOlpf(split_um=0.7, rotate_deg=35.0)])
    whole = dataclasses.replace(image, tolerance=0.1 * tolerance)
    whole._apart[ORIGIN, SHAPE] = ()
    parts = by_place(image, ORIGIN, SHAPE)
    assert len(parts) >= 3
    channel = np.zeros(SHAPE, np.uint8)
    found = sum(part.rendered(ORIGIN, channel) for part in parts)
    assert np.abs(found - whole.rendered(ORIGIN, channel)).max() <= 0.5 * tolerance


@pytest.mark.parametrize("lens", LENSES)
def test_scenery_to_one_side_is_seen_through_a_part_of_the_pattern(lens, monkeypatch):
    """The same as about the pattern's middle, though the part does not hold it."""
    outlines = [box(14.0, 3.0, 21.0, 11.0)]
    image, tiles = image_of(outlines, LENSES[lens], 1e-9), []
    found = image.rendered(ORIGIN, np.zeros(SHAPE, np.uint8))
    tiles += image._planned(ORIGIN, SHAPE)[0].tiles
    monkeypatch.setattr(window, "NARROWER", 0.0)
    even = image_of(outlines, LENSES[lens], 1e-10)
    expected = even.rendered(ORIGIN, np.zeros(SHAPE, np.uint8))
    (even_tile,) = even._planned(ORIGIN, SHAPE)[0].tiles
    assert tiles[0].middle < (-10.0, -3.0)
    assert even_tile.middle == (0.0, 0.0)
    assert np.abs(expected).max() > 1e-6
    assert np.abs(found - expected).max() <= 5e-10


def test_a_part_of_the_pattern_is_priced():
    """Fewer samples; but no node stands for its opposite as well, and there are as many as the farthest place asks."""
    image = image_of([box(14.0, 3.0, 21.0, 11.0)], lens_of(), 1e-9)
    tile = image._planned(ORIGIN, SHAPE)[0].tiles[0]
    (low, high), _ = tile.spans
    nodes = image.kernel.pupil_nodes
    assert low < -20.0 < -8.0 < high < 0.0
    assert nodes(*tile.spans) > 1.5 * nodes((low, -low), (-13.0, 13.0)) * 0.5


def islands_of(outlines, lens=None, spectra=None):
    image = image_of(outlines, lens or lens_of(), 1e-6)
    edges = image.edges if spectra is None else edges_of(outlines, spectra)
    return islands(edges, (ORIGIN, SHAPE), image.kernel, 1, image.footprint)


def test_every_edge_is_on_one_island():
    rng = np.random.default_rng(1)
    outlines = []
    for x, y in rng.uniform(-60.0, 60.0, (300, 2)):
        outlines.append(np.array([(x, y), (x + 1.0, y + 0.2), (x + 0.3, y + 0.9)]))
    outlines += [one + np.array([400.0, 100.0]) for one in outlines[:100]]
    found = islands_of(outlines)
    assert len(found) > 1
    rows = np.concatenate([np.column_stack([one.start, one.end, one.left]) for one in found])
    every = edges_of(outlines)
    expected = np.column_stack([every.start, every.end, every.left])
    assert np.array_equal(rows[np.lexsort(rows.T)], expected[np.lexsort(expected.T)])


def test_what_hangs_together_is_one_island():
    """A long bar that reaches from the frame to what is far; and outlines that share a corner."""
    far = box(60.0, 60.0, 64.0, 64.0)
    assert len(islands_of([box(-1, -1, 1, 1), far])) == 2
    assert len(islands_of([box(-1, -1, 1, 1), far, box(0.5, 3.0, 65.0, 65.5)])) == 1
    chain = [box(4.0 * k, 4.0 * k, 4.0 * k + 4.0, 4.0 * k + 4.0) for k in range(16)]
    assert len(islands_of(chain)) == 1


def test_what_is_not_closed_is_no_island():
    """Of an outline whose corners miss one another a part would be one: its transform has a pole at 0."""
    near, far = box(-1, -1, 1, 1), box(60.0, 60.0, 64.0, 64.0)
    edges = edges_of([near, far])
    opened = dataclasses.replace(edges, end=edges.end + np.where(np.arange(8)[:, None] == 5, 1e-3, 0.0))
    image = image_of([near, far], lens_of(), 1e-6)
    assert len(islands(opened, (ORIGIN, SHAPE), image.kernel, 1, image.footprint)) == 1


@pytest.mark.parametrize("lens", [Airy(f_number=BLUR / 0.55), Gaussian(sigma_um=BLUR)], ids=["airy", "gaussian"])
def test_round_and_fading_patterns_have_no_islands(lens):
    assert not by_place(image_of([box(*one) for one in BOXES], lens, 1e-6), ORIGIN, SHAPE)


def test_islands_are_told():
    shapes = [
        camsim.Rectangle(width_um=3.0, height_um=3.0, centre_um=(x, y), reflectance=0.1)
        for x, y in ((0.4, 0.3), (70.0, -50.0))
    ]
    optics = [lens_of(waves={8: 0.2}), SquarePhotosite(side_um=0.9)]
    grid = camsim.Grid(rows=3, cols=4, pitch_um=1.0)
    scene = camsim.Scene(shapes=shapes, background=0.8)
    choice = plan_render(
        scene,
        OpticalSystem.of(optics),
        grid,
        response=np.ones((1, 1)),
        wavelength_nm=np.array([550.0]),
        tolerance=1e-9,
        method="fourier",
    )
    assert any("2 islands" in decision.decision for decision in choice.plan.decisions())
    image = camsim.render(scene, optics, grid, wavelength_nm=550.0, tolerance=1e-9, method="fourier")
    assert image.error_estimate <= 1e-9
