"""Options, unusual numbers, and messages that name the way out."""

import dataclasses
import io
import re
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import pytest
from tolerances import STATISTICAL
from typer.testing import CliRunner

import camsim
from camsim.api import load
from camsim.cli.app import app
from camsim.cli.explain_noise import background_e, noise_budget
from camsim.cli.explain_plot import nyquists
from camsim.cli.explain_spectra import draw_efficiency, draw_spectra
from camsim.errors import CamsimError
from camsim.measure import CameraOtf, read_picture
from camsim.sensor.cfa import Cfa

from .conftest import SCENE

MONO = ["sensor.olpf=null", "light={line_nm: 550, illuminance_lux: 5000}"]


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("CAMSIM_PATH", raising=False)
    Path("small.yaml").write_text(SCENE, encoding="utf-8")
    return tmp_path


def run(*words: str) -> tuple[int, str, str]:
    done = CliRunner().invoke(app, list(words), terminal_width=200)
    return done.exit_code, done.stdout, " ".join(done.stderr.replace("│", " ").split())


def test_only_a_keys_own_name_is_taken_for_the_key() -> None:
    """The beginning of an option, and a word that is only a little like a key, are no keys."""
    assert "--set" not in run("explain", "slanted-edge", "--mot", "1")[2].replace("(Possible options: --set)", "")
    assert "--set" not in run("info", "a.dng", "--iso")[2]


def test_a_turned_filter_has_its_nulls_along_its_own_axes() -> None:
    turned = "{kind: four-spot, split_um: 3.66, rotate_deg: 45}"
    text = run("show", "d40-like")[1].partition("# What follows")[0]
    Path("turned.yaml").write_text(re.sub(r"olpf: \{.*\}", f"olpf: {turned}", text), encoding="utf-8")
    assert "0.13661 cycles/µm along x and y turned by 45°, 1.33 of Nyquist" in run("show", "./turned.yaml")[1]


def test_a_lens_that_is_all_tables_is_told_on_a_line() -> None:
    few = ("--set", "region={rows: 2, cols: 2}", "--set", "render.tolerance=1e-2", "-o", "f.dng")
    stated = "FieldLens(f_number=5, 13 wavelengths, 380 to 780 nm, 13 heights to 24.6723 mm, 9 Zernikes)"
    assert stated in run("capture", "field-lens", *few)[2]
    tables = "FieldLens(distortion: 17, distortion_height_um: 17, f_number=5, height_um: 13, lateral_colour_um: 13"
    assert tables in run("info", "f.dng")[1]


def test_light_that_no_channel_sees_has_a_way_out() -> None:
    infrared = "light={line_nm: 1550, irradiance_w_per_m2: 1}"
    ready = load("small.yaml", overrides=[infrared])
    assert ready.notes(ready.plan())[-1].text.startswith(
        "nothing of the light (line of 1550 nm) reaches a channel of the "
    )
    with pytest.raises(CamsimError) as caught:
        camsim.save(ready.frame(), "a.dng")
    assert "no channel of the camera responds to the scene's light, line of 1550 nm" in str(caught.value)
    assert "from 380 to 780 nm: take a light or a sensor that meet, or write the codes without" in str(caught.value)
    assert not Path("a.dng").exists()
    camsim.save(ready.frame(), "a.tiff")
    with pytest.raises(CamsimError, match=r"must be a number from 360 to 830, not 1550, .*; give irradiance_w_per_m2"):
        load("small.yaml", overrides=["light={line_nm: 1550, illuminance_lux: 1}"])
    # All of a light beyond a table is 100 % of it.
    table = "{wavelength_nm: [400, 900], values: [1, 1]}"
    beyond = f"sensor.quantum_efficiency.curves={{R: {table}, G: {table}, B: {table}}}"
    with pytest.raises(CamsimError, match=r"nm is missing, with 100 % of the photons"):
        load("small.yaml", overrides=[infrared, beyond])


def test_all_of_a_frame_is_clipped_and_reads_so() -> None:
    done = CliRunner().invoke(app, ["capture", "small.yaml", "--set", "exposure.time_s=10", "-o", "a.npy"])
    assert done.exit_code == 0
    assert "(100 %)" in done.stderr
    assert "e+0" not in done.stderr


@pytest.mark.parametrize(
    ("names", "layer", "said"),
    [
        (("R", "G", "B"), "mean", "'mean' is not in it; it has channels without a layer, B, G, R: leave the layer out"),
        (("a.Y", "b.Y"), "c", "'c' is not in it; there are 'a', 'b'"),
        (("a.Y", "Y"), "c", "'c' is not in it; there are 'a' and channels without a layer, Y, which '' means"),
    ],
)
def test_layers_have_names_or_none(names: tuple[str, ...], layer: str, said: str) -> None:
    pixels = {name: np.ones((4, 4), np.float32) for name in names}
    OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, pixels).write("a.exr")
    with pytest.raises(CamsimError) as caught:
        read_picture("a.exr", layer=layer)
    assert said in str(caught.value)


def test_theory_names_the_stages_that_are_there() -> None:
    with_filter, without = (CameraOtf.of(load("small.yaml", overrides=o)) for o in ((), MONO))
    assert with_filter.stages == ("lens", "OLPF", "photosite")
    assert without.stages == ("lens", "photosite")


def test_each_nyquist_says_whose_it_is() -> None:
    assert nyquists(Cfa.bayer("RGGB")) == {0.5: ["the sensor"], 0.25: ["R", "G1", "G2", "B"]}
    assert nyquists(Cfa.mono()) == {0.5: ["the sensor", "Y"]}


def texts_of(kind: str, *changes: str) -> set[str]:
    """What is written in a picture."""
    from camsim.cli.explain_plot import figure_of

    figure = figure_of(load("small.yaml", overrides=changes), kind)
    figure.savefig(io.BytesIO(), format="svg")
    artists: list[Any] = figure.findobj(lambda artist: hasattr(artist, "get_text"))
    return {artist.get_text().strip() for artist in artists}


def test_pictures_say_what_their_axes_are() -> None:
    written = texts_of("mtf", "render.tolerance=1e-2")
    assert written >= {"Nyquist of the sensor", "Nyquist of R, G1, G2, B"}
    written = texts_of("psf", *MONO)
    assert written >= {"x, µm", "y (down), µm", "root of relative irradiance", "photosite"}
    assert not any("OLPF" in text for text in written)


@pytest.mark.parametrize("waves", [0.0, 0.08, 0.2])
def test_a_pattern_tells_its_strehl_ratio(waves: float) -> None:
    """Of a focus shift in closed form: the squared sinc of what the phase runs through."""
    lens = f"lens={{kind: wavefront, f_number: 5.6, zernike_waves: [[4, {waves}]], reference_nm: 550}}"
    written = texts_of("psf", *MONO, lens, "light={line_nm: 550, illuminance_lux: 1000}")
    (stated,) = (float(text.rsplit(" ", 1)[1]) for text in written if "Strehl ratio" in text)
    assert stated == pytest.approx(np.sinc(2.0 * np.sqrt(3.0) * waves) ** 2, abs=2e-3)


def test_what_is_drawn_of_the_system_has_its_crosstalk() -> None:
    """Along x a photosite's own light, what its left neighbour sends, and what those above send."""
    from matplotlib.figure import Figure

    from camsim.cli import explain_plot

    figure = Figure()
    curve = "{curves: {Y: {wavelength_nm: [400, 800], values: [1, 1]}}, per: photon, peak: 0.5}"
    changes = ["sensor.cfa={kind: mono}", f"sensor.quantum_efficiency={curve}", "lens={kind: airy, f_number: 4}"]
    kernel = "sensor.charge.crosstalk=[[0, 0.1, 0], [0, 0.5, 0], [0, 0, 0.2]]"
    explain_plot._draw_mtf(figure, load("small.yaml", overrides=[*MONO, *changes, kernel]))
    lines = {line.get_label(): line for line in figure.axes[0].lines}
    f, whole = np.array(lines["system, Y with crosstalk"].get_data())
    bare = lines["lens, Y"].get_ydata() * lines["photosite"].get_ydata()
    np.testing.assert_allclose(whole, bare * np.abs(0.6 + 0.2 * np.exp(-2j * np.pi * f)) / 0.8, rtol=0, atol=1e-3)


@pytest.mark.parametrize("kernel", ["null", "[[0, 0, 0], [0, 0.5, 0.3], [0, 0, 0.1]]"])
def test_the_noise_budget_is_the_noise(kernel: str) -> None:
    """The squares of all sources add to what a frame of an even surface really spreads by; crosstalk averages PRNU."""
    scene = ["scene.shapes=[]", "region={rows: 200, cols: 200}", "sensor.cfa={kind: mono}", "lens.veiling_glare=0.2"]
    flat = "{wavelength_nm: [400, 800], values: [1, 1]}"
    mono = [f"sensor.quantum_efficiency={{curves: {{Y: {flat}}}, per: photon, peak: 0.5}}", "exposure.temperature_c=60"]
    noisy = ["sensor.charge.prnu=0.02", "sensor.charge.dcnu=0.5", "sensor.charge.dark_current_e_per_s=900"]
    more = ["sensor.readout.row_noise_e=5", "sensor.readout.output_noise_dn=1.5"]
    alone = load("small.yaml", overrides=[*scene, *mono, *noisy, *more])
    ready = load("small.yaml", overrides=[*scene, *mono, *noisy, *more, f"sensor.charge.crosstalk={kernel}"])
    frame = ready.frame()
    signal_e = float(frame.mean_electrons.mean())
    assert background_e(ready) == pytest.approx([signal_e], rel=1e-6)
    budget = noise_budget(ready, np.array([signal_e]))
    assert set(budget) >= {"photons", "Prnu", "dark current", "dark current's unevenness", "ReadNoise", "rounding"}
    assert kernel == "null" or budget["Prnu"][0] < 0.8 * noise_budget(alone, np.array([signal_e]))["Prnu"][0]
    expected = float(np.sqrt(sum(values[0] ** 2 for values in budget.values())))
    found = float((frame.mosaic * frame.electrons_per_dn).std())
    # Rows have few noises of their own: 200 of them, of a twentieth of the variance, rule the spread of the estimate.
    # What neighbours share makes the scatter's own scatter √Σρ² larger than that of as many alone: 1.3 at the most.
    one = np.sqrt(2.0 / frame.mosaic.size) * (1.0 if kernel == "null" else 1.3)
    assert abs(found / expected - 1.0) < STATISTICAL * 0.5 * (one + 0.05 * np.sqrt(2.0 / 200))


@pytest.mark.parametrize("kernel", [None, ((0.02, 0.1, 0), (0.05, 0.7, 0.04), (0, 0.03, 0.01))])
def test_the_background_is_where_the_frame_has_it(kernel: tuple[tuple[float, ...], ...] | None) -> None:
    """Of each channel, after crosstalk and with the veil: its line lay at the light before both."""
    small = ["region={rows: 8, cols: 8}", "render.tolerance=1e-4", "lens.veiling_glare=0.1", "noise.enabled=false"]
    edge = load("knife-edge", sensor="d40-like", overrides=small)
    mixes, scene = kernel and camsim.Crosstalk(kernel), dataclasses.replace(edge.scene, shapes=())
    ready = dataclasses.replace(edge, camera=edge.camera.replace(crosstalk=mixes), scene=scene)
    frame = ready.frame()
    seen = [frame.mean_electrons[frame.channel_index == k].mean() for k in range(3)]
    assert background_e(ready) == pytest.approx(seen, rel=1e-3)


@pytest.mark.parametrize("kernel", [None, ((0.02, 0.1, 0), (0.05, 0.7, 0.04), (0, 0.03, 0.01))])
@pytest.mark.parametrize("at", ["sensor", "scene"])
def test_spectra_and_efficiencies_are_those_of_the_frame(kernel: tuple[tuple[float, ...], ...] | None, at: str) -> None:
    """Crosstalk was left out of both (4011 for 4478 e⁻), and a lens drawn before light that is on the sensor."""
    from matplotlib.figure import Figure

    bright = ["scene.background.reflectance=1", "exposure={time_s: 0.01, iso: 100}", "noise.enabled=false"]
    small = ["region={rows: 8, cols: 8}", "render.tolerance=1e-4", "lens.transmission=0.8"]
    line = f"light={{line_nm: 530, irradiance_w_per_m2: 0.01, at: {at}}}"
    ready = load("flat-field", sensor="d40-like", overrides=[*bright, *small, line])
    ready = dataclasses.replace(
        ready, camera=ready.camera.replace(filters=(0.5,), crosstalk=kernel and camsim.Crosstalk(kernel))
    )
    frame = ready.frame()
    seen = [frame.mean_electrons[frame.channel_index == k].mean() for k in range(3)]
    spectra, efficiency = Figure(), Figure()
    draw_spectra(spectra, ready)
    draw_efficiency(efficiency, ready)
    passes, white = ([text.get_text() for text in axes.get_legend().get_texts()] for axes in spectra.axes[1:])
    assert [float(re.findall(r"[\d.]+", label)[0]) for label in white] == pytest.approx(seen, rel=1e-3)
    lens = ["lens, transmission"] if at == "scene" else []
    assert passes == ["surface, 1", *lens, "filter 1, transmission"]
    lines = [line for line in efficiency.axes[0].get_lines() if "," in line.get_label()][:3]
    heights = [np.interp(530.0, line.get_xdata(), line.get_ydata()) for line in lines]
    photons = 0.01 * 0.01 * ready.camera.photosite.area_um2 * 1e-12 * 530e-9 / (6.62607015e-34 * 299792458.0)
    # Behind an aplanatic lens at N, a diffuser's E is 1/4N² of what falls on it.
    photons /= 1.0 if at == "sensor" else 4.0 * 8.0**2
    assert heights == pytest.approx([e / photons for e in seen], rel=1e-3)
