"""What optical stages of one's own say besides their transfer: believed where it is right, else refused."""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import pytest
from scipy import special

import camsim
from camsim.errors import InvalidValueError
from tests.tables import rows

AIRY, SQUARE = camsim.Airy(f_number=8.0), camsim.SquarePhotosite(side_um=4.0)
FASTER = camsim.Airy(f_number=4.0)
SPLIT = camsim.FourSpotOlpf(split_um=3.0)
GRID = camsim.Grid(rows=6, cols=6, pitch_um=4.0)
SCENE = camsim.Scene(
    background=1.0, shapes=[camsim.Rectangle(width_um=25, height_um=17, rotate_deg=7, reflectance=0.0)]
)


class Lens:
    f_number, transmission = 8.0, 1.0

    def otf(self, fx_per_um, fy_per_um, wavelength_nm):
        return AIRY.otf(fx_per_um, fy_per_um, wavelength_nm)


class Whole(Lens):
    """All that an Airy pattern says of itself, by another class."""

    def cutoff_per_um(self, wavelength_nm):
        return AIRY.cutoff_per_um(wavelength_nm)

    def blur_um(self, wavelength_nm):
        return AIRY.blur_um(wavelength_nm)

    def point_spread(self, r_um, wavelength_nm):
        return AIRY.point_spread(r_um, wavelength_nm)

    def encircled_energy(self, r_um, wavelength_nm):
        return AIRY.encircled_energy(r_um, wavelength_nm)

    def pattern(self):
        return AIRY.pattern()


class Olpf:
    place = "olpf"

    def spots_um(self):
        return SPLIT.spots_um()

    def otf(self, fx_per_um, fy_per_um, wavelength_nm):
        return SPLIT.otf(fx_per_um, fy_per_um, wavelength_nm)


class Photosite:
    place, area_um2, half_extent_um, sides_um, separable = "photosite", 16.0, (2.0, 2.0), (4.0, 4.0), True

    def otf(self, fx_per_um, fy_per_um, wavelength_nm):
        return SQUARE.otf(fx_per_um, fy_per_um, wavelength_nm)


def rendered(optics, **how):
    return camsim.render(SCENE, optics, GRID, wavelength_nm=[450.0, 650.0], tolerance=1e-4, **how)


def changed(stage, **facts):
    """A stage of a class of one's own, some of whose facts are others."""
    return type("Mine", (stage,), facts)()


@pytest.mark.parametrize("method", ["boundary", "fourier"])
def test_what_is_right_is_taken(method):
    one = rendered([Whole(), Olpf(), Photosite()], method=method)
    theirs = rendered([AIRY, SPLIT, SQUARE], method=method)
    assert np.abs(one.image - theirs.image).max() <= 1e-4


@pytest.mark.parametrize(("facts", "message"), rows("wrong-stages.txt", "a lens against its transfer"))
def test_a_lens_that_contradicts_its_transfer_is_refused(facts, message):
    """Cycles/µm for cycles/mm: 0.93 of full scale off, estimate 4e-10. A peak of 1 for π/4/(λN)²: 30 times."""
    with pytest.raises(InvalidValueError, match=message):
        rendered([changed(Whole, **eval(facts)), SQUARE])


def test_a_lens_with_a_pattern_is_hashed():
    @dataclass(frozen=True)
    class Listed(Whole):
        powers: Any

    assert rendered([Listed((1.0, 2.0)), SQUARE]).method == "boundary"
    with pytest.raises(InvalidValueError, match=r"which has no hash .unhashable type: 'list'.; give its fields tuples"):
        rendered([Listed([1.0, 2.0]), SQUARE])


@pytest.mark.parametrize(("facts", "message"), rows("wrong-stages.txt", "an OLPF against its transfer"))
def test_an_olpf_that_contradicts_its_transfer_is_refused(facts, message):
    """Half distances taken for splits: 0.17 of full scale off, with an estimate of 1e-5."""
    with pytest.raises(InvalidValueError, match=message):
        rendered([AIRY, changed(Olpf, **eval(facts)), SQUARE])


def olpf_of(spots):
    """An OLPF of one's own with these spots."""

    def otf(self, fx_per_um, fy_per_um, wavelength_nm):
        return np.mean([np.exp(-2j * np.pi * (fx_per_um * x + fy_per_um * y)) for x, y in spots], axis=0)

    return changed(Olpf, spots_um=lambda self: np.array(spots, float), otf=otf)


@pytest.mark.parametrize("method", ["boundary", "fourier"])
def test_one_plate_of_ones_own(method):
    """By fourier it ended in a division by zero: it does not reach up or down at all."""
    one = rendered([AIRY, olpf_of([(-1.5, 0.0), (1.5, 0.0)]), SQUARE], method=method)
    theirs = rendered([AIRY, camsim.TwoSpotOlpf(split_um=3.0), SQUARE], method=method)
    assert np.abs(one.image - theirs.image).max() <= 1e-4


@pytest.mark.parametrize("spots", [[(1.0, 0.0)], [(-1.0, -1.0), (1.0, -1.0), (0.0, 2.0)]])
def test_spots_without_an_opposite_are_a_blur_besides_the_lens(spots):
    """As an OLPF they were 0.14 of full scale off by boundary, and the check called right images wrong."""
    with pytest.raises(InvalidValueError, match="and none opposite it, which engines and check take to be there"):
        rendered([AIRY, olpf_of(spots), SQUARE])
    blur = type("Blur", (), {"otf": type(olpf_of(spots)).otf})()
    found = camsim.render(
        camsim.Scene(background=0.0, shapes=[camsim.Disc(radius_um=3.0, reflectance=1.0)]),
        [camsim.Gaussian(sigma_um=1.0), blur, camsim.SquarePhotosite(side_um=1.0)],
        camsim.Grid(rows=25, cols=25, pitch_um=1.0),
        wavelength_nm=550.0,
        tolerance=1e-4,
    )
    assert found.error_estimate <= 1e-4
    x = np.arange(-12.0, 13.0)
    centre = [(found.image * axis).sum() / found.image.sum() for axis in (x[None, :], x[:, None])]
    np.testing.assert_allclose(centre, np.mean(spots, axis=0), atol=1e-2)


@pytest.mark.parametrize(("facts", "message"), rows("wrong-stages.txt", "a photosite against its transfer"))
def test_a_photosite_that_contradicts_its_transfer_is_refused(facts, message):
    """One that sees less of red light: no engine asked for the wavelength, 0.057 of full scale off."""
    with pytest.raises(InvalidValueError, match=message):
        rendered([AIRY, changed(Photosite, **eval(facts))])


@pytest.mark.parametrize("order", [(Lens, Whole), (Whole, Lens)])
def test_two_of_a_class_may_differ_in_what_they_can(order):
    """A lens without a cut-off was asked for it, because another one of its class had one."""
    theirs = rendered([AIRY, SQUARE]).image
    for kind in order:
        can = {name: getattr(kind(), name) for name in dir(kind) if not name.startswith("_")}
        assert np.abs(rendered([SimpleNamespace(**can), SQUARE]).image - theirs).max() <= 1e-4


class Hazy(camsim.Airy):
    """Its pattern is the Airy's still, which the image was made of, haze or not."""

    def otf(self, fx_per_um, fy_per_um, wavelength_nm):
        haze = np.exp(-2.0 * (3.0 * np.pi) ** 2 * (np.square(fx_per_um) + np.square(fy_per_um)))
        return haze * super().otf(fx_per_um, fy_per_um, wavelength_nm)


class Vignetted(camsim.Airy):
    opening = 0.5


def camera_with(**stages):
    return camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=8.0)).replace(**stages)


def electrons(**stages):
    return camera_with(**stages).diffuser_electrons(camsim.Light("D55", illuminance_lux=100.0), 0.01)[0]


def test_half_of_a_class_of_camsims_is_not_inherited():
    message = "Hazy has its own otf, and blur_um, cutoff_per_um, encircled_energy, pattern and more of the Airy"
    with pytest.raises(InvalidValueError, match=message):
        camera_with(lens=Hazy(f_number=8.0))
    assert electrons(lens=Vignetted(f_number=8.0)) == pytest.approx(0.5 * electrons(), rel=1e-12)


@dataclass(frozen=True)
class Grey:
    transmission: Any = 1.0
    opening: Any = 1.0
    f_number: float = 8.0
    place: ClassVar = "lens"

    def otf(self, fx_per_um, fy_per_um, wavelength_nm):
        return AIRY.otf(fx_per_um, fy_per_um, wavelength_nm)


@dataclass(frozen=True)
class Dimming(Grey):
    at_axis: float = 1.0
    at_corner: float = 0.2

    def illumination(self, radius_um):
        return np.interp(radius_um, (0.0, 1e4), (self.at_axis, self.at_corner))


@pytest.mark.parametrize("half", [np.float32(0.5), camsim.Curve((540.0, 560.0), (0.5, 0.5))])
def test_a_transmission_is_kept_as_of_camsims_lenses(half):
    """Beyond its table a curve was dark: 0 electrons; numpy's numbers ended in a traceback."""
    assert electrons(lens=Grey(half)) == pytest.approx(0.5 * electrons(), rel=1e-12)


@pytest.mark.parametrize(("lens", "message"), rows("wrong-stages.txt", "the light of a lens"))
def test_light_that_is_none_is_refused(lens, message):
    with pytest.raises(InvalidValueError, match=message):
        camera_with(lens=eval(lens))


@dataclass(frozen=True)
class SquarePupil:
    """A square pupil that says nothing of its sides."""

    f_number: float = 8.0
    transmission: float = 1.0

    def otf(self, fx_per_um, fy_per_um, wavelength_nm):
        u, v = (1e-3 * wavelength_nm * self.f_number * np.abs(f) for f in (fx_per_um, fy_per_um))
        return np.clip(1.0 - u, 0.0, None) * np.clip(1.0 - v, 0.0, None)

    def cutoff_per_um(self, wavelength_nm):
        return np.sqrt(2.0) / (1e-3 * wavelength_nm * self.f_number)


def test_sides_of_a_pupil_are_found_in_its_transfer():
    """Its pattern is sinc² along x times sinc² along y, and a rectangle's image is a product too."""
    rectangle = camsim.Rectangle(width_um=60.0, height_um=90.0, reflectance=0.0)
    found = camsim.render(
        camsim.Scene(background=1.0, shapes=[rectangle]),
        [SquarePupil(), camsim.SquarePhotosite(side_um=0.0)],
        camsim.Grid(rows=24, cols=24, pitch_um=4.88),
        wavelength_nm=550.0,
        tolerance=2e-5,
    )
    place = (np.arange(24) - 11.5) * 4.88

    def lit(half_um):
        t = np.pi / (0.55 * 8.0) * (place[:, None] + np.array([half_um, -half_um]))
        before = special.sici(2.0 * t)[0] - np.sin(t) ** 2 / t
        return (before[:, 0] - before[:, 1]) / np.pi

    assert np.abs(found.image - (1.0 - np.outer(lit(45.0), lit(30.0)))).max() <= 2e-5
    assert found.error_estimate <= 2e-5
