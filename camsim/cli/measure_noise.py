"""``camsim measure noise``: figures from flats and darks of a folder or of a sensor."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_type_hints

from camsim.cli.measure_mtf_table import with_error
from camsim.cli.measured import Outputs
from camsim.cli.tables import check_text_file, print_table
from camsim.core.note import Note
from camsim.core.typed import Iso, Seed, check
from camsim.errors import ConfigError, InvalidValueError, OutputError
from camsim.files.atomic import made_together, together, write_whole

if TYPE_CHECKING:
    from camsim.measure.noise import NoiseReport

_WORDS = {
    "gain_dn_per_e": "gain",
    "read_noise_e": "read noise",
    "full_well_e": "full well",
    "dark_current_e_per_s": "dark current",
    "dsnu_e": "DSNU",
    "prnu": "PRNU",
    "sensitivity_threshold_e": "sensitivity threshold",
    "saturation_e": "saturation",
    "snr_max_db": "SNR at saturation",
    "dynamic_range_db": "dynamic range",
}
_POINTS = ("exposure", "signal_dn", "variance_dn2", "snr")


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseRequest:
    """The options of the command, as the user gave them."""

    folder: str | None
    sensor: str | None
    sensors: Sequence[str]
    changes: Sequence[str]
    side: int
    frames: int
    iso: float | None
    seed: int | None
    keep: str | None
    cfa: str | None
    xml: str | None
    outputs: Outputs


def measure(request: NoiseRequest) -> None:
    """Measure, print and write what is requested; raises CamsimError with one sentence."""
    from camsim.measure.noise.taking import Frames, Side

    if (request.folder is None) == (request.sensor is None):
        raise InvalidValueError("give a folder of flats and darks, or --sensor NAME, which takes them", key="FOLDER")
    given = {"--set": request.changes, "--iso": request.iso, "--seed": request.seed, "--keep": request.keep}
    if request.folder is not None and (idle := [name for name, value in given.items() if value not in (None, ())]):
        raise InvalidValueError("the frames of a folder are taken; this belongs to --sensor", key=idle[0])
    if request.sensor is not None and request.cfa is not None:
        raise InvalidValueError("belongs to a folder; a sensor says its own (--set sensor.cfa=…)", key="--cfa")
    check(request.side, Side, "--side")
    check(request.frames, Frames, "--frames")
    if request.iso is not None:
        check(request.iso, Iso, "--iso")
    if request.seed is not None:
        check(request.seed, Seed, "--seed")
    request.outputs.check({"--xml": request.xml})
    if request.xml is not None:
        if Path(request.xml).suffix.lower() != ".xml":
            raise OutputError(f"cannot write {request.xml!r}: results after EMVA 1288 are an .xml")
        check_text_file(request.xml, force=request.outputs.force)
    with together() if request.keep is None else made_together(Path(request.keep)):
        report = _report(request)
        if request.xml is not None:
            _write_xml(report, request.xml, force=request.outputs.force)
        rows = [
            (channel.channel, *point)
            for channel in report.channels
            for point in zip(*(getattr(channel, name).tolist() for name in _POINTS), strict=True)
        ]
        request.outputs.write(("channel", *_POINTS), rows, functools.partial(_draw, report))
    request.outputs.tell(report, _print)


def _draw(report: NoiseReport, file: str) -> bytes:
    from camsim.cli.plot_noise import draw

    return draw(report, file)


def _write_xml(report: NoiseReport, file: str, *, force: bool) -> None:
    """Write a file for each channel: the standard treats them as separate cameras."""
    from camsim.measure.noise.xml_file import xml_of

    path = Path(file)
    several = len(report.channels) > 1
    files = {c: path.with_stem(f"{path.stem}-{c.channel}") if several else path for c in report.channels}
    for each in files.values():
        check_text_file(str(each), force=force)
    for channel, each in files.items():
        write_whole(str(each), xml_of(channel))


def _report(request: NoiseRequest) -> NoiseReport:
    from camsim.measure.noise import expected_of, measure_noise, read_shots, take_shots, write_shots

    if request.folder is not None:
        return measure_noise(read_shots(request.folder, cfa=request.cfa))
    from camsim.api import load_camera
    from camsim.measure.noise.taking import frames_of
    from camsim.optics import Airy

    assert request.sensor is not None
    lens = Airy(f_number=8.0)  # nominal lens: flats are uniform
    changes, said = _apart(request.changes)
    said |= {name: value for name, value in (("iso", request.iso), ("seed", request.seed)) if value is not None}
    camera = load_camera(request.sensor, lens=lens, overrides=changes, sensors=request.sensors)
    bench = {"side": request.side, "frames": request.frames, **said}
    if request.keep is not None:
        write_shots(request.keep, dict(frames_of(camera, **bench)))
    shots = take_shots(camera, **bench)
    said.pop("seed", None)
    return measure_noise(shots, expected={name: expected_of(camera, name, **said) for name in shots.channels})


def _apart(texts: Sequence[str]) -> tuple[list[str], dict[str, Any]]:
    """Return the changes of the sensor, and settings of the measurement; raises for others."""
    from camsim.config import overrides
    from camsim.sensor.exposure import Exposure

    kinds = get_type_hints(Exposure, include_extras=True)
    known = {
        "exposure.iso": kinds["iso"],
        "exposure.temperature_c": kinds["temperature_c"],
        "noise.seed": Seed,
    }
    changes, faults = overrides.parse(texts)
    if faults:
        raise ConfigError(faults)
    of_sensor, said = [], {}
    for text, change in zip(texts, changes, strict=True):
        key = ".".join(change.path)
        if change.of_sensor:
            of_sensor.append(text)
        elif key not in known:
            raise InvalidValueError(
                f"a photon transfer has no such key: it takes its flats and darks itself; those of the sensor "
                f"(sensor.readout.read_noise_e …), {', '.join(known)} can be set",
                key=f"--set {key}",
            )
        elif change.value is not None:
            said[key.partition(".")[2]] = check(change.value.plain(), known[key], f"--set {key}")
    return of_sensor, said


def _print(report: NoiseReport) -> None:
    from camsim.measure.noise.result import UNITS

    stated = any(channel.expected for channel in report.channels)
    heads = ["figure", "unit"]
    for channel in report.channels:
        heads += [channel.channel, *(["profile"] if stated else [])]
    rows: list[list[str]] = []
    reasons: dict[str, tuple[dict[str, None], dict[str, None]]] = {}  # figures and channels of each reason
    for name, unit in UNITS.items():
        row = [_WORDS.get(name, name.replace("_", " ")), unit]
        for channel in report.channels:
            estimate = channel.figures()[name]
            limit = f"≤ {estimate.at_most:.2g}" if math.isfinite(estimate.at_most) else "–"
            remark = f" {channel.remark(name)}".rstrip()
            row.append(f"{with_error(estimate.value, estimate.sigma)}{remark}" if estimate.measurable else limit)
            if not estimate.measurable:
                figures, channels = reasons.setdefault(estimate.why_not, ({}, {}))
                figures[row[0]] = channels[channel.channel] = None
            if stated:
                expected = (channel.expected or {}).get(name, math.nan)
                row.append(f"{expected:.5g}" if math.isfinite(expected) else "")
        rows.append(row)
    title = f"{report.source}: {report.frames} frames of {report.rows} × {report.cols}, EMVA 1288 R4"
    print_table(title, heads, rows)
    for reason, (figures, channels) in reasons.items():
        verb = "is" if len(figures) == 1 else "are"
        print(f"{', '.join(figures)} of {', '.join(channels)} {verb} not measurable: {reason}")
    notes: dict[Note, list[str]] = {}
    for channel in report.channels:
        for note in channel.notes:
            notes.setdefault(note, []).append(channel.channel)
    for note, names in notes.items():
        print(f"{', '.join(names)}: {note}")
    for channel in report.channels:
        if channel.defects_left_out:
            print(f"{channel.channel}: {channel.defects_left_out} defects left out")
