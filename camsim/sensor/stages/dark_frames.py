"""Real darks of a camera, in place of simulated dark signal and noise."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from camsim.core.arrays import F64
from camsim.core.custom import is_custom
from camsim.core.typed import validate
from camsim.sensor.stage import Context, ElectronicStage, Phase
from camsim.sensor.stages.dark_current import DarkCurrent
from camsim.sensor.stages.offset_map import OffsetMap, keep_pattern, pattern_at


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DarkFrames(ElectronicStage):
    """Real darks: in each exposure one of them, drawn at random, is added as it was read out.

    codes_dn : (darks, rows, cols) data numbers above their mean, taken at the ISO setting and time of the exposure;
               tiled if the sensor has more photosites
    source   : the folder that they came from;  sha256: hash of their codes

    >>> darks = DarkFrames(codes_dn=np.zeros((3, 4, 6)))
    >>> darks.shape
    (4, 6)
    """

    name: ClassVar = "dark_frames"
    stream: ClassVar = 15
    temporal: ClassVar = True

    codes_dn: Any = field(repr=False)
    source: str = ""
    sha256: str = field(default="", init=False)

    if TYPE_CHECKING:

        def __init__(self, *, codes_dn: Any, source: str = "") -> None: ...

    def __post_init__(self) -> None:
        validate(self)
        keep_pattern(self, "codes_dn", "darks, rows, cols")

    def __eq__(self, other: object) -> bool:
        return isinstance(other, DarkFrames) and self.sha256 == other.sha256

    def __hash__(self) -> int:
        return hash(self.sha256)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of a dark."""
        rows, cols = self.codes_dn.shape[1:]
        return rows, cols

    def lacks(self, others: Sequence[ElectronicStage]) -> str:
        """Return a message if stages simulate the dark signal or its noise, which darks contain."""
        reading = [
            stage
            for stage in others
            if Phase.READ in stage.phases and stage.stream is not None and not is_custom(stage)
        ]
        twice = [stage.name for stage in others if stage in reading or isinstance(stage, DarkCurrent | OffsetMap)]
        twice = [name for name in twice if name != self.name]
        return f"have {', '.join(twice)} in them, which would be there twice; leave that out" if twice else ""

    def apply(self, electrons: F64, context: Context) -> F64:
        """Add the dark of this frame, aligned with the full frame."""
        drawn = int(context.frame_generator(self.stream).integers(len(self.codes_dn)))
        dark = pattern_at(self.codes_dn[drawn], context.first, electrons.shape)
        dark *= context.electrons_per_dn
        dark += electrons
        return dark

    def draws(self, shape: tuple[int, int], context: Context) -> int:
        """Return one number for each block of rows: every block draws the number of the same dark."""
        return -(-shape[0] // 64)

    def dark_noise_e(self, electrons_per_dn: float) -> float:
        """Return by how much a photosite varies from dark to dark: a robust standard deviation."""
        if len(self.codes_dn) < 2:
            return 0.0
        apart = np.abs(self.codes_dn[1] - self.codes_dn[0])
        scatter_dn = 1.4826 * float(np.median(apart)) / math.sqrt(2.0)
        return scatter_dn * electrons_per_dn
