"""Pairs of a YAML capture and its Python twin, one for every kind of part: the same electrons, codes and records."""

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import camsim
from camsim.config.from_record import capture_from_record
from camsim.spectra.named import sensitivities

SCENE_FILE: dict[str, Any] = {
    "camsim": "scene/1",
    "sensor": "twin.yaml",
    "lens": {"kind": "airy", "f_number": 8},
    "light": {"illuminant": "D55", "illuminance_lux": 5000},
    "exposure": {"time_s": 0.01, "iso": 200},
    "region": {"rows": 10, "cols": 8},
    "scene": {
        "unit": "um",
        "background": {"reflectance": 0.8},
        "shapes": [{"kind": "rectangle", "width": 18, "height": 14.5, "rotate_deg": 4, "reflectance": 0.05}],
    },
    "render": {"tolerance": 1e-3},
    "noise": {"seed": 3},
}
SENSOR_FILE: dict[str, Any] = {
    "camsim": "sensor/1",
    "name": "Twin",
    "serial": 7,
    "frame": {"rows": 60, "cols": 80, "pitch_um": 4.0},
    "cfa": {"kind": "bayer", "pattern": "GRBG"},
    "quantum_efficiency": {"curves": "Nikon 5100 (NPL)", "per": "energy", "peak": 0.5},
    "readout": {"bit_depth": 12, "black_level_dn": 100, "base_iso": 100, "electrons_per_dn": 5.0},
}
NIKON = sensitivities("Nikon 5100 (NPL)")
CAMERA: dict[str, Any] = {
    "name": "Twin",
    "serial": 7,
    "rows": 60,
    "cols": 80,
    "pitch_um": 4.0,
    "lens": camsim.Airy(f_number=8),
    "photosite": camsim.SquarePhotosite(side_um=4),
    "cfa": camsim.Cfa.bayer("GRBG"),
    "quantum_efficiency": camsim.QuantumEfficiency([(c, NIKON[c]) for c in "RGB"], per="energy", peak=0.5),
    "adc": camsim.Adc(bit_depth=12, black_level_dn=100, electrons_per_dn=5, base_iso=100),
}
TAKEN: dict[str, Any] = {
    "light": camsim.Light("D55", illuminance_lux=5000),
    "exposure": camsim.Exposure(time_s=0.01, iso=200),
    "region": camsim.Region(rows=10, cols=8),
    "tolerance": 1e-3,
    "seed": 3,
}
SQUARE = camsim.Rectangle(width_um=18, height_um=14.5, rotate_deg=4, reflectance=0.05)


@dataclass(frozen=True, kw_only=True)
class Twin:
    """What differs from the files above (``set``: the scene's), and from their twins in Python."""

    set: dict[str, Any] = field(default_factory=dict)
    sensor: dict[str, Any] = field(default_factory=dict)
    camera: dict[str, Any] = field(default_factory=dict)
    taken: dict[str, Any] = field(default_factory=dict)
    scene: camsim.Scene = camsim.Scene(background=0.8, shapes=[SQUARE])  # noqa: RUF009 (frozen)


def of_lens(lens: camsim.Lens, **table: Any) -> Twin:
    return Twin(set={"lens": {"f_number": 8, **table}}, camera={"lens": lens})


def on_lens(table: dict[str, Any], **camera: Any) -> Twin:
    return Twin(set={"lens": {"kind": "airy", "f_number": 8, **table}}, camera=camera)


def of_sensor(key: str, table: Any, **camera: Any) -> Twin:
    return Twin(sensor={key: table}, camera=camera)


def charge(table: dict[str, Any], **camera: Any) -> Twin:
    return of_sensor("charge", table, **camera)


def readout(table: dict[str, Any], **camera: Any) -> Twin:
    return of_sensor("readout", SENSOR_FILE["readout"] | table, **camera)


def of_light(light: camsim.Light, **table: Any) -> Twin:
    return Twin(set={"light": table}, taken={"light": light})


def of_scene(scene: camsim.Scene, **table: Any) -> Twin:
    return Twin(set={"scene": {"unit": "um", "background": {"reflectance": 0.8}, **table}}, scene=scene)


def lettered(letters: str) -> tuple[dict[str, Any], camsim.QuantumEfficiency]:
    """Return curves for letters, each with its own slope: a table of a file, and the class."""
    tables = {
        c: {"wavelength_nm": [350, 850], "values": [0.2 * k, 1.0], "outside": "zero"} for k, c in enumerate(letters)
    }
    curves = [(c, camsim.Curve(t["wavelength_nm"], t["values"], outside="zero")) for c, t in tables.items()]
    return {"curves": tables, "per": "photon", "peak": 0.5}, camsim.QuantumEfficiency(curves, per="photon", peak=0.5)


def of_cfa(cfa: camsim.Cfa, **table: Any) -> Twin:
    efficiency, stage = lettered("".join(cfa.channels))
    return Twin(
        sensor={"cfa": table, "quantum_efficiency": efficiency}, camera={"cfa": cfa, "quantum_efficiency": stage}
    )


def of_shape(make: Callable[..., camsim.scene.Shape], kind: str, **table: Any) -> Twin:
    """A shape about the middle of the window; a length ends in µm in Python, and is in the scene's unit in a file."""
    painted = table if "shapes" in table else {**table, "reflectance": 0.1}
    named = {f"{key}_um" if key in LENGTHS else key: value for key, value in painted.items()}
    if "shapes" in table:
        named["shapes"] = [camsim.Disc(radius_um=3, centre_um=(-8, 1), reflectance=0.1)]
        painted["shapes"] = [{"kind": "disc", "radius": 3, "centre": [-8, 1], "reflectance": 0.1}]
    if "clip" in table:
        named["clip"] = camsim.Rectangle(width_um=16, height_um=30, reflectance=0)
    return of_scene(camsim.Scene(background=0.8, shapes=[make(**named)]), shapes=[{"kind": kind, **painted}])


def of_gradient(make: Callable[..., camsim.scene.Shape], kind: str, **table: Any) -> Twin:
    named = {f"{key}_um" if key in LENGTHS else key: value for key, value in table.items()}
    shape = make(**named, centre_um=(2, -1), low=0.1, high=RISING)
    return of_scene(
        camsim.Scene(background=0.8, shapes=[shape]),
        shapes=[{"kind": kind, **table, "centre": [2, -1], "low": 0.1, "high": RISE}],
    )


LENGTHS = {
    "height", "period", "finest_period",
    "radius", "radius_x", "radius_y", "inner_radius", "centre", "through", "segments", "width", "size", "at", "points",
    "holes", "move", "step",
}  # fmt: skip
BEND = [["move", -12, -8], ["cubic", 0, -20, 8, 14, 12, 2], ["arc", 9, 6, 20, 0, 1, -12, 8], ["close"]]
OUTER_CORNERS = [[-14, -10], [13, -9], [10, 15], [-12, 12]]

RISE = {"wavelength_nm": [300, 900], "values": [0.2, 0.9]}
RISING = camsim.Curve([300, 900], [0.2, 0.9])
IRIS: dict[str, Any] = {"shape": "bladed", "blades": 6, "obstruction": 0.1, "rotate_deg": 15}
GRID = [[0, 1, 0.5], [1, 4, 1], [0.2, 1, 0]]
OTF = [[0, 0, 0, 0, 0], [0, 0.2, 0.4, 0.2, 0], [0, 0.4, 1, 0.4, 0], [0, 0.2, 0.4, 0.2, 0], [0, 0, 0, 0, 0]]
CORNERS = [[-2, -2], [2, -2], [2, 0], [0, 0], [0, 2], [-2, 2]]
KERNEL = [[0, 0.02, 0], [0.03, 0.9, 0.01], [0, 0.02, 0]]

TWINS = {
    "airy": of_lens(camsim.Airy(f_number=2.8, transmission=0.9), kind="airy", f_number=2.8, transmission=0.9),
    "airy, coloured": of_lens(camsim.Airy(f_number=8, transmission=RISING), kind="airy", transmission=RISE),
    "annular": of_lens(camsim.AnnularAiry(f_number=8, obstruction=0.3), kind="annular-airy", obstruction=0.3),
    "gaussian": of_lens(camsim.Gaussian(sigma_um=1.5), kind="gaussian", sigma_um=1.5),
    "gaussian by its MTF50": of_lens(camsim.Gaussian.from_mtf50(0.1), kind="gaussian", mtf50_per_um=0.1),
    "ellipse": of_lens(
        camsim.EllipticalGaussian.from_axes(sigma_um=2, sigma_across_um=1, rotate_deg=30),
        kind="elliptical-gaussian", sigma_um=2, sigma_across_um=1, rotate_deg=30,
    ),
    "coma": of_lens(
        camsim.Wavefront(f_number=8, zernike_waves={8: 0.1, 3: 0.05}, reference_nm=600),
        kind="wavefront", zernike_waves=[[8, 0.1], [3, 0.05]], reference_nm=600,
    ),
    "defocused iris": of_lens(
        camsim.Wavefront(f_number=8, defocus_um=30, pupil=camsim.Pupil(**IRIS)),
        kind="wavefront", defocus_um=30, pupil=IRIS,

    ),
    "field": Twin(
        set={"lens": {"kind": "field", "file": "perfect", "focus_um": 90}},
        camera={
            "lens": camsim.FieldLens(
                f_number=5.6, wavelength_nm=[550], height_um=[0, 30000], zernike=[4], waves=[[[0], [0]]], focus_um=90
            )
        },
    ),
    "radial": of_lens(
        camsim.RadialOtf(freq_per_um=[0, 0.1, 0.2], values=[1, 0.3, 0]),
        kind="radial-otf", freq_per_um=[0, 0.1, 0.2], values=[1, 0.3, 0],
    ),
    "measured": of_lens(
        camsim.MeasuredPsf(irradiance=np.array(GRID), spacing_um=2), kind="measured-psf", irradiance=GRID, spacing_um=2
    ),
    "measured transfer": of_lens(
        camsim.MeasuredOtf(values=np.array(OTF), spacing_per_um=0.1),
        kind="measured-otf", values=OTF, spacing_per_um=0.1,
    ),
    "macro": on_lens({"magnification": 0.5}, magnification=0.5),
    "filters": on_lens({"filters": [0.5, RISE]}, filters=[0.5, RISING]),
    "veiling glare": on_lens({"veiling_glare": 0.2}, veiling_glare=0.2),
    "glare by wavelength": on_lens({"veiling_glare": RISE}, veiling_glare=RISING),
    "cos⁴": on_lens(
        {"falloff": {"kind": "cos4", "exit_pupil_mm": 0.5}}, falloff=camsim.Cos4Falloff(exit_pupil_mm=0.5)
    ),
    "fall-off": on_lens(
        {"falloff": {"kind": "radial", "radius_mm": [0, 0.1, 0.2], "values": [1, 0.7, 0.5]}},
        falloff=camsim.RadialFalloff(radius_mm=[0, 0.1, 0.2], values=[1, 0.7, 0.5]),
    ),
    "OLPF": of_sensor("olpf", {"kind": "four-spot", "split_um": 3}, olpf=camsim.FourSpotOlpf(split_um=3)),
    "OLPF, turned": of_sensor(
        "olpf", {"kind": "four-spot", "split_um": 3, "split_y_um": 2, "rotate_deg": 20},
        olpf=camsim.FourSpotOlpf(split_um=3, split_y_um=2, rotate_deg=20),
    ),
    "OLPF in pitches": of_sensor(
        "olpf", {"kind": "four-spot", "split_pitches": 0.7, "split_y_pitches": 0.6},
        olpf=camsim.FourSpotOlpf.from_pitches(pitch_um=4.0, split_pitches=0.7, split_y_pitches=0.6),
    ),
    "plate": of_sensor(
        "olpf", {"kind": "two-spot", "split_um": 3, "rotate_deg": 90},
        olpf=camsim.TwoSpotOlpf(split_um=3, rotate_deg=90),
    ),
    "plate in pitches": of_sensor(
        "olpf", {"kind": "two-spot", "split_pitches": 0.7},
        olpf=camsim.TwoSpotOlpf.from_pitches(pitch_um=4.0, split_pitches=0.7),
    ),
    "fill factor": of_sensor(
        "photosite", {"kind": "square", "fill_factor": 0.6},
        photosite=camsim.SquarePhotosite.from_fill_factor(pitch_um=4.0, fill_factor=0.6),
    ),
    "rectangular": of_sensor(
        "photosite", {"kind": "rectangular", "width_um": 3, "height_um": 2},
        photosite=camsim.RectangularPhotosite(width_um=3, height_um=2),
    ),
    "circular": of_sensor(
        "photosite", {"kind": "circular", "diameter_um": 3.5}, photosite=camsim.CircularPhotosite(diameter_um=3.5)
    ),
    "rounded": of_sensor(
        "photosite", {"kind": "rounded", "width_um": 4, "height_um": 3, "radius_um": 1},
        photosite=camsim.RoundedPhotosite(width_um=4, height_um=3, radius_um=1),
    ),
    "L": of_sensor(
        "photosite", {"kind": "polygon", "points_um": CORNERS}, photosite=camsim.PolygonPhotosite(points_um=CORNERS)
    ),
    "bayer": of_cfa(camsim.Cfa.bayer("RGGB"), kind="bayer", pattern="RGGB"),
    "quad bayer": of_cfa(camsim.Cfa.quad_bayer("BGGR", 3), kind="quad-bayer", pattern="BGGR", group=3),
    **{kind: of_cfa(camsim.Cfa.named(kind), kind=kind) for kind in ("x-trans", "rgbw", "ryyb", "cygm")},
    "mono": of_cfa(camsim.Cfa.mono(), kind="mono"),
    "letters": of_cfa(camsim.Cfa(["RGB", "WRG"]), kind="letters", pattern=["RGB", "WRG"]),
    "infrared cut": of_sensor("filters", [{**RISE, "outside": "hold"}], filters=[RISING.going_on("hold")]),
    "source": of_sensor(
        "quantum_efficiency", {**SENSOR_FILE["quantum_efficiency"], "peak": 0.4, "source": "a sheet"},
        quantum_efficiency=camsim.QuantumEfficiency.named("Nikon 5100 (NPL)", peak=0.4, source="a sheet"),
    ),
    "PRNU": charge({"prnu": 0.02}, prnu=camsim.Prnu(0.02)),
    "defects": charge(
        {"defects": {"hot_fraction": 0.2, "hot_e_per_s": 1e4, "dead_fraction": 0.1}},
        defects=camsim.Defects(hot_fraction=0.2, hot_e_per_s=1e4, dead_fraction=0.1),
    ),
    "defects by place": charge(
        {"defects": {"hot": [{"row": 27, "col": 38, "e_per_s": 1e5}], "dead": [[26, 37]]}},
        defects=camsim.Defects(hot=[(27, 38, 1e5)], dead=[(26, 37)]),
    ),
    "crosstalk": charge({"crosstalk": KERNEL}, crosstalk=camsim.Crosstalk(np.array(KERNEL))),
    "dark current": charge({"dark_current_e_per_s": 2000}, dark_current=camsim.DarkCurrent(2000)),
    "uneven dark current": charge(
        {"dark_current_e_per_s": 2000, "dcnu": 0.2, "dark_current_at_c": 20, "dark_current_doubles_every_c": 6},
        dark_current=camsim.DarkCurrent(2000, nonuniformity=0.2, at_c=20, doubling_c=6),
    ),
    "no photon noise": charge({"shot_noise": False}, shot_noise=None),
    "full well": charge({"full_well_e": 3000}, full_well=camsim.FullWell(3000)),
    "blooming": charge(
        {"full_well_e": 3000, "blooming": 0.5}, full_well=camsim.FullWell(3000), blooming=camsim.Blooming(0.5)
    ),
    "bent": charge(
        {"nonlinearity": {"kind": "polynomial", "coefficients": [-0.05], "scale_e": 10000}},
        nonlinearity=camsim.PolynomialResponse([-0.05], 10000),
    ),
    "bent by a table": charge(
        {"nonlinearity": {"kind": "table", "electrons_in": [0, 1000, 9000], "electrons_out": [0, 990, 8000]}},
        nonlinearity=camsim.ResponseTable([0, 1000, 9000], [0, 990, 8000]),
    ),
    "DSNU": charge({"dsnu_e": 20}, dsnu=camsim.Dsnu(20)),
    "reset noise": readout({"reset_noise_e": 20}, reset_noise=camsim.ResetNoise(20)),
    "read noise": readout({"read_noise_e": 20}, read_noise=camsim.ReadNoise(20)),
    "read noise of Student": readout(
        {"read_noise_e": 20, "read_noise_student_dof": 4}, read_noise=camsim.ReadNoise(20, student_dof=4)
    ),
    "uneven read noise of Tukey": readout(
        {"read_noise_e": 20, "read_noise_tukey_lambda": 0, "read_noise_spread": 0.3},
        read_noise=camsim.ReadNoise(20, tukey_lambda=0, spread=0.3),
    ),
    "telegraph noise": readout(
        {"telegraph_noise": {"fraction": 0.2, "amplitude_e": 90}},
        telegraph_noise=camsim.TelegraphNoise(fraction=0.2, amplitude_e=90),
    ),
    "gain by a table": readout(
        {"gain_at_iso": [{"iso": 150, "electrons_per_dn": 3}, {"iso": 800, "electrons_per_dn": 0.7}]},
        adc=camsim.Adc(
            bit_depth=12, black_level_dn=100, electrons_per_dn=5, base_iso=100, gain_at_iso=[(150, 3), (800, 0.7)]
        ),
    ),
    "12 bits in 16": readout(
        {"code_step_dn": 16, "bit_depth": 16, "black_level_dn": 1600, "electrons_per_dn": 0.3},
        adc=camsim.Adc(bit_depth=16, black_level_dn=1600, electrons_per_dn=0.3, base_iso=100, code_step_dn=16),
    ),
    "row noise": readout({"row_noise_e": 20}, row_noise=camsim.RowNoise(20)),
    "1/f noise": readout({"flicker_rows": {"sigma_e": 20, "exponent": 1.5}}, flicker_rows=camsim.FlickerRows(20, 1.5)),
    "column noise": readout({"column_noise_e": 20}, column_noise=camsim.ColumnNoise(20)),
    "output noise": readout({"output_noise_dn": 5}, output_noise=camsim.OutputNoise(5)),
    "dual gain": readout(
        {"read_noise_e": 20, "dual_gain": {"from_iso": 150, "read_noise_e": 5}},
        read_noise=camsim.ReadNoise(20), dual_gain=camsim.DualGain(from_iso=150, read_noise_e=5),
    ),
    "both gains": readout(
        {"read_noise_e": 20, "dual_gain": {"electrons_per_dn": 0.5, "read_noise_e": 5, "full_well_e": 4000}},
        read_noise=camsim.ReadNoise(20),
        dual_gain=camsim.DualGain(electrons_per_dn=0.5, read_noise_e=5, capacity_e=4000),
    ),
    "the high gain of both": readout(
        {"read_noise_e": 20, "dual_gain": {"electrons_per_dn": 0.5, "read_noise_e": 5, "read": "high"}},
        read_noise=camsim.ReadNoise(20),
        dual_gain=camsim.DualGain(electrons_per_dn=0.5, read_noise_e=5, read="high"),
    ),
    "companding": readout(
        {"companding": {"linear_dn": [0, 300, 4095], "codes": [0, 300, 900]}},
        adc=camsim.Adc(
            bit_depth=12, black_level_dn=100, electrons_per_dn=5, base_iso=100,
            companding=[(0, 0), (300, 300), (4095, 900)],
        ),
    ),
    "black offsets": readout(
        {"black_offsets_dn": [[0, 2], [1, 3]], "bit_depth": 14},
        adc=camsim.Adc(
            bit_depth=14, black_level_dn=100, electrons_per_dn=5, base_iso=100, black_offsets_dn=[[0, 2], [1, 3]]
        ),
    ),
    "laser": of_light(camsim.Light(line_nm=550, irradiance_w_per_m2=20), line_nm=550, irradiance_w_per_m2=20),
    "LED": of_light(
        camsim.Light(line_nm=520, width_nm=30, illuminance_lux=5000), line_nm=520, width_nm=30, illuminance_lux=5000
    ),
    "blackbody": of_light(
        camsim.Light(blackbody_k=2856, luminance_cd_per_m2=1500), blackbody_k=2856, luminance_cd_per_m2=1500
    ),
    "table": of_light(camsim.Light(RISING, illuminance_lux=5000), table=RISE, illuminance_lux=5000),
    "on the sensor": of_light(
        camsim.Light("A", illuminance_lux=20, at="sensor"), illuminant="A", illuminance_lux=20, at="sensor"
    ),
    "auto": Twin(
        set={"exposure": {"time_s": "auto", "iso": 800}}, taken={"exposure": camsim.Exposure(time_s="auto", iso=800)}
    ),
    "warm": Twin(
        set={"exposure": {"time_s": 0.01, "iso": 200, "temperature_c": 45}},
        sensor={"charge": {"dark_current_e_per_s": 2000}},
        camera={"dark_current": camsim.DarkCurrent(2000)},
        taken={"exposure": camsim.Exposure(time_s=0.01, iso=200, temperature_c=45)},
    ),
    "a named surface": of_scene(
        camsim.Scene(background=0.8, shapes=[camsim.Disc(radius_um=9, reflectance=camsim.reflectance("orange"))]),
        shapes=[{"kind": "disc", "radius": 9, "reflectance": "orange"}],
    ),
    "a coloured surface": of_scene(camsim.Scene(background=RISING), background={"reflectance": RISE}),
    "a surface that ends": of_scene(
        camsim.Scene(background=camsim.Curve([450, 600], [0.2, 0.9], outside="zero")),
        background={"reflectance": {"wavelength_nm": [450, 600], "values": [0.2, 0.9], "outside": "zero"}},
    ),
    "polygon": of_scene(
        camsim.Scene(background=0.8, shapes=[camsim.Polygon(points_um=[(-9, 0), (9, -3), (0, 9)], reflectance=0)]),
        shapes=[{"kind": "polygon", "points": [[-9, 0], [9, -3], [0, 9]], "reflectance": 0}],
    ),
    "polygon with a hole": of_shape(
        camsim.Polygon, "polygon", points=OUTER_CORNERS, holes=[[[-3, -3], [3, -2], [0, 4]]]
    ),
    "regular polygon": of_shape(camsim.RegularPolygon, "regular-polygon", sides=5, radius=12, rotate_deg=10),
    "star": of_shape(camsim.Star, "star", tips=5, radius=14, inner_radius=6, centre=[1, 2]),
    "elliptical shape": of_shape(camsim.Ellipse, "ellipse", radius_x=12, radius_y=7, rotate_deg=25),
    "ring": of_shape(camsim.Ring, "ring", radius=12, inner_radius=7),
    "sector": of_shape(camsim.Sector, "sector", radius=14, inner_radius=3, from_deg=20, turn_deg=130),
    "half-plane": of_shape(camsim.HalfPlane, "half-plane", through=[1, 2], towards_deg=85),
    "path": of_shape(camsim.Path, "path", segments=BEND, fill_rule="evenodd"),
    "line": of_shape(camsim.Line, "line", segments=BEND[:2], width=3, cap="round", join="bevel"),
    "text": of_shape(camsim.Text, "text", text="µ9", size=18, at=[-9, 6], weight="Bold"),
    "group": of_shape(
        camsim.Group, "group", shapes=[], mirror="left-right", scale=[1.5, 1], turn_deg=10, move=[2, -1],
        clip={"kind": "rectangle", "width": 16, "height": 30, "reflectance": 0},
    ),
    "grid": of_shape(camsim.RepeatOnGrid, "repeat-on-grid", shapes=[], cols=3, rows=2, step=[8, 9]),
    "ring of copies": of_shape(camsim.RepeatOnRing, "repeat-on-ring", shapes=[], count=5, upright=True),
    "chart": of_scene(
        camsim.Scene(
            background=0.8, shapes=[camsim.Chart(name="siemens-star", parameters={"radius_um": 14, "cycles": 7})]
        ),
        shapes=[{"kind": "chart", "name": "siemens-star", "radius": 14, "cycles": 7}],
    ),
    "linear gradient": of_gradient(camsim.LinearGradient, "linear-gradient", width=30, height=20, rotate_deg=10),
    "radial gradient": of_gradient(camsim.RadialGradient, "radial-gradient", radius=15),
    "grating": of_gradient(camsim.SineGrating, "sine-grating", width=30, height=20, period=9, phase_deg=30),
    "sine star": of_gradient(camsim.SineStar, "sine-star", radius=15, inner_radius=5, cycles=7),
    "sine plate": of_gradient(camsim.SineZonePlate, "sine-zone-plate", radius=15, finest_period=8),
    "pixels": of_scene(
        camsim.Scene(background=0.8, shapes=[camsim.Disc(radius_um=10, centre_um=(4, -6), reflectance=0.1)]),
        unit="pixel", shapes=[{"kind": "disc", "radius": 2.5, "centre": [1, -1.5], "reflectance": 0.1}],
    ),
    "millimetres, one over another": of_scene(
        camsim.Scene(background=0.8, shapes=[camsim.Rectangle(width_um=20, height_um=8, reflectance=0.1), SQUARE]),
        unit="mm",
        shapes=[
            {"kind": "rectangle", "width": 0.02, "height": 0.008, "reflectance": 0.1},
            {"kind": "rectangle", "width": 0.018, "height": 0.0145, "rotate_deg": 4, "reflectance": 0.05},
        ],
    ),
    "no noise": Twin(set={"noise": {"enabled": False, "seed": 3}}, taken={"noise": False}),
    "another exposure": Twin(set={"noise": {"seed": 9, "frame_number": 4}}, taken={"seed": 9, "frame_number": 4}),
    "fourier": Twin(
        set={"render": {"tolerance": 1e-4, "method": "fourier"}}, taken={"tolerance": 1e-4, "method": "fourier"}
    ),
    "a corner": Twin(
        set={"region": {"rows": 9, "cols": 7, "origin": [1, 3]}},
        taken={"region": camsim.Region(rows=9, cols=7, origin=(1, 3))},
    ),
}  # fmt: skip


@pytest.mark.parametrize("twin", TWINS.values(), ids=TWINS)
def test_a_file_and_its_python_twin_give_the_same_bytes(
    twin: Twin, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("scene.yaml").write_text(json.dumps(SCENE_FILE | twin.set), encoding="utf-8")
    Path("twin.yaml").write_text(json.dumps(SENSOR_FILE | twin.sensor), encoding="utf-8")
    ready = camsim.load("scene.yaml")
    by_yaml = ready.frame()
    by_python = camsim.Camera(**CAMERA | twin.camera).expose(twin.scene, **TAKEN | twin.taken)
    assert by_yaml.mean_electrons.tobytes() == by_python.mean_electrons.tobytes()
    assert by_yaml.mosaic.tobytes() == by_python.mosaic.tobytes()
    assert by_yaml.description == by_python.description
    assert by_yaml.mean_electrons.max() > 100.0
    assert by_yaml.report.error_estimate <= ready.tolerance
    again = capture_from_record(json.loads(json.dumps(by_yaml.description)))
    for part in (
        "camera",
        "scene",
        "light",
        "exposure",
        "region",
        "tolerance",
        "method",
        "noise",
        "seed",
        "frame_number",
    ):
        assert getattr(again, part) == getattr(ready, part), part
