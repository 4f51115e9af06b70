"""The check's integral along one piece against closed forms, the angle that an arc fills and the area that it sweeps,
and against finer rules."""

import numpy as np
import pytest

import camsim
from camsim.quadrature import gauss_legendre
from camsim.rendering.check.along import SHORT, Energy, Rules, add_bezier, add_straight
from camsim.rendering.check.along_arcs import add_round_piece
from camsim.rendering.check.beziers import between
from camsim.rendering.check.outlines import outlines_of
from camsim.rendering.check.parts import parts_seen
from camsim.rendering.check.pattern import oscillation, table_of
from camsim.rendering.check.points import memory_for, rules_of
from camsim.rendering.check.records import Outlines
from camsim.rendering.check.scenery import Pieces, pieces_of
from camsim.rendering.check.whereabouts import Whereabouts
from camsim.scene.arcs import Fineness

RULES = Rules(
    *(np.stack(gauss_legendre(count)) for count in (20, *(count for count, _ in SHORT))), longest=4.0, tiny=0.25
)


ONE = np.zeros(1, np.int64)  # channel


def energy_of(cells, per_step, far):
    """One channel's."""
    return Energy(cells[None], per_step, np.array(far)[None], ONE)


def added(add, *arguments):
    """Return what a piece adds to one channel."""
    memory = memory_for(1, 40, 1)
    add(*arguments, memory.piece if add is add_bezier else memory)
    return memory.piece[0]


def along(place, radius, from_rad, turn_rad, energy, reach):
    """Return the integral as a point at the origin has it."""
    middle = from_rad + 0.5 * turn_rad
    about = np.array([place[0] + radius * np.cos(middle), place[1] + radius * np.sin(middle), 0.5 * radius * turn_rad])
    column = [np.array([value]) for value in (place[0], place[1], radius, 0.0, from_rad, turn_rad)]
    return added(add_round_piece, 0.0, 0.0, Outlines(*column), 0, about, reach, energy, RULES)


@pytest.mark.parametrize("turn_rad", [1e-6, 1e-3, 0.05, 0.19, 0.21])
@pytest.mark.parametrize("radius", [0.3, 4.0, 3e4])
def test_an_arc_is_seen_under_its_angle_and_sweeps_its_area(turn_rad, radius):
    rng = np.random.default_rng(3)
    none = np.zeros((1, 6))
    for _ in range(20):
        # The arc's middle is anywhere from 0.5 to 60 away.
        from_rad, away = rng.uniform(-np.pi, np.pi), rng.uniform(-np.pi, np.pi)
        distance = np.exp(rng.uniform(np.log(0.5), np.log(60.0)))
        middle = from_rad + 0.5 * turn_rad
        place = distance * np.array([np.cos(away), np.sin(away)]) - radius * np.array([np.cos(middle), np.sin(middle)])
        a, b = (place + radius * np.array([np.cos(f), np.sin(f)]) for f in (from_rad, from_rad + turn_rad))
        if radius * turn_rad < 0.5 * distance:
            angle = along(place, radius, from_rad, turn_rad, energy_of(none, 1.0, [1.0, 0.0, 0.0, 0.0]), 1e-9)
            seen = np.arctan2(a[0] * b[1] - a[1] * b[0], a @ b)
            assert abs(angle - seen) <= (1e-11 if turn_rad < 0.2 else 1e-10) + 1e-15 * radius
        # E = r²: twice the area between the point and the arc, the triangle's and the segment's.
        flat = np.array([[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]])
        swept = along(place, radius, from_rad, turn_rad, energy_of(flat, 1e-9, np.zeros(4)), 1e9)
        segment = turn_rad - np.sin(turn_rad) if turn_rad > 0.01 else turn_rad**3 / 6.0 * (1.0 - turn_rad**2 / 20.0)
        twice = a[0] * b[1] - a[1] * b[0] + radius**2 * segment
        assert abs(swept - twice) <= 1e-12 * (1.0 + radius * turn_rad) * (1.0 + distance + radius)


@pytest.mark.parametrize("allowed", [1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize(
    "lens",
    [camsim.Airy(f_number=8.0), camsim.AnnularAiry(f_number=8.0, obstruction=0.6), camsim.Gaussian(sigma_um=4.4)],
)
def test_rules_along_outlines_leave_less_than_is_allowed(lens, allowed):
    """At places near and far, along pieces short and long, of which some are tiny."""
    table = table_of(lens, np.ones(1), np.ones((1, 1)), 60.0, 1e-12)
    energy, own = energy_of(table.cells[0], 1.0 / table.step, table.far[0]), rules_of(1.0, allowed)
    fine = Rules(np.stack(gauss_legendre(40)), own.few, own.fewest, longest=2.0, tiny=0.0)
    rng, off = np.random.default_rng(5), []
    for _ in range(300):
        (x, y), angle, length = rng.uniform(-20.0, 20.0, 2), rng.uniform(0.0, np.pi), np.exp(rng.uniform(-2.0, 5.0))
        way = length * np.array([np.cos(angle), np.sin(angle)])
        line = Outlines(*(np.array([value]) for value in (x, y, *way, 0.0, 0.0)))
        radius, turn = rng.uniform(2.0, 80.0), rng.uniform(0.01, 6.0)
        arc = Outlines(*(np.array([value]) for value in (x, y, radius, 0.0, angle, turn)))
        middle = angle + 0.5 * turn
        about = np.array([x + radius * np.cos(middle), y + radius * np.sin(middle), 0.5 * radius * turn])
        for piece in (
            lambda rules, line=line: added(add_straight, 0.0, 0.0, line, 0, 50.0, energy, rules),
            lambda rules, arc=arc, about=about: added(add_round_piece, 0.0, 0.0, arc, 0, about, 50.0, energy, rules),
        ):
            off.append(abs(piece(own) - piece(fine)) / (2.0 * np.pi))
    assert max(off) <= 0.1 * allowed


@pytest.mark.parametrize("allowed", [1e-3, 1e-6, 1e-9])
def test_bezier_curves_by_few_nodes_and_by_many(allowed):
    """Leaves of the check's own parts of them: at every distance, against as many pieces of sixty-four nodes each."""
    table = table_of(camsim.Airy(f_number=8.0), np.ones(1), np.ones((1, 1)), 60.0, 1e-12)
    energy = energy_of(table.cells[0], 1.0 / table.step, table.far[0])
    rng, off, nothing = np.random.default_rng(5), [], np.zeros(1)
    for _ in range(60):
        corners = (rng.uniform(-3.0, 3.0, 8) * np.exp(rng.uniform(-3.0, 0.0))).tolist()
        leaf = camsim.Path(segments_um=[("move", *corners[:2]), ("cubic", *corners[2:]), ("close",)], reflectance=0.0)
        pieces, _ = pieces_of(camsim.Scene(background=1.0, shapes=[leaf]), 1.0, Fineness(1.0, 1e-9), whole=True)
        own = parts_seen(pieces, np.zeros(len(pieces.left)), np.ones(len(pieces.left)), 1.0, allowed)
        for e in np.flatnonzero(pieces.bezier >= 0):
            ends = np.linspace(0.0, 1.0, 9)
            finer = Pieces(
                Outlines(*(np.repeat(nothing, 8) for _ in range(6))), *np.zeros((2, 8), int), np.arange(8),
                between(np.repeat(pieces.curves[pieces.bezier[[e]]], 8, axis=0), ends[:-1], ends[1:]),
            )  # fmt: skip
            fine = parts_seen(finer, *np.zeros((2, 8)), 0.05, 1e-12)
            place = own.about[e, :2] + np.exp(rng.uniform(-3.0, 5.0)) * np.array([np.cos(e), np.sin(e)])
            # All of it is looked up in the table, or none of it.
            gap = np.hypot(*(own.about[e, :2] - place)) - own.about[e, 2]
            radius = 50.0 if gap < 50.0 else 0.0
            one = added(add_bezier, *place, own.bent, own.bent.of[e], own.about[e, 2], radius, energy)
            many = sum(
                added(add_bezier, *place, fine.bent, k, fine.about[k, 2], 1.2 * radius, energy) for k in range(8)
            )
            off.append(abs(one - many) / (2.0 * np.pi))
    assert len(off) > 50
    assert max(off) <= 0.1 * allowed


def test_what_hardly_bends_is_where_it_lies():
    """Its centre is 1e4 pitches away: rings were looked for as far as that, minutes of planning behind a curve."""
    half = np.array([0.0, 0.5 * np.pi])
    column = (
        np.array([-1e4, 3.0]),
        np.zeros(2),
        np.array([1e4 + 2.0, 2.0]),
        np.zeros(2),
        half - 1e-4,
        2.0 * half + 2e-4,
    )
    pieces = Pieces(Outlines(*column), np.zeros(2, int), np.ones(2, int), np.full(2, -1), np.zeros((0, 4), complex))
    farthest = Whereabouts(pieces=pieces, corners=np.array([-1.0, -1.0, 1.0, 1.0])).farthest
    assert np.hypot(4.0 + 2.0, 1.0) <= farthest < 12.0


@pytest.mark.parametrize("allowed", [1e-4, 1e-7, 1e-10])
def test_what_turns_back_is_followed_in_few_parts(allowed):
    """A cusp, and a curve that runs out and back: halved down to rounding they were 2000 parts that crossed each other
    120 000 times, and the check took 80 s over five photosites."""
    rng, fine = np.random.default_rng(8), Fineness(0.5, allowed)
    t = np.linspace(0.0, 1.0, 200_001)[:, None]
    basis = np.hstack([(1.0 - t) ** 3, 3.0 * t * (1.0 - t) ** 2, 3.0 * t**2 * (1.0 - t), t**3])
    for corners in (
        [[0.0, 0.0], [-0.034, 0.033], [-0.034, 0.033], [0.0, 0.0]],
        [[0.0, 0.0], [1.5, 0.0], [-0.5, 0.0], [1.0, 0.0]],
        [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0], [1.0, 0.0]],
        [[0.0, 0.0], [2.0, 1.0], [2.0, 1.0], [0.0, 0.1]],
    ):
        turn, place, away = rng.uniform(0.0, 6.0), rng.uniform(-3.0, 3.0, 2), np.array([0.3, 0.8])
        turned = np.array(corners) @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        points = turned + place
        leaf = camsim.Path(
            segments_um=[("move", *points[0]), ("cubic", *points[1:].ravel()), ("line", *(place + away)), ("close",)],
            reflectance=0.0,
        )
        outlines, owners, _, _ = outlines_of(camsim.Scene(background=1.0, shapes=[leaf]), 1.0, fine)
        assert len(outlines.x) < 500
        # Triangles from the origin to all chords, and between these and their arcs.
        x0, y0, x1, y1 = owners.ends.T
        turned_by = outlines.turn_rad
        own = np.sum(x0 * y1 - x1 * y0 + outlines.dx**2 * (turned_by - np.sin(turned_by)))
        drawn = np.vstack([basis @ points, place + away])
        x, y = drawn.T
        area = np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)
        assert abs(own - area) <= 2.0 * allowed * fine.longest**2 + 1e-10


@pytest.mark.parametrize(
    "lens", [camsim.Airy(f_number=5.6), camsim.RadialOtf(freq_per_um=(0.0, 0.1, 0.3, 0.4), values=(1.0, 0.5, 0.3, 0.0))]
)
def test_a_few_distances_have_what_the_table_has(lens):
    blur, weights = np.array([0.9, 1.1]), np.array([[1.0, 0.5], [0.0, -2.0]])
    radius = np.linspace(20.0, 24.0, 4001)
    few, many = (oscillation(lens, blur, weights, own, 1e-9) for own in (radius[::100], radius))
    np.testing.assert_allclose(few, many[:, ::100], rtol=0, atol=2e-11)


@pytest.mark.parametrize(
    "lens", [camsim.Wavefront(f_number=8, pupil=camsim.Pupil(shape="square")), camsim.Gaussian(sigma_um=2.0)]
)
def test_arcs_that_others_cut_have_their_areas(lens):
    """An image that is right to a thousandth of the tolerance is found so: sides lie no farther off than that asks."""
    shapes = [
        camsim.Disc(radius_um=30.0, centre_um=(-10.0, 3.0), reflectance=0.9),
        camsim.Disc(radius_um=25.0, centre_um=(14.0, -4.0), reflectance=0.1),
        camsim.Sector(radius_um=20.0, from_deg=10.0, turn_deg=100.0, reflectance=0.6),
    ]
    found = camsim.render(
        camsim.Scene(background=0.3, shapes=shapes),
        [lens, camsim.CircularPhotosite(diameter_um=3.9)],
        camsim.Grid(rows=16, cols=16, pitch_um=4.0),
        wavelength_nm=550.0,
        tolerance=1e-7,
    )
    assert found.error_estimate <= 1e-8
