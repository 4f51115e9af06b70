"""Several measured pictures, ordered by a parameter of their captures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any, TypeAlias

from camsim.core.typed import check
from camsim.errors import InvalidValueError, UnknownNameError, UnsupportedError
from camsim.measure.result import MtfReport

Value: TypeAlias = float | str | bool | None

WORDS: Mapping[str, str] = {
    "aperture": "camera.lens.f_number",
    "time": "exposure.time_s",
    "olpf": "camera.olpf.split_um",
    "illuminance": "light.illuminance_lux",
}
"""Common names of keys of the description."""

_MOST_NAMED = 6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MtfSeries:
    """Several reports side by side.

    by      : the key in which the files' descriptions differ; None if file names are used instead
    values  : for each report, its value of the key, or the name of its file
    reports : in order of the values if these are numbers
    """

    by: str | None
    values: tuple[Value, ...]
    reports: tuple[MtfReport, ...]

    @property
    def labels(self) -> tuple[str, ...]:
        """Label of each report in a table or a plot."""
        return tuple("none" if v is None else f"{v:g}" if isinstance(v, float) else str(v) for v in self.values)

    def as_dict(self) -> dict[str, Any]:
        """Return the result as plain values for JSON."""
        pairs = zip(self.values, self.reports, strict=True)
        return {"by": self.by, "files": [{"value": value, **report.as_dict()} for value, report in pairs]}


def mtf_series(reports: Sequence[MtfReport], *, by: str | None = None) -> MtfSeries:
    """Compare reports, ordered by a key of the records in their files.

    by : a key such as ``f_number``, ``iso`` or ``camera.lens.f_number``, or one of ``WORDS``

    Raises UnsupportedError for a file without a description, UnknownNameError for a key in none of them,
    InvalidValueError for an ambiguous one.

    >>> import camsim
    >>> mtf_series([camsim.measure.measure_mtf(name) for name in ("f4.dng", "f8.dng")], by="f_number")  # doctest: +SKIP
    """
    check(reports, tuple[MtfReport, ...], "reports")
    check(by, str | None, "by")
    if by is None:
        return MtfSeries(by=None, values=_names([report.file for report in reports]), reports=tuple(reports))
    trees = []
    for report in reports:
        if report.description is None:
            raise UnsupportedError(
                f"it does not say what it was taken with, so that nothing tells its {by}; leave --by out",
                stage=report.file,
            )
        trees.append(dict(_leaves(report.description, "")))
    key = _key(trees, WORDS.get(by, by))
    values = tuple(tree.get(key) for tree in trees)
    order = list(range(len(reports)))
    if all(isinstance(value, float) for value in values):
        order.sort(key=lambda k: (values[k], k))
    return MtfSeries(by=by, values=tuple(values[k] for k in order), reports=tuple(reports[k] for k in order))


def _leaves(tree: Any, place: str) -> Iterator[tuple[str, Value]]:
    """Yield every scalar of a description with its path; numbers as floats."""
    if isinstance(tree, Mapping):
        for key, part in tree.items():
            yield from _leaves(part, f"{place}.{key}" if place else str(key))
    elif isinstance(tree, (list, tuple)):
        for number, part in enumerate(tree):
            if isinstance(part, (Mapping, list, tuple)):
                yield from _leaves(part, f"{place}.{number}")
    elif tree is None or isinstance(tree, (bool, str)):
        yield place, tree
    elif isinstance(tree, (int, float)):
        yield place, float(tree)


def _key(trees: Sequence[Mapping[str, Value]], asked: str) -> str:
    """Return the path of a key: the only one with that ending, or of several the only one that varies."""
    every = dict.fromkeys(place for tree in trees for place in tree)
    if asked in every:
        return asked
    found = [place for place in every if place.endswith(f".{asked}")]
    if not found:
        raise UnknownNameError("key", asked, {place.rpartition(".")[2] for place in every} | set(WORDS), key="--by")
    changing = [place for place in found if len({tree.get(place) for tree in trees}) > 1]
    chosen = changing if changing else found
    if len(chosen) > 1:
        more = f" and {len(chosen) - _MOST_NAMED} more" if len(chosen) > _MOST_NAMED else ""
        raise InvalidValueError(
            f"{asked!r} may be {', '.join(chosen[:_MOST_NAMED])}{more}; write one of them in full", key="--by"
        )
    return chosen[0]


def _names(files: Sequence[str]) -> tuple[str, ...]:
    """Return labels of files, numbered if names are equal."""
    names = [PurePath(file).name for file in files]
    return tuple(name if names.count(name) == 1 else f"{name} ({k})" for k, name in enumerate(names, start=1))
