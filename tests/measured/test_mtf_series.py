"""The MTF of several files side by side, in the units that people use, and over the frame."""

import dataclasses
import math

import numpy as np
import pytest
from edges import gaussian_edge, gaussian_limit

from camsim.cli import plot_mtf_map
from camsim.errors import InvalidValueError, UnknownNameError, UnsupportedError
from camsim.measure import FullFrame, Picture, Plane, Roi, measure_mtf, mtf_series

SAGITTAL_PX, TANGENTIAL_PX = 0.7, 1.1


def description(f_number, iso=100, origin=(10, 20)):
    camera = {"rows": 400, "cols": 600, "pitch_um": 4.0, "cfa": {"pattern": ["Y"]}, "lens": {"f_number": f_number}}
    exposure = {"iso": iso, "time_s": 0.01}
    return {"camera": camera, "exposure": exposure, "region": {"rows": 64, "cols": 64, "origin": origin}}


def report(tree, sigma=0.8, name="edge.dng"):
    image = gaussian_edge(64, 64, 5.0, sigma)
    plane = Plane(name="Y", samples=image)
    picture = Picture(name=name, shape=image.shape, planes=(plane,), pitch_um=4.0, description=tree)
    return measure_mtf(picture, rois=[Roi(0, 0, 64, 64)])


def test_files_are_ordered_by_what_they_were_taken_with():
    reports = [report(description(n), sigma=0.1 * n) for n in (16, 8, 11)]
    series = mtf_series(reports, by="aperture")
    assert (series.values, series.labels) == ((8.0, 11.0, 16.0), ("8", "11", "16"))
    mtf50 = [each.edges[0].figures.mtf50_cycles_per_pixel for each in series.reports]
    assert mtf50 == pytest.approx([gaussian_limit(0.5, 0.1 * n) for n in (8, 11, 16)], rel=1e-3)
    assert mtf_series(reports, by="f_number").values == series.values
    assert mtf_series(reports).values == ("edge.dng (1)", "edge.dng (2)", "edge.dng (3)")
    assert [file["value"] for file in series.as_dict()["files"]] == [8.0, 11.0, 16.0]


def test_what_a_key_does_not_say_is_refused():
    reports = [report(description(8)), report(description(11, origin=None))]
    with pytest.raises(UnknownNameError, match=r"unknown key 'f_numbr'; did you mean 'f_number'"):
        mtf_series(reports, by="f_numbr")
    with pytest.raises(InvalidValueError, match=r"may be camera\.rows, region\.rows; write one of them in full"):
        mtf_series(reports, by="rows")
    with pytest.raises(UnsupportedError, match="its iso; leave --by out"):
        mtf_series([*reports, report(None)], by="iso")


def test_the_frame_of_a_window_and_its_units():
    stated = report(description(8))
    assert stated.full_frame == FullFrame(rows=400, cols=600, axis_x_pixel=280.0, axis_y_pixel=190.0, pitch_um=4.0)
    assert stated.nyquist()["sensor"] == {"cycles_per_pixel": 0.5, "lp_per_mm": 125.0, "lw_per_ph": 400.0}
    edge = stated.as_dict()["edges"][0]
    assert edge["mtf50_lp_per_mm"] == pytest.approx(250.0 * edge["mtf50_cycles_per_pixel"])
    assert edge["mtf50_lw_per_ph"] == pytest.approx(800.0 * edge["mtf50_cycles_per_pixel"])
    assert edge["field"]["x_um"] == pytest.approx(4.0 * (edge["x_pixel"] - 280.0))
    for broken in ({"camera": 3}, description(8) | {"region": {"rows": 64}}, description(8) | {"region": None}):
        whole = report(broken).full_frame
        assert (whole.rows, whole.axis_x_pixel, whole.pitch_um) == (64, 32.0, None)


def test_sagittal_and_tangential_edges_around_the_axis():
    """A blur of two widths, along and across the radius: each edge tells the one across it."""
    rows, image, rois = 5, np.full((320, 320), 0.5), []
    for number, (row, col) in enumerate((r, c) for r in range(rows) for c in range(rows) if (r, c) != (2, 2)):
        y, x = 64 * row + 32 - 160, 64 * col + 32 - 160
        radius_deg = math.degrees(math.atan2(y, x))
        sagittal = number % 2 == 0
        normal = radius_deg + 12.0 + (90.0 if sagittal else 0.0)
        along = math.cos(math.radians(normal - radius_deg))
        sigma = math.hypot(TANGENTIAL_PX * along, SAGITTAL_PX * math.sqrt(1.0 - along**2))
        if not 4.0 < abs((normal + 45.0) % 90.0 - 45.0) < 40.0:
            continue
        image[64 * row : 64 * row + 64, 64 * col : 64 * col + 64] = gaussian_edge(64, 64, normal, sigma)
        rois.append((Roi(64 * row, 64 * col, 64, 64), "sagittal" if sagittal else "tangential", sigma))
    picture = Picture(name="map", shape=image.shape, planes=(Plane(name="Y", samples=image),))
    stated = measure_mtf(picture, rois=[roi for roi, _, _ in rois])
    assert len(stated.edges) == len(rois) > 12
    for edge, (roi, direction, sigma) in zip(stated.edges, rois, strict=True):
        place = stated.place(edge)
        assert (edge.roi, place.direction) == (roi, direction)
        assert edge.figures.mtf50_cycles_per_pixel == pytest.approx(gaussian_limit(0.5, sigma), rel=2e-3)


@pytest.mark.parametrize("origin", [(10, 20), (300, 500), (10, 500), (168, 268)])
def test_a_map_shows_its_edges_wherever_the_window_lies(origin, monkeypatch):
    """Right of the axis and below it a map ended before its first edge."""
    monkeypatch.setattr(plot_mtf_map, "bytes_of", lambda figure, file: figure)
    stated = report(description(8, origin=origin))
    place = dataclasses.replace(stated.place(stated.edges[0]), direction="sagittal")
    monkeypatch.setattr(type(stated), "place", lambda report, edge: place)
    axes = plot_mtf_map.draw_map(stated, "map.png", "cycles/px").axes[0]
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    assert left < place.x_pixel < right
    assert top < place.y_pixel < bottom
    assert (left, top) == (-right, -bottom)
