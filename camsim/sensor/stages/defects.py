"""Defective photosites."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar, TypeAlias

import numpy as np
import numpy.typing as npt

from camsim.core.annotations import Called
from camsim.core.arrays import F64, I64
from camsim.core.typed import Fraction, Index, NonNegative, Number, Several, Whole, refusal, validate
from camsim.core.words import brief
from camsim.sensor import streams
from camsim.sensor.stage import Context, ElectronicStage, Phase
from camsim.sensor.stages.dark_current import DarkCurrent
from camsim.sensor.streams import BLOCK_ROWS

Places: TypeAlias = tuple[I64, I64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Defects(ElectronicStage):
    """Hot photosites (with more dark current) and dead ones (blind), by share and by list.

    hot_fraction  : share of photosites that are hot, drawn from the sensor's serial number
    hot_e_per_s   : mean dark current of hot photosites, exponentially distributed (give both or neither)
    dead_fraction : share without response to light
    hot           : (row, col, e_per_s) of the full frame, besides those drawn
    dead          : (row, col) of the full frame, besides those drawn

    >>> Defects(hot_fraction=1e-4, hot_e_per_s=500.0, dead=[(3, 4)])
    Defects(hot_fraction=0.0001, hot_e_per_s=500.0, dead=((3, 4),))
    """

    name: ClassVar = "defects"
    phases: ClassVar = (Phase.LIGHT, Phase.CHARGE)
    stream: ClassVar = 10

    hot_fraction: Fraction | None = None
    hot_e_per_s: NonNegative | None = None
    dead_fraction: Fraction = 0.0
    hot: Annotated[Several[tuple[Index, Index, NonNegative]], Called("a list of (row, col, e_per_s)")] = ()
    dead: Annotated[Several[tuple[Index, Index]], Called("a list of (row, col)")] = ()

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            hot_fraction: Number | None = None,
            hot_e_per_s: Number | None = None,
            dead_fraction: Number = 0.0,
            hot: Several[tuple[Whole, Whole, Number]] = (),
            dead: Several[tuple[Whole, Whole]] = (),
        ) -> None: ...

    __repr__ = brief

    def __post_init__(self) -> None:
        validate(self)
        for key, other in (("hot_fraction", "hot_e_per_s"), ("hot_e_per_s", "hot_fraction")):
            if getattr(self, key) is not None and getattr(self, other) is None:
                raise refusal(self, key, f"does nothing without {other}; give that too")
        if self.hot_fraction is not None and self.hot_fraction + self.dead_fraction > 1.0:
            message = f"{self.dead_fraction} and a hot_fraction of {self.hot_fraction} are more than 1 together"
            raise refusal(self, "dead_fraction", message)

    def apply(self, electrons: F64, context: Context) -> F64:
        """Set light of dead photosites to 0; in the charge phase, add the dark current of hot ones."""
        shape = (electrons.shape[0], electrons.shape[1])
        hot, e_per_s, dead = self.within(
            serial=context.serial, shape=shape, origin=context.first, frame_cols=context.frame_cols
        )
        electrons = electrons.copy()
        if context.phase is Phase.LIGHT:
            electrons[dead] = 0.0
        else:
            current = context.other(DarkCurrent) or DarkCurrent(0.0)  # its temperature dependence applies here too
            warming = current.warming(context.temperature_c)
            np.add.at(electrons, hot, (warming * context.time_s) * e_per_s)
        return electrons

    def within(
        self, *, serial: int, shape: tuple[int, int], origin: tuple[int, int], frame_cols: int
    ) -> tuple[Places, F64, Places]:
        """Return the hot photosites of a window, their currents in e⁻/s, and the dead ones: rows and columns in it.

        serial     : serial number of the sensor, which determines the places
        origin     : (row, col) of the window's first photosite in the full frame
        frame_cols : width of the full frame
        """
        hot = [_table(tuple(self.hot))]
        dead = [np.array(self.dead, dtype=np.int64).reshape(-1, 2)]
        if self.hot_fraction or self.dead_fraction:
            for block in range(max(origin[0], 0) // BLOCK_ROWS, (origin[0] + shape[0] - 1) // BLOCK_ROWS + 1):
                drawn_hot, drawn_dead = self._drawn(serial, block, frame_cols)
                hot.append(drawn_hot)
                dead.append(drawn_dead)
        all_hot, all_dead = np.concatenate(hot), np.concatenate(dead)
        hot_places, current = _inside(all_hot[:, :2].astype(np.int64), shape, origin), all_hot[:, 2]
        dead_places = _inside(all_dead, shape, origin)
        return hot_places[1], current[hot_places[0]], dead_places[1]

    def _drawn(self, serial: int, block: int, frame_cols: int) -> tuple[F64, I64]:
        """Return (row, col, e_per_s) and (row, col) of a block of rows: number, then places, then currents."""
        rng = streams.generator(serial, self.stream, block=block)
        photosites = BLOCK_ROWS * frame_cols
        hot_count = int(rng.binomial(photosites, self.hot_fraction or 0.0))
        dead_count = min(int(rng.binomial(photosites, self.dead_fraction)), photosites - hot_count)
        index = rng.choice(photosites, hot_count + dead_count, replace=False)
        places = np.stack([block * BLOCK_ROWS + index // frame_cols, index % frame_cols], axis=1)
        current = rng.exponential(1.0, hot_count) * (self.hot_e_per_s or 0.0)
        return np.column_stack([places[:hot_count], current]), places[hot_count:]


@functools.lru_cache(maxsize=4)
def _table(hot: tuple[tuple[int, int, float], ...]) -> F64:
    """Return listed photosites as an array (n, 3), cached as every block of rows uses it."""
    return np.array(hot, dtype=np.float64).reshape(-1, 3)


def _inside(places: I64, shape: tuple[int, int], origin: tuple[int, int]) -> tuple[npt.NDArray[np.bool_], Places]:
    """Return a mask of the places of the full frame within a window, and their positions in it."""
    row, col = places[:, 0] - origin[0], places[:, 1] - origin[1]
    inside = (row >= 0) & (row < shape[0]) & (col >= 0) & (col < shape[1])
    return inside, (row[inside], col[inside])
