"""What a bench finds, record by record, each a line of JSON in the end."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any, TypeAlias

Line: TypeAlias = dict[str, Any]
DIGITS = 4  # no clock and no error has more


@dataclass(frozen=True, slots=True, kw_only=True)
class Head:
    """What was measured, in which window and on which machine.

    rows, cols, origin : of the window, in photosites of the sensor's frame
    frame_rows, frame_cols : of what the scene captures
    chosen   : why that window, in words
    tolerance : the scene's own
    """

    scene: str
    camera: str
    rows: int
    cols: int
    origin: tuple[int, int]
    frame_rows: int
    frame_cols: int
    chosen: str
    tolerance: float
    wavelengths: int
    channels: tuple[str, ...]
    machine: dict[str, str | int]
    versions: dict[str, str]


@dataclass(frozen=True, slots=True, kw_only=True)
class TruthLine:
    """One truth and its accuracy.

    engine, tolerance  : an exact engine, at the finest that it renders this scene to
    checked_to         : largest difference from photosites computed directly, on a third road
    checked_photosites : how many those were
    difference         : largest difference from the other truth, anywhere in the window; None without another
    believed_to        : ``checked_to``, and of the coarser of two truths ``difference`` if that is more
    """

    engine: str
    tolerance: float
    checked_to: float
    checked_photosites: int
    accurate_to: float
    seconds: float
    difference: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """One setting: its error and its time.

    method, label, tolerance, samples : what was asked for
    engine         : what ran
    error_max, error_rms : from the truth, over the window, relative to full scale
    row, col       : of the largest error, in photosites of the sensor's frame
    truth          : whose image it was judged by;  believed_to: how far that is to be believed
    error_estimate : what the rendering says of itself
    wall_s, cpu_s  : the quickest lap, set-up and check included;  first_wall_s: the first
    """

    method: str
    label: str
    tolerance: float | None
    samples: int | None
    engine: str
    error_max: float
    error_rms: float
    row: int
    col: int
    truth: str
    accurate_to: float
    error_estimate: float
    wall_s: float
    cpu_s: float
    first_wall_s: float
    laps: int

    @property
    def at_most(self) -> float:
        """The error that was found, or how far the truth is to be believed where that is more."""
        return max(self.error_max, self.accurate_to)

    @property
    def by_itself(self) -> bool:
        """Whether the truth is of the engine that ran."""
        return self.truth.partition(" at ")[0] == self.engine

    @property
    def distinguishable(self) -> bool:
        """Whether more than half of the error is the setting's own, not the truth's."""
        return self.error_max > 2.0 * self.accurate_to


@dataclass(frozen=True, slots=True, kw_only=True)
class LeftOut:
    """A setting that was not rendered, as are finer ones of its method, and why."""

    method: str
    label: str
    why: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """A sentence about the figures."""

    sentence: str


Record: TypeAlias = Head | TruthLine | Point | LeftOut | Finding
KINDS: dict[type, str] = {
    Head: "run",
    TruthLine: "truth",
    Point: "point",
    LeftOut: "left out",
    Finding: "finding",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Bench:
    """Everything that a bench found; see ``bench_scene``."""

    head: Head
    truths: tuple[TruthLine, ...]
    points: tuple[Point, ...]
    left_out: tuple[LeftOut, ...]
    findings: tuple[Finding, ...]

    @property
    def lines(self) -> list[Line]:
        """The records as plain trees, one after the other."""
        records: list[Record] = [self.head, *self.truths, *self.points, *self.left_out, *self.findings]
        return [line_of(record) for record in records]


def line_of(record: Record) -> Line:
    """Return a record as a plain tree: its kind and what is known."""
    return {"kind": KINDS[type(record)]} | {
        name: rounded(value) for name, value in asdict(record).items() if value is not None
    }


def rounded(value: Any) -> Any:
    """Return numbers to four significant digits, inside lists and tables too; what is not finite is None.

    >>> rounded({"error": 1.23456e-7, "laps": 5, "curve": [0.100004]})
    {'error': 1.235e-07, 'laps': 5, 'curve': [0.1]}
    """
    if isinstance(value, bool | int | str) or value is None:
        return value
    if isinstance(value, dict):
        return {name: rounded(part) for name, part in value.items()}
    if hasattr(value, "__iter__"):
        return [rounded(part) for part in value]
    number = float(value)
    return float(f"{number:.{DIGITS}g}") if math.isfinite(number) else None
