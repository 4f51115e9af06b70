"""Check that photosites sample an edge at all phases, and each phase repeatedly."""

from __future__ import annotations

import math

from camsim.errors import UnsupportedError
from camsim.measure.geometry import EdgeLine
from camsim.measure.picture import Channel

LARGEST_GAP = 0.4
_REPEATED_PERIODS = 3.0
_DIAGONALS = ((1, 1), (1, 2), (2, 1))


def refuse_gap(gap: float, line: EdgeLine, length: float, its_length: float, channel: Channel, what: str) -> None:
    """Raise UnsupportedError if phases are missing or occur only once: then a wrong angle could not be told from blur.

    gap        : longest stretch across the edge without a photosite
    length     : length of the region along the edge, corners included;  its_length: that of the edge within it
    """
    angle = line.angle_deg
    slant = math.tan(math.radians(abs(angle)))
    # Phases of the first lines must recur in later ones, which separates blur from a wrong angle.
    missing, again = channel.gap_pixel, _REPEATED_PERIODS * channel.period_pixel
    if slant * (length - again) < missing:
        need = math.ceil(missing / max(slant, 1e-3) + again)
        longer = f"take a region {need} px long, or " if need < 20.0 * length else ""
        enough = math.degrees(math.atan2(missing, max(length - again, missing))) + 0.5
        raise UnsupportedError(
            f"an edge of {angle:.2f}° is too close to a pixel axis for {length:.0f} px of length, sampling "
            f"phases are missing; {longer}turn the edge to {enough:.0f}° or more",
            stage=what,
        )
    if gap > LARGEST_GAP or (len(channel.planes) == 1 and _come_once(angle, its_length, channel)):
        never = f"a gap of {gap:.2f} px across the edge is never sampled" if gap > LARGEST_GAP else "each comes once"
        raise UnsupportedError(
            f"at {angle:.2f}° the sampling phases repeat ({never}), as they do at 45°, atan(1/2) and their like; "
            "turn the edge by 2°, or take a longer region",
            stage=what,
        )


def _come_once(angle_deg: float, length: float, channel: Channel) -> bool:
    """Whether phases occur only once because the edge is near a diagonal of the lattice.

    Photosites along the direction (m, n) of the lattice form lines that are step/√(m² + n²) apart and repeat after
    step·√(m² + n²); along the edge such a line moves across it by the tangent of the angle between the two.
    """
    step = channel.period_pixel
    for m, n in _DIAGONALS:
        long = math.hypot(m, n)
        slant = math.tan(math.radians(abs(abs(angle_deg) - math.degrees(math.atan2(m, n)))))
        if slant * (length - _REPEATED_PERIODS * step * long) < step / long:
            return True
    return False
