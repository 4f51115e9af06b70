"""Drawings: what SVG files show is what another program shows of them, at the right place and size."""

import io
import itertools
import re
from pathlib import Path

import matplotlib
import numpy as np
import pytest
import resvg_py
import segno
import ttf_opensans
from fontTools.pens.statisticsPen import StatisticsPen
from fontTools.pens.transformPen import TransformPen
from fontTools.ttLib import TTFont
from PIL import Image
from tables import rows
from truth.coverage import coverage

import camsim
from camsim.errors import CamsimError
from camsim.scene import arrange, flattened
from camsim.scene.svg import read_svg
from camsim.spectra.curve import spectrum_at

GREEN_NM = np.array([550.0])

CONSTRUCTS = dict(rows("drawings.txt", "looks"))


def page(inside, head='viewBox="0 0 40 40"'):
    return f'<svg xmlns="http://www.w3.org/2000/svg" {head}>{inside}</svg>'


def seen(file, side=40):
    """What lies on each of side × rows squares of a drawing on white, from black 0 to white 1."""
    # The green of each colour in place of its reflectance, as ``shown`` looks at green.
    colours = {text: int(text[3:5], 16) / 255 for text in re.findall("#[0-9a-fA-F]{6}", Path(file).read_text())}
    drawing = read_svg(file, width_um=float(side), palette=colours)
    return squares(drawing, round(side * ratio(file)), side)


def squares(shape, rows, cols):
    """Mean reflectance of squares of 1 µm, by the visible edges."""
    edges = arrange(camsim.Scene(background=1.0, shapes=[shape]))
    value = np.array([np.mean(spectrum_at(spectrum, GREEN_NM)) for spectrum in edges.spectra])
    corner = [0.5 * cols, 0.5 * rows]
    step = value[edges.left] - value[edges.right]
    return coverage(edges.start_um + corner, edges.end_um + corner, step, 1.0, rows, cols)


def ratio(file):
    with Image.open(io.BytesIO(bytes(resvg_py.svg_to_bytes(svg_path=str(file), dpi=96)))) as small:
        return small.height / small.width


def displayed(file, side=40, finer=16):
    """What resvg shows of it: the mean of finer pixels."""
    data = bytes(resvg_py.svg_to_bytes(svg_path=str(file), width=side * finer, background="white", dpi=96))
    with Image.open(io.BytesIO(data)) as picture:
        pixels = np.asarray(picture.convert("RGB"), np.float64)[:, :, 1] / 255.0
    rows = pixels.shape[0] // finer
    return pixels[: rows * finer].reshape(rows, finer, side, finer).mean(axis=(1, 3))


@pytest.mark.parametrize("name", list(CONSTRUCTS))
def test_a_construct_looks_as_in_another_program(tmp_path, name):
    file = tmp_path / "drawing.svg"
    file.write_text(page(CONSTRUCTS[name]))
    ours, theirs = seen(file), displayed(file)
    assert np.ptp(theirs) > 0.4
    assert np.abs(ours - theirs).max() < 0.02
    assert abs(ours.mean() - theirs.mean()) < 5e-4


@pytest.mark.parametrize(
    "head",
    [
        'width="80" height="80" viewBox="0 0 40 40"',
        'width="50.8mm" height="50.8mm" viewBox="-5 -5 50 50"',
        'width="60" height="30" viewBox="0 0 40 40"',
        'width="60" height="30" viewBox="0 0 40 40" preserveAspectRatio="xMinYMax slice"',
        'width="60" height="30" viewBox="0 0 40 40" preserveAspectRatio="none"',
        'width="40" height="40"',
    ],
)
def test_the_page_is_placed_as_in_another_program(tmp_path, head):
    file = tmp_path / "drawing.svg"
    file.write_text(page('<path d="M2 2H30L10 38Z"/>', head))
    ours, theirs = seen(file), displayed(file)
    assert ours.shape == theirs.shape
    assert np.abs(ours - theirs).max() < 0.02


def test_percentages_are_of_user_units(tmp_path):
    """Of the viewBox, however large the page is shown."""
    file = tmp_path / "drawing.svg"
    inside = '<circle cx="50%" cy="75%" r="10%"/><use href="#a" x="5%" y="10%"/><defs><path id="a" d="M0 2H36" '
    file.write_text(
        page(
            inside + 'stroke="#808080" stroke-width="10%" stroke-dasharray="20%"/></defs>',
            'width="80" height="80" viewBox="0 0 40 40"',
        )
    )
    assert np.abs(seen(file) - displayed(file)).max() < 0.02


@pytest.mark.parametrize(
    ("said", "plain"),
    [
        ('fill-rule="EvenOdd"', 'fill-rule="evenodd"'),
        ('style="fill-rule:unset"', 'fill-rule="evenodd"'),
        ('style="fill-rule:initial"', 'fill-rule="nonzero"'),
        ('style="display:NONE"', 'visibility="HIDDEN"'),
        ('style="fill:unset"', 'fill="#808080"'),
        ('fill="None" stroke="black" stroke-linejoin="Round"', 'fill="none" stroke="black" stroke-linejoin="round"'),
        ('clip-path="url(#styled)"', 'clip-path="url(#plain)"'),
    ],
)
def test_words_of_css_in_any_case_and_for_what_is_above(tmp_path, said, plain):
    """CSS Cascade 4, 7.3: unset is what is above, of what is inherited. The plain ones look as resvg shows them."""
    file, looks = tmp_path / "drawing.svg", []
    clips = '<rect width="20" height="20"/></clipPath>'
    before = f'<clipPath id="styled" style="transform:translate(9px,9px)">{clips}'
    before += f'<clipPath id="plain" transform="translate(9 9)">{clips}'
    for given in (said, plain):
        inside = f'<path d="M2 2H38V38H2Z M10 10H30V30H10Z" {given}/><rect width="3" height="3"/>'
        file.write_text(page(f'{before}<g fill="#808080" fill-rule="evenodd">{inside}</g>'))
        looks.append(seen(file))
    np.testing.assert_allclose(*looks, atol=1e-12)
    assert np.abs(looks[1] - displayed(file)).max() < 0.02 or "HIDDEN" in plain


@pytest.mark.parametrize(
    ("styled", "plain"),
    [
        ("rotate(0.1turn)", "rotate(36)"),
        ("rotate(0.5rad, 4px, 0)", "rotate(28.64788975654116 4 0)"),
        ("skewX(10grad)", "skewX(9)"),
        ("translate(2mm,1in)", "translate(7.559055118110236 96)"),
    ],
)
def test_transforms_have_units_in_styles(tmp_path, styled, plain):
    """CSS Transforms: angles in four units, lengths in all."""
    boxes = []
    for attribute in (f'style="transform:{styled}"', f'transform="{plain}"'):
        file = tmp_path / "drawing.svg"
        file.write_text(page(f'<rect {attribute} width="20" height="10"/>'))
        (rectangle,) = flattened([read_svg(file, width_um=40.0)])
        boxes.append(rectangle.layers[0][0].curves.points)
    np.testing.assert_allclose(*boxes, atol=1e-12)


def test_a_drawing_lies_where_it_is_put(tmp_path):
    """A page of 40 × 20 shown 100 µm wide about (7, −3), turned by a quarter: the corner of its rectangle, exactly."""
    file = tmp_path / "drawing.svg"
    file.write_text(page('<rect x="30" y="0" width="10" height="5"/>', 'viewBox="0 0 40 20"'))
    for size in ({"width_um": 100.0}, {"height_um": 50.0}):
        (rectangle,) = flattened([read_svg(file, **size, centre_um=(7.0, -3.0))])
        low_high = rectangle.layers[0][0].curves.boxes
        np.testing.assert_allclose([*low_high[:, :2].min(axis=0), *low_high[:, 2:].max(axis=0)], [32, -28, 57, -15.5])
    (turned,) = flattened([read_svg(file, width_um=100.0, centre_um=(7.0, -3.0), rotate_deg=90.0)])
    low_high = turned.layers[0][0].curves.boxes
    # The upper right corner of the page comes to its lower right: clockwise as displayed.
    np.testing.assert_allclose([*low_high[:, :2].min(axis=0), *low_high[:, 2:].max(axis=0)], [19.5, 22, 32, 47])


def test_fills_become_reflectances_by_palette_or_by_their_colour(tmp_path):
    file = tmp_path / "drawing.svg"
    file.write_text(page('<rect width="9" height="9" fill="RED"/><rect width="5" height="5" fill="#336699"/>'))
    ours, blue = flattened([read_svg(file, width_um=40.0, palette={"#f00": 0.25})])
    assert ours.reflectance == 0.25
    assert blue.reflectance == camsim.scene.svg.colours.reflectance((0x33, 0x66, 0x99))


def test_what_has_no_namespace_is_no_part_of_a_drawing_that_has_one(tmp_path):
    file = tmp_path / "drawing.svg"
    for head, counts in (("", 1), ('xmlns="http://www.w3.org/2000/svg"', 0)):
        file.write_text(f'<svg {head} viewBox="0 0 9 9"><rect xmlns="" width="5" height="5"/></svg>')
        assert len(flattened([read_svg(file, width_um=40.0)])) == counts


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("rgb(12.5%,50.196078%,100%)", (32, 128, 255)),  # as cairo writes them
        ("rgb(300, -5, 127.6)", (255, 0, 128)),
        ("hsl(480deg 200% 25%)", (0, 128, 0)),
        ("hsl(0,0%,150%)", (255, 255, 255)),
    ],
)
def test_colours_beyond_what_there_is_are_clipped(text, expected):
    """CSS Color 4, 4 and 15.1."""
    assert camsim.scene.svg.colours.rgb(text) == expected


def test_icons_that_others_drew():
    """The toolbar of matplotlib: files of Inkscape and of hands, with metadata, groups, arcs and document types."""
    icons = sorted(Path(matplotlib.get_data_path(), "images").glob("*.svg"))
    opaque = [icon for icon in icons if not re.search(r"opacity[:=]\"?0?\.", icon.read_text())]
    assert len(opaque) >= 10
    for icon in opaque:
        assert np.abs(seen(icon, side=24) - displayed(icon, side=24)).max() < 0.03, icon


def test_a_drawing_of_matplotlib_s_own(tmp_path):
    """Defined glyphs that are used, clip paths, style rules, thousands of numbers."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(2.0, 1.5))
    axes = figure.subplots()
    axes.plot(np.linspace(0.0, 1.0, 50), np.linspace(-0.5, 0.5, 50) ** 2, color="black")
    axes.set_title("MTF 0.5", fontsize=14)
    figure.savefig(tmp_path / "plot.svg")
    ours, theirs = seen(tmp_path / "plot.svg", side=96), displayed(tmp_path / "plot.svg", side=96)
    assert np.abs(ours - theirs).max() < 0.03


@pytest.mark.parametrize(
    ("given", "counts"),
    [("", True), ('media="print, Screen"', True), ('media="print"', False), ('type="text/less"', False)],
)
def test_a_style_for_other_media_or_in_another_language_says_nothing(tmp_path, given, counts):
    file = tmp_path / "style.svg"
    file.write_text(page(f'<style {given}>rect{{fill:#808080}}</style><rect width="40" height="40"/>'))
    np.testing.assert_allclose(seen(file, side=4), 128 / 255 if counts else 0.0, atol=1e-9)


def test_a_qr_code_that_segno_drew_is_the_chart(tmp_path):
    file = tmp_path / "qr.svg"
    segno.make_qr("camsim", error="m", boost_error=False).save(str(file), border=4)
    chart = camsim.charts.qr(text="camsim", width_um=29.0, dark=0.0, light=1.0)
    np.testing.assert_allclose(seen(file, side=29), squares(chart, 29, 29), atol=1e-9)


USES = "".join(f'<g id="a{i}">' + f'<use href="#a{i - 1}"/>' * 10 + "</g>" for i in range(1, 9))
WHOLE = [
    ("", "is no XML: no element found"),
    ("<svg", ":1:1: is no XML: unclosed token"),
    (page("", ""), "<svg>: has neither width and height nor a viewBox"),
    (page("", 'viewBox="0 0 9 9" transform="rotate(9)"'), "<svg>: its transform 'rotate(9)' is not supported"),
    (page("", 'viewBox="0 0 9 9" preserveAspectRatio="slice"'), "its preserveAspectRatio 'slice' is not understood"),
    ("<?xml-stylesheet href='a.css'?>" + page(""), "takes its style from another file"),
    ('<!DOCTYPE svg [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]>' + page("<path d='&b;'/>"), "declares the entity 'a'"),
    ('<!DOCTYPE svg [<!ENTITY x SYSTEM "file:///etc/passwd">]>' + page("&x;"), "declares the entity 'x'"),
    (page("<g>" * 200 + "</g>" * 200), "elements lie more than 100 deep"),
    (page('<path d="M0 0' + " 1 1" * 600_000 + '"/>'), "hold more than 1000000 numbers"),
    (page(f'<g id="a0"><rect width="1" height="1"/></g>{USES}'), "draws more than 100000 elements"),
]
INSIDE = [(page(inside.replace("\\n", "\n")), said) for inside, said in rows("drawings.txt", "cannot")]


@pytest.mark.parametrize(("text", "message"), [*WHOLE, *INSIDE], ids=itertools.count())
def test_what_cannot_be_shown_is_named_with_its_element_and_line(tmp_path, text, message):
    file = tmp_path / "drawing.svg"
    file.write_text(text)
    with pytest.raises(CamsimError) as refused:
        read_svg(file, width_um=100.0)
    (sentence,) = str(refused.value).splitlines()
    assert message in sentence
    assert "drawing.svg" in sentence


@pytest.mark.parametrize("rotate_deg", [0.0, 25.0])
def test_text_is_as_large_where_and_turned_as_the_font_says(rotate_deg):
    """Light, middle and second moments of the picture, by the font's own outlines moved by fontTools, to 1e-3 px."""
    path = next(font.path for font in ttf_opensans.FONTS if font.name == "OpenSans-SemiBold")
    font = TTFont(path)
    glyphs, names, em = font.getGlyphSet(), font.getBestCmap(), font["head"].unitsPerEm
    pitch_um, size_um, at_um, sigma_um = 4.0, 56.0, np.array([-30.0, 13.0]), 2.0
    c, s = np.cos(np.radians(rotate_deg)), np.sin(np.radians(rotate_deg))
    drawn, along = StatisticsPen(glyphs), 0.0
    for letter in "Rg7":
        # Font units, y up, to photosites, y down.
        scale = size_um / em / pitch_um
        place = (at_um + size_um * along / em * np.array([c, s])) / pitch_um
        glyphs[names[ord(letter)]].draw(TransformPen(drawn, (scale * c, scale * s, scale * s, -scale * c, *place)))
        along += font["hmtx"][names[ord(letter)]][0]
    text = camsim.Text(
        text="Rg7", size_um=size_um, at_um=at_um, weight="SemiBold", rotate_deg=rotate_deg, reflectance=0.0
    )
    grid = camsim.Grid(rows=36, cols=40, pitch_um=pitch_um)
    found = camsim.render(
        camsim.Scene(background=1.0, shapes=[text]),
        [camsim.Gaussian(sigma_um=sigma_um), camsim.SquarePhotosite(side_um=pitch_um)],
        grid,
        wavelength_nm=550.0,
        tolerance=1e-6,
    )
    dark = 1.0 - found.image
    x, y = np.arange(grid.cols) + grid.first_centre[0], np.arange(grid.rows) + grid.first_centre[1]
    light = dark.sum()
    mean = np.array([dark.sum(axis=0) @ x, dark.sum(axis=1) @ y]) / light
    spread = np.array([dark.sum(axis=0) @ (x - mean[0]) ** 2, dark.sum(axis=1) @ (y - mean[1]) ** 2]) / light
    blur = (sigma_um / pitch_um) ** 2 + 1.0 / 12.0
    tilt = (y - mean[1]) @ dark @ (x - mean[0]) / light
    assert light == pytest.approx(abs(drawn.area), abs=1e-2)
    assert mean == pytest.approx([drawn.meanX, drawn.meanY], abs=1e-3)
    assert spread == pytest.approx([drawn.varianceX + blur, drawn.varianceY + blur], abs=1e-2)
    assert tilt == pytest.approx(drawn.covariance, abs=1e-2)
