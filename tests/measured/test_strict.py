"""strict: an error above the tolerance is a failure that says where; without it a warning in the report."""

import dataclasses

import numpy as np
import pytest
import shapely
from examples import OPTICS, PICTURE, TOLERANCE, WAVELENGTH_NM, grid_of, scene_of, worst

import camsim
from camsim.errors import AccuracyError
from camsim.optics import OpticalSystem
from camsim.rendering.boundary import engine as boundary_engine
from camsim.rendering.check.crossings import bounds_of, crossed
from camsim.rendering.check.judge import WINDOW
from camsim.rendering.check.outlines import outlines_of
from camsim.rendering.check.patch_nodes import gathered, in_patch
from camsim.rendering.check.places import _tile_corner, hardest_photosites, windows
from camsim.rendering.check.records import Outlines
from camsim.rendering.engine import Marks
from camsim.rendering.render import plan_render
from camsim.scene.arcs import Fineness


def rendered(method, *, optics=OPTICS["f/8"], tolerance=TOLERANCE, strict=False, samples=None, **window):
    return camsim.render(
        scene_of(PICTURE),
        optics,
        grid_of(24, 24, **window),
        wavelength_nm=WAVELENGTH_NM,
        method=method,
        tolerance=tolerance,
        strict=strict,
        samples=samples,
    )


@pytest.mark.parametrize("method", ["area", "uniform", "uniform-pixel", "importance"])
def test_a_method_that_is_not_accurate_enough_fails(method):
    found = rendered(method)
    assert found.error_estimate > TOLERANCE
    with pytest.raises(
        AccuracyError, match=r"photosite \[\d+, \d+\] is off by .*tolerance is 1e-06 \(method"
    ) as raised:
        rendered(method, strict=True)
    assert "use method boundary, or allow more" in str(raised.value)
    assert f"{found.error_estimate:.2g}" in str(raised.value)


@pytest.mark.parametrize("method", ["boundary", "fourier", "auto"])
def test_an_accurate_one_does_not(method):
    assert worst(rendered(method, strict=True).image, rendered(method).image) == 0.0


def test_the_place_is_where_the_error_is(monkeypatch):
    """One photosite of the frame is corrupted: it is the one that is named, in the frame's own rows and columns."""
    row, col = corrupt(monkeypatch, 1e-3, lambda channel: True)
    place = rf"photosite \[{row + 100}, {col + 50}\] is off by 0.001,"
    with pytest.raises(AccuracyError, match=place):
        rendered("boundary", strict=True, origin=(100, 50), frame=(224, 124))


@pytest.mark.parametrize("off", [0.5, 2.0])
def test_what_is_beyond_the_tolerance_is_refused_and_no_more(monkeypatch, off):
    corrupt(monkeypatch, off * 1e-3, lambda channel: True)
    if off < 1.0:
        assert rendered("boundary", tolerance=1e-3, strict=True).error_estimate == pytest.approx(off * 1e-3, rel=0.1)
    else:
        with pytest.raises(AccuracyError, match=r"is off by 0\.002, and the tolerance is 0\.001"):
            rendered("boundary", tolerance=1e-3, strict=True)


@pytest.mark.parametrize("every_channel", [False, True])
def test_strict_looks_at_every_plane_that_is_asked_for(monkeypatch, every_channel):
    """Only the second channel's plane is corrupted, at a photosite that is the first channel's."""
    from camsim.optics import OpticalSystem
    from camsim.rendering.render import render_channels

    channel = np.zeros((24, 24), np.uint8)
    channel[0, 0] = 1
    corrupt(monkeypatch, 1e-3, lambda channel: (channel == 1).all())

    def rendered_channels():
        return render_channels(
            scene_of(PICTURE),
            OpticalSystem.of(OPTICS["f/8"]),
            grid_of(24, 24),
            response=np.ones((2, 1)),
            wavelength_nm=np.array([WAVELENGTH_NM]),
            channel=channel,
            tolerance=TOLERANCE,
            method="boundary",
            every_channel=every_channel,
            strict=True,
        )

    if every_channel:
        with pytest.raises(AccuracyError, match=r"is off by 0\.001"):
            rendered_channels()
    else:
        assert rendered_channels().error_estimate <= TOLERANCE


def corrupt(monkeypatch, by, where):
    """Raise one of the photosites that are checked, in images of which ``where`` says so of the channels."""
    run = boundary_engine.BoundaryPlan
    true_bands = run.bands
    row, col = (int(i[0]) for i in camsim_hardest())

    def corrupted(self, channel, progress):
        for band in true_bands(self, channel, progress):
            band[row, col] += by if where(channel) else 0.0
            yield band

    monkeypatch.setattr(run, "bands", corrupted)
    return row, col


def camsim_hardest():
    """Rows and columns that are checked of the 24 × 24 window, from a job of the same scene."""
    from camsim.optics import OpticalSystem
    from camsim.rendering.render import plan_render

    choice = plan_render(
        scene_of(PICTURE),
        OpticalSystem.of(OPTICS["f/8"]),
        grid_of(24, 24, origin=(100, 50), frame=(224, 124)),
        response=np.ones((1, 1)),
        wavelength_nm=np.array([WAVELENGTH_NM]),
        tolerance=TOLERANCE,
        method="boundary",
    )
    return choice.judge.hardest(choice.plan)


def test_windows_end_where_a_photosite_hears_no_rings():
    """A point hears them six times as far; integrals of the check that know all rings agree with such windows."""
    scene = camsim.Scene(background=0.3, shapes=[camsim.Rectangle(width_um=900.0, height_um=700.0, reflectance=0.9)])
    optics = [camsim.Airy(f_number=0.7), camsim.FourSpotOlpf(split_um=3.0), camsim.SquarePhotosite(side_um=4.0)]
    grid = camsim.Grid(rows=4, cols=4, pitch_um=4.0, origin=(50, 60), frame=(300, 300))
    given = {"response": np.ones((1, 1)), "wavelength_nm": np.array([WAVELENGTH_NM]), "tolerance": 1e-9}
    of_point = [optics[0], camsim.SquarePhotosite(side_um=0.0)]
    heard = []
    for stages in (of_point, optics):
        choice = plan_render(scene, OpticalSystem.of(stages), grid, method="fourier", **given)
        judge = choice.judge
        heard.append(judge._heard(choice.plan.job))
    assert heard[1] < heard[0] / 6.0
    rows, cols, sets = np.array([0, 1, 2]), np.array([0, 2, 1]), np.zeros(3, np.int64)
    points = np.array(grid.first_centre) + np.stack([cols, rows], axis=1)
    integrated = judge.base[sets] + judge.integrals.values(points, sets[None])[0]
    assert worst(judge._whole.values(rows, cols, sets.astype(np.uint8)), integrated) <= 1e-10


def test_a_capture_warns_or_fails(monkeypatch):
    plan = boundary_engine.plan_boundary

    def careless(*args, **kwargs):
        return dataclasses.replace(plan(*args, **kwargs), field_step=1.5, panel=4.0)

    monkeypatch.setattr(boundary_engine, "plan_boundary", careless)
    camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=8.0))
    pitch = camera.pitch_um
    scene = camsim.Scene(
        background=0.9, shapes=[camsim.Rectangle(width_um=6 * pitch, height_um=7 * pitch, reflectance=0.1)]
    )
    how = {
        "light": camsim.Light("D55", illuminance_lux=1000.0),
        "exposure": camsim.Exposure(time_s=0.01, iso=100.0),
        "region": camsim.Region(rows=20, cols=20),
    }
    warned = camera.expose(scene, **how).report
    assert warned.error_estimate > warned.tolerance
    assert warned.notes[0].startswith("warning: the error found, ")
    with pytest.raises(AccuracyError, match="report this as a bug of camsim, or allow more"):
        camera.expose(scene, strict=True, **how)


def test_importance_says_what_chance_has_left():
    """A quarter of the spread for sixteen times the samples; about the error that is really there."""
    few, many = (rendered("importance", samples=n) for n in (500, 8000))
    assert few.standard_error / many.standard_error == pytest.approx(4.0, rel=0.1)
    assert 0.02 * few.standard_error < few.error_estimate < 4.0 * few.standard_error
    for method in ("area", "uniform", "boundary", "fourier"):
        assert rendered(method).standard_error is None


class Coma:
    """A lens of the user's own: an Airy pattern, smeared to one side."""

    place = "lens"

    def otf(self, fx_per_um, fy_per_um, wavelength_nm):
        blur = np.exp(-2j * np.pi * 1.5 * fx_per_um) * 0.3 + 0.7
        return camsim.Airy(f_number=8.0).otf(fx_per_um, fy_per_um, wavelength_nm) * blur

    def cutoff_per_um(self, wavelength_nm):
        return camsim.Airy(f_number=8.0).cutoff_per_um(wavelength_nm)


def test_fourier_judges_itself_where_nothing_else_can(monkeypatch):
    """A lens that is not round: windows of its own, by other periods, tapers and bands; a corrupted image is seen."""
    from camsim.rendering.fourier.image import FourierImage

    optics = [Coma(), camsim.SquarePhotosite(side_um=4.0)]
    honest = rendered("auto", optics=optics, tolerance=1e-8)
    assert honest.method == "fourier"
    assert honest.error_estimate <= 1e-8
    assert honest.checked_photosites == 2 * WINDOW**2 + 1  # two windows, and what is farthest away
    true_image = FourierImage.rendered

    def corrupted(self, origin, channel, *progress):
        image = true_image(self, origin, channel, *progress)
        return image * (1.0 + 1e-5) if channel.shape[-2:] == (24, 24) else image

    monkeypatch.setattr(FourierImage, "rendered", corrupted)
    assert rendered("auto", optics=optics, tolerance=1e-8).error_estimate > 1e-6


@pytest.mark.parametrize("every_channel", [False, True])
def test_a_small_frame_is_transformed_twice_whatever_is_asked_for(monkeypatch, every_channel):
    """Once for the image and once for the check: two windows are one where that takes less, channels share theirs."""
    from camsim.optics import OpticalSystem
    from camsim.rendering.fourier.image import FourierImage
    from camsim.rendering.render import render_channels

    shapes, true_image = [], FourierImage.rendered

    def seen(self, origin, channel, *progress):
        shapes.append(channel.shape[-2:])
        return true_image(self, origin, channel, *progress)

    monkeypatch.setattr(FourierImage, "rendered", seen)
    channel = np.indices((6, 6)).sum(axis=0).astype(np.uint8) % 3
    response, nm = np.array([[1.0, 0.2], [0.3, 1.0], [0.5, 0.5]]), np.array([450.0, 600.0])

    def planes(**asked):
        return render_channels(
            scene_of(PICTURE),
            OpticalSystem.of([Coma(), camsim.SquarePhotosite(side_um=4.0)]),
            grid_of(6, 6),
            response=response,
            wavelength_nm=nm,
            channel=channel,
            tolerance=1e-8,
            **asked,
        )

    found = planes(every_channel=every_channel)
    assert len(shapes) == 2
    assert shapes[0] == (6, 6)
    assert found.checked_photosites == 2 * WINDOW**2 + 1  # two windows, and what is farthest away
    assert found.error_estimate <= 1e-8
    if every_channel:
        np.testing.assert_array_equal(np.take_along_axis(found.planes, channel[None], axis=0)[0], planes().image)


@pytest.mark.parametrize(("rows", "cols"), [(1, 1), (2, 9), (24, 24)])
def test_windows_lie_within_the_grid(rows, cols):
    triangle = scene_of([(np.array([(-1e3, 0.0), (0.2, 0.3), (1e3, 1e3)]), 0.5)])
    outlines, *_ = outlines_of(triangle, 4.0, Fineness())
    row, col = windows(outlines, grid_of(rows, cols), WINDOW)
    assert row.min() >= 0
    assert row.max() < rows
    assert col.min() >= 0
    assert col.max() < cols


def test_parts_without_a_direction_are_looked_at_from_any_side():
    """An arc shorter than rounding begins where it ends: photosites beside it were NaN, a crash."""
    nothing = Outlines(*(np.array([value]) for value in (-4e3, 2.0, 4e3, 0.0, 0.0, 1e-18)))
    grid, marks = grid_of(24, 24), Marks(near=3.0, quiet=9.0, reach=5.0, leaf=16, apart=20.0)
    for row, col in (hardest_photosites(nothing, grid, marks, count=16), windows(nothing, grid, WINDOW, 5.0)):
        assert len(row) >= 16
        assert ((row >= 0) & (row < 24) & (col >= 0) & (col < 24)).all()


def test_the_check_looks_at_corners_of_tiles_that_are_just_far_enough():
    """In the corner of a tile that has one part of the scene nearer than what is interpolated, and another beyond."""
    rng = np.random.default_rng(2)
    leaf, apart, grid = 16, 20.0, grid_of(128, 112)
    marks, found = Marks(near=3.0, quiet=9.0, reach=5.0, leaf=leaf, apart=apart), 0
    for turn in range(60):
        start = rng.uniform(-50.0, 50.0, (9, 2))
        end = np.roll(start, -1, axis=0)
        place = _tile_corner(start, end, marks, grid, turn)
        if place is None:
            continue
        found += 1
        index = place - grid.first_centre
        tile = index // leaf * leaf
        assert set((index - tile).tolist()) <= {0.0, leaf - 1.0}
        # The tile's photosites reach half a pitch beyond their centres.
        ends = np.stack([start, end]) - grid.first_centre + 0.5
        gap = np.maximum(np.maximum(tile - ends, ends - tile - leaf), 0.0)
        far = np.hypot(gap[..., 0], gap[..., 1]).min(axis=0) >= apart
        assert far.any()
        assert not far.all()
    assert found > 30


@pytest.mark.parametrize(("turn_deg", "step_um"), [(0.0, -8.0), (180.0, 8.0)])
def test_the_check_looks_where_what_an_outline_cuts_changes_most(turn_deg, step_um):
    """Between the second and third sample of eight, each 4 µm wide: at most half a sample beside."""
    falls = np.array([0.0, 0.0, 1.0, 0.6, 0.3, 0.0, 0.0, 0.0])
    picture = camsim.Picture(planes=np.tile(falls, (6, 1)), width_um=32.0, rotate_deg=turn_deg)
    cover = camsim.Rectangle(width_um=100.0, height_um=20.0, centre_um=(0.0, 15.0), reflectance=0.5)
    bounds = bounds_of(camsim.Scene(background=0.2, shapes=[picture, cover]), 0, 1.0, Fineness(0.5, 1e-6))
    places = crossed([(picture, bounds)], camsim.Grid(rows=30, cols=40, pitch_um=1.0), 20)
    assert np.abs(places[:, 0] - step_um).max() <= 2.0
    assert places[:, 1] == pytest.approx(5.0)  # the cover's side


def test_what_is_seen_of_a_gradient_has_few_sides():
    """Its field is as smooth across cells as within them: none counts at once. It was cut into 37 000."""
    gradient = camsim.RadialGradient(radius_um=30.0)
    cover = camsim.Disc(radius_um=20.0, centre_um=(20.0, 0.0), reflectance=0.5)
    bounds = bounds_of(camsim.Scene(background=0.2, shapes=[gradient, cover]), 0, 1.0, Fineness(0.5, 1e-10))
    assert 200 < np.count_nonzero(bounds.in_front) < 10_000


def test_what_is_seen_of_a_patch_adds_up():
    """A wave over what outlines with holes leave of a square, by closed forms of its edges."""
    rng = np.random.default_rng(3)
    wave = np.array([1.3, 0.7])
    for _ in range(200):
        count = rng.integers(3, 12)
        turn, middle = np.sort(rng.random(count)) * 2.0 * np.pi, rng.uniform(-0.3, 1.3, 2)
        spokes = rng.uniform(0.1, 1.5, count)[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        area = shapely.Polygon(middle + spokes, [middle + 0.3 * spokes])
        if not area.is_valid:
            continue
        rings = [shapely.get_coordinates(ring) for ring in shapely.get_rings(area)]
        start, end = np.concatenate([r[:-1] for r in rings]), np.concatenate([r[1:] for r in rings])
        nodes, weights = in_patch(start, end, 12)
        seen = shapely.get_rings(shapely.orient_polygons(shapely.get_parts(area.intersection(shapely.box(0, 0, 1, 1)))))
        exact = 0.0
        for corners in map(shapely.get_coordinates, seen):
            a, way = corners[:-1], np.diff(corners, axis=0)
            # ∮ sin(k·x)·(k × dx)/|k|² along straight edges.
            mean = np.sin(a @ wave + 0.5 * way @ wave) * np.sinc(way @ wave / (2.0 * np.pi))
            exact += mean @ (wave[0] * way[:, 1] - wave[1] * way[:, 0]) / (wave @ wave)
        assert abs(np.cos(nodes @ wave) @ weights - exact) < 1e-13


def test_many_nodes_in_a_patch_are_gathered():
    """A picture that a ring's 10 000 sides cut took the check 26 s: every side had nodes of its own."""
    order, turn = 14, np.linspace(0.0, 2.0 * np.pi, 3001)
    rim = np.array([0.3, 0.8]) + 0.6 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    nodes, weights = in_patch(rim[:-1], rim[1:], order)
    light = np.stack([weights, weights * nodes[:, 0] ** 3])
    few, gathered_light = gathered(nodes, light, order)
    assert 20 * len(few) < len(nodes)
    for phase in np.random.default_rng(3).uniform(-6.0, 6.0, (20, 2)):  # to either side, of which 14 nodes leave 1e-15
        wave, again = (np.exp(2j * places @ phase) for places in (nodes, few))
        assert np.abs(gathered_light @ again - light @ wave).max() < 1e-13
    same, as_given = gathered(nodes[: 4 * order**2], light[:, : 4 * order**2], order)  # fewer than it takes
    assert same.size == 8 * order**2
    assert as_given.shape == (2, 4 * order**2)


def test_what_checks_pictures_hears_all_of_what_is_far_away():
    """A hundredth of the light of a picture of 400 pitches comes from beyond 20: summed by middles of its samples."""
    square = {"width_um": 1600.0, "centre_um": (3.0, -2.0), "rotate_deg": 7.0}
    picture = camsim.Picture(planes=np.full((100, 100), 0.9), **square)
    drawn = camsim.Rectangle(height_um=1600.0, reflectance=0.9, **square)
    grid, tolerance = grid_of(9, 11), 1e-3
    right = camsim.render(
        camsim.Scene(background=0.0, shapes=[drawn]),
        OPTICS["f/8"],
        grid,
        wavelength_nm=WAVELENGTH_NM,
        tolerance=1e-8,
        method="boundary",
    ).image
    choice = plan_render(
        camsim.Scene(background=0.0, shapes=[picture]),
        OpticalSystem.of(OPTICS["f/8"]),
        grid,
        response=np.ones((1, 1)),
        wavelength_nm=np.array([WAVELENGTH_NM]),
        tolerance=tolerance,
        method="fourier",
    )
    rows, cols = np.array([0, 5, 8]), np.array([0, 5, 2])
    found = choice.judge.values(rows, cols, np.zeros(3, np.uint8))
    assert worst(found, right[rows, cols]) <= tolerance / 40.0
    # Ten thousand samples, each at a hundred nodes or so, take some ten milliseconds a photosite.
    assert 1e-3 < choice.judge.seconds(choice.plan) / len(choice.judge.hardest(choice.plan)[0]) < 0.1
