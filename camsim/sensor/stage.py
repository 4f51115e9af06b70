"""Electronic stages: declarations and one operation, ``apply``, from electrons to electrons."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, ClassVar, Protocol, TypeVar, runtime_checkable

import numpy as np

from camsim.core.arrays import F32, F64
from camsim.core.custom import is_custom, refused
from camsim.sensor import streams

CUSTOM_STREAMS = 1000
"""First random stream for custom stages; those below are camsim's."""

_NORMAL = 0.25  # the largest standard deviation of normal gains: four of them above 0

S = TypeVar("S")


class Phase(IntEnum):
    """The phase in which a stage acts, in the order of what happens to the charge.

    >>> [phase.name for phase in Phase]
    ['LIGHT', 'NEIGHBOURS', 'CHARGE', 'COUNT', 'WELL', 'READ']
    """

    LIGHT = 1  # light on each photosite, neighbours of the window included
    NEIGHBOURS = 2  # crosstalk between neighbouring photosites
    CHARGE = 3  # mean charge collected during the exposure
    COUNT = 4  # the mean becomes whole electrons
    WELL = 5  # capacity of a photosite
    READ = 6  # read-out up to the converter


@dataclass(frozen=True, slots=True, kw_only=True)
class Context:
    """What a stage may know besides its electrons: exposure, seeds, and the photosites that they are in.

    time_s, iso      : exposure time and ISO setting
    temperature_c    : temperature of the sensor, for the dark current; None: that for which its figure holds
    electrons_per_dn : for noise after the gain
    seed             : seeds the temporal noise, together with ``frame_number``
    serial           : serial number of the sensor, which seeds the fixed patterns
    origin           : (row, col) of the window's first photosite in the full frame
    frame_cols       : width of the full frame
    read_out         : index of this read-out of the exposure; from phase READ on read-outs draw independent noise
    rows_in_all      : number of rows of the window
    rows_before      : number of rows of the window above these electrons
    margin           : photosites of padding on each side of these electrons, for contributions of neighbours
    phase            : in which the stage is asked to act
    shape            : (rows, cols) of these electrons; None before electrons exist (``over``, ``draws``)
    stages           : all active stages
    asking           : the stage being applied; a custom one may draw only from streams that it declares
    begun            : streams from which that stage has begun to draw for these rows

    >>> context = Context(time_s=0.01, seed=1, serial=1, origin=(0, 0), frame_cols=8, rows_in_all=4)
    >>> context.first
    (0, 0)
    >>> context.generator(1001).random(3).shape
    (3,)
    """

    time_s: float
    iso: float = 100.0
    temperature_c: float | None = None
    electrons_per_dn: float = 1.0
    seed: int
    serial: int
    frame_number: int = 0
    read_out: int = 0
    origin: tuple[int, int]
    frame_cols: int
    rows_in_all: int
    rows_before: int = 0
    margin: int = 0
    phase: Phase = Phase.READ
    shape: tuple[int, int] | None = None
    stages: tuple[ElectronicStage, ...] = ()
    asking: ElectronicStage | None = None
    begun: set[int] = field(default_factory=set, repr=False, compare=False)

    @property
    def first(self) -> tuple[int, int]:
        """The (row, col) of the first of these electrons in the full frame."""
        return self.origin[0] + self.rows_before - self.margin, self.origin[1] - self.margin

    def other(self, kind: type[S]) -> S | None:
        """Return the active stage of a class; None without one."""
        return next((stage for stage in self.stages if isinstance(stage, kind)), None)

    def generator(self, stream: int) -> np.random.Generator:
        """Return the generator of a temporal stage for these rows, at its start: call once and draw all from it."""
        self._check_declared(stream, temporal=True)
        return self._drawing(stream, self.rows_before // streams.BLOCK_ROWS)

    def frame_generator(self, stream: int) -> np.random.Generator:
        """Return the generator of a temporal stage that draws once per frame."""
        self._check_declared(stream, temporal=True)
        return self._drawing(stream, 0)

    def _drawing(self, stream: int, block: int) -> np.random.Generator:
        return streams.generator(
            self.seed, stream, block=block, frame_number=self.frame_number, read_out=self._its_read_out
        )

    @property
    def _its_read_out(self) -> int:
        """Index of the read-out for drawing; 0 before phase READ, where read-outs share the charge."""
        return self.read_out if self.phase is Phase.READ else 0

    def normals(self, stream: int, shape: tuple[int, ...]) -> F32:
        """Return the (rows, cols) standard normals of a fixed pattern that belong to these photosites."""
        self._check_declared(stream, temporal=False)
        if self.shape not in (None, tuple(shape)) and is_custom(self.asking):
            asked = f"{type(self.asking).__name__} asks for normals of shape {tuple(shape)} for {self.shape} photosites"
            way_out = "there is one for each photosite; context.column_normals gives one for each column"
            raise refused("extra_stages", f"{asked}; {way_out}")
        rows, cols = shape
        normals = streams.fixed_normals(
            self.serial, stream, rows=rows, cols=cols, origin=self.first, frame_cols=self.frame_cols
        )
        return normals.copy() if is_custom(self.asking) else normals  # a custom stage may modify them

    def column_normals(self, stream: int, cols: int) -> F32:
        """Return the (cols,) standard normals of a fixed pattern that belong to these photosites' columns."""
        self._check_declared(stream, temporal=False)
        origin = 0, self.first[1]
        one_row = streams.fixed_normals(
            self.serial, stream, rows=1, cols=cols, origin=origin, frame_cols=self.frame_cols
        )
        return one_row.ravel()

    def normals_drawn(self, rows: int) -> int:
        """Return how many numbers ``normals`` draws for ``rows`` rows when called block by block, as the chain does."""
        return streams.fixed_count(rows, first_row=self.first[0], frame_cols=self.frame_cols)

    def _check_declared(self, stream: int, *, temporal: bool) -> None:
        """Raise if a custom stage draws from a stream it does not declare: another could share its numbers."""
        stage = self.asking
        if stage is None or not is_custom(stage):
            return
        name = type(stage).__name__
        if stream not in streams_of(stage):
            way_out = f"stream: ClassVar = {stream}" if stage.stream is None else "each that it draws from"
            message = f"{name} draws from stream {stream}, and its stream is {stage.stream}; declare {way_out}"
            raise refused("extra_stages", message)
        if temporal and stream in self.begun:
            again = "it begins anew, with the same numbers; draw from one generator, or declare another stream"
            raise refused("extra_stages", f"{name} asks for the generator of stream {stream} twice; {again}")
        if temporal and not stage.temporal:
            way_out = "declare temporal: ClassVar = True, or take context.normals for a pattern of the sensor"
            raise refused("extra_stages", f"{name} draws anew in each frame, and its temporal is False; {way_out}")
        if temporal:
            self.begun.add(stream)


@runtime_checkable
class ElectronicStage(Protocol):
    """Base class of stages: a subclass is a frozen dataclass with ``apply`` and the attributes that differ from these.

    name          : name of the camera's field for the stage, with which its error messages begin
    phases        : when it acts, mostly one
    stream        : id of its random stream, or several; None: nothing is drawn. Ids must not be reused, or old captures
                    change
    temporal      : whether it draws anew in each frame (from the seed) or once for the sensor (from the serial number)
    without_noise : whether it also acts in captures without noise
    margin        : photosites of padding that it needs on every side
    whole_window  : whether it needs all rows at once

    >>> import camsim
    >>> isinstance(camsim.ReadNoise(3.0), ElectronicStage), camsim.ReadNoise(3.0).phases
    (True, (<Phase.READ: 6>,))
    """

    __slots__ = ()

    name: ClassVar[str]
    phases: ClassVar[tuple[Phase, ...]] = (Phase.READ,)
    stream: ClassVar[Any] = None  # a number, a tuple of numbers or None; stages narrow the type
    temporal: ClassVar[bool] = False
    without_noise: ClassVar[bool] = False
    margin: ClassVar[int] = 0
    whole_window: ClassVar[bool] = False

    def apply(self, electrons: F64, context: Context) -> F64:
        """Return the electrons (rows, cols) after the stage; the input must not be modified."""
        ...

    def over(self, context: Context) -> ElectronicStage:
        """Return the stage prepared for a window: random numbers shared by its blocks are drawn here, once."""
        return self

    def draws(self, shape: tuple[int, int], context: Context) -> int:
        """Return the number of random numbers that the stage draws for a window in a phase."""
        return 0

    def dark_noise_e(self, electrons_per_dn: float) -> float:
        """Return the standard deviation of the stage's temporal noise in a dark frame, electrons."""
        return 0.0

    def lacks(self, others: Sequence[ElectronicStage]) -> str:
        """Return a sentence on the stages that this one needs and that are missing; empty if none are."""
        return ""


def streams_of(stage: ElectronicStage) -> tuple[int, ...]:
    """Return the ids of a stage's random streams."""
    stream = stage.stream
    return () if stream is None else tuple(stream) if isinstance(stream, Sequence) else (int(stream),)


def add_normals(electrons: F64, sigma_e: float, normals: F32) -> F64:
    """Return electrons + sigma_e · normals."""
    noisy = normals.astype(np.float64)
    noisy *= sigma_e
    noisy += electrons
    return noisy


def gains(fraction: float, normals: F32) -> F64:
    """Return gains of mean 1 and standard deviation ``fraction``, never below 0.

    Small fractions give normal gains, large ones log-normal: normals clipped at 0 would have a mean above 1.
    """
    one = normals.astype(np.float64)
    if fraction > _NORMAL:
        variance = math.log1p(fraction**2)
        one *= math.sqrt(variance)
        one -= 0.5 * variance
        return np.exp(one, out=one)
    one *= fraction
    one += 1.0
    raised: F64 = np.maximum(one, 0.0, out=one)
    return raised
