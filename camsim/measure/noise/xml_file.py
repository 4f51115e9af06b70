"""Results of one channel as XML, in the form of the standard's reference implementation.

That is the program emva1288 on PyPI, of the working group: ``results`` / section / figure / ``short``, ``symbol``,
``unit``, ``value``, with its names. A figure that is not measurable is ``None``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from xml.etree import ElementTree as Etree

from camsim.measure.noise.result import ChannelNoise


def xml_of(channel: ChannelNoise) -> bytes:
    """Return the figures of a channel that the standard defines."""
    root = Etree.Element("results")
    for section, name, (short, symbol, unit), value in _figures(channel):
        parent = root.find(section)
        figure = Etree.SubElement(parent if parent is not None else Etree.SubElement(root, section), name)
        stated = f"{value:.9g}" if math.isfinite(value) else "None"
        for tag, text in (("short", short), ("symbol", symbol), ("unit", unit), ("value", stated)):
            Etree.SubElement(figure, tag).text = text
    Etree.indent(root)
    found: bytes = Etree.tostring(root, encoding="utf-8", xml_declaration=True)
    return found + b"\n"


def _figures(channel: ChannelNoise) -> Iterator[tuple[str, str, tuple[str, str, str], float]]:
    """Yield section, name, (short, symbol, unit) and value."""
    value = {name: each.value if each.measurable else math.nan for name, each in channel.figures().items()}
    gain, read_e, saturation_e = value["gain_dn_per_e"], value["read_noise_e"], value["saturation_e"]
    root_db = 20.0 * math.log10(math.sqrt(saturation_e)) if saturation_e > 0.0 else math.nan
    least_e = value["sensitivity_threshold_e"]
    yield "sensitivity", "K", ("System gain", "K", "DN/e-"), gain
    yield "sensitivity", "inverse_K", ("Inverse of overall system gain", "1/K", "e-/DN"), 1.0 / gain
    yield "sensitivity", "sigma_d", ("Temporal Dark Noise", "sigma_d", "e-"), read_e
    yield "sensitivity", "u_e_min", ("Sensitivity threshold", "mu_e.min", "e-"), least_e
    yield "sensitivity", "u_e_sat", ("Saturation Capacity", "mu_e.sat", "e-"), saturation_e
    yield "sensitivity", "SNR_max", ("Signal-to-Noise Ratio", "SNR_max", ""), math.sqrt(max(saturation_e, 0.0))
    yield "sensitivity", "SNR_max_dB", ("Maximum Signal to Noise Ratio in Db", "SNR_max.dB", "dB"), root_db
    yield "sensitivity", "DR", ("Dynamic Range", "DR", ""), saturation_e / least_e
    yield "sensitivity", "DR_dB", ("Dynamic Range", "DR_dB", "dB"), value["dynamic_range_db"]
    error = 100.0 * value["linearity_error"]
    yield "linearity", "LE", ("Mean linearity error", "LE", "%"), error
    dark = value["dark_current_e_per_s"]
    yield "dark_current", "u_I_mean", ("Dark Current from mean", "mu_I.mean", "e-/s"), dark
    yield "spatial", "DSNU1288", ("DSNU", "DSNU_1288", "e-"), value["dsnu_e"]
    yield "spatial", "PRNU1288", ("PRNU", "PRNU_1288", "%"), 100.0 * value["prnu"]
