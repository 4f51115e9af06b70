"""Charts: what they draw is what their standards, or one line of mathematics, say of them."""

import inspect
import itertools
import json
from collections import Counter

import numpy as np
import pytest
import scipy.special
import shapely
from tolerances import STATISTICAL

import camsim
from camsim.camera.description import describe
from camsim.config.from_record import stages_from_record
from camsim.optics import OpticalSystem
from camsim.rendering.decisions import rendering_decisions
from camsim.rendering.render import plan_render
from camsim.scene.charts import KNOWN, Chart, meanings, parameters

# One of each, as small as says something; lengths in µm.
EXAMPLES = {
    "slanted-edges": {"side_um": 40.0, "rows": 2, "cols": 3, "angles_deg": [3, 8], "dark": [0.1, 0.3], "light": 0.9},
    "e-sfr": {"height_um": 200.0},
    "lens-grid": {"width_um": 300.0, "height_um": 200.0, "cols": 5, "rows": 3, "light": 0.9},
    "siemens-star": {"radius_um": 80.0, "cycles": 8, "light": 0.9},
    "usaf-1951": {"groups": [4, 5], "light": 0.9},
    "bars": {"lp_per_mm": [20.0, 40.0], "light": 0.9},
    "checkerboard": {"side_um": 10.0, "rows": 3, "cols": 5, "light": 0.9},
    "dot-grid": {"spacing_um": 20.0, "radius_um": 5.0, "rows": 3, "cols": 4, "light": 0.9},
    "zone-plate": {"radius_um": 80.0, "rim_period_um": 12.0},
    "colorchecker": {"width_um": 150.0},
    "step-wedge": {"width_um": 120.0, "height_um": 20.0, "light": 0.9},
    "dead-leaves": {"width_um": 80.0, "height_um": 60.0, "least_radius_um": 4.0, "largest_radius_um": 20.0},
    "points": {"radius_um": 1.0, "stars": 9, "width_um": 90.0, "height_um": 60.0},
    "qr": {"text": "camsim", "width_um": 116.0},
    "random": {"width_um": 120.0, "height_um": 80.0, "shapes": 20},
}


def corners(shape):
    """Corners (n, 2) of a shape with straight sides."""
    (primitive,) = shape.primitives()
    return primitive.layers[0][0].curves.points[:, 0]


def extent(shape):
    found = corners(shape)
    return np.ptp(found, axis=0)


@pytest.mark.parametrize("name", list(KNOWN))
def test_a_chart_is_told_by_its_name_and_parameters(name):
    """So small are files that hold it, and so it is made again from them."""
    chart = Chart(name=name, parameters=EXAMPLES[name])
    stated = json.loads(json.dumps(describe(chart)))
    assert len(json.dumps(stated)) < 2000
    again = stages_from_record(stated)
    assert again == chart
    assert again.shapes == chart.shapes


def leaves(shape):
    """The shapes that a chart holds, however deep."""
    inner = getattr(shape, "shapes", None)
    return [shape] if inner is None else [leaf for each in inner for leaf in leaves(each)]


@pytest.mark.parametrize("name", list(KNOWN))
def test_it_is_told_what_a_chart_became_and_what_was_left_out(name):
    """Kinds, outlines and sides by counting what it holds; all of it is left out under a cover."""
    chart = Chart(name=name, parameters=EXAMPLES[name])
    kinds = Counter(type(leaf).__name__ for leaf in leaves(chart))
    outlines = sum(len(list(leaf.primitives())) for leaf in leaves(chart))
    cover = camsim.Rectangle(width_um=1e4, height_um=1e4, reflectance=0.5)
    for shapes in ([chart], [chart, cover]):
        choice = plan_render(
            camsim.Scene(background=0.9, shapes=shapes),
            OpticalSystem.of([camsim.Airy(f_number=8.0), camsim.SquarePhotosite(side_um=4.0)]),
            camsim.Grid(rows=8, cols=8, pitch_um=4.0),
            response=np.ones((1, 1)),
            wavelength_nm=np.array([550.0]),
            tolerance=1e-2,
            method="boundary",
        )
        stated = [
            (d.topic, d.decision, d.reason) for d in rendering_decisions(choice, light_samples=1, shapes=len(shapes))
        ]
        ((_, became, made_of), *_) = [line for line in stated if line[0] == "shape"]
        left_out = choice.plan.job.left_out
        assert became == f"{name} 0: {left_out.sides[:outlines].sum()} sides"
        assert made_of.startswith("".join(f"{count} × {kind}, " for kind, count in kinds.most_common()))
        assert f", {outlines} outline" in made_of
        if kinds.keys() <= {"Rectangle", "Polygon", "Disc", "Sector"}:
            one_each = kinds["Disc"] + kinds["Sector"]
            assert made_of.count(f", {one_each} curves among them") == made_of.count("curves") == (one_each > 0)
        if cover in shapes:
            assert f"{outlines} left out: wholly under a later one" in made_of
            assert any(topic == "scene" and text.startswith("4 edges from ") for topic, text, _ in stated)


def test_every_chart_has_an_example():
    assert set(EXAMPLES) == set(KNOWN)


@pytest.mark.parametrize("name", list(KNOWN))
def test_a_chart_moves_with_its_centre(name):
    """Every corner, curve and colour is the same one, moved."""
    here = Chart(name=name, parameters=EXAMPLES[name])
    there = Chart(name=name, parameters=EXAMPLES[name] | {"centre_um": (64.0, -32.0)})
    assert here.name == there.name == name
    assert len(here.shapes) == len(there.shapes) > 1
    for one, two in zip(here.primitives(), there.primitives(), strict=True):
        assert one.reflectance == two.reflectance
        moved = two.layers[0][0].curves.boxes - [64.0, -32.0, 64.0, -32.0]
        np.testing.assert_allclose(one.layers[0][0].curves.boxes, moved, atol=1e-9)


@pytest.mark.parametrize("name", list(KNOWN))
def test_every_parameter_is_documented_and_judged(name):
    draw = KNOWN[name]
    assert set(meanings(draw)) == set(parameters(draw)) == set(inspect.signature(draw).parameters)
    for key in parameters(draw):
        with pytest.raises(camsim.CamsimError, match=rf"{draw.__name__}\.{key}: "):
            Chart(name=name, parameters=EXAMPLES[name] | {key: object()})


def test_usaf_elements_have_the_frequencies_and_proportions_of_the_standard():
    """MIL-STD-150A: 2^(group + (element − 1)/6) line pairs per mm, bars 5 : 1, three of them in two directions."""
    groups = (2, 3, 4, 7)
    bars = iter(camsim.charts.usaf_1951(groups=groups, labels=False).shapes)
    for group, element in itertools.product(groups, range(1, 7)):
        period_um = 1e3 / (4.0 if group == 2 else 8.0 if group == 3 else 16.0 if group == 4 else 128.0)
        period_um /= 1.122462048309373 ** (element - 1)  # the sixth root of 2
        for axis in (0, 1):
            three = [corners(next(bars)) for _ in range(3)]
            starts = [bar[:, axis].min() for bar in three]
            np.testing.assert_allclose(np.diff(starts), period_um, rtol=1e-9)
            for bar in three:
                np.testing.assert_allclose(np.ptp(bar, axis=0)[axis], 0.5 * period_um, rtol=1e-9)
                np.testing.assert_allclose(np.ptp(bar, axis=0)[1 - axis], 2.5 * period_um, rtol=1e-9)
    assert next(bars, None) is None


def test_usaf_elements_keep_their_distance():
    """No bar is nearer to another element's than it is wide, over three pairs of groups in one another."""
    bars = camsim.charts.usaf_1951(groups=range(6), labels=False).shapes
    elements = [
        shapely.MultiPolygon([shapely.Polygon(corners(bar)) for bar in bars[i : i + 6]]) for i in range(0, 216, 6)
    ]
    for (i, one), (j, two) in itertools.combinations(enumerate(elements), 2):
        finer_um = min(min(extent(bars[6 * k])) for k in (i, j))
        assert one.distance(two) > 0.99 * finer_um


def test_bars_have_their_frequencies():
    bars = camsim.charts.bars(lp_per_mm=[10.0, 33.0], pairs=4, length_um=500.0).shapes
    for some, period_um in ((bars[:4], 100.0), (bars[4:], 1e3 / 33.0)):
        np.testing.assert_allclose(np.diff([bar.centre_um[0] for bar in some]), period_um, rtol=1e-12)
        np.testing.assert_allclose([bar.width_um for bar in some], 0.5 * period_um, rtol=1e-12)
    assert camsim.charts.bars(periods_um=[100.0]).shapes == camsim.charts.bars(lp_per_mm=[10.0]).shapes


def test_blocks_of_the_lens_grid_have_radial_and_tangential_sides():
    blocks = camsim.charts.lens_grid(width_um=3000.0, height_um=2000.0).shapes
    skewed = [corners(block) for block in blocks if np.hypot(*corners(block).mean(axis=0)) > 150.0]
    assert len(skewed) == len(blocks) - 1
    for block in skewed:
        sides = np.roll(block, -1, axis=0) - block
        rays = 0.5 * (np.roll(block, -1, axis=0) + block)
        sine = np.cross(np.c_[sides, 0 * sides[:, 0]], np.c_[rays, 0 * rays[:, 0]])[:, 2]
        sine /= np.hypot(*sides.T) * np.hypot(*rays.T)
        # Two sides run through the axis, the other two across their own rays.
        np.testing.assert_allclose(np.sort(np.abs(sine)), [0.0, 0.0, 1.0, 1.0], atol=1e-9)


def test_dead_leaves_have_the_spectrum_of_natural_pictures():
    """1/f² over a decade below the frequency of the least discs.

    Two places d apart lie on one leaf with a probability of γ(d)/(2γ(0) − γ(d)), γ(d) the mean overlap of a disc with
    itself moved by d: so the radii that are drawn say the spectrum. Pictures painted of the discs, the last on top,
    must have it.
    """
    least, side, ends = 3.0, 384, np.geomspace(0.0105, 0.105, 11)
    middles = np.sqrt(ends[1:] * ends[:-1])
    leaves = [leaves_of(seed, side, least) for seed in range(3)]
    law = spectrum_of(np.array([disc.radius_um for disc in leaves[0].shapes]), middles)
    slope, _ = np.polyfit(np.log(middles), np.log(law), 1)
    assert abs(slope + 2.0) < 0.1

    power = np.mean([power_of(painted(chart, side)) for chart in leaves], axis=0)
    frequency = np.hypot(np.fft.fftfreq(side)[:, None], np.fft.fftfreq(side))
    rings = [(frequency >= a) & (frequency < b) for a, b in itertools.pairwise(ends)]
    found = np.array([power[ring].mean() for ring in rings])
    # A Hann window leaves 4/9 of the frequencies independent along each axis, and half of them are the others' mirror.
    free = np.array([ring.sum() for ring in rings]) * len(leaves) / 2.0 * (4.0 / 9.0) ** 2
    off = np.log(found / law) - np.average(np.log(found / law), weights=free)
    np.testing.assert_array_less(np.abs(off), STATISTICAL / np.sqrt(free) + 0.05)


def leaves_of(seed, side, least):
    return camsim.charts.dead_leaves(
        width_um=side, height_um=side, least_radius_um=least, largest_radius_um=50.0 * least, seed=seed
    )


def spectrum_of(radii, frequency):
    """Transform of the covariance of dead leaves, up to a factor."""
    apart = np.linspace(0.0, 2.0 * radii.max(), 1000)
    overlap = np.empty_like(apart)
    for index, distance in enumerate(apart):
        reaching = radii[2.0 * radii > distance]
        share = distance / (2.0 * reaching)
        overlap[index] = np.sum(reaching**2 * (np.arccos(share) - share * np.sqrt(1.0 - share**2)))
    covariance = overlap / (2.0 * overlap[0] - overlap)
    return [np.trapezoid(covariance * scipy.special.j0(2.0 * np.pi * f * apart) * apart, apart) for f in frequency]


def painted(leaves, side):
    """What is seen at side × side places 1 µm apart."""
    seen = np.full((side, side), 0.35)
    for disc in leaves.shapes:
        (x, y), radius = np.add(disc.centre_um, 0.5 * side - 0.5), disc.radius_um
        rows = slice(max(0, int(np.ceil(y - radius))), max(0, min(side, int(y + radius) + 1)))
        cols = slice(max(0, int(np.ceil(x - radius))), max(0, min(side, int(x + radius) + 1)))
        down, across = np.ogrid[rows, cols]
        seen[rows, cols][(across - x) ** 2 + (down - y) ** 2 < radius**2] = disc.reflectance
    return seen


def power_of(seen):
    taper = np.hanning(len(seen))[:, None] * np.hanning(len(seen))
    mean = (seen * taper).sum() / taper.sum()
    return np.abs(np.fft.fft2((seen - mean) * taper)) ** 2
