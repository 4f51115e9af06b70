"""What cannot be is refused in the constructor, with the name of the parameter: of every stage every parameter."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
import shapely
from electronics import LAWS
from test_many_wrong_calls import CAMERA, EXPOSURE, FLAT, GRID, LIGHT, SCENE  # noqa: F401 (stages are told by their text)

import camsim
from camsim.errors import CamsimError, InvalidValueError, WrongCallError
from tests.tables import rows

CORNERS = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
TRIANGLE = (("move", 0.0, 0.0), ("line", 1.0, 0.0), ("line", 0.0, 1.0), ("close",))

STAGES: tuple[Any, ...] = (
    *(eval(stage) for (stage,) in rows("stages.txt", "one of each class")),
    *{type(law.stage): law.stage for law in LAWS.values() if dataclasses.fields(law.stage)}.values(),
)
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
