"""Linearisation of a picture whose read-out was not linear, as transfer functions need it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from camsim.camera.capture import Capture
from camsim.core.arrays import F64
from camsim.measure.picture import Picture, Plane
from camsim.sensor.stages.nonlinearity import Nonlinearity, charge_e

_NODES = 8193
"""Nodes of the piecewise-linear inverse response: a relative error of 1e-8."""


def straightened(picture: Picture, capture: Capture) -> Picture:
    """Return a capture's picture with its camera's non-linearity inverted.

    Mean electrons and the truth precede the read-out and are unchanged.
    """
    bends = capture.camera.nonlinearity
    if bends is None:
        return picture
    per_dn = capture.camera.converter.electrons_per_dn_at(capture.exposure.iso)
    return replace(picture, planes=tuple(_plane(plane, bends, per_dn) for plane in picture.planes))


def _plane(plane: Plane, bends: Nonlinearity, electrons_per_dn: float) -> Plane:
    if not plane.holds_dark:
        return plane
    per_unit = 1.0 if plane.white is None else electrons_per_dn
    levels = np.array([level for level in (plane.white, plane.lowest) if level is not None])
    signals_e = [(numbers.astype(np.float64) - plane.black) * per_unit for numbers in (plane.samples, levels)]
    reach = np.concatenate([signal.ravel() for signal in signals_e])
    charges = _nodes(bends, float(reach.min()), float(reach.max()))
    samples, ends = (
        plane.black + np.interp(signal, bends.response(charges), charges) / per_unit for signal in signals_e
    )
    straight = iter(ends.tolist())
    return replace(
        plane,
        samples=samples,
        white=None if plane.white is None else next(straight),
        lowest=None if plane.lowest is None else next(straight),
    )


def _nodes(bends: Nonlinearity, low_e: float, high_e: float) -> F64:
    """Return charges whose responses span the range of signals; below 0, where noise leads, the response is linear."""
    most = charge_e(bends, high_e) if high_e > 0.0 else 1.0
    even = np.linspace(min(2.0 * low_e, 0.0), most, _NODES)
    one = getattr(bends, "electrons_in", ())
    return np.union1d(even, [at for at in one if at < most])
