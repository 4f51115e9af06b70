"""What the Fourier engine makes of a crowd before it transforms it, each part against a count or another sum."""

import functools

import numpy as np
import pytest
import shapely

import camsim
from camsim.optics import OpticalSystem
from camsim.rendering import render_channels
from camsim.rendering.circles import circles
from camsim.rendering.edges import Edges, corners_of
from camsim.rendering.fourier.blocks import Place
from camsim.rendering.fourier.clamped import clamped, netted
from camsim.rendering.fourier.density import Density
from camsim.rendering.fourier.edge_transforms import Corners, edge_transforms
from camsim.rendering.fourier.image import FourierImage
from camsim.rendering.fourier.inverse import inverse
from camsim.rendering.fourier.tile import Tile
from camsim.rendering.grid import Grid
from camsim.rendering.spectral import multiples

ROUNDING = 1e-12


def loops(rng, count, spread):
    """Triangles and squares as edges, one after the other, each of a spectrum of its own (1, 2, 3)."""
    corners, starts, ends, left = [], [], [], []
    for k in range(count):
        n = 3 + k % 2
        angle = np.sort(rng.uniform(0.0, 2.0 * np.pi, n))
        own = rng.uniform(-spread, spread, 2) + rng.uniform(0.5, 6.0) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        corners.append(own)
        starts.append(own)
        ends.append(np.roll(own, -1, axis=0))
        left.append(np.full(n, 1 + k % 3))
    left = np.concatenate(left)
    edges = Edges(start=np.concatenate(starts), end=np.concatenate(ends), left=left, right=np.zeros_like(left))
    return corners, edges


def test_clamped_and_netted_outlines_have_the_areas_of_what_is_inside():
    rng = np.random.default_rng(1)
    corners, edges = loops(rng, 400, 20.0)
    origin, low, high = (0.3, -0.7), (-8.1, -5.3), (7.7, 6.1)
    inside = clamped(edges, low, high, origin)
    shares = np.concatenate([np.zeros((1, 3)), np.eye(3)])
    start, end, jump = netted(inside.start, inside.end, shares[inside.left] - shares[inside.right], low, high)
    twice = start[:, 0] * end[:, 1] - end[:, 0] * start[:, 1]
    box = shapely.box(*low, *high)
    for spectrum in range(3):
        own = [shapely.Polygon(one - origin) for k, one in enumerate(corners) if k % 3 == spectrum]
        assert 0.5 * np.sum(twice * jump[:, spectrum]) == pytest.approx(
            sum(one.intersection(box).area for one in own), abs=1e-9
        )
    # Nothing runs over anything else along a side.
    sides = 0.0
    for axis in (0, 1):
        for bound in (low[axis], high[axis]):
            along = (start[:, axis] == bound) & (end[:, axis] == bound)
            sides += float(np.abs(end - start)[along].sum())
    assert sides <= 2.0 * (high[0] - low[0] + high[1] - low[1]) + ROUNDING
    assert start.min() >= min(low)
    assert start.max() <= max(high)


def test_an_outline_about_the_whole_box_is_its_four_sides():
    a = np.array([[-9.0, -9.0], [9.0, -8.0], [8.0, 9.0], [0.0, 9.5], [-9.0, 9.0]])
    edges = Edges(start=a, end=np.roll(a, -1, axis=0), left=np.ones(5, int), right=np.zeros(5, int))
    inside = clamped(edges, (-1.0, -1.0), (1.0, 1.0))
    assert len(inside) == 4  # the two pieces along the lower side are one


def test_nothing_is_seen_in_a_box_without_area():
    """All that lay beside such a box ran to and fro along it: an ellipse of 55 000 sides left 2852 edges, a minute."""
    edges = loops(np.random.default_rng(3), 400, 20.0)[1]
    assert not len(clamped(edges, (-8.1, -30.0), (7.7, -30.0)))


def test_greys_are_alike_however_faint():
    rng = np.random.default_rng(2)
    light = rng.uniform(0.1, 1.0, (3, 40))
    greys = np.append(rng.uniform(0.0, 1.0, 300), 0.35 + 10.0 ** -np.arange(2.0, 9.0))
    contrast = (greys[:, None, None] * light - 0.35 * light).reshape(len(greys), -1)
    which, times = multiples(contrast)
    assert len(np.unique(which)) == 1
    assert np.abs(times[:, None] * contrast[which] - contrast).max() <= ROUNDING


def test_circles_touch_three_edges_in_a_row():
    rng = np.random.default_rng(5)
    grid = camsim.Grid(rows=40, cols=40, pitch_um=1.0)
    for turned in (1.0, -1.0):
        centre, radius = rng.uniform(-5.0, 5.0, 2), rng.uniform(4.0, 9.0)
        angle = np.sort(turned * (np.arange(12) + rng.uniform(-0.3, 0.3, 12)) * np.pi / 6.0)[:: int(turned)]
        # Corners where tangents at neighbouring angles meet.
        half, middle = 0.5 * np.diff(np.append(angle, angle[0] + turned * 2.0 * np.pi)), angle
        middle = angle + half
        corners = centre + (radius / np.cos(half))[:, None] * np.stack([np.cos(middle), np.sin(middle)], axis=1)
        count = len(corners)
        edges = Edges(
            start=corners, end=np.roll(corners, -1, axis=0), left=np.ones(count, int), right=np.zeros(count, int)
        )
        found, radii = circles(edges, grid=grid, nearest=1.0, blur=1.0)
        assert len(radii)
        assert np.abs(found - centre).max() <= 1e-9
        assert np.abs(radii - radius).max() <= 1e-9


def test_corners_are_those_of_all_ends():
    rng = np.random.default_rng(6)
    _, edges = loops(rng, 50, 9.0)
    mixed = edges.some(rng.permutation(len(edges)))
    for own in (edges, mixed, edges.some(np.zeros(0, int))):
        places, begins, ends = corners_of(own.start, own.end)
        assert np.array_equal(places[begins], own.start)
        assert np.array_equal(places[ends], own.end)
        assert len(places) == len(np.unique(own.points, axis=0))


def test_density_counts_what_lies_in_a_box():
    rng = np.random.default_rng(7)
    _, edges = loops(rng, 3000, 300.0)
    density, middle = Density.of(edges), 0.5 * (edges.start + edges.end)
    low, high = np.array([-130.0, -60.0]), np.array([90.0, 110.0])
    inside = ((middle >= low) & (middle <= high)).all(axis=1)
    count, length = density.within(low, high)
    assert np.count_nonzero(inside) <= count <= 1.4 * np.count_nonzero(inside)
    assert length >= edges.length[inside].sum()
    assert density.within(density.low - 1.0, density.high + 1.0)[0] == len(edges)


@pytest.mark.parametrize("cut", [0.004, 0.012, 0.03, 0.06])
def test_what_is_smooth_is_the_same_at_few_photosites_and_between(cut):
    """Against the sum of its waves, photosite by photosite."""
    rng = np.random.default_rng(8)
    tile = Tile.square((0, 0, 37, 61), inner=100.0, outer=300.0, period=1000, cut=cut, near=10.0)
    rows, columns = tile.sums
    assert rows < 1000  # added up one by one
    values = rng.normal(size=(rows, columns)) + 1j * rng.normal(size=(rows, columns))
    j, i = (np.arange(rows) + rows // 2) % rows - rows // 2, np.arange(columns)
    values[np.hypot(j[:, None], i) > cut * 1000] = 0.0
    wave_y = np.exp(2j * np.pi * np.outer(np.arange(37), j) / 1000)
    wave_x = np.exp(2j * np.pi * np.outer(i, np.arange(61)) / 1000) * np.where(i > 0, 2.0, 1.0)[:, None]
    right = (wave_y @ values @ wave_x).real / 1000**2
    assert np.abs(inverse(values, tile) - right).max() <= 1e-11 * np.abs(values).sum() / 1000**2


def test_a_tile_that_no_edge_is_left_in_has_a_transform_of_nothing():
    nothing = Corners(np.zeros((0, 2)), np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros((0, 1)))
    place = Place(first_i=-3, first_j=-4, count_i=2, count_j=21, px=24, py=24, cut=1.5, column=0, row=0, rows=24)
    assert not edge_transforms(place, nothing).any()


def test_a_colour_that_is_covered_has_no_nodes():
    starfish = camsim.Star(tips=90, radius_um=9.0, inner_radius_um=5.0, reflectance=0.1)
    red = camsim.Curve((400.0, 700.0), (0.0, 1.0), outside="hold")
    covered = camsim.Disc(radius_um=3.0, reflectance=red)
    system = OpticalSystem.of([camsim.Airy(f_number=4.0), camsim.SquarePhotosite(side_um=1.0)])
    one, both = (
        render_channels(
            camsim.Scene(background=1.0, shapes=shapes),
            system,
            Grid(rows=8, cols=8, pitch_um=1.0),
            response=np.ones((1, 2)),
            wavelength_nm=np.array([500.0, 600.0]),
            channel=np.zeros((8, 8), np.uint8),
            tolerance=1e-7,
            method="fourier",
        ).image
        for shapes in ([starfish], [covered, starfish])
    )
    np.testing.assert_allclose(both, one, rtol=0.0, atol=2e-7)


@pytest.mark.parametrize(("wavelengths", "taken"), [(3, "mixtures"), (48, "plain")])
def test_spectra_are_mixed_where_that_takes_less(monkeypatch, wavelengths, taken):
    """Each of 60 patches has a spectrum of its own: few wavelengths make few mixtures, many leave each edge with 40."""
    rng = np.random.default_rng(8)
    places = np.stack(np.meshgrid(np.arange(10), np.arange(6)), axis=-1).reshape(-1, 2) * 9.0 - [40.0, 22.0]
    nm = np.linspace(430.0, 680.0, wavelengths)
    shapes = [
        camsim.Rectangle(
            width_um=7.0,
            height_um=7.0,
            centre_um=tuple(at),
            reflectance=camsim.Curve(tuple(nm), tuple(rng.random(nm.size))),
        )
        for at in places.tolist()
    ]
    system = OpticalSystem.of([camsim.Airy(f_number=2.0), camsim.SquarePhotosite(side_um=1.0)])
    chosen, images = [], {}
    ways = FourierImage._ways.func

    def rendered():
        return render_channels(
            camsim.Scene(background=0.5, shapes=shapes), system, Grid(rows=48, cols=64, pitch_um=1.0), tolerance=1e-6,
            response=np.full((1, nm.size), 1.0 / nm.size), wavelength_nm=nm, channel=np.zeros((48, 64), np.uint8),
            method="fourier",
        ).image  # fmt: skip

    planned = FourierImage._planned
    monkeypatch.setattr(
        FourierImage,
        "_planned",
        lambda image, *where: chosen.append((image, planned(image, *where)[1])) or planned(image, *where),
    )
    images["cheaper"] = rendered()
    kinds = {
        "plain" if alike is image._ways[0] else "mixtures"
        for image, alike in chosen
        if image.shell is None and not image.over_rectangle
    }
    assert kinds == {taken}
    for name, which in (("plain", 0), ("mixtures", -1)):
        own = functools.cached_property(lambda image, which=which: (ways(image)[which],))
        own.__set_name__(FourierImage, "_ways")
        monkeypatch.setattr(FourierImage, "_ways", own)
        images[name] = rendered()
    assert np.abs(images["plain"] - images["mixtures"]).max() < 1e-7
    assert np.abs(images["plain"] - images["cheaper"]).max() < 1e-7
