"""Letters are sorted once into outlines and their holes: by winding numbers, and as paths that are sorted anew."""

import numpy as np
import pytest

import camsim
from camsim.scene.curves import CUBIC
from camsim.scene.outlines import Outlines, area_of
from camsim.scene.primitives import Fill, Primitive, flattened
from camsim.scene.shapes.text import font_of
from camsim.scene.side_limits import SideLimits

SIDES = 60  # of a piece, in this test's own polygons
OVERLAPPING = "ÅÇŲ"  # what hangs from them is drawn into them
GROUPS = {
    "as it is": {},
    "turned": {"turn_deg": 33.0},
    "mirrored": {"mirror": "left-right"},
    "flat": {"scale": (1.5, 0.1), "turn_deg": 10.0},
    "sheared": {"matrix": (1.0, 0.2, -0.7, 0.9, 3.0, -2.0)},
    "clipped": {"clip": camsim.Disc(radius_um=24.0, centre_um=(3.0, 2.0), reflectance=0.0)},
}


def _loops(curves):
    """Loops as polygons of many sides: Béziers by their own formula."""
    t = np.arange(SIDES)[:, None] / SIDES
    for begin, end in zip(curves.first[:-1], curves.first[1:], strict=True):
        places = []
        for points, kind in zip(curves.points[begin:end], curves.kind[begin:end], strict=True):
            a, b, c, d = points
            bent = (1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t**2 * c + t**3 * d
            places.append(bent if kind == CUBIC else a[None])
        yield np.concatenate(places)


def _windings(curves, places):
    """How often loops wind about places, by the angles of their corners."""
    found = np.zeros(len(places))
    for loop in _loops(curves):
        seen = (loop[:, 0] + 1j * loop[:, 1])[None] - (places[:, 0] + 1j * places[:, 1])[:, None]
        found += np.angle(np.roll(seen, -1, axis=1) / seen).sum(axis=1) / (2.0 * np.pi)
    return np.round(found)


@pytest.mark.parametrize("weight", ["Light", "ExtraBoldItalic"])
def test_what_letters_are_sorted_into_covers_what_their_outlines_wind_about(weight):
    font, rng = font_of(weight), np.random.default_rng(1)
    for letter in "aBgi8%&Øij®ÿ:" + OVERLAPPING:
        glyph, parts = font.glyph(letter), font.parts(letter)
        assert parts[0].simple == (letter not in OVERLAPPING + "®" * (weight == "ExtraBoldItalic"))
        low, high = glyph.boxes[:, :2].min(axis=0), glyph.boxes[:, 2:].max(axis=0)
        places = rng.uniform(low, high, (300, 2))
        times = np.sum([_windings(fill.curves, places) != 0.0 for fill in parts], axis=0)
        assert np.array_equal(times, _windings(glyph, places) != 0.0), letter  # once, by one part


def test_what_letters_are_sorted_into_has_the_area_of_all_loops_together():
    font = font_of("Regular")
    letters = [chr(code) for code in (*range(33, 127), *range(192, 256))]
    for letter in letters:
        whole = Primitive(((Fill(font.glyph(letter)),),), 0.0)
        parts = [Primitive(((fill,),), 0.0) for fill in font.parts(letter)]
        together, *each = (area_of(one, Outlines.of([one]).rings(SideLimits(0.01))[0]).area for one in (whole, *parts))
        assert sum(each) == pytest.approx(together, abs=1e-12), letter


@pytest.mark.parametrize("group", GROUPS.values(), ids=GROUPS)
def test_letters_that_meet_are_those_drawn_as_paths(group):
    """Letters over one another, one covered in part, and some whose dots and cedillas meet others."""
    tolerance = 1e-6
    set_in = [
        camsim.Text(text="gi%Ç\nÅj8", size_um=22.0, at_um=(-25.0, -4.0), line=0.62, reflectance=0.1),
        camsim.Text(text="ÿ&", size_um=30.0, at_um=(-14.0, 9.0), weight="Light", rotate_deg=20.0, reflectance=0.9),
    ]
    paths = [camsim.Path(segments_um=_segments(one), reflectance=one.reflectance) for one in flattened(set_in)]
    found = [
        camsim.render(
            camsim.Scene(
                background=0.5,
                shapes=[
                    camsim.RepeatOnGrid(shapes=[camsim.Group(shapes=shapes, **group)], cols=2, step_um=(31.0, 5.0))
                ],
            ),
            [camsim.Airy(f_number=5.6), camsim.SquarePhotosite(side_um=4.88)],
            camsim.Grid(rows=8, cols=14, pitch_um=4.88),
            wavelength_nm=550.0,
            tolerance=tolerance,
            method="boundary",
        )
        for shapes in (set_in, paths)
    ]
    assert max(one.error_estimate for one in found) <= tolerance
    assert np.abs(found[0].image - found[1].image).max() <= 2.0 * tolerance
    assert np.ptp(found[0].image) > 0.05


def _segments(primitive):
    segments = []
    for fill in primitive.fills:
        curves = fill.curves
        for begin, end in zip(curves.first[:-1], curves.first[1:], strict=True):
            segments.append(("move", *curves.points[begin, 0]))
            for (_, b, c, d), kind in zip(curves.points[begin:end], curves.kind[begin:end], strict=True):
                segments.append(("cubic", *b, *c, *d) if kind == CUBIC else ("line", *d))
            segments.append(("close",))
    return segments
