"""The error estimate tells the truth: whatever is corrupted, an error of ten tolerances does not stay below one.

Each row corrupts one thing on the road from the scene to the image, where the engine takes it and the check does not.
"""

import dataclasses

import numpy as np
import pytest
from examples import OPTICS, PICTURE, PITCH_UM, TOLERANCE, WAVELENGTH_NM, grid_of, scene_of, worst

import camsim
from camsim.optics import OpticalSystem, airy
from camsim.rendering import footprint, job, outlines
from camsim.rendering.boundary import coherence as quiet
from camsim.rendering.boundary import engine as boundary_engine
from camsim.rendering.boundary import image as boundary_image
from camsim.rendering.boundary import ringing, tables
from camsim.rendering.fields import job as field_job
from camsim.rendering.fields import layer, samples
from camsim.rendering.render import render_channels
from camsim.rendering.waves import edges as wave_edges
from camsim.rendering.waves import fields as wave_fields
from camsim.rendering.waves import image as wave_image
from camsim.rendering.waves import levels, plan, transfers
from camsim.scene import outlines as scene_outlines

# Short waves on a wide footprint: there the far form begins where the footprint's moments still matter.
WIDE = [
    camsim.Airy(f_number=2.8),
    camsim.FourSpotOlpf(split_um=1.5 * PITCH_UM),
    camsim.SquarePhotosite(side_um=PITCH_UM),
]
WIDER = [
    camsim.Airy(f_number=4.0),
    camsim.FourSpotOlpf(split_um=3.0 * PITCH_UM),
    camsim.SquarePhotosite(side_um=PITCH_UM),
]
TURNED = [
    camsim.Airy(f_number=2.8),
    camsim.TwoSpotOlpf(split_um=PITCH_UM, rotate_deg=30.0),
    camsim.RectangularPhotosite(width_um=PITCH_UM, height_um=0.6 * PITCH_UM),
]
SHARP = [camsim.Airy(f_number=1.4), camsim.SquarePhotosite(side_um=0.0)]
SYSTEMS = {name: OPTICS[name] for name in ("f/1.4, fill factor 0.5", "f/8", "f/8, OLPF")}


def at_pitch(cls, x, y, reflectance, **sizes):
    sizes = {name: size * PITCH_UM for name, size in sizes.items()}
    return cls(centre_um=(x * PITCH_UM, y * PITCH_UM), reflectance=reflectance, **sizes)


def rectangle(x, y, width, height, reflectance):
    return at_pitch(camsim.Rectangle, x, y, reflectance, width_um=width, height_um=height)


def disc(x, y, radius, reflectance):
    return at_pitch(camsim.Disc, x, y, reflectance, radius_um=radius)


RED = camsim.Curve((450.0, 700.0), (0.05, 0.9), outside="hold")
SAMPLES = np.random.default_rng(0).uniform(size=(20, 26))
COVER = disc(-3.0, 2.0, 4.0, 0.5)


def photograph(rotate_deg=0.0):
    return camsim.Picture(planes=SAMPLES, width_um=22.0 * PITCH_UM, rotate_deg=rotate_deg, interpolation="cubic")


def star(x, y):
    return camsim.PointSource(photosites=3.0, centre_um=(x * PITCH_UM, y * PITCH_UM))


SCENES = {
    "photograph": camsim.Scene(background=0.4, shapes=[photograph()]),
    "turned photograph": camsim.Scene(background=0.4, shapes=[photograph(20.0)]),
    "hidden photograph": camsim.Scene(background=0.4, shapes=[photograph(), COVER]),
    "stars": camsim.Scene(background=0.1, shapes=[star(-3.2, 2.1), COVER, star(9.3, -7.7)]),
    "picture": scene_of(PICTURE),
    "overlap": camsim.Scene(background=0.9, shapes=[rectangle(0, 0, 20, 14, 0.2), rectangle(4, 3, 12, 18, 0.6)]),
    "shared": camsim.Scene(background=0.9, shapes=[rectangle(-5, 0, 10, 14, 0.2), rectangle(5, 0, 10, 14, 0.6)]),
    "disc": camsim.Scene(background=0.0, shapes=[disc(0.5, 0.5, 12.3, 1.0)]),
    "cut disc": camsim.Scene(background=0.0, shapes=[disc(0, 0, 15.3, 1.0), rectangle(10, 2, 20, 9, 0.3)]),
    "far": camsim.Scene(background=1.0, shapes=[rectangle(0, 0, 9, 9, 0.2), rectangle(28, 0, 10, 12, 0.0)]),
    "crowd": camsim.Scene(
        background=1.0, shapes=[disc(x, y, 1.5, 0.1) for x in range(-15, 16, 6) for y in range(-15, 16, 6)]
    ),
}


def rendered(optics=OPTICS["f/8"], scene="picture", method="boundary", tolerance=TOLERANCE, rows=40, cols=40):
    return camsim.render(
        SCENES[scene], optics, grid_of(rows, cols), wavelength_nm=WAVELENGTH_NM, method=method, tolerance=tolerance
    )


NODES_NM = np.linspace(420.0, 680.0, 66)


def in_colour(optics=OPTICS["f/8"], scene="overlap", method="boundary", tolerance=TOLERANCE):
    """A spectrum of 66 wavelengths, seen by two channels."""
    response = np.stack([np.exp(-(((NODES_NM - peak) / 60.0) ** 2)) for peak in (500.0, 600.0)])
    channel = np.indices((40, 40)).sum(axis=0).astype(np.uint8) % 2
    scene = dataclasses.replace(
        SCENES[scene], shapes=[dataclasses.replace(s, reflectance=RED) for s in SCENES[scene].shapes]
    )
    return render_channels(
        scene,
        OpticalSystem.of(optics),
        grid_of(40, 40),
        response=response / response.sum(axis=1, keepdims=True),
        wavelength_nm=NODES_NM,
        channel=channel,
        tolerance=tolerance,
        method=method,
    )


def scaled(function, factor):
    return lambda *args, **kwargs: factor * function(*args, **kwargs)


def returning(change):
    """What replaces a function by one whose result is changed."""

    def corrupt(function):
        return lambda *args, **kwargs: change(function(*args, **kwargs))

    return corrupt


def fields(**factors):
    """Some numbers of a dataclass multiplied."""
    return returning(
        lambda right: dataclasses.replace(right, **{name: getattr(right, name) * f for name, f in factors.items()})
    )


def given(**changed):
    """The function called with some arguments changed."""

    def corrupt(function):
        return lambda *args, **kwargs: function(
            *args, **{name: changed[name](value) if name in changed else value for name, value in kwargs.items()}
        )

    return corrupt


def seen_by_reversed_painter(function):
    """Primitives that are handed on are the true scene's: they are made anew."""

    def arranged(scene, *limits, **how):
        return function(dataclasses.replace(scene, shapes=scene.shapes[::-1]), *limits, **how | {"primitives": None})

    return arranged


def moved(found):
    return dataclasses.replace(found, start_um=found.start_um * (1 + 1e-4), end_um=found.end_um * (1 + 1e-4))


def swapped(footprint_of):
    def wrong(system, pitch_um):
        width, height = system.photosite.sides_um
        other = camsim.RectangularPhotosite(width_um=height, height_um=width)
        return footprint_of(dataclasses.replace(system, photosite=other), pitch_um)

    return wrong


def split_wider(footprint_of):
    def wrong(system, pitch_um):
        olpf = dataclasses.replace(system.olpf, split_um=1.01 * system.olpf.split_um)
        return footprint_of(dataclasses.replace(system, olpf=olpf), pitch_um)

    return wrong


def few_nodes(fuse):
    def wrong(signals, **how):
        nodes = np.linspace(signals.wavelength_nm[0], signals.wavelength_nm[-1], 3)
        nearest = np.argmin(np.abs(signals.wavelength_nm[:, None] - nodes), axis=1)
        return nodes, np.stack([signals.density[..., nearest == j].sum(axis=-1) for j in range(3)], axis=-1)

    return wrong


def pattern(**changed):
    return lambda airy: dataclasses.replace(
        airy, **{name: change(getattr(airy, name)) for name, change in changed.items()}
    )


def of_numbers(**changed):
    return returning(lambda n: n._replace(**{name: change(getattr(n, name)) for name, change in changed.items()}))


def stronger(found):
    return None if found is None else 1.001 * found


CORRUPTIONS = {
    # geometry
    "the scene is a ten-thousandth too large": (outlines, "arrange", returning(moved), {}),
    "discs have 64 sides": (outlines, "arrange", lambda f: lambda scene, limits, **how: f(scene), {"scene": "disc"}),
    "discs are a ten-thousandth too large": (
        scene_outlines,
        "polygons",
        returning(lambda found: found._replace(corners_um=1.0001 * found.corners_um)),
        {"scene": "disc"},
    ),
    # painter's order
    "the painter works backwards": (outlines, "arrange", seen_by_reversed_painter, {"scene": "overlap"}),
    "a shared edge has one colour": (
        outlines,
        "arrange",
        returning(lambda found: dataclasses.replace(found, right=np.zeros_like(found.right))),
        {"scene": "shared"},
    ),
    # pruning
    "edges of little contrast are dropped": (
        job,
        "equal_sides",
        lambda f: lambda e, density: np.abs(density[e.left] - density[e.right]).sum(axis=(1, 2)) < 0.5,
        {"scene": "overlap"},
    ),
    "what is near is dropped as far": (
        job,
        "far_outlines",
        given(allowed=lambda a: 1e6 * a),
        {"scene": "far", "rows": 36, "cols": 36},
    ),
    # spectra and fusion
    "three wavelengths": (job, "fuse", few_nodes, {"colour": True}),
    "weights one node off": (job, "fuse", returning(lambda f: (f[0], np.roll(f[1], 1, axis=-1))), {"colour": True}),
    "a spectrum a thousandth too bright": (
        job.Signals,
        "of",
        lambda f: (
            lambda *args: dataclasses.replace(
                f(*args), density=f(*args).density * (1.0 + 1e-3 * np.arange(len(f(*args).density)))[:, None, None]
            )
        ),
        {"colour": True},
    ),
    "the background a ten-thousandth too bright": (job.Job, "of", fields(base=1.0001), {"scene": "overlap"}),
    "the lens's length 1 % too long": (job, "blur_of", lambda f: scaled(f, 1.01), {}),
    # tables
    "a field too strong": (boundary_image, "field_tables", lambda f: scaled(f, 1.001), {}),
    "an edge response too strong": (boundary_image, "edge_responses", lambda f: scaled(f, 1.001), {"optics": WIDE}),
    "responses across the wrong normal": (
        boundary_image,
        "edge_responses",
        lambda f: lambda *a, **k: f(*a[:3], a[3][:, ::-1], *a[4:], **k),
        {"optics": TURNED},
    ),
    "the potential's slope": (tables, "potential", lambda f: scaled(f, 1.001), {}),
    "c1 in the far form": (
        boundary_image,
        "far_moments",
        lambda f: scaled(f, np.array([1.0, 1.05, 1.0, 1.0])),
        {"optics": WIDE},
    ),
    # constants, wherever they are used
    "c1 of the pattern": (airy, "AIRY", pattern(powers=lambda c: (1.05 * c[0], *c[1:])), {"optics": WIDE}),
    "rings thirty times too faint": (
        airy,
        "AIRY",
        pattern(rings=lambda r: tuple((u, a / 300, n) for u, a, n in r)),
        {"optics": SHARP},
    ),
    "the pattern's energy": (airy, "AIRY", pattern(energy=lambda f: lambda rho: f(1.01 * rho)), {}),
    "the pattern's transfer": (airy, "AIRY", pattern(otf=lambda f: lambda u: f(1.01 * u)), {"optics": WIDE}),
    "quiet too soon": (quiet.Waves, "negligible_distance", lambda f: scaled(f, 0.2), {"optics": SHARP}),
    "moments end too soon": (
        ringing,
        "_moment_distance",
        lambda f: scaled(f, 0.3),
        {"optics": WIDER, "scene": "overlap"},
    ),
    "rings in the centre of a disc are left out": (
        ringing,
        "_meeting",
        lambda f: lambda waves, edges, grid, least, allowed: least,
        {"scene": "disc", "optics": SHARP, "over": 1.0},
    ),
    # kernels, through what they are given
    "careless radii": (
        boundary_engine,
        "plan_boundary",
        fields(near=0.3, reach=0.3),
        {"optics": WIDE},
    ),
    "a coarse field": (boundary_engine, "plan_boundary", fields(field_step=8.0), {"optics": WIDE}),
    "a coarse response": (boundary_engine, "plan_boundary", fields(response_step=8.0), {"optics": WIDE}),
    "long panels": (boundary_engine, "plan_boundary", fields(panel=5.0), {"optics": WIDE}),
    "few nodes on a tile": (
        boundary_engine,
        "plan_boundary",
        returning(lambda s: dataclasses.replace(s, tile_nodes=3)),
        {"rows": 100, "cols": 100},
    ),
    "quadrature weights": (boundary_image, "numbers", of_numbers(gauss_w=lambda w: 1.001 * w), {}),
    "tiles interpolated from the wrong side": (
        boundary_image,
        "numbers",
        of_numbers(to_photosites=lambda m: np.ascontiguousarray(m[:, ::-1])),
        {"rows": 100, "cols": 100},
    ),
    "moments σ²": (footprint.Footprint, "of", fields(sigma2=3.0), {"optics": WIDE}),
    "moments ⟨ζ²⟩": (
        footprint.Footprint,
        "of",
        returning(lambda f: dataclasses.replace(f, m2=np.conj(f.m2))),
        {"optics": TURNED},
    ),
    # OLPF and photosite
    "an OLPF 1 % too wide": (footprint.Footprint, "of", split_wider, {"optics": WIDE}),
    "a photosite lying on its side": (footprint.Footprint, "of", swapped, {"optics": TURNED}),
    # frequency sums
    "a transfer too strong": (
        transfers.Lens,
        "curves",
        returning(lambda c: (1.001 * c[0], c[1])),
        {"method": "fourier"},
    ),
    "a footprint's transfer": (
        transfers.Footprint,
        "on",
        returning(lambda f: (f[0] ** 2, *f[1:])),
        {"method": "fourier"},
    ),
    "edges too strong": (wave_edges.EdgeSource, "transform", returning(stronger), {"method": "fourier"}),
    "nodes along edges": (
        wave_edges,
        "_nodes",
        returning(lambda n: (n[0], n[1], 1.001 * n[2])),
        {"method": "fourier", "scene": "crowd"},
    ),
    "a band of two thirds": (
        plan.WavesPlan,
        "_band",
        lambda f: scaled(f, 0.66),
        {"method": "fourier", "optics": SHARP, "rows": 20, "cols": 20},
    ),
    "no far levels": (plan, "levels_of", returning(lambda found: found[:1]), {"method": "fourier"}),
    "far levels between the wrong points": (
        wave_image.FrequencyImage,
        "taps",
        returning(lambda t: t[:, ::-1]),
        {"method": "fourier"},
    ),
    "shares of more than all": (
        levels.Level,
        "shares",
        returning(lambda found: (1.001 * found[0], found[1])),
        {"method": "fourier"},
    ),
    "a frequency counted twice": (
        wave_image.FrequencyImage,
        "_part",
        returning(lambda part: part + 1e-4),
        {"method": "fourier"},
    ),
    # pictures, gradients and points
    "samples too bright": (
        wave_fields.FieldSource,
        "transform",
        returning(stronger),
        {"scene": "photograph", "method": "fourier"},
    ),
    "splines too strong": (
        wave_fields,
        "_squares",
        returning(stronger),
        {"scene": "turned photograph", "method": "fourier"},
    ),
    "samples half a step beside": (
        layer.Layer,
        "places",
        returning(lambda places: places + 0.1),
        {"scene": "turned photograph", "method": "fourier"},
    ),
    "a picture that nothing hides": (
        samples,
        "_cover",
        lambda f: lambda one, times, first, shape: f(dataclasses.replace(one, outline=None), times, first, shape),
        {"scene": "hidden photograph", "method": "fourier"},
    ),
    "points that are hidden": (
        field_job,
        "seen_of",
        lambda f: lambda scene: f(dataclasses.replace(scene, shapes=[s for s in scene.shapes if s is not COVER])),
        {"scene": "stars", "method": "fourier"},
    ),
    "a point a tenth of a photosite beside": (
        field_job,
        "layer_of",
        lambda f: lambda one, pitch_um, colours: f(one, 1.01 * pitch_um, colours),
        {"scene": "stars", "method": "fourier"},
    ),
    "three wavelengths in fourier": (plan, "fuse", few_nodes, {"colour": True, "method": "fourier"}),
}


HONEST = {}
"""Renderings that nothing corrupts, by what was asked for."""


@pytest.mark.parametrize("name", CORRUPTIONS)
def test_what_is_corrupted_is_seen(monkeypatch, name):
    place, attribute, corrupt, how = CORRUPTIONS[name]
    how = dict(how)
    over = how.pop("over", 10.0)
    run = in_colour if how.pop("colour", False) else rendered
    key = run.__name__, repr(how)
    honest = HONEST[key] = HONEST.get(key) or run(**how)
    true = getattr(place, attribute)
    with monkeypatch.context() as patch:
        wrong = corrupt(true)
        patch.setattr(place, attribute, staticmethod(wrong) if isinstance(place, type) and attribute == "of" else wrong)
        corrupted = run(**how)
    assert honest.error_estimate <= TOLERANCE
    assert worst(corrupted.image, honest.image) > over * TOLERANCE  # or the test says nothing
    assert corrupted.error_estimate > TOLERANCE


@pytest.mark.parametrize("tolerance", [1e-2, 1e-6])
@pytest.mark.parametrize("optics", SYSTEMS.values(), ids=SYSTEMS)
def test_an_honest_rendering_is_within_its_tolerance(optics, tolerance):
    rendering = rendered(optics, tolerance=tolerance, rows=24, cols=24)
    assert rendering.error_estimate <= tolerance
    assert rendering.checked_photosites >= 4


def test_a_scene_without_edges_has_no_error():
    flat = camsim.render(camsim.Scene(background=0.4), OPTICS["f/8"], grid_of(3, 3), wavelength_nm=WAVELENGTH_NM)
    assert worst(flat.image, 0.4) == 0.0
    assert flat.error_estimate == 0.0


@pytest.mark.parametrize(("rows", "cols"), [(1, 1), (2, 2)])
def test_of_a_tiny_frame_every_photosite_is_checked(rows, cols):
    """Then the estimate is the largest error, to a tenth of the tolerance; the truth is a far finer rendering."""
    coarse = rendered(OPTICS["f/8, OLPF"], tolerance=1e-2, rows=rows, cols=cols)
    fine = rendered(OPTICS["f/8, OLPF"], tolerance=1e-7, rows=rows, cols=cols)
    assert coarse.checked_photosites == rows * cols
    assert coarse.error_estimate == pytest.approx(worst(coarse.image, fine.image), abs=1e-2 / 10)


def test_a_narrow_ring_of_a_pupil_raises_no_alarm():
    """Its transfer bends at a twentieth of the cut-off; sums that knew only the phase were 1.8 tolerances off."""
    optics = [camsim.AnnularAiry(f_number=4.6, obstruction=0.9), camsim.SquarePhotosite(side_um=0.4)]
    square = camsim.Rectangle(width_um=21.3, height_um=13.7, rotate_deg=20.0, reflectance=0.9)
    scene = camsim.Scene(background=0.1, shapes=[square])
    grid = camsim.Grid(rows=40, cols=40, pitch_um=1.0)
    found = camsim.render(scene, optics, grid, wavelength_nm=589.0, tolerance=1e-6, method="fourier")
    assert found.error_estimate <= 0.3e-6
