"""A sensor's noise for arrays in a loop."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import numpy as np
from numpy.typing import ArrayLike

from camsim.camera.body import Body
from camsim.camera.shot import reflected
from camsim.camera.window import Region
from camsim.core.annotations import Called
from camsim.core.arrays import F32, F64
from camsim.core.number_kinds import array_of
from camsim.core.typed import Celsius, Iso, Number, Positive, Seed, Whole, check, validate
from camsim.core.words import brief
from camsim.errors import InvalidValueError
from camsim.sensor.chain import record
from camsim.sensor.stage import Context


@dataclass(frozen=True, eq=False)
class Noise:
    """A sensor's electronics without the converter, for training loops: mean electrons in, noisy electrons out.

    sensor        : a Sensor or a Camera
    iso           : sets the gain and quantities that depend on it; None: the base ISO
    time_s        : exposure time, for dark current
    temperature_c : temperature of the sensor, °C; None: the one for which its dark current is given

    Called with electrons (rows, cols), or (…, rows, cols) for several images, and a seed, it returns float32 electrons
    as read, of the same shape: those of ``Sensor.expose``, with the image's index as the frame number. A CPU tensor is
    read without a copy, through the array protocol; ``torch.from_numpy`` takes the result without a copy. Codes:
    ``sensor.converter.quantise(noisy, iso=…)``.

    >>> import camsim
    >>> noise = camsim.Noise(camsim.Sensor.from_yaml("mono-345"), iso=800)
    >>> noisy = noise(np.full((64, 64), 100.0), seed=1)
    >>> noisy.shape, noisy.dtype, bool(90.0 < noisy.mean() < 110.0)
    ((64, 64), dtype('float32'), True)
    """

    sensor: Annotated[Body, Called("a Sensor or a Camera", "Sensor.from_yaml makes one")]
    iso: Iso | None = None
    time_s: Positive = 0.01
    temperature_c: Celsius | None = None

    if TYPE_CHECKING:

        def __init__(
            self, sensor: Body, iso: Number | None = None, time_s: Number = 0.01, temperature_c: Number | None = None
        ) -> None: ...

    __repr__ = brief

    def __post_init__(self) -> None:
        validate(self)
        if len(self.sensor.read_outs) > 1:
            message = "merges two read-outs; give one, replace(dual_gain=dataclasses.replace(…, read='high'))"
            raise InvalidValueError(message, key="sensor", stage="Noise")

    def __call__(self, electrons: ArrayLike, seed: Whole) -> F32:
        """Return (…, rows, cols) electrons as read from mean electrons of light."""
        given = array_of(electrons, "electrons", "Noise")
        if given.dtype.kind not in "fiu" or given.ndim < 2 or not given.size:
            message = f"must be numbers (rows, cols) or (…, rows, cols), not {given.dtype} of shape {given.shape}"
            raise InvalidValueError(message, key="electrons", stage="Noise")
        if given.ndim > 2 and given.shape[-1] in (3, 4):
            message = f"is {given.shape}, and images are (…, rows, cols); give planes first, np.moveaxis(…, -1, 0)"
            raise InvalidValueError(message, key="electrons", stage="Noise")
        if not 0.0 <= given.min() <= given.max() < np.inf:
            message = "must be finite, and 0 or more: a mean charge"
            raise InvalidValueError(message, key="electrons", stage="Noise")
        context = self._context(given.shape[-2], given.shape[-1], check(seed, Seed, "seed", "Noise"))
        stages = self.sensor.electronics(context.iso)
        images = given.reshape(-1, *given.shape[-2:])
        noisy = np.empty(images.shape, np.float32)
        for number, image in enumerate(images):
            mean_e: F64 = image.astype(np.float64)
            if any(stage.margin for stage in stages):
                period = self.sensor.cfa.period
                rows, cols = (reflected(size, step) for size, step in zip(mean_e.shape, period, strict=True))
                mean_e = mean_e[rows[:, None], cols]
            noisy[number] = record(mean_e, stages, dataclasses.replace(context, frame_number=number))
        return noisy.reshape(given.shape)

    def _context(self, rows: int, cols: int, seed: int) -> Context:
        sensor = self.sensor
        iso = sensor.adc.base_iso if self.iso is None else self.iso
        grid = sensor.grid(None if (rows, cols) == (sensor.rows, sensor.cols) else Region(rows=rows, cols=cols))
        return Context(
            time_s=self.time_s, iso=iso, temperature_c=self.temperature_c,
            electrons_per_dn=sensor.converter.electrons_per_dn_at(iso), seed=seed, serial=sensor.serial,
            read_out=sensor.read_out_number, origin=grid.origin, frame_cols=sensor.cols, rows_in_all=rows,
        )  # fmt: skip
