"""The pipeline: scene, light and exposure through a camera's stages into a Frame."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, TypeAlias

import numpy as np
from annotated_types import Ge, Le

from camsim.camera.body import Body
from camsim.camera.description import OF_A_FRAME
from camsim.camera.frame import Frame, Products, Report, check_products, frame_numbers
from camsim.camera.notes import Setting, notes_after, notes_before
from camsim.camera.optical_image import OpticalImage, key_of
from camsim.camera.recording import Recording
from camsim.camera.reporting import Clock, Signals, accuracy_notes, rounding_notes, wavelengths
from camsim.camera.row_batches import RowBatches
from camsim.camera.window import Region
from camsim.core.annotations import Called
from camsim.core.arrays import F64, U16, read_only
from camsim.core.cached import cached_property
from camsim.core.memory import needed_bytes, too_large
from camsim.core.note import Note
from camsim.core.typed import FrameNumber, Number, Positive, Seed, Several, Truth, Whole, check, refusal, validate
from camsim.core.words import brief
from camsim.errors import InvalidValueError
from camsim.optics.no_lens import NoLens
from camsim.rendering import Rendering
from camsim.rendering.auto import Choice
from camsim.rendering.cube import MOST_PLANES, SpectralCube, radiance_cube
from camsim.rendering.render import plan_render
from camsim.rendering.running import carry_out
from camsim.scene import Scene
from camsim.sensor.colour_matrix import MatrixOf
from camsim.sensor.exposure import Exposure
from camsim.sensor.streams import BLOCK_ROWS
from camsim.spectra.light import Light, LightSamples

Progress = Callable[[str, float], None]
Method: TypeAlias = Literal["auto", "boundary", "fourier"]


@dataclass(frozen=True, kw_only=True)
class Capture(Recording):
    """Everything that makes a picture, and the pipeline from scene to codes.

    camera, scene, light, exposure : the camera, and what it photographs
    seed, frame_number : determine the temporal noise; fixed patterns do not depend on them
    noise         : False leaves out all noise and the dark current
    region, scene_name : a window of the frame, None for all of it; for the report
    tolerance, strict : of the optics, relative to a perfect diffuser or the brightest surface; True raises if missed
    method        : "auto", "boundary" or "fourier", see ``camsim.render``
    colour_matrix : the matrices written to files: "standard" (illuminants A and D65) or "scene" (this light)
    spectral_nm   : wavelengths of "spectral"; None: 400 to 700 nm every 10, or the line of monochromatic light

    >>> from camsim import load
    >>> [frame.shape for frame in load("flat-field", overrides=["region={rows: 4, cols: 6}"]).frames(2)]
    [(4, 6), (4, 6)]
    """

    made_of: ClassVar = OF_A_FRAME

    camera: Annotated[Body, Called("a Camera", "Camera.from_yaml of a sensor makes one")]
    scene: Scene
    light: Annotated[Light, Called("a Light", "such as Light('D55', illuminance_lux=1000)")]
    exposure: Annotated[Exposure, Called("an Exposure", "such as Exposure(time_s=0.01, iso=200)")]
    seed: Seed = 0
    frame_number: FrameNumber = 0
    region: Region | None = None
    tolerance: Annotated[float, Ge(1e-11), Le(1e-2)] = 1e-6
    method: Method = "auto"
    strict: bool = False
    noise: bool = True
    colour_matrix: MatrixOf = "standard"
    spectral_nm: Several[Positive] | None = None
    scene_name: str = "scene"

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            camera: Body,
            scene: Scene,
            light: Light,
            exposure: Exposure,
            seed: Whole = 0,
            frame_number: Whole = 0,
            region: Region | None = None,
            tolerance: Number = 1e-06,
            method: Method = "auto",
            strict: Truth = False,
            noise: Truth = True,
            colour_matrix: MatrixOf = "standard",
            spectral_nm: Several[Number] | None = None,
            scene_name: str = "scene",
        ) -> None: ...

    __repr__ = brief

    def __post_init__(self) -> None:
        validate(self)
        if isinstance(self.camera.lens, NoLens):
            message = "has no lens, through which a scene is seen; give one of Camera.from_yaml(…, lens=…)"
            raise refusal(self, "camera", message)
        nodes_nm = self.spectral_nm
        if nodes_nm is not None and not 1 <= len(nodes_nm) <= MOST_PLANES:
            raise refusal(self, "spectral_nm", f"{len(nodes_nm)} wavelengths; give 1 to {MOST_PLANES}")
        if nodes_nm is not None and any(after <= before for before, after in pairwise(nodes_nm)):
            raise refusal(self, "spectral_nm", "wavelengths must increase, each given once")
        self.camera.grid(self.region)  # raises for a window that exceeds the frame
        object.__setattr__(self, "camera", self.camera.with_ends(self.light))

    @cached_property
    def samples(self) -> LightSamples:
        """The light, of 1 W/m², at quadrature nodes that resolve every curve of camera and scene."""
        return self.camera.samples(self.light.of_one_watt, self.scene.spectra)

    @cached_property
    def radiant_exposure_j_per_m2(self) -> float:
        """Radiant exposure: the only effect that light level and exposure time have on the optical image."""
        exposure_j_per_m2 = self.light.total_w_per_m2 * self.time_s
        if not math.isfinite(exposure_j_per_m2):
            raise InvalidValueError("the light is not finite; give less light, or a shorter exposure", key="light")
        return exposure_j_per_m2

    @cached_property
    def optical_key(self) -> str:
        """Key of everything that determines the optical image; captures with equal keys can share an image."""
        camera, how = self.camera, (self.tolerance, self.method, self.strict)
        response = camera.image_per_reflectance(self.samples)
        return key_of(
            self.exposed_scene, camera.optics.stages, self.window.wide, camera.cfa, response, self.samples, how
        )

    @cached_property
    def exposed_scene(self) -> Scene:
        """The scene, with points given in electrons converted to intensities."""
        full_e = self.camera.electrons_per_reflectance(self.samples, self.radiant_exposure_j_per_m2)
        return self.scene.exposed(self.samples.wavelength_nm, full_e)

    @cached_property
    def veil_e(self) -> F64:
        """(channels,) electrons that veiling glare adds to a photosite on the axis."""
        return self.radiant_exposure_j_per_m2 * self.camera.veil_of(self.exposed_scene, self.samples, self.tolerance)

    def plan(self) -> Choice:
        """Return the rendering method that will be used, without rendering; lights are in electrons per J/m²."""
        return plan_render(
            self.exposed_scene, self.camera.optics, self.window.wide,
            response=self.camera.image_per_reflectance(self.samples), wavelength_nm=self.samples.wavelength_nm,
            tolerance=self.tolerance, method=self.method,
        )  # fmt: skip

    def notes(self, choice: Choice, products: Products = ("mosaic",)) -> tuple[Note, ...]:
        """Return notes on unexpected results that are predictable before rendering; ``choice``: from ``plan``."""
        setting = Setting(
            camera=self.camera, scene=self.scene, light=self.light, exposure=self.exposure, time_s=self.time_s,
            veil_e=self.veil_e, noise=self.noise, mean_wanted="truth" in products,
        )  # fmt: skip
        return tuple(notes_before(setting, choice))

    def frame(self, *, products: Products = ("mosaic",), progress: Progress | None = None) -> Frame:
        """Take the picture.

        products : "truth" fills ``Frame.truth``, "spectral" ``Frame.spectral``; everything else is always present
        progress : called with (stage, fraction done)
        """
        return next(self.frames(products=products, progress=progress))

    def optical_image(self, *, products: Products = ("mosaic",), progress: Progress | None = None) -> OpticalImage:
        """Render the optical image, for captures that share scene and optics."""
        choice, rendering = self._seen(products, progress)
        return OpticalImage(choice=choice, rendering=rendering, key=self.optical_key)

    def _seen(self, products: Products, progress: Progress | None) -> tuple[Choice, Rendering]:
        choice, channels, truth = self.plan(), self.window.channels_of_all(), "truth" in products
        return choice, carry_out(choice, channels, every_channel=truth, strict=self.strict, progress=progress)

    def frames(
        self,
        count: Whole = 1,
        *,
        products: Products = ("mosaic",),
        progress: Progress | None = None,
        optical_image: OpticalImage | None = None,
    ) -> Iterator[Frame]:
        """Yield pictures of one scene, rendered once, with frame numbers from ``frame_number`` on.

        Each frame reports its own seconds; the first includes light and rendering. Arrays shared by several frames
        (``mean_electrons``, ``truth``, ``channel_index``) are read-only: copy them to modify them.
        optical_image : image of a capture with the same ``optical_key``, else an error is raised; None: rendered here
        """
        check_products(products)
        if given := check(optical_image, OpticalImage | None, "optical_image"):
            given.refuse_for(self.optical_key, every_channel="truth" in products)
        numbers = frame_numbers(self.frame_number, count)
        rows, cols = self.grid.rows, self.grid.cols
        if message := too_large(rows, cols, needed_bytes(rows, cols, len(self.camera.cfa.channels), products)):
            raise refusal(self, "region", f"{message}; expose a smaller region")
        clock = Clock()
        cube = self._cube(products)
        clock.lap("light")
        choice, rendering = (given.choice, given.rendering) if given else self._seen(products, progress)
        in_place = given is None  # rendered here, so it may be overwritten: saves a copy of a large frame
        exposed = self.window.exposed(self._exposed(rendering.image, in_place=in_place), self.veil_e, 0)
        planes = None if rendering.planes is None else self._exposed(rendering.planes, in_place=in_place)
        truth = self.window.truth(planes, self.veil_e, exposed.displayed_e)
        if count > 1:  # frames share the array: a change in one would alter the next
            read_only(exposed.mean_e, exposed.displayed_e, exposed.channel, truth)
        diffuser_e = self.camera.diffuser_electrons(self.light, self.time_s)
        notes = *self.notes(choice, products), *rounding_notes(truth, diffuser_e, self.tolerance)
        clock.lap("render")
        for frame_number in numbers:
            signals = self._signals()
            recorded_e, codes = self._recorded(exposed, frame_number, clock, signals)
            yield self._frame(
                mosaic=codes, electrons=recorded_e, mean_electrons=exposed.displayed_e, truth=truth, spectral=cube,
                channel_index=exposed.channel, frame_number=frame_number,
                report=self._report(rendering, clock, signals, notes),
            )  # fmt: skip
            clock = Clock()

    def rows(
        self,
        take: Callable[[U16], None],
        *,
        products: Products = ("mosaic",),
        progress: Progress | None = None,
    ) -> Frame:
        """Take a picture without holding it in memory: ``take`` receives bands of codes (m, cols) in order.

        Bands come from the top; the codes equal those of ``frame``. The returned frame holds metadata and no arrays of
        photosites. Blooming needs all rows at once, so with it the window is held in memory.
        """
        check_products(products, streamed=True)
        check(take, Callable[[U16], None], "take")
        clock = Clock()
        choice, cube = self.plan(), self._cube(products)
        clock.lap("light")
        signals, passed = self._signals(), 0

        def record_rows(image: F64) -> None:
            nonlocal passed
            exposed = self.window.exposed(self._exposed(image, in_place=True), self.veil_e, passed)
            clock.lap("render")
            _, codes = self._recorded(exposed, self.frame_number, clock, signals)
            take(codes)
            clock.lap("write")
            passed += len(codes)

        # Noise is drawn in blocks of rows; blooming needs all rows at once.
        together = self.grid.rows if self.camera.needs_whole_window else BLOCK_ROWS
        batches = RowBatches(record_rows, together=together, overlap=self.window.wide.rows - self.grid.rows)
        rendering = carry_out(
            choice, self.window.channels_of_all(), take=batches.add, strict=self.strict, progress=progress
        )
        batches.finish()
        none = np.empty((0, self.grid.cols))
        return self._frame(
            mosaic=none.astype(np.uint16), electrons=none, mean_electrons=none, truth=None, spectral=cube,
            channel_index=none.astype(np.uint8), passed_rows=passed, frame_number=self.frame_number,
            report=self._report(rendering, clock, signals, self.notes(choice, products)),
        )  # fmt: skip

    def _exposed(self, image: F64, *, in_place: bool) -> F64:
        """Return electrons from electrons per J/m²; ``in_place``: written over the image."""
        return np.multiply(image, self.radiant_exposure_j_per_m2, out=image if in_place else None)

    def _cube(self, products: Products) -> SpectralCube | None:
        if "spectral" not in products:
            return None
        return radiance_cube(
            self.exposed_scene, self.camera.optics, self.grid, light=self.light, veil=self.camera.veil,
            wavelength_nm=None if self.spectral_nm is None else tuple(self.spectral_nm),
            tolerance=self.tolerance, method=self.method, strict=self.strict,
        )  # fmt: skip

    @cached_property
    def _steps_e(self) -> tuple[float, ...]:
        return self.camera.steps_e(self.light, self.time_s, self.tolerance)

    def _report(self, rendering: Rendering, clock: Clock, signals: Signals, notes: tuple[Note, ...]) -> Report:
        signal = signals.all()
        return Report(
            scene=self.scene_name,
            optics=tuple(brief(stage) for stage in self.camera.optics.stages),
            electronics=tuple(brief(stage) for stage in self.electronics),
            wavelengths=wavelengths(self.light, self.samples.wavelength_nm.size, rendering.wavelengths),
            method=rendering.method,
            tolerance=rendering.tolerance,
            error_estimate=rendering.error_estimate,
            truth_error_estimate=rendering.planes_error,
            checked_photosites=rendering.checked_photosites,
            seconds=dict(clock.seconds),
            signal=signal,
            notes=(*accuracy_notes(rendering), *notes, *notes_after(signal, self.camera, self.exposure.iso)),
            standard_error=rendering.standard_error,
            work={**rendering.work.counts(), "random_numbers": self.random_numbers},
        )
