"""Laws of every optical stage; a new stage gets all of them by a line in the list."""

import copy
import dataclasses

import numpy as np
import pytest
from own_optics import OWN_OPTICS
from scipy import integrate, special
from tolerances import ROUNDING

import camsim
from camsim.optics import OpticalSystem

WAVELENGTH_NM = 550.0

OPTICAL_STAGES = {
    "Airy f/8": camsim.Airy(f_number=8.0),
    "Airy f/1.2": camsim.Airy(f_number=1.2, transmission=0.9),
    "annular": camsim.AnnularAiry(f_number=8.0, obstruction=0.4),
    "Gaussian": camsim.Gaussian(sigma_um=1.3),
    "defocus": camsim.Wavefront(f_number=8.0, defocus_um=40.0),
    "square pupil": camsim.Wavefront(f_number=8.0, pupil=camsim.Pupil(shape="square")),
    "disc": camsim.CircularPhotosite(diameter_um=4.0),
    "rounded square": camsim.RoundedPhotosite(width_um=4.0, height_um=4.0, radius_um=1.0),
    "OLPF": camsim.FourSpotOlpf(split_um=3.66),
    "photosite": camsim.SquarePhotosite(side_um=4.88),
    "photosite, fill factor 0.4": camsim.SquarePhotosite.from_fill_factor(pitch_um=3.45, fill_factor=0.4),
    "point": camsim.SquarePhotosite(side_um=0.0),
    "lens and photosite": OpticalSystem(lens=camsim.Airy(f_number=5.6), photosite=camsim.SquarePhotosite(side_um=4.88)),
    "lens, OLPF and photosite": OpticalSystem(
        lens=camsim.Airy(f_number=2.8),
        olpf=camsim.FourSpotOlpf(split_um=2.0),
        photosite=camsim.SquarePhotosite(side_um=4.0),
    ),
}
LOPSIDED_STAGES = {
    "coma, trefoil and astigmatism": camsim.Wavefront(f_number=8.0, zernike_waves=((3, 0.1), (8, 0.2), (9, -0.1))),
    "iris": camsim.Wavefront(f_number=8.0, pupil=camsim.Pupil(shape="bladed", blades=5, obstruction=0.2)),
    "ellipse": camsim.EllipticalGaussian.from_axes(sigma_um=2.0, sigma_across_um=0.7, rotate_deg=20.0),
    "measured": camsim.MeasuredPsf(irradiance=((0, 1, 0.5), (1, 4, 2), (0.2, 1, 0.1), (0, 0.3, 0)), spacing_um=0.7),
    "measured transfer": camsim.MeasuredOtf(
        values=np.pad([[0.2, 0.5j, 0.1], [0.7, 1.0, 0.7], [0.1, -0.5j, 0.2]], 1), spacing_per_um=0.05
    ),
    "rectangle": camsim.RectangularPhotosite(width_um=4.0, height_um=2.0),
    "rounded rectangle": camsim.RoundedPhotosite(width_um=4.0, height_um=3.0, radius_um=1.5),
    "tile": camsim.RoundedPhotosite(width_um=4.0, height_um=3.0, radius_um=0.5),
    "L": camsim.PolygonPhotosite(points_um=((-2, -2), (2, -2), (2, 0), (0, 0), (0, 2), (-2, 2))),
    "unequal splits, turned": camsim.FourSpotOlpf(split_um=3.0, split_y_um=1.0, rotate_deg=20.0),
    "one plate": camsim.TwoSpotOlpf(split_um=3.0),
}
ALL_STAGES = OPTICAL_STAGES | LOPSIDED_STAGES | OWN_OPTICS
ROUND_STAGES = {name: stage for name, stage in OPTICAL_STAGES.items() if hasattr(stage, "encircled_energy")}


@pytest.fixture(params=ALL_STAGES.values(), ids=ALL_STAGES)
def stage(request):
    return request.param


@pytest.fixture(params=OPTICAL_STAGES.values(), ids=OPTICAL_STAGES)
def mirrored_stage(request):
    return request.param


@pytest.fixture
def frequencies(rng):
    """Frequencies in cycles/µm: in the pass band, near its end and far beyond it."""
    return rng.normal(size=(2, 400)) * np.repeat([0.05, 0.3, 1.0, 20.0], 100)


def otf(stage, fx, fy, wavelength_nm=WAVELENGTH_NM):
    return stage.otf(np.asarray(fx, float), np.asarray(fy, float), wavelength_nm)


def test_a_uniform_scene_keeps_its_level(stage):
    assert otf(stage, 0.0, 0.0) == pytest.approx(1.0, abs=ROUNDING)


def test_nothing_is_amplified(stage, frequencies):
    assert np.abs(otf(stage, *frequencies)).max() <= 1.0 + ROUNDING


def test_the_point_image_is_real(stage, frequencies):
    fx, fy = frequencies
    np.testing.assert_allclose(otf(stage, -fx, -fy), np.conj(otf(stage, fx, fy)), rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("turn", ["mirrored in x", "mirrored in y", "transposed"])
def test_mirror_symmetry(mirrored_stage, frequencies, turn):
    fx, fy = frequencies
    other = {"mirrored in x": (-fx, fy), "mirrored in y": (fx, -fy), "transposed": (fy, fx)}[turn]
    np.testing.assert_allclose(otf(mirrored_stage, *other), otf(mirrored_stage, fx, fy), rtol=0, atol=ROUNDING)


def test_elementwise_on_any_shape(stage, frequencies):
    fx, fy = frequencies
    before = fx.copy(), fy.copy()
    whole = otf(stage, fx, fy)
    assert whole.dtype in (np.float64, np.complex128)
    np.testing.assert_array_equal(fx, before[0])
    np.testing.assert_array_equal(fy, before[1])
    np.testing.assert_array_equal(otf(stage, fx.reshape(20, 20), fy.reshape(20, 20)).ravel(), whole)
    for i in range(0, 400, 40):
        assert complex(otf(stage, fx[i], fy[i])) == pytest.approx(whole[i], abs=ROUNDING)


@pytest.mark.parametrize("name", OPTICAL_STAGES | LOPSIDED_STAGES)
def test_lists_are_frequencies_too(name):
    """OLPFs and rectangular photosites ended in “can't multiply sequence”."""
    stage, fx, fy = ALL_STAGES[name], [0.0, 0.05], [0.02, -0.03]
    np.testing.assert_array_equal(stage.otf(fx, fy, WAVELENGTH_NM), otf(stage, fx, fy))


@pytest.mark.parametrize(
    "name", [name for name in ALL_STAGES if not name.startswith("measured")]
)  # between samples waves may dip
def test_the_point_image_is_nowhere_negative(name, rng):
    """Bochner: exactly then the matrix OTF(f_i − f_j) of any frequencies has no eigenvalue below 0."""
    for spread_per_um in (0.05, 0.3, 2.0):
        fx, fy = rng.normal(size=(2, 16)) * spread_per_um
        matrix = otf(ALL_STAGES[name], fx[:, None] - fx, fy[:, None] - fy)
        assert np.linalg.eigvalsh(matrix).min() > -16 * ROUNDING


def test_continuous_at_zero(stage):
    assert abs(otf(stage, 1e-9, 1e-9) - 1.0) < 1e-7


def test_finite_everywhere(stage):
    f = np.array([0.0, 1e-300, 1e-12, 1.0, 1e6, 1e12])
    assert np.isfinite(otf(stage, f[:, None], f)).all()


def test_equal_by_value_and_frozen(stage):
    assert copy.deepcopy(stage) == stage
    assert hash(copy.deepcopy(stage)) == hash(stage)
    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(stage, dataclasses.fields(stage)[0].name, 1.0)


@pytest.mark.parametrize("round_stage", ROUND_STAGES.values(), ids=ROUND_STAGES)
@pytest.mark.parametrize("r_um", [0.4, 2.0, 7.0])
def test_encircled_energy_belongs_to_the_otf(round_stage, r_um):
    """Light within a radius is the OTF summed against the disc's own transform: 2πr ∫ OTF(f)·J1(2πfr) df."""
    cutoff_per_um = round_stage.cutoff_per_um(WAVELENGTH_NM)
    expected, _ = integrate.quad(
        lambda f: 2 * np.pi * r_um * float(otf(round_stage, f * 0.6, f * 0.8)) * special.j1(2 * np.pi * f * r_um),
        0.0,
        cutoff_per_um,
        points=cutoff_per_um * np.arange(0.1, 1.0, 0.1),  # an obstruction's transfer has kinks at some of them
        limit=400,
        epsabs=1e-11,
        epsrel=1e-11,
    )
    energy = float(round_stage.encircled_energy(np.array(r_um), WAVELENGTH_NM))
    assert energy == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("round_stage", ROUND_STAGES.values(), ids=ROUND_STAGES)
def test_encircled_energy_rises_from_0_to_1(round_stage):
    r_um = np.concatenate([[0.0], np.geomspace(1e-6, 1e9, 3000)])
    energy = round_stage.encircled_energy(r_um, WAVELENGTH_NM)
    assert energy[0] == 0.0
    assert np.diff(energy).min() > -ROUNDING
    assert abs(energy[-1] - 1.0) < 1e-8


@pytest.mark.parametrize(("across_um", "down_um", "turn_deg"), [(3.66, None, 0.0), (3.0, 1.0, 20.0), (2.0, 0.0, -65.0)])
def test_the_olpf_is_the_transform_of_its_spots(frequencies, across_um, down_um, turn_deg):
    """Spots as complex numbers x + iy: y points down, so that a factor of e^iθ turns clockwise as displayed."""
    splits = {} if down_um == 0.0 else {"split_y_um": down_um}
    kind = camsim.TwoSpotOlpf if down_um == 0.0 else camsim.FourSpotOlpf
    olpf = kind(split_um=across_um, rotate_deg=turn_deg, **splits)
    sides = np.array([-0.5, 0.5])
    spots = (across_um * sides + 1j * (across_um if down_um is None else down_um) * sides[:, None]).ravel()
    spots = np.unique(spots) * np.exp(1j * np.radians(turn_deg))
    found = olpf.spots_um() @ [1.0, 1j]
    np.testing.assert_allclose(np.abs(found[:, None] - spots).min(axis=0), 0.0, atol=1e-12)
    assert found.size == spots.size
    fx, fy = frequencies
    waves = np.exp(-2j * np.pi * (np.multiply.outer(spots.real, fx) + np.multiply.outer(spots.imag, fy)))
    np.testing.assert_allclose(waves.mean(axis=0), otf(olpf, fx, fy), rtol=0, atol=1e3 * ROUNDING)


def _within(reach, x, y, half_x, half_y):
    """Whether a point is within ``reach`` of a rectangle (or a line, or a point) about the origin."""
    return np.hypot(np.maximum(np.abs(x) - half_x, 0.0), np.maximum(np.abs(y) - half_y, 0.0)) <= reach


INSIDE = {
    "photosite": (lambda x, y: np.maximum(np.abs(x), np.abs(y)) <= 2.44),
    "rectangle": (lambda x, y: (np.abs(x) <= 2.0) & (np.abs(y) <= 1.0)),
    "disc": (lambda x, y: np.hypot(x, y) <= 2.0),
    "rounded rectangle": (lambda x, y: _within(1.5, x, y, 0.5, 0.0)),
    "tile": (lambda x, y: _within(0.5, x, y, 1.5, 1.0)),
    "L": (lambda x, y: (np.maximum(np.abs(x), np.abs(y)) <= 2.0) & ((x <= 0.0) | (y <= 0.0))),
}


@pytest.mark.parametrize("name", INSIDE)
def test_the_photosite_is_the_transform_of_its_area(frequencies, name):
    """The mean of e^(2πi f·a) over the points a on a fine raster that are inside; the area is their number."""
    photosite = ALL_STAGES[name]
    step = 0.01
    a = step * (np.arange(-250, 250) + 0.5)
    inside = INSIDE[name](a, a[:, None])
    fx, fy = frequencies[:, :200]
    along, down = (np.exp(2j * np.pi * np.multiply.outer(f, a)) for f in (fx, fy))
    sums = np.einsum("fy,fy->f", down, along @ inside.T)
    # A cell of the raster is in or out: at an outline of 16 µm that is 1e-2 of 8 µm² at worst, and in the mean nothing.
    np.testing.assert_allclose(sums / np.count_nonzero(inside), otf(photosite, fx, fy), rtol=0, atol=5e-3)
    assert photosite.area_um2 == pytest.approx(np.count_nonzero(inside) * step**2, rel=5e-3)
    reach = [float(np.abs(a[inside.any(axis=axis)]).max()) + 0.5 * step for axis in (0, 1)]
    assert photosite.half_extent_um == pytest.approx(reach, abs=step)


@pytest.mark.parametrize(
    ("name", "least", "most"),
    [
        ("Airy f/8", 0.4, 0.5),
        ("Airy f/1.2", 0.4, 0.5),
        ("annular", 0.4, 0.5),
        ("Gaussian", 0.8, 1.0),
        ("ellipse", 0.1, 1.0),
    ],
)
@pytest.mark.parametrize("lost", [0.03, 1e-3, 1e-5])
def test_the_reach_loses_what_it_may_and_is_not_far_beyond(name, least, most, lost):
    """A diffraction pattern's tail is half of what may be lost (twice its mean is allowed for), a Gaussian's all."""
    stage = ALL_STAGES[name]
    r_um = stage.reach_um(lost, WAVELENGTH_NM) * np.linspace(1.0, 1.02, 2000)
    if name == "ellipse":  # its two axes scaled to a circle: rings of e^(−r²/2), beyond an r that goes with the angle
        angle = np.linspace(0.0, 2 * np.pi, 400, endpoint=False)
        beyond = np.exp(-0.5 * r_um[:, None] ** 2 / np.hypot(2.0 * np.cos(angle), 0.7 * np.sin(angle)) ** 2).mean(
            axis=1
        )
    else:
        beyond = 1.0 - np.asarray(stage.encircled_energy(r_um, WAVELENGTH_NM))
    assert beyond.max() <= lost + ROUNDING
    assert least * lost < beyond.mean() <= most * lost


def test_a_system_takes_its_stages_in_any_order():
    lens, olpf = camsim.Airy(f_number=4.0), camsim.FourSpotOlpf(split_um=2.0)
    photosite = camsim.SquarePhotosite(side_um=4.0)
    assert OpticalSystem.of([photosite, olpf, lens]) == OpticalSystem.of([lens, olpf, photosite])
