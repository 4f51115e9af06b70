"""Right uses of camsim, one a line: type checkers take all of them, and they run."""

import pathlib
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

import camsim

A = np.array([400.0, 700.0])


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
own = camera.replace(extra_stages=[Pedestal(5.0)], extra_optics=[Haze(1.0)])
frame = camera.expose(scene, light=light, exposure=exposure, region=region, tolerance=1e-2, products={"truth"})
numbers: npt.NDArray[np.uint16] = frame.mosaic
truth: npt.NDArray[np.float32] | None = frame.truth
picture: npt.NDArray[np.uint8] = frame.preview()
notes: tuple[str, ...] = frame.report.notes
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
read_out = camsim.ResponseTable(A, [1, 2])
cfa = camsim.Cfa(["RG", "GB"])
triangle_photosite = camsim.PolygonPhotosite(points_um=[[0, 0], [1, 0], [0, 1]])
round_lens: camsim.Lens = camsim.RadialOtf(freq_per_um=A - 400.0, values=[1, 0]) if not len(A) else lens
