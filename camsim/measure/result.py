"""Results of an MTF measurement, each figure with its standard error."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import Any

from camsim.core.arrays import F64
from camsim.core.note import Note
from camsim.measure.acutance import DISTANCES_PICTURE_HEIGHTS, acutance
from camsim.measure.field import FieldPlace, field_place
from camsim.measure.full_frame import NYQUIST_OF_SENSOR_CYCLES_PER_PIXEL, FullFrame
from camsim.measure.geometry import Roi


@dataclass(frozen=True, slots=True, kw_only=True)
class Figures:
    """The figures of one edge, or their standard errors; NaN where there is none.

    mtf50_cycles_per_pixel   : lowest frequency at which the MTF falls to 50 %; mtf30, mtf10 likewise
    mtf_at_nyquist           : at the channel's Nyquist frequency, half its sampling frequency
    mtf_at_nyquist_of_sensor : at that of all photosites, 0.5 cycles per pixel
    rise_10_90_pixel         : distance over which the edge-spread function rises from 10 to 90 %
    angle_deg                : turn from the nearest pixel axis, −45..45°, clockwise as displayed
    contrast                 : (bright − dark)/(bright + dark), black level subtracted
    snr                      : step over the scatter of a photosite about the fit
    """

    mtf50_cycles_per_pixel: float
    mtf30_cycles_per_pixel: float
    mtf10_cycles_per_pixel: float
    mtf_at_nyquist: float
    mtf_at_nyquist_of_sensor: float
    rise_10_90_pixel: float
    angle_deg: float
    contrast: float
    snr: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Theory:
    """What the optics should give at this edge, at the same frequencies.

    mtf                    : (n,) absolute value of the product of the transfer functions
    difference             : (n,) measured − theory
    mtf50_cycles_per_pixel, mtf_at_nyquist, mtf_at_nyquist_of_sensor : figures of the theory; see Figures
    difference_to_nyquist  : the largest |difference| up to the channel's Nyquist frequency
    """

    mtf: F64
    difference: F64
    mtf50_cycles_per_pixel: float
    mtf_at_nyquist: float
    mtf_at_nyquist_of_sensor: float
    difference_to_nyquist: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EdgeMtf:
    """One edge in one channel.

    figures, standard_error    : see Figures
    channel, roi               : where it was measured
    x_pixel, y_pixel           : a point of the edge
    normal_deg                 : direction from dark to bright, clockwise as displayed from the x axis
    curvature_per_pixel        : 1/radius of the edge
    nyquist_cycles_per_pixel   : Nyquist frequency of the channel's lattice; the sensor's is 0.5
    tail                       : whether the line spread beyond the region was added (tail_fraction: its share)
    frequency_cycles_per_pixel : (n,);  mtf, mtf_error: (n,) and its standard error
    distance_pixel             : (m,) across the edge;  esf: 0 dark … 1 bright;  line_spread_per_pixel: its derivative
    knot_spacing_pixel         : resolution of the spread function
    photosites, left_out       : number used, and number left out as defects
    notes                      : remarks
    theory                     : None unless a transfer function was given
    """

    figures: Figures
    standard_error: Figures
    channel: str
    roi: Roi
    x_pixel: float
    y_pixel: float
    normal_deg: float
    curvature_per_pixel: float
    nyquist_cycles_per_pixel: float
    tail: bool
    tail_fraction: float
    frequency_cycles_per_pixel: F64
    mtf: F64
    mtf_error: F64
    distance_pixel: F64
    esf: F64
    line_spread_per_pixel: F64
    knot_spacing_pixel: float
    photosites: int
    left_out: int
    notes: tuple[Note, ...] = ()
    theory: Theory | None = None

    def as_dict(self) -> dict[str, Any]:
        """Return plain values for JSON: figures at the top, NaN as None, ``roi`` as row, col, rows, cols."""
        tree: dict[str, Any] = {"channel": self.channel, "roi": asdict(self.roi)}
        tree |= {f.name: getattr(self.figures, f.name) for f in fields(Figures)}
        tree["standard_error"] = asdict(self.standard_error)
        displayed = {f.name for f in fields(self)} - {"figures", "standard_error", "channel", "roi", "theory"}
        tree |= {f.name: getattr(self, f.name) for f in fields(self) if f.name in displayed}
        tree["notes"] = [asdict(note) for note in self.notes]
        if self.theory is not None:
            tree["theory"] = asdict(self.theory)
        return {key: _plain(value) for key, value in tree.items()}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MtfReport:
    """All edges of one picture, and why others were left out.

    full_frame  : the camera's full frame, whose height is the picture height also of a window
    description : the description in the file; None for other files
    """

    file: str
    pitch_um: float | None
    edges: tuple[EdgeMtf, ...]
    full_frame: FullFrame
    refused: tuple[str, ...] = ()
    description: Mapping[str, Any] | None = field(default=None, repr=False)

    def place(self, edge: EdgeMtf) -> FieldPlace:
        """Return the field position of an edge, and whether its MTF is sagittal or tangential."""
        return field_place(edge.x_pixel, edge.y_pixel, math.radians(edge.normal_deg), self.full_frame)

    def nyquist(self) -> dict[str, dict[str, float]]:
        """Return the Nyquist frequency of the sensor and that of each channel, in every unit."""
        one = {edge.channel: edge.nyquist_cycles_per_pixel for edge in self.edges}
        every = {"sensor": NYQUIST_OF_SENSOR_CYCLES_PER_PIXEL, **one}
        return {name: self.full_frame.in_units(frequency) for name, frequency in every.items()}

    def acutance(self, edge: EdgeMtf, distance_picture_heights: float) -> float:
        """Return the acutance of the frame at a viewing distance, if it is as sharp everywhere as at this edge."""
        return acutance(
            edge.frequency_cycles_per_pixel,
            edge.mtf,
            rows=self.full_frame.rows,
            distance_picture_heights=distance_picture_heights,
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the result as plain values for JSON."""
        return {
            "file": self.file,
            "pitch_um": self.pitch_um,
            "picture_height_pixel": self.full_frame.rows,
            "nyquist": _plain(self.nyquist()),
            "edges": [self._edge(edge) for edge in self.edges],
            "refused": list(self.refused),
        }

    def _edge(self, edge: EdgeMtf) -> dict[str, Any]:
        tree = edge.as_dict()
        for level in (50, 30, 10):
            each = self.full_frame.in_units(getattr(edge.figures, f"mtf{level}_cycles_per_pixel"))
            tree |= {f"mtf{level}_{unit}": _plain(value) for unit, value in each.items()}
        tree["field"] = _plain(asdict(self.place(edge)))
        tree["acutance_at_picture_heights"] = {f"{d:g}": self.acutance(edge, d) for d in DISTANCES_PICTURE_HEIGHTS}
        return tree


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, (tuple, list)):
        return [_plain(entry) for entry in value]
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
