"""Common parts of measuring commands: a file with its capture, and output as text, table and plot."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from camsim.cli.tables import check_text_file, csv_text
from camsim.errors import InvalidValueError, UnsupportedError
from camsim.files.atomic import together, write_whole

if TYPE_CHECKING:
    from camsim.camera.capture import Capture
    from camsim.measure import Picture


class Stated(Protocol):
    """A report with a JSON form."""

    def as_dict(self) -> dict[str, Any]: ...  # noqa: D102 (above)


R = TypeVar("R", bound=Stated)


@dataclass(frozen=True, slots=True, kw_only=True)
class Outputs:
    """Where a report goes: ``--json`` in place of text, ``--csv``, ``--plot``, and whether files may be overwritten."""

    as_json: bool
    csv: str | None
    plot: str | None = None
    force: bool

    def check(self, others: Mapping[str, str | None] = MappingProxyType({})) -> None:
        """Raise, before any work, if an output cannot be written; ``others``: further files, by their options."""
        files = {"--csv": self.csv, "--plot": self.plot, **others}
        named = [Path(file).resolve() for file in files.values() if file is not None]
        if len(set(named)) < len(named):
            *first, last = files
            raise InvalidValueError(f"two of {', '.join(first)} and {last} name one file", key=last)
        if self.csv is not None:
            check_text_file(self.csv, force=self.force)
        if self.plot is not None:
            from camsim.cli.plot import check_drawing

            check_drawing(self.plot, force=self.force)

    def write(
        self, heads: Sequence[str], rows: Iterable[Sequence[object]], draw: Callable[[str], bytes] | None = None
    ) -> None:
        """Write the requested files; ``draw`` takes the name of the plot's file and returns its bytes."""
        with together():
            if self.csv is not None:
                write_whole(self.csv, csv_text(heads, rows).encode("utf-8"))
            if self.plot is not None and draw is not None:
                write_whole(self.plot, draw(self.plot))

    def tell(self, report: R | list[R], show: Callable[[R], None]) -> None:
        """Print a report, or several, as JSON or as text."""
        if self.as_json:
            tree = [each.as_dict() for each in report] if isinstance(report, list) else report.as_dict()
            print(json.dumps(tree, indent=2, ensure_ascii=False))
            return
        for each in report if isinstance(report, list) else [report]:
            show(each)


def picture_and_capture(file: str) -> tuple[Picture, Capture]:
    """Return a file's picture and its capture; raises UnsupportedError if it has no description."""
    from camsim.measure import read_picture

    picture = read_picture(file)
    return picture, capture_of(picture, file)


def capture_of(picture: Picture, file: str) -> Capture:
    """Return the capture of a file's picture; raises UnsupportedError if it has no description."""
    from camsim.config.from_record import capture_from_record

    if picture.description is None:
        raise UnsupportedError(
            "does not say what it was taken of; camsim's own files do (.dng, .tiff, .exr, .png:mosaic)", stage=file
        )
    return replace(capture_from_record(picture.description), scene_name=file)
