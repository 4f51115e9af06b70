"""Results of a measurement of noise."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, fields
from typing import Any

from camsim.core.arrays import F64
from camsim.core.note import Note
from camsim.measure.noise.estimate import Estimate
from camsim.measure.noise.photon_transfer import PhotonTransfer

UNITS = {
    "gain_dn_per_e": "DN/e⁻",
    "read_noise_e": "e⁻",
    "full_well_e": "e⁻",
    "dark_current_e_per_s": "e⁻/s",
    "dsnu_e": "e⁻",
    "prnu": "fraction",
    "linearity_error": "fraction",
    "sensitivity_threshold_e": "e⁻",
    "saturation_e": "e⁻",
    "snr_max_db": "dB",
    "dynamic_range_db": "dB",
}

BENT = "bent"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Spectrogram:
    """Power spectra of fixed patterns (EMVA 1288 R4, 8.5).

    frequency_cycles_per_pixel : (n,) of the sensor's pitch
    rows, cols : (n,) root of the power along rows and along columns, DN; white noise of σ gives σ at every frequency
    """

    frequency_cycles_per_pixel: F64
    rows: F64
    cols_frequency_cycles_per_pixel: F64
    cols: F64


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ChannelNoise:
    """The figures of one channel.

    transfer         : gain, read noise, full well, dark current, DSNU, PRNU, linearity
    sensitivity_threshold_e : the signal that is as large as its noise, √(σ_d² + σ_q²/K² + ¼) + ½; σ_q² = 1/12 DN²
    saturation_e     : the signal of full flats, limited by the well or the converter
    snr_max_db       : √saturation_e, by photon noise alone
    dynamic_range_db : saturation over the sensitivity threshold
    exposure, signal_dn, variance_dn2, snr : (n,) of the flats, above dark; snr: signal over temporal noise
    dark, flat       : spectrograms of the mean dark and of the flat nearest to half of saturation
    expected         : figures of the camera's profile, if known
    notes            : remarks on the figures
    """

    channel: str
    photosites: int
    defects_left_out: int
    transfer: PhotonTransfer
    sensitivity_threshold_e: Estimate
    saturation_e: Estimate
    snr_max_db: Estimate
    dynamic_range_db: Estimate
    exposure: F64
    signal_dn: F64
    variance_dn2: F64
    snr: F64
    dark: Spectrogram
    flat: Spectrogram
    expected: dict[str, float] | None = None
    notes: tuple[Note, ...] = ()

    def remark(self, name: str) -> str:
        """Return the remark on a figure: "bent" if a non-linear read-out affects it."""
        by_gain = "e⁻" in UNITS[name] or UNITS[name] == "dB"
        return BENT if by_gain and any(note.code == BENT for note in self.notes) else ""

    def figures(self) -> dict[str, Estimate]:
        """Return every figure by name, in order."""
        named = {field.name: getattr(self.transfer, field.name) for field in fields(PhotonTransfer)}
        more = ("sensitivity_threshold_e", "saturation_e", "snr_max_db", "dynamic_range_db")
        return named | {name: getattr(self, name) for name in more}

    def as_dict(self) -> dict[str, Any]:
        """Return plain values for JSON; a figure that is not measurable has a reason in place of a value."""
        tree: dict[str, Any] = {
            "channel": self.channel,
            "photosites": self.photosites,
            "defects_left_out": self.defects_left_out,
        }
        figures: dict[str, Any] = {}
        for name, estimate in self.figures().items():
            stated: dict[str, Any] = {"unit": UNITS[name]}
            if estimate.measurable:
                stated |= {"value": estimate.value, "standard_error": estimate.sigma}
                if remark := self.remark(name):
                    stated["remark"] = remark
            else:
                stated |= {"value": None, "not_measurable": estimate.why_not}
                if math.isfinite(estimate.at_most):
                    stated["at_most"] = estimate.at_most
            expected = (self.expected or {}).get(name, math.nan)
            if math.isfinite(expected):
                stated["expected"] = expected
            figures[name] = stated
        tree["figures"] = figures
        tree["notes"] = [asdict(note) for note in self.notes]
        for name in ("exposure", "signal_dn", "variance_dn2", "snr"):
            tree[name] = getattr(self, name).tolist()
        for name in ("dark", "flat"):
            spectrogram = getattr(self, name)
            tree[f"spectrogram_{name}_dn"] = {
                field.name: getattr(spectrogram, field.name).tolist() for field in fields(Spectrogram)
            }
        return tree


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class NoiseReport:
    """All channels of one sensor."""

    source: str
    rows: int
    cols: int
    frames: int
    channels: tuple[ChannelNoise, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return the result as plain values for JSON."""
        head = {name: getattr(self, name) for name in ("source", "rows", "cols", "frames")}
        return {**head, "standard": "EMVA 1288 R4", "channels": [channel.as_dict() for channel in self.channels]}
