"""The judges judged: every truth against another one, against reference values, and against closed forms."""

import functools
import json
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tests.truth import fields, groups, photosites, picture, pupils, rays, round_lenses, samples, sums, waves
from tests.truth.boundary import BoundaryTruth

CASES = json.loads((Path(__file__).parents[1] / "data" / "oracle-values.json").read_text())["cases"]
SHAPES = [
    {"kind": "polygon", "points": [(-9.3, -12.1), (14.2, -7.7), (3.3, 15.9), (-2.0, 2.5)]},
    {"kind": "disc", "centre": (5.0, 3.0), "radius": 4.0},
    {"kind": "rectangle", "width": 6.0, "height": 3.0, "centre": (0.0, 0.0), "rotate_deg": 20.0},
    {"kind": "disc", "centre": (9.0, 3.0), "radius": 2.5},
    {"kind": "polygon", "points": [(-9.3, -12.1), (14.2, -7.7), (14.0, -14.0)]},
]
CURVED = [
    {"kind": "ellipse", "centre": (1.0, -2.0), "radii": (11.0, 5.0), "rotate_deg": 30.0},
    {"kind": "ring", "centre": (4.0, 3.0), "radius": 7.0, "inner": 4.0},
    {"kind": "sector", "centre": (-2.0, 0.0), "radius": 8.0, "inner": 2.0, "from_deg": 150.0, "turn_deg": 250.0},
    {"kind": "capsule", "points": [(-6.0, 5.0), (6.0, -4.0)], "width": 2.5},
    {
        "kind": "polygon",
        "points": [(-9.0, -9.0), (9.0, -8.0), (0.0, 1.5)],
        "holes": [[(-3.0, -7.0), (0.0, -2.0), (3.0, -6.0)]],
    },
    {"kind": "ellipse", "centre": (2.0, 1.0), "radii": (2.0, 6.0), "rotate_deg": 80.0},
    {"kind": "sector", "centre": (7.0, 7.0), "radius": 5.0, "inner": 0.0, "from_deg": -160.0, "turn_deg": 90.0},
]
BLOB = {
    "kind": "path",
    "rule": "evenodd",
    "outlines": [
        [
            (-9.0, -6.0),
            [(-2.0, -14.0), (6.0, -2.0), (10.0, -7.0)],
            [(14.0, 9.0), (2.0, 8.0)],
            [(-8.0, 4.0), (-9.0, -6.0)],
        ],
        [(-3.0, -3.0), [(4.0, -9.0), (-2.0, 9.0), (4.0, 1.0)], [(-7.0, 2.0), (-3.0, -3.0)]],
    ],
}
LEAF = {"kind": "path", "rule": "nonzero", "outlines": [[(1, 0), [(5, -4), (9, 0)], [(4, 3), (6, 1), (1, 0)]]]}
DRAWN = [
    BLOB,
    {"kind": "repeat-on-ring", "shapes": [LEAF], "count": 3, "centre": (2.0, 1.0)},
    {
        "kind": "group",
        "shapes": [
            LEAF,
            {"kind": "ellipse", "centre": (1.0, 1.0), "radii": (5.0, 3.0), "rotate_deg": 20.0},
        ],
        "mirror": "left-right",
        "scale": (1.5, 0.8),
        "turn_deg": 30.0,
        "move": (1.0, 2.0),
        "clip": {"kind": "polygon", "points": [(-3.0, -3.0), (6.0, -2.0), (5.0, 3.0), (-2.0, 5.0)]},
    },
]
LEVELS = np.array([0.5, 1.0, 0.25, 0.7, 0.1, 0.9, 0.6, 0.3])  # of the shapes, and of the background


PICTURES = {"straight": SHAPES, "curved": CURVED, "drawn": groups.flattened(DRAWN), "two": SHAPES[::4]}


@functools.cache
def with_jumps(name):
    pieces = picture.pieces(PICTURES[name])
    return pieces, np.array([[LEVELS[p.left] - LEVELS[p.right]] for p in pieces])


POINT, SQUARE = {"kind": "point"}, {"kind": "square", "side": 1.0}


def test_line_integrals_meet_the_reference_values():
    for case in CASES[::8]:
        pieces = picture.pieces([{"kind": "polygon", "points": case["polygon"]}])
        photosite = {"kind": "square", "side": case["box"]} if case["box"] else POINT
        olpf = {"split": case["olpf"], "split_y": case["olpf"], "rotate_deg": 0.0} if case["olpf"] else None
        jumps = [[1.0 if piece.left == 0 else -1.0] for piece in pieces]
        truth = BoundaryTruth(pieces, [round_lenses.Airy(case["L"])], jumps, photosite, olpf, target=1e-12)
        value, unsure = truth.values([[case["x"], case["y"]]])
        assert value[0] == pytest.approx(case["value"], abs=5e-14), case
        assert unsure[0] < 1e-12


FOOTPRINTS = {
    "point": (POINT, None, "curved"),
    "plate": (SQUARE, {"split": 0.75, "split_y": 0.0, "rotate_deg": 45.0}, "straight"),
    "circle": ({"kind": "circle", "diameter": 0.9}, None, "curved"),
    "rounded": ({"kind": "rounded", "width": 1.0, "height": 0.8, "radius": 0.2}, None, "straight"),
    "triangle": ({"kind": "polygon", "points": [(-0.5, -0.4), (0.5, -0.3), (0.1, 0.5)]}, None, "curved"),
    "square": (SQUARE, None, "drawn"),
}
LENSES = {
    "airy": round_lenses.Airy(0.9),
    "annular": round_lenses.Airy(2.0, 0.3),
    "gaussian": round_lenses.Gauss(3.0),
    "curve": round_lenses.Curve((0.0, 0.3, 0.6, 1.0), (1.0, 0.5, -0.1, 0.0)),
}


@pytest.mark.parametrize(
    ("lens", "footprint"),
    [
        ("airy", "point"),
        ("annular", "plate"),
        ("gaussian", "circle"),
        ("curve", "rounded"),
        ("annular", "triangle"),
        ("airy", "square"),
    ],
)
def test_line_integrals_meet_fourier_sums(lens, footprint):
    lens, (photosite, olpf, name) = LENSES[lens], FOOTPRINTS[footprint]
    x, y = np.arange(-4.0, 8.0, 3.0), np.arange(-3.0, 4.0, 3.0)
    points = np.stack([axis.ravel() for axis in np.meshgrid(x, y)], axis=1)
    pieces, jumps = with_jumps(name)
    lines, unsure = BoundaryTruth(pieces, [lens], jumps, photosite, olpf, target=1e-12).values(points)
    sums, also = waves.WaveTruth(pieces, [waves.Round(lens)], jumps, photosite, olpf).values(x, y)
    assert max(also, unsure.max()) < 2e-12
    assert np.abs(lines.reshape(sums.shape) - sums).max() < 2e-12


@pytest.mark.parametrize("name", ["straight", "curved", "drawn"])
def test_the_painters_rule_by_rays(name):
    """Along every ray out of a point what is seen is asked place by place; no outline is looked at."""
    shapes, lens, point = [*map(picture.ready, PICTURES[name])], round_lenses.Airy(3.0), np.array([3.1, 1.7])
    radius = np.linspace(0.0, 30.0, 201)
    share = np.diff(rays.rayleigh_energy(radius, 3.0))
    middle = 0.5 * (radius[:-1] + radius[1:])
    total = []
    for angle in 2.0 * np.pi * (np.arange(40) + 0.5) / 40:
        ahead = np.array([math.cos(angle), math.sin(angle)])
        seen = {
            k: picture.seen(shapes, point + middle[k] * ahead) for k in (*range(0, middle.size, 4), middle.size - 1)
        }
        for a, b in pairwise(sorted(seen)):  # four places in a row are asked one by one where their ends differ
            seen |= {
                k: seen[a] if seen[a] == seen[b] else picture.seen(shapes, point + middle[k] * ahead)
                for k in range(a + 1, b)
            }
        levels = [LEVELS[seen[k]] for k in range(middle.size)]
        total.append(np.array(levels) @ share + LEVELS[-1] * (1.0 - share.sum()))
    pieces, jumps = with_jumps(name)
    value, _ = BoundaryTruth(pieces, [lens], jumps, POINT, None, target=1e-9).values(point[None])
    assert LEVELS[-1] + value[0] == pytest.approx(np.mean(total), abs=3e-3)


@pytest.mark.parametrize(
    "shapes",
    [
        [(0.0, -1.0, 1.0), (1.0, -1.0, 2.0)],
        [(1.0, -1.0, 2.0), (0.0, -1.0, 1.0)],
        [(-1.0, 2.0, 3.0), [(1.5, -0.5), (2.0, -0.5), (2.0, 2.0), (1.5, 2.0)]],
        [[(-1.0, -3.0), (2.5, -3.0), (2.5, -1.0), (-1.0, -1.0)], (-1.0, 2.0, 3.0)],
    ],
)
def test_outlines_that_touch_leave_the_areas_that_are_seen(shapes):
    """Area of each shape by its pieces, ∮ x dy, and by counting places."""
    given = [
        {"kind": "disc", "centre": list(s[:2]), "radius": s[2]}
        if isinstance(s, tuple)
        else {"kind": "polygon", "points": [list(p) for p in s]}
        for s in shapes
    ]
    side = np.linspace(-6.0, 6.0, 241) + 0.0123
    ends = np.concatenate([np.add.outer([-s[2], s[2]], s[:2]) if isinstance(s, tuple) else s for s in shapes])
    across, down = (side[(side > low) & (side < high)] for low, high in zip(ends.min(0), ends.max(0), strict=True))
    counted = np.bincount([picture.seen(given, np.array([x, y])) + 1 for x in across for y in down], minlength=3)[1:]
    area = np.zeros(len(shapes))
    for piece in picture.pieces(given):
        if piece.centre is None:
            (x0, y0), (x1, y1) = piece.start, piece.end
            signed = 0.5 * (x0 + x1) * (y1 - y0)
        else:
            a = np.linspace(piece.first, piece.last, 2001)
            x, y = (c + u * np.cos(a) + v * np.sin(a) for c, u, v in zip(piece.centre, piece.u, piece.v, strict=True))
            signed = np.trapezoid(x, y)
        for shape, sign in ((piece.left, 1.0), (piece.right, -1.0)):
            if shape >= 0:
                area[shape] += sign * signed
    assert area == pytest.approx(counted * 0.05**2, abs=0.1)


def test_outlines_along_one_another_make_one_piece():
    square = [(0, 0), (2, 0), (2, 2), (0, 2)]
    beside = [(2, 1), (4, 1), (4, 3), (2, 3)]
    found = picture.pieces(
        [
            {"kind": "polygon", "points": square},
            {"kind": "polygon", "points": beside},
            {"kind": "polygon", "points": square},
        ]
    )
    between = [
        {p.left, p.right} for p in found if p.start[0] == p.end[0] == 2.0 and {p.start[1], p.end[1]} == {1.0, 2.0}
    ]
    assert between == [{1, 2}]  # the last one painted, and its neighbour
    for shape in (-1, 1, 2):
        way = [np.subtract(p.end, p.start) * ((p.left == shape) - (p.right == shape)) for p in found]
        np.testing.assert_allclose(np.sum(way, axis=0), 0.0, atol=1e-12)


PLAIN = {"zernike_waves": [], "reference_nm": 500.0, "f_number": 1.0, "defocus_um": 0.0, "blur": 2e-3}


@pytest.mark.parametrize("obstruction", [0.0, 0.35])
def test_a_pupil_without_aberrations_is_an_airy_pattern(obstruction):
    pupil = {"shape": "circular", "obstruction": obstruction, "blades": 0, "rotate_deg": 0.0}
    at = 0.37 * np.arange(-40, 41)
    expected = round_lenses.Airy(1.0, obstruction).pattern(np.hypot(at, at[:, None]))
    assert np.abs(pupils.pattern(PLAIN | {"pupil": pupil}, 500.0, at, at) - expected).max() < 1e-13


@pytest.mark.parametrize(("digits", "off"), [(5.0, 1e-5), (9.0, 1e-9), (16.0, 2e-14)])
@pytest.mark.parametrize("count", [8, 90])
def test_sums_of_waves_are_those_of_their_definition(count, digits, off, rng):
    """Relative to all light, which is what the digits count."""
    places, light = rng.uniform(-1.0, 1.0, (5, 40)), np.exp(1j * rng.uniform(-3.0, 3.0, (5, 40)))
    waved = np.exp(1j * places[..., None] * (-31.0 + 0.7 * np.arange(count)))
    rows = sums.of_rows(places, light, -31.0, 0.7, count, digits)
    assert np.abs(rows - np.einsum("kq,kqm->km", light, waved)).max() < 40.0 * off
    columns = sums.of_columns(places[0], light.T, -31.0, 0.7, count, digits)
    assert np.abs(columns - waved[0].T @ light.T).max() < 40.0 * off
    x, bright = rng.uniform(-30.0, 30.0, (40, 2)), rng.normal(size=40)
    kx, ky = np.fft.fftfreq(count, 1.0 / count), np.arange(count // 2 + 1)
    each = np.exp(-0.02j * np.pi * (ky[:, None, None] * x[:, 1] + kx[:, None] * x[:, 0]))
    assert np.abs(sums.over_the_plane(x, bright, 0.01, count, digits) - each @ bright).max() < 40.0 * off


@pytest.mark.parametrize("order", [1, 20, 400])
def test_rules_of_hundreds_of_nodes_are_exact(order):
    x, w = pupils.gauss(order)
    assert w @ np.exp(x) == pytest.approx(2.0 * math.sinh(1.0) if order > 1 else 2.0, rel=2e-15)


def test_pupils_have_their_area(rng):
    for _ in range(50):
        pupil = {"shape": str(rng.choice(["square", "bladed"])), "blades": int(rng.integers(3, 12)), "obstruction": 0.2}
        pupil["rotate_deg"] = float(rng.choice([0.0, 90.0, 45.0, rng.uniform(0.0, 180.0)]))
        rule = pupils.rows_of(pupil, 60)
        assert sum(share * (end - begin) for _, share, begin, end in rule) == pytest.approx(
            pupils.area(pupil), abs=1e-12
        )


def test_a_square_pupil_is_two_slits():
    pupil = {"shape": "square", "obstruction": 0.0, "blades": 0, "rotate_deg": 0.0}
    at = 0.37 * np.arange(-40, 41)
    expected = np.multiply.outer(np.sinc(at) ** 2, np.sinc(at) ** 2)
    assert np.abs(pupils.pattern(PLAIN | {"pupil": pupil}, 500.0, at, at) - expected).max() < 1e-13


def test_photosites_have_their_area_and_transfer():
    kx, ky = np.array([0.0, 0.3, -1.1]), np.array([0.0, 0.7])
    radius = np.hypot(kx, ky[:, None])
    disc = photosites.transfer({"kind": "circle", "diameter": 0.8}, kx, ky)
    np.testing.assert_allclose(disc.ravel()[1:], 2.0 * round_lenses._jinc(np.pi * 0.8 * radius).ravel()[1:], atol=1e-13)
    rounded = {"kind": "rounded", "width": 1.0, "height": 0.8, "radius": 0.2}
    assert photosites.area(rounded) == pytest.approx(0.8 - (4.0 - math.pi) * 0.04, abs=1e-14)
    nodes, weights = photosites.inner_nodes({"kind": "rectangle", "width": 3.0, "height": 2.0})
    assert weights @ nodes[:, 0] ** 2 == pytest.approx(9.0 / 12.0, abs=1e-13)


@pytest.mark.parametrize("interpolation", ["squares", "cubic"])
def test_the_light_of_fields(interpolation):
    """Behind a disc: line integrals and Fourier sums; with nothing in front: nodes over halves of samples."""
    one = {"samples": [[0.2, 0.9, 0.4], [0.7, 0.1, 1.0]], "step": 1.3, "centre": [0.4, -0.3], "rotate_deg": 25.0}
    field = {"kind": "picture", "interpolation": interpolation, **one}
    cover = {"kind": "ellipse", "centre": (0.5, 0.2), "radii": (1.2, 0.7), "rotate_deg": 30.0}
    lens, x, y = round_lenses.Airy(1.5), np.array([-1.0, 0.5]), np.array([0.25])
    points = np.stack([axis.ravel() for axis in np.meshgrid(x, y)], axis=1)
    found = []
    for shapes in ([field], [field, cover]):
        parts, owner = fields.parted(shapes)
        pieces = picture.pieces(parts)
        ways = [fields.light_of(shapes, pieces, owner, 0, cutoff=1.0, more=more) for more in (7, 6)]
        lines = BoundaryTruth([], [lens], np.empty((0, 1)), SQUARE, None, target=1e-12, lights=[(*ways, np.ones(1))])
        waved = waves.WaveTruth([], [waves.Round(lens)], np.empty((0, 1)), SQUARE, None, lights=[(*ways, np.ones(1))])
        value, unsure = lines.values(points)
        assert max(unsure.max(), np.abs(waved.values(x, y)[0].ravel() - value).max()) < 1e-11
        found.append(value)
    light = samples.light_of_picture(np.array(one.pop("samples")), interpolation=interpolation, nodes=6, **one)
    plain = samples.photosites(light, centres=points, blur=1.5, side=SQUARE["side"], spots=np.zeros((1, 2)), nodes=10)
    assert np.abs(plain - found[0]).max() < 1e-11
    assert np.all(found[1] < found[0] - 1e-3)
