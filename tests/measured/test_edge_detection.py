"""Edges found by themselves: how many of a chart, in which regions, and what is said of those that cannot be told."""

import math
import re

import numpy as np
import pytest
from edges import gaussian_limit
from scipy import special
from tolerances import STATISTICAL

import camsim
from camsim.measure import CameraOtf, Picture, measure_mtf, picture_of_frame
from camsim.measure.find import find_edges
from camsim.measure.picture import mosaic_planes
from camsim.sensor.cfa import Cfa

ARRAYS = {
    "mono": ("Y",),
    "bayer": ("RG", "GB"),
    "x-trans": Cfa.named("x-trans").pattern,
    "quad-bayer": Cfa.quad_bayer().pattern,
}


def picture_of(image, array="mono", **levels):
    return Picture(name="x", shape=image.shape, planes=mosaic_planes(image, ARRAYS[array], **levels))


def block(shape, centre, sides, angle_deg, sigma):
    """How much of each photosite a turned, blurred rectangle covers, and the middles (x, y) of its four sides."""
    y, x = np.mgrid[: shape[0], : shape[1]] + 0.5
    c, s = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    u, v = (x - centre[0]) * c + (y - centre[1]) * s, (y - centre[1]) * c - (x - centre[0]) * s
    covered = np.ones(shape)
    for place, half in ((u, 0.5 * sides[0]), (v, 0.5 * sides[1])):
        covered *= special.ndtr((place + half) / sigma) * special.ndtr((half - place) / sigma)
    across, along = 0.5 * sides[0] * np.array([c, s]), 0.5 * sides[1] * np.array([-s, c])
    return covered, [np.array(centre) + side for side in (across, -across, along, -along)]


def places_of(found):
    """Middles of regions, and the places that reasons tell, (x, y)."""
    regions = [(best.col + 0.5 * best.cols, best.row + 0.5 * best.rows) for best, *_ in found.edges]
    stated = [re.search(r"at row (\d+), column (\d+)", sentence) for sentence in found.without]
    return np.array([*regions, *((float(place[2]), float(place[1])) for place in stated)])


@pytest.mark.parametrize(
    ("scene", "sides"),
    [("edge-grid", 32), ("field-lens", 4), ("e-sfr", 32)],
)
def test_sides_of_the_shipped_charts_are_found_and_measured(scene, sides):
    """As many as MTF Mapper meets. For the 140 of the lens-grid see tests/cli/test_measure_command.py."""
    capture = camsim.load(scene)
    report = measure_mtf(picture_of_frame(capture.frame()), theory=CameraOtf.of(capture))
    assert len(report.edges) >= sides
    assert len(report.edges) + len(report.refused) >= sides
    for edge in report.edges:
        error = edge.figures.mtf50_cycles_per_pixel - edge.theory.mtf50_cycles_per_pixel
        assert abs(error) < STATISTICAL * edge.standard_error.mtf50_cycles_per_pixel
    for sentence in report.refused:
        assert re.search(r"pixel axis|sampling phases repeat|picture's border|direction", sentence)


@pytest.mark.parametrize(
    ("array", "side", "contrast", "angle"),
    [
        ("mono", 25.0, 0.7, 6.0),
        ("bayer", 25.0, 0.7, 6.0),
        ("x-trans", 32.0, 0.1, -14.0),
        ("quad-bayer", 32.0, 0.1, -14.0),
        ("bayer", 60.0, 0.7, 38.0),
    ],
)
def test_every_side_of_a_block_is_found_once(rng, array, side, contrast, angle):
    """Four blocks, low contrast and high, whatever the filters: each side has a region, or a place and a reason."""
    pitch = 1.5 * side + 20.0
    shape = (math.ceil(2 * pitch), math.ceil(2 * pitch))
    image, middles = np.full(shape, 0.8), []
    for x in (0.5, 1.5):
        for y in (0.5, 1.5):
            centre = (np.array([x, y]) + rng.uniform(-0.02, 0.02, 2)) * pitch
            covered, sides = block(shape, centre, (side, side), angle, 0.7)
            image -= contrast * covered
            middles += sides
    image += rng.normal(0.0, 0.01 * contrast, shape)
    found = find_edges(picture_of(image, array))
    places = places_of(found)
    assert len(places) == 16
    for middle in middles:
        assert np.hypot(*(places - middle).T).min() < 0.3 * side


def test_an_edge_at_the_border_is_measured_beside_it(rng):
    """A block 9 px from the top, one that the border cuts, and one 1 px from it, which has no room above."""
    shape, sigma = (120, 330), 0.8
    parts = [((60, 49), (70, 80)), ((165, 5), (70, 90)), ((270, 34), (70, 66))]
    covered = [block(shape, centre, sides, 5.0, sigma)[0] for centre, sides in parts]
    image = 0.9 - 0.8 * np.sum(covered, axis=0) + rng.normal(0, 0.002, shape)
    report = measure_mtf(picture_of(image))
    assert len(report.edges) == 4 + 3 + 3
    assert [bool(re.search("px from it to the picture's border", each)) for each in report.refused] == [True]
    for edge in report.edges:
        error = edge.figures.mtf50_cycles_per_pixel - gaussian_limit(0.5, sigma)
        assert abs(error) < STATISTICAL * edge.standard_error.mtf50_cycles_per_pixel


def test_an_edge_that_another_shape_covers_is_measured_where_it_is_free(rng):
    shape, sigma = (200, 260), 0.8
    image = 0.9 - 0.8 * block(shape, (130, 300), (1000, 400), 5.0, sigma)[0]
    over = block(shape, (130, 100), (60, 90), 20.0, sigma)[0]
    image = image * (1 - over) + 0.4 * over + rng.normal(0, 0.002, shape)
    report = measure_mtf(picture_of(image))
    assert len([edge for edge in report.edges if abs(edge.figures.angle_deg - 5.0) < 0.2]) == 2
    for edge in report.edges:
        error = edge.figures.mtf50_cycles_per_pixel - gaussian_limit(0.5, sigma)
        assert abs(error) < STATISTICAL * edge.standard_error.mtf50_cycles_per_pixel


def bad_and_good(rng):
    """As a card on a table: an edge with light that rises beside it and a faint strip along it, and a square."""
    shape = (200, 460)
    y, x = np.mgrid[: shape[0], : shape[1]] + 0.5
    below = special.ndtr((y - 60 + 0.011 * x) / 2.0)
    light = 1500 + 16.0 * np.clip(y - 60, 0, None)
    strip = 150 * special.ndtr((x - 310) / 2.0) * (np.abs(y - 50 + 0.03 * (x - 310)) < 5)
    faint = 130 * (np.abs(y - 22 + 0.02 * x) < 4)
    image = 60 + below * light + (strip + faint) * (1 - below)
    image *= 1 - 0.9 * block(shape, (230, 145), (60, 60), 6.0, 0.8)[0]
    return np.clip(rng.poisson(image) + rng.normal(0, 4, shape) + 256, 0, 4000).round().astype(np.uint16)


@pytest.mark.parametrize("array", ["mono", "bayer"])
def test_an_edge_that_cannot_be_told_does_not_end_the_report(rng, array):
    report = measure_mtf(picture_of(bad_and_good(rng), array, black=256.0, white=4095.0))
    assert report.as_dict()["edges"]
    squares = [edge for edge in report.edges if abs(edge.figures.angle_deg - 6.0) < 0.5]
    assert len({edge.roi for edge in squares}) == 4
    for edge in report.edges:
        assert edge.mtf[0] == pytest.approx(1.0)
        assert edge.mtf.max() <= 1.3
    assert all(sentence.startswith("x: ") for sentence in report.refused)


def test_ragged_surfaces_are_measured_or_refused(rng):
    """Textures, discs and lines of chance: whatever is reported is the transfer function of an edge."""
    y, x = np.mgrid[:260, :260]
    image = 500.0 + x
    for _ in range(25):
        cx, cy, size, turn = rng.uniform(0, 260), rng.uniform(0, 260), rng.uniform(5, 100), rng.uniform(0, math.pi)
        u = (x - cx) * math.cos(turn) + (y - cy) * math.sin(turn)
        v = (y - cy) * math.cos(turn) - (x - cx) * math.sin(turn)
        kind = rng.integers(3)
        inside = (np.hypot(u, v) < size, np.abs(u) < 0.05 * size, (np.abs(u) < size) & (np.abs(v) < 0.5 * size))[kind]
        image = np.where(inside, rng.uniform(50, 900), image)
    image = np.clip(rng.poisson(image), 0, 1000).astype(np.uint16)
    report = measure_mtf(picture_of(image, "bayer", white=1000.0))
    report.as_dict()
    for edge in report.edges:
        assert edge.mtf[0] == pytest.approx(1.0)
        assert edge.mtf.max() <= 1.3
