"""``camsim list`` and ``camsim show``."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from camsim.config import library, yaml_source
from camsim.config.library import Located
from camsim.config.sensor_search import SensorSearch
from camsim.optics.protocols import KnowsSplits
from camsim.sensor.companding import stated_points

if TYPE_CHECKING:
    from camsim.camera.body import Body

Row = tuple[str, str]


def lines_of_list(what: str, sensors: Sequence[str] = ()) -> Iterator[str]:
    """Return one line per name; sensors and scenes with a description, sensors also with their folder.

    sensors : folders in which sensors are searched by name
    """
    from camsim.spectra import named

    names: Mapping[str, Callable[[], Iterable[str]]] = {
        "sensors": lambda: _sensors(SensorSearch.of(sensors, Path())),
        "scenes": lambda: _shipped("scene"),
        "lenses": lambda: _shipped("lens"),
        "illuminants": named.illuminant_names,
        "reflectances": named.reflectance_names,
        "sensitivities": named.sensitivity_names,
    }
    yield from names[what]()


def text_of(name: str, sensors: Sequence[str] = ()) -> str:
    """Return the file of a sensor, scene or lens, then derived figures as comments: still valid YAML."""
    search = SensorSearch.of(sensors, Path())
    kind, located = search.locate_any(name)
    document = yaml_source.read(located.path, located.displayed)
    said = document.tree.get("camsim") if isinstance(document.tree, dict) else None
    named: dict[str, library.Kind] = {"sensor": "sensor", "scene": "scene", "lens": "lens"}
    if isinstance(said, str):
        kind = named.get(said.partition("/")[0], kind)
    if kind == "lens":
        rows = _figures_of_lens(located)
    else:
        rows = _figures_of_sensor(located) if kind == "sensor" else _figures_of_scene(located, search)
    text = located.path.read_text(encoding="utf-8").rstrip("\n")
    width = max(len(label) for label, _ in rows)
    figures = "\n".join(f"#   {label:<{width}}  {value}" for label, value in rows)
    return f"# {located.displayed}\n{text}\n\n# What follows from it:\n{figures}"


def _sensors(search: SensorSearch) -> Iterator[str]:
    found = dict(search.all())
    width = max(map(len, found))
    for name, located in sorted(found.items()):
        words = _first_comment(located.path.read_text(encoding="utf-8", errors="replace"))
        place = "shipped" if located.path == library.shipped("sensor").get(name) else located.displayed
        yield f"{name:<{width}}  {words}{' ' if words else ''}({place})"


def _shipped(kind: library.Kind) -> Iterator[str]:
    found = library.shipped(kind)
    width = max(map(len, found))
    for name, path in found.items():
        yield f"{name:<{width}}  {_first_comment(path.read_text(encoding='utf-8'))}"


def _first_comment(text: str) -> str:
    """Return the first sentence of a file's initial comment."""
    lines = []
    for line in text.splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.lstrip("# "))
    return " ".join(lines).split(". ")[0].rstrip(".")


def _figures_of_sensor(located: Located) -> list[Row]:
    from camsim.api import load_camera
    from camsim.camera.notes import notes_of_sensor
    from camsim.measure.noise.photon_transfer import sensitivity_threshold_e
    from camsim.optics import Airy

    # None of the figures depends on the lens.
    camera = load_camera(located.path, lens=Airy(f_number=8.0))
    adc, pitch_um = camera.converter, camera.pitch_um
    well_e = camera.well_as_read_e(adc.base_iso)
    saturation_e = camera.charge_at_e(1.0, adc.base_iso)
    # The smallest signal: standard deviations of read-out noise and of rounding.
    dark_e = math.hypot(camera.dark_noise_e(adc.base_iso), adc.electrons_per_dn / math.sqrt(12.0))
    threshold_e = sensitivity_threshold_e(dark_e)
    ratio = saturation_e / threshold_e
    width_mm, height_mm = camera.cols * pitch_um / 1e3, camera.rows * pitch_um / 1e3
    rows = [
        ("photosites", f"{camera.rows} × {camera.cols}, {camera.rows * camera.cols / 1e6:.1f} million"),
        ("size", f"{width_mm:.2f} × {height_mm:.2f} mm, diagonal {math.hypot(width_mm, height_mm):.2f} mm"),
        ("Nyquist frequency", f"{0.5 / pitch_um:.5g} cycles/µm ({500.0 / pitch_um:.1f} line pairs/mm), all photosites"),
    ]
    if isinstance(camera.olpf, KnowsSplits):
        rows.append(("OLPF null", _olpf_null(camera.olpf, pitch_um)))
    rows += [
        ("white level", f"{adc.white_level_dn(adc.base_iso, well_e)} DN at ISO {adc.base_iso:g}"),
        *((("codes", f"companded: {stated_points(tuple(adc.companding))}"),) if adc.companding else ()),
        ("saturation", f"{saturation_e:.0f} e⁻ at ISO {adc.base_iso:g}"),
        ("SNR maximum", _snr_maximum(camera, saturation_e, dark_e)),
        *_saturation_exposures(camera, saturation_e),
        ("dark noise", f"{dark_e:.2f} e⁻ (read noise and rounding)"),
        (
            "dynamic range",
            f"{20.0 * math.log10(ratio):.1f} dB, {math.log2(ratio):.1f} stops, at ISO {adc.base_iso:g}: "
            f"saturation over {threshold_e:.2f} e⁻, SNR 1",
        ),
        *(("note", note.text) for note in notes_of_sensor(camera)),
    ]
    return rows


def _figures_of_lens(located: Located) -> list[Row]:
    from camsim.config.lens_files import read_lens_file

    lens = read_lens_file(located)
    nm = lens.wavelength_nm
    middle_nm = nm[len(nm) // 2]
    rows = [
        ("wavelengths", f"{nm[0]:g} to {nm[-1]:g} nm, {len(nm)}" if len(nm) > 1 else f"{nm[0]:g} nm stands for all"),
        ("diffraction", f"λN = {lens.blur_um(middle_nm):.4g} µm at {middle_nm:g} nm"),
    ]
    if lens.turns:
        rows.append(("image circle", f"{2e-3 * lens.height_um[-1]:.4g} mm"))
        displayed = [lens.height_um[k] for k in (0, len(lens.height_um) // 2, -1)]
        waves = ", ".join(f"{lens.at(h, 0.0).waves_rms(middle_nm):.3g} at {1e-3 * h:.3g} mm" for h in displayed)
        rows.append(("wavefront", f"waves rms at {middle_nm:g} nm, tilt apart: {waves}"))
    return rows


def _blur(camera: Body, wavelength_nm: float) -> Row:
    """Return the size of the PSF, and its cut-off frequency."""
    system, kind = camera.optics, type(camera.lens).__name__
    scale_um, cutoff_per_um = system.blur_um(wavelength_nm), system.cutoff_per_um(wavelength_nm)
    ends = f"{scale_um / camera.pitch_um:.3g} pitches; cut-off {cutoff_per_um:.4g} cycles/µm"
    if system.chromatic:
        return "diffraction", f"λN = {scale_um:.4g} µm at {wavelength_nm:g} nm, {ends}"
    return "lens", f"{kind}, the same at every wavelength: {scale_um:.4g} µm, {ends}"


def _olpf_null(olpf: KnowsSplits, pitch_um: float) -> str:
    """Return the first zeros of the low-pass filter's OTF."""
    splits = dict(zip("xy", olpf.splits_um, strict=True))
    along = [axis for axis, split_um in splits.items() if split_um]
    if len(along) == 2 and splits["x"] == splits["y"]:
        splits, along = {"x and y": splits["x"]}, ["x and y"]
    turned = f" turned by {olpf.rotate_deg:g}°" if olpf.rotate_deg else ""
    nulls = [
        f"{0.5 / splits[axis]:.5g} cycles/µm along {axis}{turned}, {pitch_um / splits[axis]:.2f} of Nyquist"
        for axis in along
    ]
    return "; ".join(nulls)


def _snr_maximum(camera: Body, saturation_e: float, dark_e: float) -> str:
    """Return signal over temporal noise just below saturation, in common units."""
    photons = saturation_e if camera.shot_noise is not None else 0.0
    snr = saturation_e / math.hypot(dark_e, math.sqrt(photons))
    return f"{snr:.0f}, {20.0 * math.log10(snr):.1f} dB, {math.log2(snr):.1f} bits"


def _saturation_exposures(camera: Body, saturation_e: float) -> list[Row]:
    """Return how many lux·s on the sensor saturate each channel."""
    from camsim.spectra.light import Light

    light = Light("D55", illuminance_lux=1.0, at="sensor")
    per_lux_s = camera.diffuser_electrons(light, 1.0)
    displayed = [
        f"{channel} {saturation_e / electrons:.3g}" if electrons > 0.0 else f"{channel} never"
        for channel, electrons in zip(camera.cfa.channels, per_lux_s, strict=True)
    ]
    return [("lux·s to white", f"{', '.join(displayed)}, of D55 on the sensor")]


def _figures_of_scene(located: Located, search: SensorSearch) -> list[Row]:
    from camsim.api import load

    setup = load(located.path, sensors=search.given)
    camera, light = setup.camera, setup.light
    rows, cols = (setup.region.rows, setup.region.cols) if setup.region else (camera.rows, camera.cols)
    wavelength_nm = light.line_nm or 550.0
    electrons = camera.diffuser_electrons(light, setup.time_s)
    white = ", ".join(f"{c} {e:.5g}" for c, e in zip(camera.cfa.channels, electrons, strict=True))
    on_sensor = ""
    if light.at == "scene" and light.illuminance_lux is not None:
        lux = camera.opening * light.illuminance_lux / (4.0 * camera.working_f_number**2)
        on_sensor = f", {lux:.4g} lx on the sensor from white through a clear lens"
    return [
        ("camera", camera.name),
        (
            "picture",
            f"{rows} × {cols} photosites, {rows * camera.pitch_um / 1e3:.3f} × "
            f"{cols * camera.pitch_um / 1e3:.3f} mm on the sensor",
        ),
        ("shapes", str(len(setup.scene.shapes))),
        ("light", f"{light.name}, {light.level} on the {light.at}{on_sensor}"),
        ("exposure", f"{setup.time_s:.6g} s at a working f-number of {camera.working_f_number:g}"),
        ("white", f"mean electrons of a perfect diffuser on the axis: {white}"),
        _blur(camera, wavelength_nm),
    ]
