"""What optical stages of one's own say besides their transfer: believed where it is right, else refused."""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import pytest
from scipy import special

import camsim
from camsim.errors import InvalidValueError

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


@pytest.mark.parametrize(
    ("facts", "message"),
    [
        # 1000 cycles/mm for 1 cycle/µm, the other way round: 0.93 of full scale off, with an estimate of 4e-10.
        ({"cutoff_per_um": lambda s, nm: 1e-3 * AIRY.cutoff_per_um(nm)}, "0.0002778 cycles/µm .* its otf is 0.999 at"),
        ({"cutoff_per_um": lambda s, nm: AIRY.cutoff_per_um(650.0)}, "at 450 nm, and its otf is 0.195 at 0.1925"),
        ({"cutoff_per_um": lambda s, nm: None}, r"Mine.cutoff_per_um\(450\): must be a number above 0, not None"),
        ({"chromatic": False}, r"by its chromatic False \(the same at 450 nm\); leave chromatic out"),
        # π/4/(λN)² is the peak of an Airy pattern: 30 times full scale off.
        (
            {"point_spread": lambda s, r, nm: AIRY.point_spread(r, nm) / AIRY.point_spread(0.0 * r, nm)},
            "point_spread is 1 per µm² of unit power at 0 µm and 450 nm, and by its otf 0.0606",
        ),
        ({"point_spread": lambda s, r, nm: 0.0}, "point_spread gives 0.0 for 4 radii"),
        ({"encircled_energy": lambda s, r, nm: FASTER.encircled_energy(r, nm)}, "and by its otf 0.32"),
        (
            {"otf": lambda s, x, y, nm: FASTER.otf(x, y, nm), "cutoff_per_um": lambda s, nm: 0.6},
            "point_spread is 0.0606.* and by its otf 0.242",
        ),
        ({"pattern": lambda s: camsim.Gaussian(sigma_um=1.0).pattern()}, r"by its pattern\(\); both are of the same"),
        ({"otf": lambda s, x, y, nm: AIRY.otf(x, 0.5 * y, nm), "cutoff_per_um": lambda s, nm: 0.6}, "makes it round"),
        ({"otf": lambda s, x, y, nm: np.exp(-np.add(np.multiply(x, x, out=x), y * y))}, "writes into the frequencies"),
    ],
)
def test_a_lens_that_contradicts_its_transfer_is_refused(facts, message):
    with pytest.raises(InvalidValueError, match=message):
        rendered([changed(Whole, **facts), SQUARE])


def test_a_lens_with_a_pattern_is_hashed():
    @dataclass(frozen=True)
    class Listed(Whole):
        powers: Any

    assert rendered([Listed((1.0, 2.0)), SQUARE]).method == "boundary"
    with pytest.raises(InvalidValueError, match=r"which has no hash .unhashable type: 'list'.; give its fields tuples"):
        rendered([Listed([1.0, 2.0]), SQUARE])


@pytest.mark.parametrize(
    ("facts", "message"),
    [
        # Half distances taken for splits: 0.17 of full scale off, with an estimate of 1e-5.
        ({"spots_um": lambda s: 2.0 * SPLIT.spots_um()}, r"by its spots_um\(\); they are offsets from the middle"),
        ({"spots_um": lambda s: SPLIT.spots_um().tolist()}, r"give an array \(n, 2\)"),
        ({"otf": lambda s, x, y, nm: SPLIT.otf(x * nm / 550, y, nm)}, "and 1 by its being a olpf|asked without a wave"),
        ({"otf": lambda s, x, y, nm: 1.0 / nm}, "otf failed: ZeroDivisionError|otf gives shape"),
    ],
)
def test_an_olpf_that_contradicts_its_transfer_is_refused(facts, message):
    with pytest.raises(InvalidValueError, match=message):
        rendered([AIRY, changed(Olpf, **facts), SQUARE])


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


@pytest.mark.parametrize(
    ("facts", "message"),
    [
        ({"sides_um": (2.0, 2.0)}, "by its sides_um; width and height"),
        # A photosite that sees less of red light: no engine asked for the wavelength, 0.057 of full scale off.
        (
            {"otf": lambda s, x, y, nm: camsim.SquarePhotosite(side_um=nm / 200.0).otf(x, y, nm)},
            r"at 0 nm .* put what depends on the wavelength into a blur besides",
        ),
        (
            {
                "otf": lambda s, x, y, nm: camsim.CircularPhotosite(diameter_um=4.0).otf(x, y, nm),
            },
            r"by its factors \(separable True\); leave separable out",
        ),
        (
            {"half_extent_um": (1.0, 2.0), "area_um2": 8.0},
            "is 1 µm along x, and by its otf it is larger",
        ),
        ({"half_extent_um": 2.0}, "half_extent_um: must be a list of 2, not 2.0"),
        ({"area_um2": 16e6}, "area_um2: 1.6e[+]07 µm², and what reaches 2 × 2 µm from its centre has less"),
    ],
)
def test_a_photosite_that_contradicts_its_transfer_is_refused(facts, message):
    with pytest.raises(InvalidValueError, match=message):
        rendered([AIRY, changed(Photosite, **facts)])


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


@pytest.mark.parametrize(
    ("lens", "message"),
    [
        (Grey(1.5), "Grey.transmission: must be a number from 0 to 1"),
        (Grey("0.9"), "Grey.transmission: must be a number from 0 to 1"),
        (Grey(opening=-1.0), "Grey.opening: must be a number above 0, not -1"),
        (Dimming(at_axis=0.9), "Dimming.illumination: is 0.9 on the axis; it is relative to that, 1 there"),
        (Dimming(at_corner=-2.0), "Dimming.illumination: is not finite, or below 0, somewhere between"),
    ],
)
def test_light_that_is_none_is_refused(lens, message):
    with pytest.raises(InvalidValueError, match=message):
        camera_with(lens=lens)


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
