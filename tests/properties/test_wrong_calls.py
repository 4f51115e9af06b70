"""What cannot be is refused in the constructor, with the name of the parameter: of every stage every parameter."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
import shapely
from electronics import LAWS
from test_many_wrong_calls import CAMERA, EXPOSURE, FLAT, GRID, LIGHT, SCENE

import camsim
from camsim.errors import CamsimError, InvalidValueError, WrongCallError

CORNERS = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
TRIANGLE = (("move", 0.0, 0.0), ("line", 1.0, 0.0), ("line", 0.0, 1.0), ("close",))

STAGES: tuple[Any, ...] = (
    CAMERA, SCENE, LIGHT, EXPOSURE, FLAT, CAMERA.cfa, CAMERA.adc, CAMERA.quantum_efficiency, CAMERA.lens,
    camsim.Capture(camera=CAMERA, scene=SCENE, light=LIGHT, exposure=EXPOSURE),
    camsim.Region(rows=4, cols=4), GRID,
    camsim.Rectangle(width_um=1.0, height_um=1.0, reflectance=0.1), SCENE.shapes[0],
    camsim.Polygon(points_um=CORNERS, reflectance=0.1),
    camsim.RegularPolygon(sides=5, radius_um=1.0, reflectance=0.1), camsim.HalfPlane(reflectance=0.1),
    camsim.Star(tips=5, radius_um=2.0, inner_radius_um=1.0, reflectance=0.1),
    camsim.Ellipse(radius_x_um=1.0, radius_y_um=2.0, reflectance=0.1),
    camsim.Ring(radius_um=2.0, inner_radius_um=1.0, reflectance=0.1),
    camsim.Sector(radius_um=2.0, turn_deg=90.0, reflectance=0.1), camsim.Text(text="a", size_um=9.0, reflectance=0.1),
    camsim.Path(segments_um=TRIANGLE, reflectance=0.1),
    camsim.Line(segments_um=TRIANGLE, width_um=0.1, reflectance=0.1),
    camsim.Picture(planes=np.full((1, 2, 2), 0.5), width_um=4.0),
    camsim.PointSource(electrons=9.0),
    camsim.LinearGradient(width_um=4.0, height_um=4.0), camsim.RadialGradient(radius_um=4.0),
    camsim.SineGrating(width_um=4.0, height_um=4.0, period_um=2.0),
    camsim.SineZonePlate(radius_um=4.0, finest_period_um=1.0),
    camsim.SineStar(radius_um=4.0, inner_radius_um=2.0, cycles=3),
    camsim.Group(shapes=SCENE.shapes), camsim.RepeatOnGrid(shapes=SCENE.shapes, step_um=(1.0, 1.0)),
    camsim.RepeatOnRing(shapes=SCENE.shapes, count=3),
    camsim.Chart(name="siemens-star", parameters={"radius_um": 9.0}), camsim.Svg(name="a", shapes=SCENE.shapes),
    camsim.AnnularAiry(f_number=8.0, obstruction=0.3), camsim.Gaussian(sigma_um=1.0), camsim.Pupil(),
    camsim.EllipticalGaussian(covariance_um2=((1.0, 0.0), (0.0, 2.0))),
    camsim.MeasuredMatrix(
        light="D50", white_xyz=(0.96, 1.0, 0.82), camera_to_xyz=((1.2, 0.1, 0.1), (0.5, 0.9, -0.2), (0.0, -0.1, 1.5))
    ),
    camsim.MeasuredPsf(irradiance=((0.0, 1.0), (1.0, 2.0)), spacing_um=0.5), camsim.Wavefront(f_number=8.0),
    camsim.MeasuredOtf(values=np.pad([[1.0]], 1), spacing_per_um=0.5), camsim.TwoSpotOlpf(split_um=2.0),
    camsim.RadialOtf(freq_per_um=(0.0, 0.1, 0.2), values=(1.0, 0.5, 0.0)), camsim.FourSpotOlpf(split_um=2.0),
    CAMERA.photosite, camsim.CircularPhotosite(diameter_um=2.0), camsim.PolygonPhotosite(points_um=CORNERS),
    camsim.RectangularPhotosite(width_um=2.0, height_um=2.0),
    camsim.RoundedPhotosite(width_um=2.0, height_um=2.0, radius_um=0.5),
    camsim.Cos4Falloff(exit_pupil_mm=50.0), camsim.RadialFalloff(radius_mm=(0.0, 1.0), values=(1.0, 0.5)),
    camsim.DualGain(from_iso=800.0, read_noise_e=1.0),
    camsim.FieldLens(f_number=4.0, wavelength_nm=[550.0], zernike=[4], waves=[[[0.0], [0.1]]], height_um=[0.0, 5e3]),
    *{type(law.stage): law.stage for law in LAWS.values() if dataclasses.fields(law.stage)}.values(),
)  # fmt: skip
PUBLIC = [stage for stage in STAGES if type(stage).__name__ in camsim.__all__]
PARAMETERS = [(stage, field.name) for stage in PUBLIC for field in dataclasses.fields(stage) if field.init]


def test_every_public_stage_is_here() -> None:
    public = {getattr(camsim, name) for name in camsim.__all__ if dataclasses.is_dataclass(getattr(camsim, name))}
    made = {camsim.Frame, camsim.Rendering, camsim.Report, camsim.Note, camsim.Context, camsim.ShotNoise}
    # What they take is judged where light is given: tests/analytic/test_exposed_light.py.
    exposed = {camsim.Sensor, camsim.Noise, camsim.GivenLight}
    assert public - made - exposed == {type(stage) for stage, _ in PARAMETERS}


@pytest.mark.parametrize(("stage", "name"), PARAMETERS, ids=lambda part: part if isinstance(part, str) else "")
def test_every_parameter_of_every_stage_is_judged(stage: Any, name: str) -> None:
    for wrong in (object(), b"1", {1, 2}, np.array([["a"]]), 1j):
        with pytest.raises(InvalidValueError, match="must be ") as refused:
            dataclasses.replace(stage, **{name: wrong})
        assert (refused.value.key, refused.value.stage) == (name, type(stage).__name__)


@pytest.mark.parametrize(
    "kind", sorted({type(stage) for stage in PUBLIC}, key=lambda kind: kind.__name__), ids=lambda kind: kind.__name__
)
def test_every_class_says_which_parameter_is_meant(kind: Any) -> None:
    """Python alone would say what it cannot take, and not what it takes."""
    names = [field.name for field in dataclasses.fields(kind) if field.init]
    with pytest.raises(WrongCallError, match=f"{kind.__name__}.*unknown parameter; did you mean '{names[0]}'") as wrong:
        kind(**{names[0].upper(): 1})
    assert isinstance(wrong.value, TypeError)
    with pytest.raises(WrongCallError, match=rf"{kind.__name__}: takes .*and no more"):
        kind(*range(len(names) + 1))
    if any(field.kw_only for field in dataclasses.fields(kind)):
        with pytest.raises(CamsimError, match=rf"{kind.__name__}.*(by name|missing|must be)"):
            kind(object())


@pytest.mark.parametrize("kind", [list, tuple, np.array, lambda values: np.array(values, np.float32), range])
def test_lists_tuples_and_arrays_make_the_same(kind: Any) -> None:
    values = (400, 500, 600) if kind is not range else range(400, 700, 100)
    curve = camsim.Curve(kind(values) if kind is not range else values, (0.25, 0.5, 1.0))
    assert curve == camsim.Curve((400.0, 500.0, 600.0), (0.25, 0.5, 1.0))
    assert all(type(value) is float for value in curve.wavelength_nm)


@pytest.mark.parametrize("number", [8, 8.0, np.float32(8), np.float64(8), np.int16(8), np.uint8(8), np.array(8.0)])
def test_numbers_of_any_kind_make_the_same(number: Any) -> None:
    lens = camsim.Airy(f_number=number)
    assert (lens, type(lens.f_number)) == (camsim.Airy(f_number=8.0), float)


def test_what_is_the_same_in_another_form() -> None:
    pairs = camsim.Wavefront(f_number=4.0, zernike_waves=((4, 0.1), (7, -0.05)))
    assert camsim.Wavefront(f_number=4.0, zernike_waves={4: 0.1, 7: -0.05}) == pairs
    ring = shapely.Polygon(CORNERS).exterior.coords
    assert camsim.Polygon(points_um=ring, reflectance=0.1).points_um == (*CORNERS, CORNERS[0])
    assert hash(camsim.Curve([400, 500], np.ones(2))) == hash(camsim.Curve((400.0, 500.0), (1.0, 1.0)))


def test_what_lies_beyond_a_table_goes_by_what_it_is_of() -> None:
    table = camsim.Curve((450.0, 650.0), (0.5, 0.9))
    assert camsim.Airy(f_number=8.0, transmission=table).transmission.outside == "hold"
    assert camsim.Scene(background=table).background.outside == "hold"
    assert camsim.Light(table, illuminance_lux=1.0).spectrum.outside == "zero"
    efficiency = camsim.QuantumEfficiency((("Y", table),), per="photon", peak=0.5)
    for camera in (CAMERA.replace(quantum_efficiency=efficiency), CAMERA.replace(filters=[table])):
        with pytest.raises(InvalidValueError, match=r"300..450 nm is missing, .* or say outside='zero'"):
            camsim.Capture(camera=camera, scene=SCENE, light=LIGHT, exposure=EXPOSURE)
        narrow = camsim.Light(line_nm=550.0, illuminance_lux=1.0)
        settled = camsim.Capture(camera=camera, scene=SCENE, light=narrow, exposure=EXPOSURE).camera
        assert {curve.outside for _, curve in settled.quantum_efficiency.curves} | {"zero"} == {"zero"}
