"""Records of a bench, each written as a line of JSON."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any, TypeAlias

Line: TypeAlias = dict[str, Any]
DIGITS = 4  # significant digits of times and errors


@dataclass(frozen=True, slots=True, kw_only=True)
class Head:
    """What was measured, in which window and on which machine.

    rows, cols, origin : size and position of the window, in photosites of the sensor's frame
    frame_rows, frame_cols : size of the scene's capture
    chosen   : reason for the window
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

    engine, tolerance  : an exact engine, at the finest tolerance for this scene
    checked_to         : largest difference from photosites computed directly, by a third method
    checked_photosites : number of those photosites
    difference         : largest difference from the other truth, anywhere in the window; None without another
    accurate_to        : accuracy: ``checked_to``, or for the coarser of two truths ``difference`` if larger
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

    method, label, tolerance, samples : as requested
    engine         : engine used
    error_max, error_rms : errors against the truth over the window, relative to full scale
    row, col       : place of the largest error, in photosites of the sensor's frame
    truth          : engine of the reference image;  accurate_to: accuracy of that
    error_estimate : estimate of the rendering
    wall_s, cpu_s  : the fastest lap, including set-up and check;  first_wall_s: the first
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
        """The error, or the accuracy of the truth if that is larger."""
        return max(self.error_max, self.accurate_to)

    @property
    def by_itself(self) -> bool:
        """Whether the truth is from the same engine."""
        return self.truth.partition(" at ")[0] == self.engine

    @property
    def distinguishable(self) -> bool:
        """Whether more than half of the error is due to the setting, not the truth."""
        return self.error_max > 2.0 * self.accurate_to


@dataclass(frozen=True, slots=True, kw_only=True)
class LeftOut:
    """A setting that was not rendered, nor were finer ones of its method, and the reason."""

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
    """Return a record as a plain tree: its kind and its values."""
    return {"kind": KINDS[type(record)]} | {
        name: rounded(value) for name, value in asdict(record).items() if value is not None
    }


def rounded(value: Any) -> Any:
    """Return numbers to four significant digits, also inside lists and tables; None for non-finite ones.

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
