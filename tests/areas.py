"""Areas of what is seen, by Green's theorem over its edges."""

import numpy as np


def _under(found):
    return 0.5 * (found.start_um[:, 0] * found.end_um[:, 1] - found.start_um[:, 1] * found.end_um[:, 0])


def area_of(found, region=1):
    """Area of a region of an arrangement."""
    return float(np.sum(((found.left == region).astype(float) - (found.right == region)) * _under(found)))


def brightness(found):
    """Area times what each region is brighter than the background, of all regions of an arrangement."""
    surface = np.array(found.spectra, float)
    return float(_under(found) @ (surface[found.left] - surface[found.right]))


def area_seen(pieces, region=1):
    """Area of a region by the pieces, sides and arcs, that the check sees."""
    o = pieces.outlines
    end = o.from_rad + o.turn_rad
    arcs = o.dx * (
        o.dx * o.turn_rad + o.x * (np.sin(end) - np.sin(o.from_rad)) - o.y * (np.cos(end) - np.cos(o.from_rad))
    )
    sides = (pieces.left == region).astype(float) - (pieces.right == region)
    return float(np.sum(sides * 0.5 * np.where(o.turn_rad == 0.0, o.x * o.dy - o.y * o.dx, arcs)))
