"""What is rendered: the paper's square under every point spread function, and by what.

446 × 446 photosites of 4.88 µm, a black square of 250 px turned by 4° on white, at 550 nm unless a spectrum is named.
Errors are taken on a window around the square's left edge, its upper end included: ± 32 px across, 62 rows.
"""

from __future__ import annotations

import fnmatch
import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from camsim.camera.camera import Camera
from camsim.core.arrays import F64
from camsim.errors import UnknownNameError
from camsim.optics import Airy, FourSpotOlpf, Gaussian, OpticalStage, OpticalSystem, SquarePhotosite
from camsim.rendering import Grid, Rendering, render, render_channels
from camsim.rendering.render import plan_render
from camsim.scene import Rectangle, Scene
from camsim.spectra.light import Light

PITCH_UM, SIDE_PX, SIZE, TURN_DEG, WAVELENGTH_NM = 4.88, 250.0, 446, 4.0, 550.0
OLPF_SPLIT_PX = 0.75
WINDOW_ROWS, WINDOW_COLS, WINDOW_ORIGIN = 62, 64, (87, 72)
MTF50S = (0.10, 0.15, 0.20, 0.25, 0.30, 0.35, 0.40)
F_NUMBERS = (2.8, 4.0, 5.6, 8.0, 11.0, 16.0, 22.0, 32.0)
SHIFTS = 25
FEW_SHIFTS = (3, 5)  # of other programs and quick runs; of what takes long
FINE = 0.9e-6  # tolerances below this take long
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 3e-7, 1e-7, 1e-8)  # 3e-7 for an error that 1e-6 misses by little
FEW_TOLERANCES = (1e-2, 1e-4, 1e-6, 1e-8)
BEYOND = 1e-10  # for a quick run: closed forms refuse it
EXACT = ("auto", "boundary", "fourier")
IMPORTANCE = (121, 2025, 40401)  # samples; the last on an Airy pattern alone, elsewhere it shows the same for longer
SAMPLED: dict[str, tuple[int | None, ...]] = {
    "area": (None,),
    "uniform-pixel": (None,),
    "uniform": (None,),
    "importance": IMPORTANCE,
    "strips": (None,),
}
METHODS = (*EXACT, *SAMPLED)


@dataclass(frozen=True, slots=True, kw_only=True)
class Psf:
    """One system in front of the square.

    name, label : for options and for people
    mtf50       : of a Gaussian lens, cycles per pixel; None: an Airy pattern
    f_number    : of an Airy lens
    side_px     : of the square photosite; 0 is a point
    split_px    : of the OLPF; 0: none
    green       : the light of a D40-like camera's green filter under D55 instead of one wavelength
    """

    name: str
    label: str
    mtf50: float | None = None
    f_number: float = 8.0
    side_px: float = 0.0
    split_px: float = 0.0
    green: bool = False

    @property
    def gaussian(self) -> bool:
        """Whether the lens is a Gaussian."""
        return self.mtf50 is not None

    def stages(self, lap: int = 0) -> list[OpticalStage]:
        """Return the optical stages; another ``lap`` is a lens that no cache has seen, the same to 1e-11."""
        fresh = 1.0 + lap * 1e-11
        lens: OpticalStage
        if self.mtf50 is not None:
            lens = Gaussian.from_mtf50(self.mtf50 / PITCH_UM * fresh)
        else:
            lens = Airy(f_number=self.f_number * fresh)
        stages: list[OpticalStage] = [lens, SquarePhotosite(side_um=self.side_px * PITCH_UM)]
        if self.split_px:
            stages.append(FourSpotOlpf(split_um=self.split_px * PITCH_UM))
        return stages

    def spectrum(self) -> tuple[F64, F64]:
        """Return wavelengths (n,) in nm and their weights (n,), which add up to 1."""
        return _green() if self.green else (np.array([WAVELENGTH_NM]), np.ones(1))

    def same_lens(self, other: Psf) -> bool:
        """Whether the other system differs by its photosite and OLPF only."""
        return (self.mtf50, self.f_number, self.green) == (other.mtf50, other.f_number, other.green)

    def blurs_px(self) -> F64:
        """Return the lens's own length (λN or σ) at each wavelength, in pitches."""
        lens = OpticalSystem.of(self.stages()).lens
        return np.array([lens.blur_um(w) for w in self.spectrum()[0]]) / PITCH_UM


@functools.lru_cache(maxsize=1)
def _green() -> tuple[F64, F64]:
    """Wavelengths and weights of the D40-like camera's green channel under D55."""
    camera = Camera.from_yaml("d40-like", lens=Airy(f_number=8.0))
    samples = camera.samples(Light("D55", illuminance_lux=1000.0))
    response = camera.electrons_per_reflectance(samples, 1.0)[camera.cfa.channels.index("G")]
    seen = response > 0.0
    return samples.wavelength_nm[seen], response[seen] / response.sum()


def _psfs() -> tuple[Psf, ...]:
    found = [Psf(name=f"gaussian-{m:.2f}", label=f"Gaussian, MTF50 {m:.2f} c/px", mtf50=m) for m in MTF50S]
    for suffix, words, side, split in (
        ("", "", 0.0, 0.0),
        ("-box", " + photosite", 1.0, 0.0),
        ("-box-olpf", " + photosite + OLPF", 1.0, OLPF_SPLIT_PX),
    ):
        found += [
            Psf(name=f"airy-f{n:g}{suffix}", label=f"Airy f/{n:g}{words}", f_number=n, side_px=side, split_px=split)
            for n in F_NUMBERS
        ]
    found.append(
        Psf(
            name="bayer-green",
            label="Airy f/8 + photosite + OLPF, Bayer green",
            side_px=1.0,
            split_px=OLPF_SPLIT_PX,
            green=True,
        )
    )
    return tuple(found)


PSF_HINT = "; patterns such as 'airy-f8*', 'gaussian-*' and '*-olpf' name several"
PSFS = {psf.name: psf for psf in _psfs()}
# All tolerances here, few elsewhere; everything is clocked here, ``auto`` elsewhere.
CORE_PSFS = (
    *("airy-f8-box", "airy-f8-box-olpf", "gaussian-0.25", "bayer-green", "airy-f2.8-box", "airy-f32-box"),
    *("gaussian-0.10", "gaussian-0.40", "airy-f8"),
)
CLOCKED_PSFS = ("gaussian-0.25", "airy-f8", "airy-f8-box", "airy-f8-box-olpf")
QUICK_PSFS = ("gaussian-0.25", "airy-f8-box", "airy-f8-box-olpf")
PAPER_TABLES = {
    "I": tuple(name for name in PSFS if name.startswith("gaussian")),
    "III": tuple(f"airy-f{n:g}" for n in F_NUMBERS),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """One program's method with its one knob.

    method    : of camsim, or what another program's knob is called
    tolerance : of an exact engine;  samples: of ``importance``;  knob: of another program
    """

    program: str = "camsim"
    method: str
    tolerance: float | None = None
    samples: int | None = None
    knob: float | None = None

    @property
    def label(self) -> str:
        """The method and its knob in words."""
        if self.tolerance is not None:
            return f"{self.method} {self.tolerance:.0e}".replace("e-0", "e-")
        if self.samples is not None:
            return f"{self.method}, {self.samples} samples"
        return self.method if self.knob is None else f"{self.program}, {self.method} {self.knob:g}"


def settings_of(psf: Psf, methods: Sequence[str], *, quick: bool = False) -> list[Setting]:
    """Return the settings that make sense for a system: tolerances, or numbers of samples."""
    settings = []
    for method in methods:
        if method in EXACT:
            few = (*FEW_TOLERANCES, BEYOND) if quick else FEW_TOLERANCES
            tolerances = TOLERANCES if psf.name in CORE_PSFS and not quick else few
            settings += [Setting(method=method, tolerance=tolerance) for tolerance in tolerances]
        elif not psf.green and not (method == "strips" and (not psf.gaussian or psf.side_px)):
            bare = not psf.gaussian and psf.side_px == 0.0
            most = IMPORTANCE[0 if quick else 2 if bare else 1]
            settings += [Setting(method=method, samples=n) for n in SAMPLED[method] if (n or 0) <= most]
    return settings


def is_timed(psf: Psf, setting: Setting, *, quick: bool = False) -> bool:
    """Whether the frame is clocked: everything on the core systems, ``auto`` on all.

    Sampling takes as long with every lens: one of each kind does for its long settings, one of all in a quick run.
    """
    if quick and setting.method in SAMPLED and setting.method != "strips":
        return psf.name == QUICK_PSFS[1]
    if (setting.samples or 0) > IMPORTANCE[0]:
        return psf.name in CLOCKED_PSFS
    return setting.method == "auto" or psf.name in CORE_PSFS


def shift_count(setting: Setting, *, quick: bool = False) -> int:
    """Return how many of the 25 shifts errors are taken over; always the same for a setting."""
    if setting.program != "camsim":
        return 1 if setting.program == "prysm" else FEW_SHIFTS[0]
    if quick:
        return FEW_SHIFTS[0]
    long = setting.samples in IMPORTANCE[1:] or (setting.tolerance or 1.0) < FINE
    return FEW_SHIFTS[1] if long else SHIFTS


def chosen_psfs(patterns: Sequence[str], *, quick: bool = False) -> list[Psf]:
    """Return the systems that the patterns (names, or ``airy-f8*``) name; all, or the quick ones, without any."""
    if not patterns:
        # The core ones first: a run that is interrupted has them.
        return [PSFS[name] for name in (QUICK_PSFS if quick else dict.fromkeys((*CORE_PSFS, *PSFS)))]
    names: dict[str, None] = {}
    for pattern in patterns:
        found = fnmatch.filter(PSFS, pattern)
        if not found:
            raise UnknownNameError("psf", pattern, PSFS, hint=PSF_HINT)
        names.update(dict.fromkeys(found))
    return [PSFS[name] for name in names]


def chosen_methods(names: Sequence[str]) -> list[str]:
    """Return the methods named, or all."""
    for name in names:
        if name not in METHODS:
            raise UnknownNameError("method", name, METHODS)
    return [name for name in METHODS if not names or name in names]


def shifts_px(count: int) -> F64:
    """Return ``count`` of the 25 displacements (x, y) of the square, along the edge's normal, within ± half a pixel."""
    along = (np.arange(SHIFTS) + 0.5) / SHIFTS - 0.5
    along = along[np.round(np.linspace(0, SHIFTS - 1, count)).astype(int) if count > 1 else [SHIFTS // 2]]
    turn = math.radians(TURN_DEG)
    return np.stack([along * math.cos(turn), along * math.sin(turn)], axis=1)


def corners_px() -> F64:
    """Return the square's corners (4, 2) about its centre, in pitches, positive shoelace area."""
    turn, half = math.radians(TURN_DEG), 0.5 * SIDE_PX
    across = half * np.array([math.cos(turn), math.sin(turn)])
    down = half * np.array([-math.sin(turn), math.cos(turn)])
    return np.array([-across - down, across - down, across + down, -across + down])


def edge_distance_px() -> F64:
    """Return each of the window's photosites' distance (rows, cols) from the unshifted left edge, inside positive."""
    turn, (x0, y0) = math.radians(TURN_DEG), window().first_centre
    x, y = np.meshgrid(x0 + np.arange(WINDOW_COLS), y0 + np.arange(WINDOW_ROWS))
    distance: F64 = x * math.cos(turn) + y * math.sin(turn) + 0.5 * SIDE_PX
    return distance


def square(shift_px: Sequence[float] | F64 = (0.0, 0.0)) -> Scene:
    """Return the scene."""
    side = SIDE_PX * PITCH_UM
    centre = (float(shift_px[0]) * PITCH_UM, float(shift_px[1]) * PITCH_UM)
    black = Rectangle(width_um=side, height_um=side, rotate_deg=TURN_DEG, centre_um=centre, reflectance=0.0)
    return Scene(background=1.0, shapes=[black])


def frame() -> Grid:
    """Return the whole frame, which is timed."""
    return Grid(rows=SIZE, cols=SIZE, pitch_um=PITCH_UM)


def window() -> Grid:
    """Return the photosites on which errors are taken."""
    return Grid(rows=WINDOW_ROWS, cols=WINDOW_COLS, pitch_um=PITCH_UM, origin=WINDOW_ORIGIN, frame=(SIZE, SIZE))


def one_photosite() -> Grid:
    """Return a single photosite beside the edge: to render it takes the set-up, the check and next to nothing else."""
    row, col = WINDOW_ORIGIN[0] + WINDOW_ROWS // 2, WINDOW_ORIGIN[1] + WINDOW_COLS // 2
    return Grid(rows=1, cols=1, pitch_um=PITCH_UM, origin=(row, col), frame=(SIZE, SIZE))


@functools.cache
def expected_s(psf: Psf, setting: Setting) -> float:
    """Return the seconds of one core that an exact method is expected to take for the frame; 0 for sampling."""
    if setting.tolerance is None:
        return 0.0
    wavelength_nm, weights = psf.spectrum() if psf.green else (np.array([WAVELENGTH_NM]), np.ones(1))
    choice = plan_render(
        square((0.0, 0.0)),
        OpticalSystem.of(psf.stages(0)),
        frame(),
        response=weights[None],
        wavelength_nm=wavelength_nm,
        tolerance=setting.tolerance,
        method=setting.method,
    )
    return choice.cost.seconds


def rendered(
    psf: Psf, setting: Setting, grid: Grid, *, shift_px: Sequence[float] | F64 = (0.0, 0.0), lap: int = 0
) -> Rendering:
    """Render the square; a system of several wavelengths as one channel of a mosaic would be."""
    how: dict[str, float | int | str | None] = {"method": setting.method}
    if setting.tolerance is not None:
        how["tolerance"] = setting.tolerance
    if setting.samples is not None:
        how["samples"] = setting.samples
    scene, stages = square(shift_px), psf.stages(lap)
    if not psf.green:
        return render(scene, stages, grid, wavelength_nm=WAVELENGTH_NM, **how)  # type: ignore[arg-type]
    wavelength_nm, weights = psf.spectrum()
    return render_channels(
        scene,
        OpticalSystem.of(stages),
        grid,
        response=weights[None],
        wavelength_nm=wavelength_nm,
        channel=np.zeros((grid.rows, grid.cols), np.uint8),
        **{"tolerance": 1e-6, **how},  # type: ignore[arg-type]
    )
