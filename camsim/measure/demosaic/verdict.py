"""Evaluation of one result against its truth."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from camsim.core.arrays import F32
from camsim.core.typed import check
from camsim.errors import InvalidValueError, UnsupportedError
from camsim.measure.demosaic.alignment import SHIFTED_PX, best_shift
from camsim.measure.demosaic.artefacts import artefacts
from camsim.measure.demosaic.develop import developed
from camsim.measure.demosaic.phases import order_fault
from camsim.measure.demosaic.scaling import Fault, scaled
from camsim.measure.demosaic.similarity import ms_ssim, psnr_db, ssim
from camsim.measure.demosaic.subject import CHANNELS, Subject
from camsim.measure.demosaic.whole import channel_shifted, enlarged, overflowed, turned
from camsim.measure.given import check_given

_ROUNDING = 2e-6
"""Relative to the largest value: differences below the rounding of scaled 32-bit numbers."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """Quality figures of a demosaiced picture; see docs/demosaic.md for every formula.

    cpsnr_db, psnr_db  : linear light, peak: a perfect diffuser; infinite for an identical picture
    cpsnr_developed_db : of the developed pictures (camera matrix, sRGB curve), peak 1
    ssim, ms_ssim      : of the developed pictures, the mean over channels; ms_ssim NaN below 176 px a side
    delta_e_mean, delta_e_95, zipper, false_colour : see ``Artefacts``
    shift_x_px, shift_y_px : shift of the picture against the truth, right and down
    identical          : whether the picture is the truth itself, to the rounding of 32-bit numbers
    scale              : value of a perfect diffuser in the picture;  balanced: whether it was white-balanced
    faults             : faults of the picture as a whole, by name
    """

    method: str
    cpsnr_db: float
    psnr_db: tuple[float, float, float]
    cpsnr_developed_db: float
    ssim: float
    ms_ssim: float
    delta_e_mean: float
    delta_e_95: float
    zipper: float
    false_colour: float
    shift_x_px: float
    shift_y_px: float
    identical: bool
    scale: float
    balanced: bool
    faults: tuple[Fault, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Return plain values for JSON; an infinite PSNR is None, with ``identical`` true."""
        tree = {field.name: getattr(self, field.name) for field in fields(self)}
        tree["psnr_db"] = {name: _finite(value) for name, value in zip(CHANNELS, self.psnr_db, strict=True)}
        tree["faults"] = [{"name": fault.name, "sentence": fault.sentence} for fault in self.faults]
        return {key: _finite(value) for key, value in tree.items()}


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def evaluate(found: F32, subject: Subject, *, method: str, scale: float | None = None) -> tuple[Verdict, F32]:
    """Return the verdict, and the result on the truth's scale.

    found : (rows, cols, 3) linear
    scale : value of a perfect diffuser in a balanced result; None: found by comparison, and faults are looked for
    """
    check_given(found=found)
    check(subject, Subject, "subject")
    if found.shape != subject.truth.shape:
        raise InvalidValueError(
            f"{found.shape[0]} × {found.shape[1]} pixels, and the truth has {subject.shape[0]} × {subject.shape[1]}; "
            "give a result of the same size, not cropped and not turned",
            key="size",
            stage=method,
        )
    if not np.isfinite(found).all():
        bad = int(np.count_nonzero(~np.isfinite(found)))
        raise UnsupportedError(f"{bad} of its values are no numbers (NaN or infinite)", stage=method)
    if scale is None:
        whole = turned(found, subject) or overflowed(found, subject) or order_fault(found, subject)
        fitted = scaled(found, subject)
        # With a wrong filter order or another picture, levels and gamma are meaningless.
        faults = (whole,) if whole is not None else fitted.faults
        image, level, balanced = fitted.image, fitted.scale, fitted.balanced
    else:
        image, level, balanced, faults = found / np.float32(scale), scale, True, ()
    identical = bool(np.abs(image - subject.truth).max() <= _ROUNDING * max(1.0, float(subject.truth.max())))
    if identical:
        image = subject.truth
    x, y = best_shift(image, subject)
    if not {fault.name for fault in faults} & {"wrong phase", "flipped", "overflowed"}:
        channel = channel_shifted(image, subject)
        if channel is not None:
            faults = (*faults, channel)
        elif math.hypot(x, y) > SHIFTED_PX:
            said = f"it lies {x:+.2f} px to the right of the truth and {y:+.2f} px below it"
            faults = (*faults, Fault("shifted", said))
        if (large := enlarged(image, subject)) is not None:
            faults = (*faults, large)
    cpsnr, channels = psnr_db(image, subject.truth, subject.used)
    displayed, wanted = developed(image, subject.to_xyz), developed(subject.truth, subject.to_xyz)
    seen = artefacts(image, subject)
    verdict = Verdict(
        method=method,
        cpsnr_db=cpsnr,
        psnr_db=(channels[0], channels[1], channels[2]),
        cpsnr_developed_db=psnr_db(displayed, wanted, subject.used)[0],
        ssim=ssim(displayed, wanted, subject.used),
        ms_ssim=ms_ssim(displayed, wanted, subject.used),
        delta_e_mean=seen.delta_e_mean,
        delta_e_95=seen.delta_e_95,
        zipper=seen.zipper,
        false_colour=seen.false_colour,
        shift_x_px=x,
        shift_y_px=y,
        identical=identical,
        scale=level,
        balanced=balanced,
        faults=faults,
    )
    return verdict, image
