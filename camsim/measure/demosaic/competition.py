"""Several methods on one subject: ranked verdicts, and reasons for missing ones."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from camsim.camera.frame import Frame
from camsim.core.arrays import F32
from camsim.core.typed import check
from camsim.errors import CamsimError
from camsim.measure.demosaic.methods import Method
from camsim.measure.demosaic.subject import Subject
from camsim.measure.demosaic.verdict import Verdict, evaluate
from camsim.measure.given import check_given

OnVerdict = Callable[[Verdict, F32], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Ranking:
    """The verdicts on one subject, the best CPSNR first.

    rows, cols : size of the picture;  photosites: number used, without border and clipped ones
    left_out   : a sentence for each method that could not be run
    """

    subject: str
    rows: int
    cols: int
    photosites: int
    clipped: int
    cfa: str
    verdicts: tuple[Verdict, ...]
    left_out: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Return the result as plain values for JSON."""
        head = {name: getattr(self, name) for name in ("subject", "rows", "cols", "photosites", "clipped", "cfa")}
        verdicts = [{"rank": rank, **verdict.as_dict()} for rank, verdict in enumerate(self.verdicts, start=1)]
        return {**head, "verdicts": verdicts, "left_out": list(self.left_out)}


def compete(
    subject: Subject,
    frame: Frame,
    entries: Iterable[Method],
    *,
    left_out: Iterable[str] = (),
    on_verdict: OnVerdict | None = None,
) -> Ranking:
    """Run methods on a frame and rank them; ``on_verdict`` is called with each verdict and the method's picture."""
    check_given(frame=frame)
    check(subject, Subject, "subject")
    verdicts, why = [], list(left_out)
    for method in entries:
        try:
            verdict, image = evaluate(method.run(frame), subject, method=method.name, scale=subject.level)
        except CamsimError as error:
            why.append(str(error) if method.name in str(error) else f"{method.name}: {error}")
            continue
        verdicts.append(verdict)
        if on_verdict is not None:
            on_verdict(verdict, image)
    return ranked(subject, verdicts, why)


def ranked(subject: Subject, verdicts: Iterable[Verdict], left_out: Iterable[str] = ()) -> Ranking:
    """Return the verdicts in order of CPSNR."""
    check(subject, Subject, "subject")
    return Ranking(
        subject=subject.name,
        rows=subject.shape[0],
        cols=subject.shape[1],
        photosites=int(subject.used.sum()),
        clipped=subject.clipped,
        cfa="/".join(subject.cfa or ()),
        verdicts=tuple(sorted(verdicts, key=lambda verdict: (-verdict.cpsnr_db, verdict.method))),
        left_out=tuple(left_out),
    )
