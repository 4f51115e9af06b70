"""``camsim list`` and ``camsim show``."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

from camsim.config import library, yaml_source
from camsim.config.library import Kind, Located
from camsim.errors import CamsimError, ConfigError, UnknownNameError

Row = tuple[str, str]


def lines_of_list(what: str) -> Iterator[str]:
    """Return one line a name; sensors and scenes with what they are."""
    from camsim.spectra import named

    names: Mapping[str, Callable[[], Iterable[str]]] = {
        "sensors": lambda: _described("sensor"),
        "scenes": lambda: _described("scene"),
        "illuminants": named.illuminant_names,
        "reflectances": named.reflectance_names,
        "sensitivities": named.sensitivity_names,
    }
    yield from names[what]()


def text_of(name: str) -> str:
    """Return the file of a sensor or scene, then what follows from it, as comments: still valid YAML."""
    kind, located = _located(name)
    document = yaml_source.read(located.path, located.shown)
    said = document.tree.get("camsim") if isinstance(document.tree, dict) else None
    if isinstance(said, str) and said.partition("/")[0] in ("sensor", "scene"):
        kind = "sensor" if said.startswith("sensor/") else "scene"
    rows = _figures_of_sensor(located) if kind == "sensor" else _figures_of_scene(located)
    text = located.path.read_text(encoding="utf-8").rstrip("\n")
    width = max(len(label) for label, _ in rows)
    figures = "\n".join(f"#   {label:<{width}}  {value}" for label, value in rows)
    return f"# {located.shown}\n{text}\n\n# What follows from it:\n{figures}"


def _described(kind: Kind) -> Iterator[str]:
    found = library.shipped(kind)
    width = max((len(name) for name in found), default=0)
    for name, path in found.items():
        yield f"{name:<{width}}  {_first_comment(path.read_text(encoding='utf-8'))}".rstrip()


def _first_comment(text: str) -> str:
    """Return the sentence that a shipped file begins with."""
    lines = []
    for line in text.splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.lstrip("# "))
    return " ".join(lines).split(". ")[0].rstrip(".")


def _located(name: str) -> tuple[Kind, Located]:
    try:
        return "sensor", library.locate("sensor", name)
    except ConfigError:
        raise
    except CamsimError:
        pass
    try:
        return "scene", library.locate("scene", name)
    except UnknownNameError:
        known: Sequence[str] = [*library.shipped("sensor"), *library.shipped("scene")]
        raise UnknownNameError("sensor or scene", name, known) from None


def _figures_of_sensor(located: Located) -> list[Row]:
    from camsim.capturing import load_camera
    from camsim.optics import Airy

    # None of the figures depends on the lens.
    camera = load_camera(located.path, lens=Airy(f_number=8.0))
    adc, pitch_um = camera.adc, camera.pitch_um
    well_e = camera.full_well.capacity_e if camera.full_well else None
    saturation_e = adc.saturation_e(adc.base_iso, well_e)
    step_e = adc.electrons_per_dn
    read_e = camera.read_noise.sigma_e if camera.read_noise else 0.0
    # The smallest signal: read noise and the rounding of a code, as standard deviations.
    dark_e = math.hypot(read_e, step_e / math.sqrt(12.0))
    ratio = saturation_e / dark_e
    width_mm, height_mm = camera.cols * pitch_um / 1e3, camera.rows * pitch_um / 1e3
    rows = [
        ("photosites", f"{camera.rows} × {camera.cols}, {camera.rows * camera.cols / 1e6:.1f} million"),
        ("size", f"{width_mm:.2f} × {height_mm:.2f} mm, diagonal {math.hypot(width_mm, height_mm):.2f} mm"),
        ("Nyquist frequency", f"{0.5 / pitch_um:.5g} cycles/µm ({500.0 / pitch_um:.1f} line pairs/mm)"),
    ]
    if camera.olpf is not None:
        null = 0.5 / camera.olpf.split_um
        share = null / (0.5 / pitch_um)
        rows.append(("OLPF null", f"{null:.5g} cycles/µm along x and y, {share:.2f} of Nyquist"))
    rows += [
        ("white level", f"{adc.white_level_dn(adc.base_iso, well_e)} DN at ISO {adc.base_iso:g}"),
        (
            "saturation",
            f"{saturation_e:.0f} e⁻ at ISO {adc.base_iso:g}, SNR there {math.sqrt(saturation_e):.0f}",
        ),
        ("dark noise", f"{dark_e:.2f} e⁻ (read noise and rounding)"),
        (
            "dynamic range",
            f"{20.0 * math.log10(ratio):.1f} dB, {math.log2(ratio):.1f} stops, at ISO {adc.base_iso:g}",
        ),
    ]
    return rows


def _figures_of_scene(located: Located) -> list[Row]:
    from camsim.capturing import load

    setup = load(located.path)
    camera, light = setup.camera, setup.light
    rows, cols = (setup.region.rows, setup.region.cols) if setup.region else (camera.rows, camera.cols)
    wavelength_nm = light.line_nm or 550.0
    scale_um = camera.lens.lambda_n_um(wavelength_nm)
    lux = light.illuminance_lux / (4.0 * camera.lens.f_number**2)
    return [
        ("camera", camera.name),
        (
            "picture",
            f"{rows} × {cols} photosites, {rows * camera.pitch_um / 1e3:.3f} × "
            f"{cols * camera.pitch_um / 1e3:.3f} mm on the sensor",
        ),
        ("shapes", str(len(setup.scene.shapes))),
        (
            "light",
            f"{light.name}, {light.illuminance_lux:g} lx on the scene, {lux:.4g} lx on the sensor from white"
            " through a clear lens",
        ),
        (
            "diffraction",
            f"λN = {scale_um:.4g} µm at {wavelength_nm:g} nm, {scale_um / camera.pitch_um:.3g} pitches; "
            f"cut-off {1.0 / scale_um:.4g} cycles/µm",
        ),
    ]
