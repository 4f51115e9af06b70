"""What is not one measurable edge is refused, in a sentence that says what is wrong and what would work."""

import math
import re
from types import SimpleNamespace

import numpy as np
import pytest
from edges import gaussian_edge, gaussian_mtf
from PIL import Image

import camsim
from camsim.errors import InputError, InvalidValueError, UnsupportedError
from camsim.measure import Picture, Plane, Roi, measure_edge, measure_mtf, read_picture
from camsim.measure.picture import Channel
from camsim.measure.reading import picture_of_frame
from camsim.measure.sampling import refuse_gap

WHOLE = Roi(0, 0, 64, 64)


def noisy(image, sigma=0.004, seed=1):
    return image + np.random.default_rng(seed).normal(0.0, sigma, image.shape)


def half_of_corner():
    y, x = np.mgrid[:64, :64]
    return np.where((x + 0.1 * y > 33) & (y - 0.1 * x > 25), 0.9, 0.1)


def two_edges():
    return gaussian_edge(64, 64, 5, 0.8, shift_px=-12) - gaussian_edge(64, 64, 5, 0.8, shift_px=12) + 0.1


def staircase():
    return gaussian_edge(64, 64, 5, 0.8, shift_px=-12) + gaussian_edge(64, 64, 5, 0.8, shift_px=12)


def line_between_greys(width, *, dark=0.35, bright=0.6):
    """A line of 0.03 runs along the edge, on its darker side."""
    edge, line = (gaussian_edge(64, 64, 5, 0.8, dark=0.0, bright=1.0, shift_px=shift) for shift in (0.3, 0.3 - width))
    return dark * (1.0 - line) + 0.03 * (line - edge) + bright * edge


REFUSED = {
    "flat": (np.full((64, 64), 0.5), "no edge"),
    "end of an edge": (
        np.where(np.arange(64)[:, None] < 40, gaussian_edge(64, 64, 5, 0.8), 0.1),
        "corner|end of an edge|one straight edge",
    ),
    "corner": (half_of_corner(), "corner|one straight edge"),
    "two edges": (two_edges(), "two edges|second edge|no edge"),
    "staircase": (staircase(), "two edges|second edge"),
    "vertical": (gaussian_edge(64, 64, 0.0, 0.8), "too close to a pixel axis.*turn the edge to"),
    "nearly vertical": (gaussian_edge(64, 64, 0.4, 0.8), "too close to a pixel axis.*px long"),
    "45 degrees": (gaussian_edge(64, 64, 45.0, 0.8), "phases repeat.*turn the edge"),
    "atan(1/2)": (gaussian_edge(64, 64, np.degrees(np.arctan(0.5)), 0.8), "phases repeat"),
    "little contrast": (gaussian_edge(64, 64, 5, 0.8, dark=0.5, bright=0.53), "contrast .* under 5 %"),
    "hairline between two greys": (line_between_greys(0.6), "thin line|beside a line"),
    "line between two greys": (line_between_greys(1.0), "beside a line"),
    "stroke between two greys": (line_between_greys(7.0), "second edge|line"),
    "stroke beside a strong edge": (line_between_greys(7.0, dark=0.1, bright=0.8), "second edge|line"),
    "highlights": (np.minimum(gaussian_edge(64, 64, 5, 0.8), 0.8), "clipped highlights.*expose less"),
    "no number": (np.where(np.eye(64) > 0, np.nan, gaussian_edge(64, 64, 5, 0.8)), "no numbers"),
    "wider than the region": (
        gaussian_edge(64, 64, 7, 12.0),
        r"over 2\d px or more, .* only 32 px .* take 5\d px or more",
    ),
    "edge at the border": (gaussian_edge(64, 64, 5, 0.8, shift_px=31), "side|beyond the edge|contrast"),
}


@pytest.mark.parametrize("name", REFUSED)
@pytest.mark.parametrize("noise", [0.0, 0.004])
def test_a_region_without_one_edge_is_refused(name, noise):
    image, pattern = REFUSED[name]
    if noise and name != "highlights":
        image = noisy(image, noise)
    white = 0.8 if name == "highlights" else None
    with pytest.raises(UnsupportedError, match=pattern) as caught:
        measure_edge(Plane(name="Y", samples=image, white=white), WHOLE)
    assert "roi 0,0,64,64, channel Y" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_an_edge_that_leaves_its_region_is_refused():
    """Where the first fit moved it no photosite was near: a division by zero (found by mutating files)."""
    y, x = np.mgrid[:29, :36]
    samples = noisy(np.where(x - 0.05 * y > 25.92, 1.0, 0.0), sigma=0.05, seed=34)
    samples[7:] = 1.37
    with pytest.raises(UnsupportedError, match="no single straight edge fits"):
        measure_edge(Plane(name="R", samples=samples, step=(2, 2)), Roi(0, 0, 58, 58))


def test_noise_alone_is_no_edge():
    with pytest.raises(UnsupportedError, match="no edge"):
        measure_edge(Plane(name="Y", samples=noisy(np.full((64, 64), 0.5), 0.05)), WHOLE)


def test_clipped_shadows_are_told_from_a_black_that_is_dark():
    codes = np.rint(np.maximum(noisy(4000 * gaussian_edge(64, 64, 5, 0.8, dark=0.0), 3.0), 0.0)).astype(np.uint16)
    with pytest.raises(UnsupportedError, match="clipped shadows"):
        measure_edge(Plane(name="Y", samples=codes, lowest=0.0), WHOLE)
    quiet = np.rint(4000 * gaussian_edge(64, 64, 5, 0.8, dark=0.0)).astype(np.uint16)
    assert measure_edge(Plane(name="Y", samples=quiet, lowest=0.0), WHOLE).figures.contrast > 0.99


def shots(photons, gain, seed=2):
    """Codes above a black of 64, with photon and read noise."""
    rng = np.random.default_rng(seed)
    edge = gaussian_edge(64, 64, 5, 0.8, dark=0.05, bright=0.9)
    return np.round(64.0 + gain * rng.poisson(photons * edge) + rng.normal(0.0, 0.6, edge.shape))


@pytest.mark.parametrize("part", [0.7, 0.95, 1.0])
@pytest.mark.parametrize(("photons", "gain"), [(20000, 0.2), (2000, 0.5), (200, 4.0)])
def test_highlights_that_clip_below_what_a_file_can_store_are_seen(photons, gain, part):
    codes = shots(photons, gain)
    limit = math.floor(64.0 + part * 0.9 * photons * gain)
    for plane in (
        Plane(name="Y", samples=np.minimum(codes, limit).astype(np.uint16), black=64.0, white=65535.0),
        Plane(name="Y", samples=np.minimum(codes - 64.0, limit - 64.0) / (photons * gain)),
    ):
        with pytest.raises(UnsupportedError, match=r"bright side is one number.*clipped there"):
            measure_edge(plane, WHOLE)
    measure_edge(Plane(name="Y", samples=codes.astype(np.uint16), black=64.0, white=65535.0), WHOLE)


@pytest.mark.parametrize("kept", ["frame", "dng"])
def test_highlights_of_a_channel_with_an_offset_are_seen(tmp_path, kept):
    """Blue is full 12 codes sooner than the others: 0.394 was its MTF50 where theory has 0.281."""
    sets = ("charge.full_well_e=20000", "readout.black_offsets_dn=[[0,0],[0,-12]]")
    overrides = [*(f"sensor.{one}" for one in sets), "exposure.time_s=0.06", "render.tolerance=1e-3"]
    frame = camsim.load("slanted-edge", overrides=overrides).frame()
    picture = picture_of_frame(frame)
    if kept != "frame":
        camsim.save(frame, tmp_path / f"a.{kept}")
        picture = read_picture(tmp_path / f"a.{kept}")
    with pytest.raises(UnsupportedError, match="clipped highlights"):
        measure_mtf(picture, channel="B")


@pytest.mark.parametrize("dark", [0.0, 0.05])
def test_sides_without_noise_are_not_clipped(dark):
    edge = gaussian_edge(64, 64, 5, 0.8, dark=dark, bright=0.9)
    for samples in (edge, edge.astype(np.float32), np.round(4000.0 * edge).astype(np.uint16), np.round(200.0 * edge)):
        figures = measure_edge(Plane(name="Y", samples=samples), WHOLE).figures
        assert figures.mtf50_cycles_per_pixel == pytest.approx(
            math.sqrt(2.0 * math.log(2.0)) / (2.0 * math.pi * 0.8), rel=0.03
        )


def test_of_light_below_black_no_contrast_is_said():
    edge = gaussian_edge(64, 64, 5, 0.8)
    measured = measure_edge(Plane(name="Y", samples=edge - 0.7), WHOLE)
    assert math.isnan(measured.figures.contrast)
    assert any(note.code == "below-black" for note in measured.notes)
    right = measure_edge(Plane(name="Y", samples=edge), WHOLE)
    assert measured.figures.mtf50_cycles_per_pixel == pytest.approx(right.figures.mtf50_cycles_per_pixel, rel=1e-6)


def test_true_and_false_are_no_light(tmp_path):
    file = tmp_path / "mask.npy"
    np.save(file, gaussian_edge(64, 64, 5, 0.8) > 0.5)
    with pytest.raises(InputError, match="true and false"):
        read_picture(file)


def test_black_is_taken_off_whole_numbers():
    """Of uint16 and a black level of 100 the codes below it were 65 526."""
    planes = tuple(
        Plane(name="Y", samples=np.full((2, 1), 90, np.uint16), first=(0, col), step=(1, 2), black=100)
        for col in (0, 1)
    )
    signal, _, _ = Channel(planes).on_a_lattice(Roi(0, 0, 2, 2))
    np.testing.assert_allclose(signal, -10.0)


def test_too_few_rows():
    with pytest.raises(UnsupportedError, match="too few"):
        measure_edge(Plane(name="Y", samples=gaussian_edge(6, 64, 5, 0.8)), Roi(0, 0, 6, 64))


def test_a_picture_without_edges():
    flat = Picture(name="x", shape=(200, 200), planes=(Plane(name="Y", samples=noisy(np.full((200, 200), 0.5))),))
    with pytest.raises(UnsupportedError, match="no measurable slanted edge"):
        measure_mtf(flat)


def test_encoded_data_is_refused_until_someone_says_how_it_is_encoded(tmp_path):
    linear = gaussian_edge(96, 96, 5, 0.8)
    codes = np.rint(255 * linear ** (1 / 2.2)).astype(np.uint8)
    for name in ("a.png", "a.jpg", "a.tiff"):
        Image.fromarray(codes).save(tmp_path / name)
        with pytest.raises(InvalidValueError, match=r"linear data is needed.*--gamma"):
            read_picture(tmp_path / name)
    with pytest.raises(InvalidValueError, match="gamma"):
        read_picture(tmp_path / "a.png", gamma="adobe")
    edge = measure_edge(read_picture(tmp_path / "a.png", gamma=2.2).planes[0], Roi(0, 0, 96, 96))
    right = measure_edge(Plane(name="Y", samples=linear), Roi(0, 0, 96, 96))
    assert edge.figures.mtf50_cycles_per_pixel == pytest.approx(right.figures.mtf50_cycles_per_pixel, rel=0.01)
    wrong = measure_edge(read_picture(tmp_path / "a.png", gamma=1.0).planes[0], Roi(0, 0, 96, 96))
    assert abs(wrong.figures.mtf50_cycles_per_pixel / right.figures.mtf50_cycles_per_pixel - 1) > 0.01


@pytest.mark.parametrize("length", [20.0, 33.0, 64.0])
@pytest.mark.parametrize("step", [1, 2])
def test_an_edge_turned_as_far_as_is_said_has_its_phases(length, step):
    channel = Channel((Plane(name="Y", samples=np.zeros((8, 8)), step=(step, step)),))

    def refuse(angle_deg):
        refuse_gap(0.0, SimpleNamespace(angle_deg=angle_deg), length, length, channel, "x")

    with pytest.raises(UnsupportedError, match=r"turn the edge to (\d+)° or more") as caught:
        refuse(0.0)
    refuse(float(re.search(r"to (\d+)°", str(caught.value)).group(1)))


@pytest.mark.parametrize("width", [0.05, 0.1, 0.2])
def test_a_line_too_thin_to_be_seen_is_said_to_be_possible(width):
    """Coma makes the same edge, so it is not refused; the note's bound is above what the line does, and not far."""
    edge = measure_edge(Plane(name="Y", samples=line_between_greys(width)), WHOLE)
    too_high = 0.5 / gaussian_mtf(edge.figures.mtf50_cycles_per_pixel, 0.8) - 1.0
    (said,) = (float(number) for note in edge.notes for number in re.findall(r"up to ([\d.]+) % too high", str(note)))
    assert 0.95 * too_high < said / 100 < 1.5 * too_high
    assert not measure_edge(Plane(name="Y", samples=noisy(gaussian_edge(64, 64, 5, 0.8))), WHOLE).notes
