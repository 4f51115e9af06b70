"""The list of electronic stages: the fields of a camera, in the order of the signal path."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Annotated, Any, TypeAlias, TypedDict

from camsim.core.annotations import Called
from camsim.core.typed import Several, validate
from camsim.errors import InvalidValueError
from camsim.sensor.custom import check_custom
from camsim.sensor.stage import ElectronicStage
from camsim.sensor.stages.blooming import Blooming
from camsim.sensor.stages.column_noise import ColumnNoise
from camsim.sensor.stages.crosstalk import Crosstalk
from camsim.sensor.stages.dark_current import DarkCurrent
from camsim.sensor.stages.dark_frames import DarkFrames
from camsim.sensor.stages.defects import Defects
from camsim.sensor.stages.dsnu import Dsnu
from camsim.sensor.stages.flicker_rows import FlickerRows
from camsim.sensor.stages.full_well import FullWell
from camsim.sensor.stages.nonlinearity import Nonlinearity
from camsim.sensor.stages.offset_map import OffsetMap
from camsim.sensor.stages.output_noise import OutputNoise
from camsim.sensor.stages.prnu import Prnu
from camsim.sensor.stages.read_noise import ReadNoise
from camsim.sensor.stages.reset_noise import ResetNoise
from camsim.sensor.stages.row_noise import RowNoise
from camsim.sensor.stages.shot_noise import ShotNoise
from camsim.sensor.stages.telegraph_noise import TelegraphNoise

Custom: TypeAlias = Annotated[ElectronicStage, Called("a dataclass that inherits from camsim.ElectronicStage")]


@dataclass(frozen=True, kw_only=True)
class Electronics:
    """The electronic stages; leaving one out (None) does not change the random numbers of the others.

    extra_stages : custom stages (``camsim.sensor.stage.ElectronicStage``); each acts in its phase, after camsim's
    """

    prnu: Prnu | None = None
    crosstalk: Crosstalk | None = None
    dark_current: DarkCurrent | None = None
    defects: Defects | None = None
    shot_noise: ShotNoise | None = ShotNoise()  # noqa: RUF009 (frozen, without fields)
    blooming: Blooming | None = None
    full_well: FullWell | None = None
    nonlinearity: Nonlinearity | None = None
    reset_noise: ResetNoise | None = None
    read_noise: ReadNoise | None = None
    telegraph_noise: TelegraphNoise | None = None
    row_noise: RowNoise | None = None
    flicker_rows: FlickerRows | None = None
    column_noise: ColumnNoise | None = None
    dsnu: Dsnu | None = None
    offset_map: OffsetMap | None = dataclasses.field(default=None, metadata={"described": "if any"})
    output_noise: OutputNoise | None = None
    dark_frames: DarkFrames | None = dataclasses.field(default=None, metadata={"described": "if any"})
    extra_stages: Several[Custom] = dataclasses.field(default=(), metadata={"described": "if any"})

    def __post_init__(self) -> None:
        validate(self)
        check_custom(tuple(self.extra_stages))
        stages = self.stages
        for stage in stages:
            if missing := stage.lacks(stages):
                raise InvalidValueError(missing, key=stage.name)

    @property
    def stages(self) -> tuple[ElectronicStage, ...]:
        """The stages that are set, in order."""
        listed: list[Any] = [getattr(self, name) for name in ORDER]
        there = [stage for stage in (*listed, *self.extra_stages) if stage is not None]
        # The sort is stable: within a phase the order is that of the list.
        return tuple(sorted(there, key=lambda stage: stage.phases[-1]))


class ElectronicChanges(TypedDict, total=False):
    """What ``replace`` may exchange here: the fields of ``Electronics``."""

    prnu: Prnu | None
    crosstalk: Crosstalk | None
    dark_current: DarkCurrent | None
    defects: Defects | None
    shot_noise: ShotNoise | None
    blooming: Blooming | None
    full_well: FullWell | None
    nonlinearity: Nonlinearity | None
    reset_noise: ResetNoise | None
    read_noise: ReadNoise | None
    telegraph_noise: TelegraphNoise | None
    row_noise: RowNoise | None
    flicker_rows: FlickerRows | None
    column_noise: ColumnNoise | None
    dsnu: Dsnu | None
    offset_map: OffsetMap | None
    output_noise: OutputNoise | None
    dark_frames: DarkFrames | None
    extra_stages: Several[ElectronicStage]


ORDER = tuple(field.name for field in dataclasses.fields(Electronics) if field.name != "extra_stages")
"""Names of the stages' fields, in order."""
