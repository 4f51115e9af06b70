"""What one may guess: names that are there, help that is complete, reprs of a line, pictures in notebooks."""

from __future__ import annotations

import dataclasses
import inspect
import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import camsim
from camsim.errors import InvalidValueError, UnknownNameError
from camsim.files.png import picture
from camsim.files.preview import develop
from tests.tables import rows

SMALL = ["region={rows: 12, cols: 16}", "render.tolerance=1e-2"]


@pytest.fixture(scope="module")
def frame() -> camsim.Frame:
    return camsim.capture("slanted-edge", overrides=SMALL)


@pytest.fixture(scope="module")
def grey() -> camsim.Frame:
    return camsim.capture("slanted-edge", sensor="mono-345", overrides=SMALL)


def test_what_load_reads_is_what_capture_takes(frame: camsim.Frame) -> None:
    ready = camsim.load("slanted-edge", overrides=SMALL)
    assert isinstance(ready, camsim.Capture)
    np.testing.assert_array_equal(ready.frame().mosaic, frame.mosaic)
    assert camsim.Scene.from_yaml("slanted-edge", overrides=SMALL) == ready.scene
    # Lengths in pixels are of the sensor's pitch.
    other = camsim.Scene.from_yaml("slanted-edge", sensor="mono-345")
    assert other.shapes[0].width_um == pytest.approx(ready.scene.shapes[0].width_um * 3.45 / 4.88)  # type: ignore[union-attr]
    with pytest.raises(UnknownNameError, match="did you mean 'slanted-edge'"):
        camsim.Scene.from_yaml("slanted-egde")


def test_a_preview_is_three_channels_of_bytes(frame: camsim.Frame, grey: camsim.Frame) -> None:
    np.testing.assert_array_equal(frame.preview(), develop(frame))
    assert grey.preview().shape == (12, 16, 3)
    assert (grey.preview() == develop(grey)[..., None]).all()


@pytest.mark.parametrize("size", [(12, 16), (500, 700), (2000, 1000), (1, 1)])
def test_a_notebooks_picture_has_a_readable_size(size: tuple[int, int]) -> None:
    pixels = np.zeros((*size, 3), np.uint8)
    pixels[: size[0] // 2 + 1] = 200
    displayed = np.asarray(Image.open(io.BytesIO(picture(pixels))))
    assert 200 <= max(displayed.shape) <= 800
    assert displayed[0, 0, 0] == 200
    assert displayed.shape[0] / displayed.shape[1] == pytest.approx(size[0] / size[1], rel=0.01)


@pytest.mark.parametrize(("change", "message"), rows("wrong-stages.txt", "arrays of a frame"))
def test_what_is_put_into_a_frame_is_a_frame(frame: camsim.Frame, change: str, message: str) -> None:
    """DNGs cut off what is behind the point, wrapped −5 to 65 531, and were of another size than their record says."""
    with pytest.raises(InvalidValueError, match=message):
        dataclasses.replace(frame, **eval(change)(frame))
    for same in (frame.mosaic.astype(">u2"), frame.mosaic.tolist()):
        kept = dataclasses.replace(frame, mosaic=same).mosaic
        assert kept.dtype == np.uint16
        np.testing.assert_array_equal(kept, frame.mosaic)


def test_a_frame_in_a_notebook(frame: camsim.Frame) -> None:
    png = frame._repr_png_()
    assert png is not None
    assert Image.open(io.BytesIO(png)).size == (240, 180)
    html = frame._repr_html_()
    for said in ("data:image/png;base64,", "12 × 16 of 4.88 µm, RG/GB", "signal of G", "FourSpotOlpf(split_um=3.66)"):
        assert said in html
    bare = dataclasses.replace(frame, mosaic=frame.mosaic[:0], passed_rows=12)  # written row by row
    assert bare._repr_png_() is None
    assert "<img" not in bare._repr_html_()
    assert "signal of G" in frame.report._repr_html_()


def test_curves_and_scenes_in_a_notebook() -> None:
    html = camsim.reflectance("orange")._repr_html_()  # type: ignore[union-attr]
    assert "orange" in html
    assert "<polyline" in html
    scene = camsim.Scene(background=0.2, shapes=[camsim.Disc(radius_um=k + 1, reflectance=0.5) for k in range(30)])
    html = scene._repr_html_()
    assert html.count("Disc(radius_um=") == 10
    assert "20 more" in html
    assert "0.2" in camsim.Scene(background=0.2)._repr_html_()
    assert "&lt;b&gt;" in camsim.Curve([400, 500], [0, 0], "<b>")._repr_html_()


LONG = camsim.Curve(range(380, 781), np.linspace(0.0, 1.0, 401))
CORNERS = [(k / 4, k * k / 16) for k in range(300)]


@pytest.mark.parametrize(("thing", "said"), rows("notes.txt", "what stages print"))
def test_a_repr_is_a_line_that_can_be_read(thing: str, said: str) -> None:
    assert repr(eval(thing)) == said


def test_reprs_of_what_is_large(frame: camsim.Frame) -> None:
    ready = camsim.load("colorchecker")
    for thing in (frame, frame.report, ready, ready.camera, ready.scene, ready.plan(), frame.colour):
        assert len(repr(thing)) < 1000
        assert "\n" not in repr(thing)
    assert repr(frame).startswith("Frame(12 × 16 photosites of D40-like, 4.88 µm, RG/GB, 12 bits, ")
    assert repr(frame.report).startswith("Report(slanted-edge: boundary, error ")
    assert repr(ready.plan()).startswith("Choice(boundary: ")
    rendering = camsim.render(
        camsim.Scene(background=0.5), [ready.camera.lens], ready.camera.grid(), wavelength_nm=550.0, tolerance=1e-2
    )
    assert repr(rendering) == "Rendering(2000 × 3008 by boundary, error 0 of 0.01)"


def test_help_of_replace_names_every_stage() -> None:
    """The keywords are the camera's fields; their types are judged in tests/architecture/test_constructors.py."""
    listed = inspect.signature(camsim.Camera.replace).parameters
    assert set(listed) == {"self", *(field.name for field in dataclasses.fields(camsim.Camera))}
    assert str(listed["olpf"]) == "olpf: 'LowPass | None' = unchanged"


def test_no_public_call_hides_its_arguments() -> None:
    """Whatever is public says what it takes by name: nothing is **how."""
    hidden = []
    for name in camsim.__all__:
        thing = getattr(camsim, name)
        if inspect.ismodule(thing) or not callable(thing):
            continue
        members = {name: thing} | {f"{name}.{key}": getattr(thing, key) for key in vars(thing) if key[0] != "_"}
        for label, member in members.items():
            if inspect.isfunction(member) or inspect.ismethod(member):
                kinds = {parameter.kind for parameter in inspect.signature(member).parameters.values()}
                if inspect.Parameter.VAR_KEYWORD in kinds:
                    hidden.append(label)
    assert not hidden


def test_every_name_of_the_stub_is_there() -> None:
    stub = (Path(camsim.__file__).parent / "__init__.pyi").read_text(encoding="utf-8")
    for name in camsim.__all__:
        assert f" as {name}\n" in stub
        thing: Any = getattr(camsim, name)
        assert thing is not None
    assert inspect.ismodule(camsim.measure)


def test_frames_end_where_their_numbers_do() -> None:
    """No file of a later one could be captured again."""
    last = camsim.load("flat-field", overrides=["region={rows: 2, cols: 2}", f"noise.frame_number={2**31 - 2}"])
    assert [frame.frame_number for frame in last.frames(2)] == [2**31 - 2, 2**31 - 1]
    with pytest.raises(InvalidValueError, match=r"^Capture.frame_number: 2147483646, and 3 frames"):
        next(last.frames(3))


def test_what_frames_have_in_common_is_not_written_into() -> None:
    """Light that was scaled in one frame was the next one's: codes of 128 for 201. A frame alone is its owner's."""
    capture = camsim.load("flat-field", overrides=["region={rows: 4, cols: 4}"])
    for frame in capture.frames(2, products=("truth",)):
        for name in ("mean_electrons", "truth", "channel_index"):
            with pytest.raises(ValueError, match="read-only"):
                getattr(frame, name)[0] = 0
        frame.electrons[0] = frame.mosaic[0] = 0  # its own
    alone = capture.frame()
    alone.mean_electrons[0] = 0.0
    seen = capture.optical_image()
    with pytest.raises(ValueError, match="read-only"):
        seen.rendering.image[0] = 0.0
    assert next(capture.frames(optical_image=seen)).mean_electrons.min() > 0.0


def test_an_optical_image_is_for_captures_that_share_it() -> None:
    small = ["region={rows: 6, cols: 5}", "render.tolerance=1e-3"]
    one = camsim.load("slanted-edge", overrides=small)
    seen = one.optical_image()
    darker = camsim.load("slanted-edge", overrides=[*small, "exposure.time_s=0.001", "noise.enabled=false"])
    np.testing.assert_array_equal(next(darker.frames(optical_image=seen)).mosaic, darker.frame().mosaic)
    longer = dataclasses.replace(one.exposure, time_s=2.0 * one.time_s)
    star = dataclasses.replace(one, scene=camsim.Scene(background=0.0, shapes=[camsim.PointSource(electrons=1e3)]))
    for mine, other in (
        (seen, dataclasses.replace(one, tolerance=1e-4)),
        (seen, dataclasses.replace(one, region=camsim.Region(rows=6, cols=6))),
        (star.optical_image(), dataclasses.replace(star, exposure=longer)),
    ):
        with pytest.raises(InvalidValueError, match=r"^optical_image: belongs to a capture of another optical key"):
            next(other.frames(optical_image=mine))
    with pytest.raises(InvalidValueError, match=r"^optical_image: was rendered without every channel"):
        next(one.frames(products=("truth",), optical_image=seen))
    with pytest.raises(InvalidValueError, match=r"^optical_image: must be an OpticalImage or None, not 3"):
        next(one.frames(optical_image=3))  # type: ignore[arg-type]


def test_truth_in_single_precision_says_what_it_rounds() -> None:
    """A star of 1e4 electrons before a diffuser of one: what is stored is 3e-4 of the diffuser off, not 1e-4."""
    dim = ["region={rows: 6, cols: 5}", "light.illuminance_lux=1", "exposure.time_s=0.001"]
    dim.append("lens={kind: gaussian, f_number: 4, sigma_um: 2}")
    capture = camsim.load("flat-field", sensor="d40-like", overrides=[*dim, "noise.enabled=false"])
    star = camsim.Scene(background=0.0, shapes=[camsim.PointSource(electrons=1e4)])
    capture = dataclasses.replace(capture, scene=star, tolerance=1e-4)
    notes = capture.frame(products=("truth",)).report.notes
    assert "truth-rounded" in [note.code for note in notes]
    assert "truth-rounded" not in [note.code for note in capture.frame().report.notes]
    with pytest.raises(InvalidValueError, match=r"beside a point of light takes .* or for a fainter point$"):
        dataclasses.replace(capture, tolerance=1e-8).frame()
