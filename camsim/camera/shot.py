"""Given light through a sensor into a Frame: no lens, no scene, nothing resampled."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np

from camsim.camera.body import Body
from camsim.camera.frame import Frame, Products, Report, check_products, frame_numbers
from camsim.camera.given_light import RELATIVE, GivenLight
from camsim.camera.notes import notes_after, notes_of_exposed
from camsim.camera.recording import Recording
from camsim.camera.reporting import Clock
from camsim.camera.window import Region
from camsim.core.annotations import Called
from camsim.core.arrays import F32, F64, I64, U16
from camsim.core.cached import cached_property
from camsim.core.kernels import shared
from camsim.core.memory import needed_bytes, too_large
from camsim.core.typed import FrameNumber, Seed, Truth, Whole, refusal, validate
from camsim.core.words import brief
from camsim.errors import InvalidValueError
from camsim.optics.no_lens import NoLens
from camsim.sensor.colour_matrix import MatrixOf
from camsim.sensor.exposure import Exposure
from camsim.spectra.light import Light

WHITE = Light("D65", illuminance_lux=10.0, at="sensor")
"""Default illumination of a perfect diffuser on the sensor: a scene of 640 lux gives it behind a lens at f/4."""


_ROWS_AT_ONCE = 32
_WAY_OUT = "time, ISO or the light itself sets how bright it is"


@dataclass(frozen=True, kw_only=True)
class Shot(Recording):
    """An array of light, and the sensor that it lies on.

    camera        : a Sensor
    image         : the light of the whole exposure
    light         : of a perfect diffuser on the sensor, for an image of reflectances; else for white balance
    region        : place of the image in the frame; None: the middle
    exposure, seed, frame_number, noise, colour_matrix : see ``Capture``

    >>> from camsim.camera.sensor import Sensor
    >>> image = GivenLight(samples=np.full((4, 6), 1000.0), unit="electrons")
    >>> shot = Shot(camera=Sensor.from_yaml("d40-like"), image=image, exposure=Exposure(time_s=0.01, iso=200))
    >>> shot.frame().mosaic.shape
    (4, 6)
    """

    made_of: ClassVar = (
        *("camera", "image", "light", "exposure", "region"),
        *("seed", "frame_number", "noise", "colour_matrix"),
    )

    camera: Annotated[Body, Called("a Sensor", "Sensor.from_yaml makes one")]
    image: GivenLight
    light: Annotated[Light, Called("a Light", "such as Light('D65', illuminance_lux=10, at='sensor')")] = WHITE
    exposure: Annotated[Exposure, Called("an Exposure", "such as Exposure(time_s=0.01, iso=200)")]
    seed: Seed = 0
    frame_number: FrameNumber = 0
    region: Region | None = None
    noise: bool = True
    colour_matrix: MatrixOf = "standard"

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            camera: Body,
            image: GivenLight,
            light: Light = WHITE,
            exposure: Exposure,
            seed: Whole = 0,
            frame_number: Whole = 0,
            region: Region | None = None,
            noise: Truth = True,
            colour_matrix: MatrixOf = "standard",
        ) -> None: ...

    __repr__ = brief

    def __post_init__(self) -> None:
        validate(self)
        if not isinstance(self.camera.lens, NoLens):
            raise refusal(self, "camera", "has a lens, and light on the sensor passes none; give a Sensor")
        if self.light.at != "sensor":
            raise refusal(self, "light", "is on a scene, and here is none; give Light(…, at='sensor')")
        relative = self.image.unit in RELATIVE
        if isinstance(self.exposure.time_s, str) and not relative:
            message = f"is auto, and {self.image.unit} say how much light there is; give seconds"
            raise InvalidValueError(message, key="time_s", stage="Exposure")
        image = self.image.settled((self.camera.rows, self.camera.cols))
        region = self.region
        if region is None and (image.rows, image.cols) != (self.camera.rows, self.camera.cols):
            region = Region(rows=image.rows, cols=image.cols)
        if region is not None and (region.rows, region.cols) != (image.rows, image.cols):
            message = f"is {region.rows} × {region.cols}, and the light has {image.rows} × {image.cols} photosites"
            raise refusal(self, "region", f"{message}; give one of that size, or none")
        seen = self.light if relative else None if image.unit == "electrons" else image.spectrum
        object.__setattr__(self, "image", image)
        object.__setattr__(self, "region", region)
        object.__setattr__(self, "camera", self.camera.with_ends(seen))
        self.camera.grid(region)  # raises for a window that exceeds the frame

    @cached_property
    def response(self) -> F64 | None:
        """Mean electrons (channels, n) for a 1 in each of the image's planes; None if it is a mosaic of electrons."""
        return self.image.per_channel(self.camera, self.light, self.time_s)

    @property
    def tells_every_channel(self) -> bool:
        """Whether the light determines the electrons of every channel at every photosite."""
        return self.response is not None

    def frame(self, *, products: Products | None = None, progress: Callable[[str, float], None] | None = None) -> Frame:
        """Expose.

        products : "truth" fills ``Frame.truth``; None and "frame": if the light determines it
        progress : called with (stage, fraction done)
        """
        check_products(products or ())
        wanted = {"mosaic", "frame"} if products is None else set(products)
        if "frame" in wanted and self.tells_every_channel:
            wanted.add("truth")
        if "spectral" in wanted:
            raise InvalidValueError("has no spectral: it is of a scene's radiance, and here is none", key="products")
        if "truth" in wanted and not self.tells_every_channel:
            message = "has no truth: a mosaic of electrons says nothing of the other channels; give a plane for each"
            raise InvalidValueError(message, key="products")
        rows, cols = self.grid.rows, self.grid.cols
        if message := too_large(rows, cols, needed_bytes(rows, cols, len(self.camera.cfa.channels), wanted)):
            raise refusal(self, "image", f"{message}; give a smaller one")
        clock = Clock()
        samples = self._with_neighbours()
        image = self._sampled(samples)
        below = int(np.count_nonzero(image < 0.0)) if self.image.unit in RELATIVE else 0
        dark = np.zeros(len(self.camera.cfa.channels))
        exposed = self.window.exposed(image, dark, 0)
        truth = self.window.truth(self._planes(samples), dark, exposed.displayed_e) if "truth" in wanted else None
        del samples
        clock.lap("light")
        signals = self._signals()
        electrons, codes = self._recorded(exposed, self.frame_number, clock, signals)
        signal, iso = signals.all(), self.exposure.iso
        report = Report(
            scene=self.image.source or "array",
            optics=("none: light as it lies on the photosites",),
            electronics=tuple(brief(stage) for stage in self.electronics),
            wavelengths=self._wavelengths(),
            method="none",
            tolerance=0.0,
            error_estimate=0.0,
            checked_photosites=0,
            truth_error_estimate=None if truth is None else 0.0,
            seconds=dict(clock.seconds),
            signal=signal,
            notes=(
                *notes_of_exposed(self.camera, iso, below, encoded=self.image.seems_encoded),
                *notes_after(signal, self.camera, iso, _WAY_OUT),
            ),
            work={"random_numbers": self.random_numbers},
        )
        return self._frame(
            mosaic=codes, electrons=electrons, mean_electrons=exposed.displayed_e, truth=truth,
            channel_index=exposed.channel,
            frame_number=self.frame_number, report=report,
        )  # fmt: skip

    @cached_property
    def optical_key(self) -> str:
        """Key that is equal for shots of the same light."""
        return self.image.sha256

    def frames(
        self,
        count: int = 1,
        *,
        products: Products | None = None,
        progress: Callable[[str, float], None] | None = None,
    ) -> Iterator[Frame]:
        """Yield exposures to the same light: the same fixed patterns, fresh noise."""
        for number in frame_numbers(self.frame_number, count):
            yield dataclasses.replace(self, frame_number=number).frame(products=products, progress=progress)

    def rows(
        self,
        take: Callable[[U16], None],
        *,
        products: Products = ("mosaic",),
        progress: Callable[[str, float], None] | None = None,
    ) -> Frame:
        """Pass the codes to ``take``, as ``Capture.rows`` does, in one batch: the light is in memory anyway."""
        check_products(products, streamed=True)
        frame = self.frame(products=products, progress=progress)
        take(frame.mosaic)
        return frame

    def description(self, frame_number: int) -> dict[str, Any]:
        """Return the description of a frame; for the light its name, place and hash."""
        stated = super().description(frame_number)
        stated["image"]["sha256"] = self.image.sha256
        return stated

    def _with_neighbours(self) -> Any:
        """Return the light of all photosites involved, reflected at the border within each channel."""
        samples = self.image.on_photosites()
        if self.camera.crosstalk is None:
            return samples
        # A mosaic has no other channel at a photosite: reflect by a period, to one of the same channel.
        steps = self.camera.cfa.period if self.response is None else (1, 1)
        rows, cols = (reflected(size, step) for size, step in zip(samples.shape[:2], steps, strict=True))
        return samples[rows[:, None], cols]

    def _sampled(self, samples: Any) -> F64:
        """Return (rows, cols) mean electrons, each photosite in its channel."""
        if self.response is None:
            return np.array(samples, np.float64)
        cfa, wide = self.camera.cfa, self.window.wide
        image = np.empty((wide.rows, wide.cols))
        index = cfa.channel_index(*cfa.period, wide.origin)
        for (row, col), channel in np.ndenumerate(index):
            here = np.s_[row :: cfa.period[0], col :: cfa.period[1]]
            _weigh(samples[here], self.response[channel], image[here])
        return image

    def _planes(self, samples: Any) -> F32:
        """Return (channels, rows, cols) mean electrons of every channel, for the truth."""
        assert self.response is not None
        planes = np.empty((len(self.response), *samples.shape[:2]), np.float32)
        for weights, plane in zip(self.response, planes, strict=True):
            _weigh(samples, weights, plane)
        return planes

    def _wavelengths(self) -> str:
        unit = self.image.unit
        if unit == "electrons":
            return "none: electrons have no colour"
        low_nm, high_nm = (self.light if unit in RELATIVE else self.image.spectrum).ends_nm
        return f"{low_nm:g}–{high_nm:g} nm"


def reflected(size: int, step: int) -> I64:
    """Return indices padded by one at either end, by reflection with period ``step``."""
    inside = np.arange(-1, size + 1)
    inside[0], inside[-1] = min(step, size) - 1, max(size - step, 0)
    return inside


def _weigh(samples: Any, weights: F64, total: F64 | F32) -> None:
    """Write Σ plane × weight, (rows, cols), summed in double precision, rows by rows as a cache holds them."""
    planes = samples[..., None] if samples.ndim == 2 else samples

    def work(begin: int, end: int) -> None:
        for first in range(begin, end, _ROWS_AT_ONCE):
            rows = slice(first, min(first + _ROWS_AT_ONCE, end))
            sums = np.zeros(total[rows].shape)
            for plane in np.flatnonzero(weights):
                sums += np.multiply(planes[rows, :, plane], weights[plane], dtype=np.float64)
            total[rows] = sums

    shared(len(total), work, least=_ROWS_AT_ONCE)
