"""Shapes cover what they should: areas by closed forms, painter's order by asking places, text by FreeType."""

import dataclasses
import math

import numpy as np
import pytest
import shapely
from areas import area_of, area_seen
from tolerances import ROUNDING

import camsim
from camsim.errors import CamsimError, InvalidValueError
from camsim.rendering.direct.scenery import pieces_of
from camsim.scene import arrange
from camsim.scene.arcs import Fineness
from camsim.scene.side_limits import SideLimits
from tests.tables import rows

FINE = SideLimits(segment_um=0.7, wobble_um=1e-3, cut_um2=1e-3, moment_um3=1e-3)
RING, CIRCLE = math.pi * (49 - 16), math.pi * 49


def path(*places, **item):
    (x, y), *others = places
    return camsim.Path(segments_um=[("move", x, y), *(("line", *p) for p in others)], reflectance=0.2, **item)


def pentagram(fill_rule):
    angle = 0.8 * np.pi * np.arange(5)
    return path(*np.stack([np.sin(angle), -np.cos(angle)], axis=1).tolist(), fill_rule=fill_rule)


def five(radius):
    """A regular pentagon's area by the radius of its corners."""
    return 2.5 * math.sin(0.4 * math.pi) * radius**2


def curved(*segments, **item):
    return camsim.Path(segments_um=[*segments], reflectance=0.2, **item)


def line(width, *segments, **item):
    return camsim.Line(segments_um=[*segments], width_um=width, reflectance=0.2, **item)


def sector(turn_deg, inner=0.0, **item):
    return camsim.Sector(radius_um=7, inner_radius_um=inner, turn_deg=turn_deg, reflectance=0.2, **item)


HEART = math.cos(0.4 * math.pi) / math.cos(0.2 * math.pi)  # of a pentagram: its inner corners' radius
POINTED = 5.0 * HEART * math.sin(0.2 * math.pi)  # twice five triangles from the centre to a tip and an inner corner
DISC = camsim.Disc(radius_um=7, reflectance=0.2)
HOLED = camsim.Ring(radius_um=7, inner_radius_um=4, reflectance=0.2)
BOXES = shapely.MultiPolygon([shapely.box(0, 0, 6, 6) - shapely.box(1, 1, 4, 4), shapely.box(7, 0, 9, 1)])
HOLES = [[(1, 1), (2, 1), (1, 2)], [(4, 4), (4, 8), (8, 8), (8, 4)]]
FRAME = [("move", 0, 0), ("line", 9, 0), ("line", 9, 7), ("line", 0, 7), ("close",)]
QUARTER = [("move", 8, 0), ("arc", 8, 8, 0, 0, 1, 0, 8)]
# Squares and discs at ends of no length: one lies over a line's, and outlines wind alike.
DOTS = [("move", 3, 1), ("line", 3, 1), ("move", 9, 1), ("close",), ("move", 20, 20)]
SQUARES = [("move", 3, 1), ("arc", 5, 5, 0, 1, 1, 3, 1), ("move", 9, 1), ("close",), ("line", 14, 1)]
SIDES = [("move", 0, 0), ("line", 8, 0), ("line", 8, 8), ("line", 0, 8), ("close",)]
CROSSING = camsim.Rectangle(width_um=30, height_um=30, centre_um=(15, 0), reflectance=0.2)
# One of the dashes goes on where the outline begins. A line along a curve turns back where (1 − t)·32 = t·18: after
# 32²/50, with half a disc.
SHAPES = {name: (eval(shape), eval(area)) for name, shape, area in rows("areas.txt", "of shapes")}


@pytest.mark.parametrize(
    ("shape", "box"),
    [
        (camsim.Sector(radius_um=10, turn_deg=90, centre_um=(40, 0), reflectance=0.2), (40, 0, 50, 10)),
        (camsim.Sector(radius_um=10, from_deg=-60, turn_deg=120, reflectance=0.2), (0, -(75**0.5), 10, 75**0.5)),
        (curved(("move", 40, 0), ("cubic", 40, 20, 60, 20, 60, 0)), (40, 0, 60, 15)),
        (curved(("move", 0, 0), ("cubic", 0, 40, 40, -40, 40, 0)), (0, -20 / 3**0.5, 40, 20 / 3**0.5)),
        (curved(("move", 3, 4), ("arc", 5, 5, 0, 1, 0, -3, 4), ("close",)), (-5, -5, 5, 4)),
        (
            camsim.Group(
                shapes=[camsim.Rectangle(width_um=9, height_um=9, reflectance=0.2)],
                clip=camsim.Rectangle(width_um=50, height_um=2, centre_um=(20, 4), reflectance=0.2),
            ),
            (-4.5, 3, 4.5, 4.5),
        ),
    ],
    ids=["sector", "sector to both sides", "cubic", "cubic with two bends", "arc", "clipped"],
)
def test_upright_copies_stand_about_the_centre(shape, box):
    """Of two copies about a point, one lies as far from it as the other, whatever their outlines are made of."""
    centre = np.array([7.0, -3.0])
    ring = camsim.RepeatOnRing(shapes=[shape], count=2, centre_um=centre, upright=True)
    copies = (np.concatenate([layer[0].curves.points[:, 0] for layer in copy.layers]) for copy in ring.primitives())
    first, second = copies
    middle = 0.5 * np.add(box[:2], box[2:])
    np.testing.assert_allclose(second - first, np.broadcast_to(2.0 * (centre - middle), first.shape), atol=1e-12)


@pytest.mark.parametrize("limits", [SideLimits(), FINE], ids=["coarse", "fine"])
@pytest.mark.parametrize(("shape", "area"), SHAPES.values(), ids=list(SHAPES))
def test_areas(shape, area, limits):
    """Whatever the sides, a shape has its area: to rounding, and to 1e-7 where a bent line is followed by arcs, or a
    clip cuts sides that grow."""
    found = area_of(arrange(camsim.Scene(background=0.9, shapes=[shape]), limits))
    assert found == pytest.approx(area, rel=1e-7 if isinstance(shape, camsim.Line | camsim.Group) else 10 * ROUNDING)


@pytest.mark.parametrize(("shape", "area"), SHAPES.values(), ids=list(SHAPES))
def test_areas_that_the_check_sees(shape, area):
    """By arcs of circles, and winding numbers of its own."""
    pieces, _ = pieces_of(camsim.Scene(background=0.9, shapes=[shape]), 1.0, Fineness())
    assert area_seen(pieces) == pytest.approx(area, rel=1e-7)


def test_what_covers_what_adds_up():
    """A frame is divided among shapes that overlap, touch and share edges: nothing is lost or there twice."""
    frame = camsim.Rectangle(width_um=40, height_um=40, reflectance=0.1)
    over = (
        camsim.HalfPlane(through_um=(3, 0), towards_deg=0, reflectance=0.2),
        camsim.Disc(radius_um=9, centre_um=(3, 0), reflectance=0.3),
        camsim.Ring(radius_um=6, inner_radius_um=3, centre_um=(3, 0), reflectance=0.4),
        camsim.Sector(radius_um=3, turn_deg=120, centre_um=(3, 0), reflectance=0.5),
    )
    clipped = camsim.Group(shapes=(frame, *over), clip=frame)
    found = arrange(camsim.Scene(background=0.9, shapes=[clipped]), FINE)
    areas = [area_of(found, k) for k in range(1, 6)]
    assert sum(areas) == pytest.approx(1600.0, rel=ROUNDING)
    disc = math.pi * 81
    assert areas[1] == pytest.approx(17 * 40 - disc / 2, abs=FINE.cut_um2)
    assert areas[2:] == pytest.approx(
        [disc - 27 * math.pi - 3 * math.pi, 27 * math.pi, 3 * math.pi], abs=2 * FINE.cut_um2
    )


LEVELS = (0.0, 0.2, 0.7, 1.0)


def random_shape(rng, depth=0):
    """A shape and the function that tells whether places lie in it, by its own coordinates."""
    item = {"reflectance": float(rng.choice(LEVELS))}
    kind, centre = rng.integers(8 if depth < 2 else 6), rng.uniform(-4, 4, 2)
    radius, inner = np.sort(rng.uniform(0.5, 4.0, 2))[::-1]
    angle = rng.uniform(-180, 180)

    def polar(x, y):
        return np.hypot(x - centre[0], y - centre[1]), np.degrees(np.arctan2(y - centre[1], x - centre[0]))

    if kind == 0:
        made = camsim.Ring(radius_um=radius, inner_radius_um=inner, centre_um=centre, **item)
        return made, lambda x, y: (polar(x, y)[0] < radius) & (polar(x, y)[0] > inner)
    if kind == 1:
        turn = rng.uniform(10, 350)
        made = camsim.Sector(radius_um=radius, from_deg=angle, turn_deg=turn, centre_um=centre, **item)
        return made, lambda x, y: (polar(x, y)[0] < radius) & ((polar(x, y)[1] - angle) % 360 < turn)
    if kind == 2:
        made = camsim.Ellipse(radius_x_um=radius, radius_y_um=inner, rotate_deg=angle, centre_um=centre, **item)
        return made, lambda x, y: np.hypot(*(turned(x - centre[0], y - centre[1], -angle) / [[radius], [inner]])) < 1
    if kind == 3:
        made = camsim.HalfPlane(through_um=centre, towards_deg=angle, **item)
        return made, lambda x, y: turned(x - centre[0], y - centre[1], -angle)[0] > 0
    if kind in (4, 5):
        corners = np.round(rng.uniform(-5, 5, (int(rng.integers(4, 8)), 2)), 3)
        rule = ("nonzero", "evenodd")[kind - 4]
        made = dataclasses.replace(path(*corners.tolist(), fill_rule=rule), **item)
        return made, lambda x, y: wound(corners, x, y, rule)
    (one, in_one), (two, in_two) = random_shape(rng, depth + 1), random_shape(rng, 2)
    if kind == 6:
        factor, move = rng.uniform(0.5, 1.5, 2), rng.uniform(-2, 2, 2)
        made = camsim.Group(shapes=[one], mirror="up-down", scale=tuple(factor), turn_deg=angle, move_um=move)

        def within(x, y):
            u, v = turned(x - move[0], y - move[1], -angle)
            return in_one(u / factor[0], -v / factor[1])

        return made, within
    clipped = camsim.Group(shapes=[one], clip=two)
    return clipped, lambda x, y: in_one(x, y) & in_two(x, y)


def turned(x, y, degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.stack([c * x - s * y, s * x + c * y])


def wound(corners, x, y, rule):
    """Turns of the directions to the corners, added up: no ray is cast."""
    way = np.arctan2(corners[:, 1, None] - y, corners[:, 0, None] - x)
    step = (np.diff(way, axis=0, append=way[:1]) + np.pi) % (2 * np.pi) - np.pi
    turns = np.round(step.sum(axis=0) / (2 * np.pi))
    return turns != 0 if rule == "nonzero" else turns % 2 == 1


def reflectance_of(shape):
    while isinstance(shape, camsim.Group):
        [shape] = shape.shapes
    return shape.reflectance


@pytest.mark.parametrize("seed", range(5))
def test_random_shapes_against_places(seed):
    """Areas of every reflectance within a frame, against 160 000 places that each ask what was painted last."""
    rng = np.random.default_rng(seed)
    made = [random_shape(rng) for _ in range(rng.integers(2, 7))]
    step = 0.03
    place = np.arange(-200, 200) * step + 0.5 * step
    x, y = (np.ravel(axis) for axis in np.meshgrid(place, place))
    seen = np.full(x.size, 0.9)
    for shape, within in made:
        seen[within(x, y)] = reflectance_of(shape)
    frame = camsim.Rectangle(width_um=12, height_um=12, reflectance=0.9)
    scene = camsim.Scene(
        background=0.5,
        shapes=[frame, camsim.Group(shapes=[shape for shape, _ in made], clip=frame)],
    )
    found, (pieces, spectra) = arrange(scene, FINE), pieces_of(scene, 1.0, Fineness())
    for k, reflectance in enumerate(spectra[1:], 1):
        expected = np.count_nonzero(seen == reflectance) * step**2
        assert area_of(found, found.spectra.index(reflectance)) == pytest.approx(expected, abs=0.1)
        assert area_seen(pieces, k) == pytest.approx(area_of(found, found.spectra.index(reflectance)), abs=0.02)


def test_lines_of_text_stand_as_they_are_told():
    def box(**how):
        text = camsim.Text(text="HH\nH", size_um=10.0, reflectance=0.0, **how)
        found = arrange(camsim.Scene(background=1.0, shapes=[text])).start_um
        return np.concatenate([found.min(axis=0), found.max(axis=0)])

    left, centre, right = (box(align=align, at_um=(5.0, 7.0)) for align in ("left", "centre", "right"))
    assert left[3] == pytest.approx(7.0 + 13.6)
    assert left[1] == pytest.approx(7.0 - 10 * 1462 / 2048)  # capitals of Open Sans are 1462 of 2048 units high
    # What is beside an H differs by a unit on its two sides.
    assert left[2] - 5.0 == pytest.approx(5.0 - right[0], abs=0.006)
    assert centre[0] + centre[2] == pytest.approx(10.0, abs=0.006)
    middle = box(vertical="middle", at_um=(5.0, 7.0))
    assert middle[1] + middle[3] == pytest.approx(14.0)
    upright, turned_over = box(), box(rotate_deg=180)
    assert turned_over == pytest.approx(-upright[[2, 3, 0, 1]])


def nested(depth):
    shape = camsim.Disc(radius_um=1.0, reflectance=0.0)
    for _ in range(depth):
        shape = camsim.Group(shapes=[shape, shape])
    return shape


def test_more_shapes_than_can_be_drawn_are_refused():
    for make, said in (
        (lambda: nested(70), "makes 8388608 sides and curves; the most is 5000000"),
        (
            lambda: camsim.RepeatOnGrid(shapes=[nested(10)], cols=10**6, rows=10**6, step_um=(1, 1)),
            "makes 1024000000000000 sides and curves; the most is 5000000",
        ),
    ):
        with pytest.raises(InvalidValueError, match=said):
            make()


def test_a_chain_of_groups_is_so_deep_and_no_deeper():
    shape = camsim.Disc(radius_um=1.0, reflectance=0.0)
    for _ in range(64):
        shape = camsim.Group(shapes=[shape])
    assert area_of(arrange(camsim.Scene(background=1.0, shapes=[shape]))) == pytest.approx(math.pi)
    with pytest.raises(CamsimError, match="groups lie 65 deep in one another; the most is 64"):
        camsim.Group(shapes=[shape])


def test_a_scribble_is_filled_or_refused():
    """A thousand random sides cross 160 000 times; three times as many are refused before memory is taken."""
    corners = np.random.default_rng(1).uniform(-9, 9, (2000, 2))
    scribble = path(*corners[:120].tolist(), fill_rule="evenodd")
    assert 0.3 * 324 < area_of(arrange(camsim.Scene(background=0.9, shapes=[scribble]))) < 0.7 * 324
    with pytest.raises(CamsimError, match="crosses itself more than 200000 times; draw it in parts"):
        arrange(camsim.Scene(background=0.9, shapes=[path(*corners.tolist())]))


def test_what_is_masked_is_no_number():
    masked = np.ma.masked_greater([0.1, 0.2, 0.9], 0.5)
    with pytest.raises(InvalidValueError, match=r"finite number|must be a number"):
        camsim.Curve([400.0, 500.0, 600.0], masked)
    with pytest.raises(InvalidValueError, match="masked"):
        camsim.measure.Plane(name="Y", samples=np.ma.masked_greater(np.eye(64), 0.5))
    assert camsim.Curve([400.0, 500.0, 600.0], np.ma.array([0.1, 0.2, 0.3])).values == (0.1, 0.2, 0.3)


@pytest.mark.parametrize(
    ("segments", "how"),
    [
        ([("move", 1, 2), ("line", 1, 2)], {"cap": "butt"}),
        ([("move", 1, 2)], {"cap": "round"}),
        ([("move", 1, 2), ("line", 1, 2)], {"cap": "square", "dashes_um": [1]}),
    ],
)
def test_a_line_of_nothing(segments, how):
    """As in SVG: nothing is drawn, no end is seen, or there is no place for a dash."""
    assert line(2, *segments, **how).pieces == 0


def test_a_closed_line_that_is_closed_again_has_no_ends():
    segments = [("move", 0, 0), ("line", 9, 0), ("line", 0, 9), ("close",)]
    once, twice = (line(2, *each, cap="square", join="bevel").pieces for each in (segments, [*segments, ("close",)]))
    assert once == twice
