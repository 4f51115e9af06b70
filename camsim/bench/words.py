"""The results of a bench as sentences."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from camsim.bench.records import Head, Point, Record, TruthLine
from camsim.bench.settings import power

NOISE = 1.15  # two times that differ by less are the same


def findings(records: Iterable[Record]) -> Iterator[str]:
    """Yield sentences on the results of a bench."""
    found = list(records)
    points = [r for r in found if isinstance(r, Point)]
    for head in (r for r in found if isinstance(r, Head)):
        yield words_of_window(head)
    yield from words_of_truths([r for r in found if isinstance(r, TruthLine)])
    each = [p for p in points if p.method == "auto"] or points
    for point in each:
        yield words_of_point(point, points)


def words_of_window(head: Head) -> str:
    """Return a text on what was rendered."""
    row, col = head.origin
    window = f"{head.rows} × {head.cols} photosites from [{row}, {col}]"
    if (head.rows, head.cols) == (head.frame_rows, head.frame_cols):
        return f"Rendered: {window}, {head.chosen}."
    return f"Rendered: {window} of {head.frame_rows} × {head.frame_cols}, {head.chosen}; times and errors are of these."


def words_of_truths(truths: Sequence[TruthLine]) -> Iterator[str]:
    """Return a text on the truth to which errors refer, and on its accuracy."""
    for t in truths:
        yield (
            f"Truth: {t.engine} at {power(t.tolerance)}; {t.checked_photosites} of its photosites computed directly "
            f"differ by {short(t.checked_to)} at most."
        )
    if len(truths) == 2 and truths[0].difference is not None:
        yield (
            f"The two truths differ by {short(truths[0].difference)} at most, anywhere in the window; "
            "each engine is compared with the other's, and errors below "
            f"{' and '.join(f'{short(t.accurate_to)} ({t.engine})' for t in truths)} cannot be distinguished."
        )
    elif truths:
        yield (
            f"No other engine renders this window so finely in the time: {truths[0].engine} is compared with itself at "
            "its finest, and with what was computed directly."
        )


def words_of_point(point: Point, points: Sequence[Point]) -> str:
    """Return a text on a setting's time and error, and on what is faster at no larger error."""
    ran = f" ({point.engine})" if point.engine != point.method else ""
    label = point.label if point.tolerance is None else f"{point.method} at {power(point.tolerance)}"
    error, reached = f"error {short(point.error_max)}", point.error_max
    if point.by_itself:
        error += f" from itself at {point.truth.partition(' at ')[2]}"
    if not point.distinguishable and point.at_most > 0.0:
        error = f"error about {short(point.at_most)} or less ({short(point.error_estimate)} where computed directly)"
        reached = min(point.error_max, point.error_estimate)
    quicker = [p for p in points if p.at_most <= reached and is_faster(p, point)]
    words = f"{label}{ran}: {seconds(point.wall_s)}, {error}; "
    if not quicker:
        near = [p for p in points if p.wall_s < point.wall_s and p.error_max <= max(point.error_max, point.at_most)]
        if not near:
            return words + "nothing is faster at that error."
        best = min(near, key=lambda p: p.wall_s)
        return words + f"nothing is clearly faster at that error ({best.label}: {seconds(best.wall_s)})."
    best = min(quicker, key=lambda p: p.wall_s)
    return words + f"{best.label} is faster at no larger an error: {seconds(best.wall_s)}."


def is_faster(one: Point, other: Point) -> bool:
    """Whether one took clearly less time by both clocks: a busy machine misleads either."""
    return NOISE * one.wall_s < other.wall_s and NOISE * one.cpu_s < other.cpu_s


def short(value: float) -> str:
    """Return an error to one digit.

    >>> short(2.34e-8), short(0.0), short(0.0312)
    ('2e-8', '0', '0.03')
    """
    if value == 0.0:
        return "0"
    return f"{value:.1g}" if value >= 1e-3 else power(float(f"{value:.0e}"))


def seconds(value: float) -> str:
    """Return a time in words.

    >>> seconds(0.1312), seconds(0.00042), seconds(12.345)
    ('0.13 s', '0.00042 s', '12 s')
    """
    return f"{float(f'{value:.2g}'):g} s"
