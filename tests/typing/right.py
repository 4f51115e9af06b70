"""Right uses of camsim, one a line: type checkers take all of them, and they run."""

import pathlib
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

import camsim

A = np.array([400.0, 700.0])
F, G, N, B = np.float32(4), np.float16(0.5), np.int64(4), np.bool_(True)
F_UM = [F, F]


@dataclass(frozen=True)
class Haze:
    """A blur of one's own."""

    sigma_um: float

    def otf(
        self, fx_per_um: npt.NDArray[np.float64], fy_per_um: npt.NDArray[np.float64], wavelength_nm: float
    ) -> npt.NDArray[np.float64]:
        return np.asarray(np.exp(-2.0 * (np.pi * self.sigma_um) ** 2 * (fx_per_um**2 + fy_per_um**2)))


@dataclass(frozen=True)
class Pedestal(camsim.ElectronicStage):
    """An electronic stage of one's own."""

    name: ClassVar[str] = "pedestal"

    level_e: float

    def apply(self, electrons: npt.NDArray[np.float64], context: camsim.Context) -> npt.NDArray[np.float64]:
        return electrons + self.level_e


flat = camsim.Curve([400, 700], [1, 1], outside="hold")
from_arrays = camsim.Curve(A, A / 1000.0)
lens = camsim.Airy(f_number=np.float64(8))
mirror = camsim.AnnularAiry(f_number=8, obstruction=0.3, transmission=camsim.Curve(A, (0.5, 0.9)))
coma = camsim.Wavefront(f_number=4, zernike_waves={4: 0.1, 7: -0.05}, pupil=camsim.Pupil(shape="bladed", blades=5))
pairs = camsim.Wavefront(f_number=4, zernike_waves=[(4, 0.1), (7, -0.05)])
measured = camsim.MeasuredPsf(irradiance=np.ones((3, 3)), spacing_um=1)
transfer = camsim.MeasuredOtf(values=np.pad([[1.0 + 0j]], 1), spacing_per_um=0.1)
ellipse = camsim.EllipticalGaussian.from_axes(sigma_um=2, sigma_across_um=1, rotate_deg=30)
olpf = camsim.FourSpotOlpf.from_pitches(pitch_um=4.0, split_pitches=0.75)
plate = camsim.TwoSpotOlpf(split_um=3, rotate_deg=45)
photosite = camsim.SquarePhotosite.from_fill_factor(pitch_um=4.0, fill_factor=0.5)
triangle = camsim.Polygon(points_um=np.array([[0, 0], [9, 0], [0, 9]]), reflectance=camsim.reflectance("orange"))
disc = camsim.Disc(radius_um=3, centre_um=[1, 2], reflectance=0.1)
scene = camsim.Scene(background=0.5, shapes=[triangle, disc, camsim.Rectangle(width_um=1, height_um=2, reflectance=0)])
shipped = camsim.Scene.from_yaml(
    "slanted-edge", overrides=["scene.background.reflectance=0.4"], sensors=[pathlib.Path()]
)
light = camsim.Light("D55", illuminance_lux=5000)
table = camsim.Light(camsim.Curve(A, A), irradiance_w_per_m2=0.5, at="sensor")
exposure = camsim.Exposure(time_s="auto", iso=100)
efficiency = camsim.QuantumEfficiency([("Y", flat)], per="photon", peak=0.5)
adc = camsim.Adc(bit_depth=12, black_level_dn=100, electrons_per_dn=2, base_iso=100, black_offsets_dn=[[0, 1], [1, 0]])
region = camsim.Region(rows=8, cols=8, origin=(0, 0))
body = camsim.Camera.from_yaml("mono-345", lens=mirror)
camera = body.replace(rows=20, cols=20, pitch_um=4, photosite=photosite, cfa=camsim.Cfa.mono(), adc=adc)
seeing = camera.replace(quantum_efficiency=efficiency, lens=lens)
noisy = camera.replace(read_noise=camsim.ReadNoise(3), prnu=camsim.Prnu(0.01), defects=camsim.Defects(hot=[(1, 2, 3)]))
bare = camera.replace(olpf=None, filters=[0.5, camsim.Curve(A, A / 1000.0, outside="hold")], name="bare", pitch_um=5)
one = camera.replace(extra_stages=[Pedestal(5.0)], extra_optics=[Haze(1.0)])
frame = camera.expose(scene, light=light, exposure=exposure, region=region, tolerance=1e-2, products={"truth"})
numbers: npt.NDArray[np.uint16] = frame.mosaic
truth: npt.NDArray[np.float32] | None = frame.truth
picture: npt.NDArray[np.uint8] = frame.preview()
notes: tuple[camsim.Note, ...] = frame.report.notes
both = camera.expose(scene, light=light, exposure=exposure, tolerance=1e-2, products=("mosaic", "truth"))
frame.save(pathlib.Path("right.tiff"), force=True)
camsim.save(frame, "right.npy", product="electrons", force=True)
capture: camsim.Capture = camsim.load("slanted-edge", sensor="mono-345", overrides=["exposure.iso=800"], seed=7)
method: str = capture.plan().method
taken = camsim.capture(pathlib.Path("slanted-edge"), overrides=("region={rows: 8, cols: 8}", "render.tolerance=1e-2"))
grid = camsim.Grid(rows=4, cols=4, pitch_um=4)
image = camsim.render(scene, [lens, olpf, photosite, Haze(1.0)], grid, wavelength_nm=550, tolerance=1e-2).image
sampled = camsim.render(scene, [lens, photosite], grid, wavelength_nm=[500], method="uniform", tolerance=1e-2).image
edges = camsim.measure.picture_of_frame(frame).planes
x: float = flat.wavelength_nm[0]
kernel = camsim.Crosstalk(np.eye(3) / 3)
corner = camsim.RadialFalloff(radius_mm=[0, 1], values=[1.0, 0.5])
bent = camsim.PolynomialResponse([0.1], 1e4)
read_out = camsim.ResponseTable(A - 400.0, [0, 2])
cfa = camsim.Cfa(["RG", "GB"])
triangle_photosite = camsim.PolygonPhotosite(points_um=[[0, 0], [1, 0], [0, 1]])
round_lens: camsim.Lens = camsim.RadialOtf(freq_per_um=A - 400.0, values=[1, 0]) if not len(A) else lens
# NumPy's numbers, in an argument of every type that takes numbers
airy_n = camsim.Airy(f_number=F, transmission=G)
mtf50_n = camsim.Gaussian.from_mtf50(G)
elliptical_n = camsim.EllipticalGaussian(covariance_um2=((F, G), (G, F)), f_number=N)
axes_n = camsim.EllipticalGaussian.from_axes(sigma_um=F, sigma_across_um=G, rotate_deg=N, f_number=F, transmission=G)
field_n = camsim.FieldLens(
    f_number=F, wavelength_nm=[np.float32(550)], zernike=[N], waves=np.full((1, 2, 1), G), height_um=[N - 4, F]
)
psf_n = camsim.MeasuredPsf(irradiance=[[F, F], [F, F]], spacing_um=G, f_number=N)
indexed_n = camsim.Wavefront(f_number=F, zernike_waves=[(N, G), (np.uint8(7), G)])
four_n = camsim.FourSpotOlpf(split_um=F, split_y_um=G, rotate_deg=N)
four_pitches_n = camsim.FourSpotOlpf.from_pitches(pitch_um=F, split_pitches=G, split_y_pitches=G, rotate_deg=N)
two_pitches_n = camsim.TwoSpotOlpf.from_pitches(pitch_um=F, split_pitches=G, rotate_deg=N)
square_n = camsim.SquarePhotosite(side_um=F)
fill_n = camsim.SquarePhotosite.from_fill_factor(pitch_um=F, fill_factor=G)
grid_n = camsim.Grid(rows=N, cols=N, pitch_um=F, origin=(N, N), frame=(np.int16(20), np.int16(20)))
region_n = camsim.Region(rows=N, cols=N, origin=(N, N))
polygon_n = camsim.Polygon(
    points_um=[(N - 4, N - 4), (F, N - 4), [N - 4, F]], holes_um=[[(G, G), (G + G, G), (G, G + G)]], reflectance=G
)
disc_n = camsim.Disc(radius_um=F, centre_um=F_UM, reflectance=G)
path_n = camsim.Path(segments_um=[["move", N, N], ["line", F, G], ["line", G, F], ["close"]], reflectance=G)
group_n = camsim.Group(shapes=[disc_n], scale=(F, G), turn_deg=N, move_um=F_UM)
matrix_n = camsim.Group(shapes=[disc_n], matrix=[F, 0, 0, F, G, N])
on_ring_n = camsim.RepeatOnRing(shapes=[disc_n], count=N, centre_um=F_UM, upright=B)
scene_n = camsim.Scene(background=G, shapes=(disc_n,))
light_n = camsim.Light(line_nm=np.float32(550), width_nm=F, illuminance_lux=F)
exposure_n = camsim.Exposure(time_s=G, iso=np.int64(100), temperature_c=F)
adc_n = camsim.Adc(
    bit_depth=np.uint8(12),
    black_level_dn=N,
    electrons_per_dn=F,
    base_iso=np.int64(100),
    black_offsets_dn=[[N - 4, N]],
    gain_at_iso=[(F, G)],
)
companded_n = camsim.Adc(
    bit_depth=12, black_level_dn=N, electrons_per_dn=F, base_iso=100, companding=[(N - 4, N - 4), (np.int16(4095), N)]
)
efficiency_n = camsim.QuantumEfficiency([("Y", flat)], "photon", peak=G)
quad_n = camsim.Cfa.quad_bayer("RGGB", N)
defects_n = camsim.Defects(hot_fraction=G, hot_e_per_s=F, dead_fraction=G, hot=[(N, N, F)], dead=[(N, np.int16(5))])
capacitance_n = camsim.ResetNoise.of_capacitance(F, temperature_c=N)
camera_n = body.replace(
    rows=np.int64(20), cols=np.int64(20), pitch_um=np.float32(5), serial=N, magnification=G, filters=[G]
)
sensor_n = camsim.Sensor(
    rows=np.int64(20),
    cols=np.int64(20),
    pitch_um=F,
    serial=N,
    photosite=square_n,
    cfa=camsim.Cfa.mono(),
    quantum_efficiency=efficiency,
    adc=adc,
    filters=[G],
)
given_n = camsim.GivenLight(
    samples=np.ones((4, 4, 1)), unit="photons", wavelength_nm=[np.float32(550)], per_photosite=np.int64(1)
)
shot_n = sensor_n.expose(given_n, exposure=exposure_n, region=camsim.Region(N, N), seed=N, noise=B)
array_n = sensor_n.expose(np.ones((4, 4)), unit="electrons", exposure=exposure_n, per_photosite=np.int64(1))
noise_n = camsim.Noise(sensor_n, iso=F, time_s=G, temperature_c=N)(np.ones((4, 4)), N)
frame_n = body.expose(
    scene_n, light=light_n, exposure=exposure_n, region=region_n, seed=N, tolerance=np.float32(1e-2), noise=B
)
loaded_n = camsim.load("slanted-edge", seed=N)
rendered_n = camsim.render(scene, [lens], grid_n, wavelength_nm=np.float32(550), tolerance=np.float64(1e-2)).image
kept_f_number: float = airy_n.f_number
kept_rows: int = region_n.rows
kept_level: float | None = light_n.illuminance_lux
