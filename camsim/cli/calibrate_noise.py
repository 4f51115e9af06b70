"""``camsim calibrate noise``: a sensor file from a folder of raw files, or a comparison of the two."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from annotated_types import Ge, Le

from camsim.cli.measure_mtf_table import with_error
from camsim.cli.tables import check_text_file, print_table
from camsim.core.typed import Pitch, Seed, check
from camsim.errors import InvalidValueError
from camsim.files.atomic import together, write_whole
from camsim.files.hot_list import hot_text

if TYPE_CHECKING:
    from camsim.measure.calibrate import Calibration, Shot, ShotsOfCamera
    from camsim.measure.calibrate.likeness import SideBySide
    from camsim.measure.noise import Estimate

_APART = 0.01


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrationRequest:
    """The options of the command, as the user gave them."""

    folder: str
    output: str | None
    hot: str | None
    dry_run: bool
    check: str | None
    name: str | None
    pitch_um: float | None
    cfa: str | None
    window: int
    seed: int
    as_json: bool
    plot: str | None
    force: bool


def calibrate(request: CalibrationRequest) -> None:
    """Calibrate, print and write; raises CamsimError with one sentence."""
    from camsim.measure.calibrate import calibrate as calibrated
    from camsim.measure.calibrate import read_folder

    _validate(request)
    shots = read_folder(request.folder, cfa=request.cfa, side=request.window)
    if request.dry_run:
        _print_shots(shots)
        return
    found = calibrated(shots)
    if request.check is not None:
        _check(request, shots, found)
        return
    from camsim.measure.calibrate.profile_file import profile_text

    name = request.name or next((shot.camera for shot in shots.shots if shot.camera), "") or Path(request.folder).name
    text = profile_text(
        found, name=name, pitch_um=request.pitch_um, hot_file=None if request.hot is None else Path(request.hot).name
    )
    with together():
        if request.hot is not None:
            write_whole(request.hot, hot_text(found.hot).encode("utf-8"))
        if request.output is not None:
            write_whole(request.output, text.encode("utf-8"))
        if request.plot is not None:
            from camsim.cli.plot_calibration import draw

            write_whole(request.plot, draw(found, request.plot))
    if request.as_json:
        print(json.dumps(_as_dict(found), indent=1, ensure_ascii=False))
    else:
        _print(found)
        if request.output is not None:
            print(f"{request.output}: camsim expose LIGHT --sensor {_as_path(request.output)} takes it")


def _validate(request: CalibrationRequest) -> None:
    from camsim.cli.new import check_yaml_output

    asked = {"-o": request.output, "--check": request.check, "--dry-run": request.dry_run or None}
    given = [name for name, value in asked.items() if value is not None]
    if len(given) > 1:
        raise InvalidValueError(f"given together with {given[0]}; leave one of the two out", key=given[1])
    if not given and not (request.plot or request.as_json):
        raise InvalidValueError("give one of -o CAMERA.yaml, --check CAMERA.yaml and --dry-run", key="calibrate noise")
    check(request.window, Annotated[int, Ge(32), Le(8192)], "--window")
    check(request.seed, Seed, "--seed")
    if request.pitch_um is not None:
        check(request.pitch_um, Pitch, "--pitch-um")
    if request.output is not None:
        check_yaml_output(request.output, force=request.force)
    if request.hot is not None:
        if request.output is None or Path(request.hot).resolve().parent != Path(request.output).resolve().parent:
            raise InvalidValueError("is of the sensor file that -o writes, and lies in its folder", key="--hot")
        check_text_file(request.hot, force=request.force)
    if request.plot is not None:
        from camsim.cli.plot import check_drawing

        check_drawing(request.plot, force=request.force)


def _as_path(file: str) -> str:
    return file if Path(file).parent != Path() else f"./{file}"


def _print_shots(shots: ShotsOfCamera) -> None:
    """Print the kind of each group of frames, and its source."""
    alike: dict[tuple[object, ...], list[Shot]] = {}
    for shot in sorted(shots.shots, key=lambda each: (each.iso, each.kind, each.time_s or 0.0, each.exposure)):
        key = shot.iso, shot.kind, shot.time_s, shot.exposure, shot.temperature_c, shot.stated_by, shot.read_out
        alike.setdefault(key, []).append(shot)
    rows, both = [], len(shots.read_outs) > 1
    for group in alike.values():
        first = group[0]
        rows.append([
            f"{first.iso:g}" if first.iso_stated else "?", first.kind, first.stated_by,
            "?" if first.time_s is None else f"{first.time_s:g}",
            "" if first.temperature_c is None else f"{first.temperature_c:g}", *[first.read_out] * both,
            str(len(group)), f"{sum(shot.mean_dn for shot in group) / len(group):.1f}",
        ])  # fmt: skip
    filters = "/".join(shots.pattern)
    heads = ["ISO", "kind", "by", "time, s", "°C", *["gain"] * both, "frames", "mean, DN"]
    print_table(f"{shots.name}: {len(shots.shots)} frames of {shots.rows} × {shots.cols}, {filters}", heads, rows)
    from camsim.measure.calibrate.folder import COLUMNS

    print(f"by: what says so; an index.csv ({', '.join(COLUMNS)}) says otherwise")


def _figures(found: Calibration) -> Iterator[tuple[str, Estimate]]:
    from camsim.measure.noise import Estimate

    yield "black_dn", found.black_dn
    for setting in found.settings:
        yield f"electrons_per_dn at ISO {setting.iso:g}", setting.electrons_per_dn
    for field in fields(found):
        value = getattr(found, field.name)
        if isinstance(value, Estimate) and field.name != "black_dn":
            yield field.name, value
    if found.high is not None:
        for setting in found.high.settings:
            yield f"electrons_per_dn at ISO {setting.iso:g}, high gain", setting.electrons_per_dn
        yield "read_noise_e of high gain", found.high.read_noise_e
    law = found.law
    if law is not None and law.shape.law != "normal":
        yield (
            f"tails ({'1/dof of Student' if law.shape.law == 'student' else 'λ of Tukey'})",
            Estimate(law.shape.tails, law.errors["tails"]),
        )
    if law is not None and law.shape.spread:
        yield "read_noise_spread", Estimate(law.shape.spread, law.errors["spread"])


def _as_dict(found: Calibration) -> dict[str, Any]:
    figures: dict[str, Any] = {}
    for name, each in _figures(found):
        if each.measurable:
            figures[name] = {"value": each.value, "standard_error": each.sigma}
        else:
            limit = {"at_most": each.at_most} if math.isfinite(each.at_most) else {}
            figures[name] = {"value": None, "not_measurable": each.why_not, **limit}
    return {
        "source": found.shots.name,
        "frames": len(found.shots.shots),
        "iso": [each.iso for each in found.settings],
        "bit_depth": found.bit_depth,
        "code_step_dn": found.step_dn,
        "dual_gain_from_iso": found.over_iso.dual_from_iso,
        "law": None if found.law is None else found.law.shape.law,
        "figures": figures,
        "notes": [asdict(note) for note in found.notes],
    }


def _print(found: Calibration) -> None:
    rows = []
    reasons = []
    for name, each in _figures(found):
        limit = f"≤ {each.at_most:.2g}" if math.isfinite(each.at_most) else "–"
        rows.append([name, with_error(each.value, each.sigma) if each.measurable else limit])
        if not each.measurable:
            reasons.append(f"{name} is not determined: {each.why_not}")
    shape = found.shots.channel_index.shape
    title = f"{found.shots.name}: {len(found.shots.shots)} frames, the middle {shape[0]} × {shape[1]} photosites"
    print_table(title, ["figure", "value"], rows)
    codes = f"{found.bit_depth} bits, codes {found.step_dn:g} apart"
    dual = found.over_iso.dual_from_iso
    law = "not looked for" if found.law is None else found.law.shape.law
    gains = "one conversion gain" if dual is None else f"a high conversion gain from ISO {dual:g} on"
    gains = gains if found.high is None else "both conversion gains of each exposure"
    print(f"{codes}; {gains}; law of the read noise: {law}")
    for line in (*reasons, *found.notes):
        print(line)


def _check(request: CalibrationRequest, shots: ShotsOfCamera, found: Calibration) -> None:
    from camsim.camera.sensor import Sensor
    from camsim.measure.calibrate.likeness import side_by_side, simulated

    assert request.check is not None
    sensor = Sensor.from_yaml(request.check)
    if (sensor.rows, sensor.cols) != (shots.rows, shots.cols) or sensor.cfa.pattern != shots.pattern:
        there = f"{sensor.rows} × {sensor.cols} photosites of {'/'.join(sensor.cfa.pattern)}"
        raise InvalidValueError(
            f"has {there}, and the frames {shots.rows} × {shots.cols} of {'/'.join(shots.pattern)}; give their own",
            key="--check",
            stage=request.check,
        )
    sides = [
        side
        for one in found.read_outs
        for side in side_by_side(one.shots, simulated(one.shots, one, sensor, seed=request.seed), one)
    ]
    if request.plot is not None:
        from camsim.cli.plot_calibration import draw_check

        write_whole(request.plot, draw_check(sides, request.plot))
    if request.as_json:
        print(json.dumps([_side_as_dict(side) for side in sides], indent=1, ensure_ascii=False))
    else:
        _print_check(request, sides)


def _side_as_dict(side: SideBySide) -> dict[str, Any]:
    return {
        "iso": side.iso,
        "read_out": side.read_out,
        "mean_dn": side.mean_dn.tolist(),
        "variance_dn2": {"camera": side.variance_dn2.tolist(), "profile": side.profile_variance_dn2.tolist()},
        "kl_nats": side.kl_nats,
        "kl_floor_nats": side.kl_floor_nats,
        "probability": {each.test: each.probability for each in side.tests},
    }


def _print_check(request: CalibrationRequest, sides: Sequence[SideBySide]) -> None:
    import numpy as np

    rows = []
    for side in sides:
        ratio = np.median(side.profile_variance_dn2 / side.variance_dn2)
        darks = [math.sqrt(each.temporal.dn2) for each in (side.darks, side.profile_darks)]
        lines = [math.sqrt(max(each.rows.dn2, 0.0)) for each in (side.darks, side.profile_darks)]
        rows.append([
            f"{side.iso:g} {side.read_out}".strip(), f"{ratio:.4f}", f"{darks[0]:.4g} / {darks[1]:.4g}",
            f"{lines[0]:.3g} / {lines[1]:.3g}",
            f"{side.kl_nats:.2g} ({side.kl_floor_nats:.2g})", *(f"{each.probability:.2g}" for each in side.tests),
        ])  # fmt: skip
    tests = [each.test for each in sides[0].tests]
    heads = ["ISO", "variance ratio", "dark σ, DN", "row σ, DN", "KL, nats", *(f"p: {test}" for test in tests)]
    print_table(f"{request.folder} / {request.check}", heads, rows)
    print("KL: divergence of the darks' codes, camera from profile, in brackets that of the camera's own halves")
    apart = [f"ISO {side.iso:g}: {each.test}" for side in sides for each in side.tests if each.probability < _APART]
    if apart:
        print(f"distinguishable at 1 %: {'; '.join(apart)}")
    else:
        print("no test tells the profile's frames from the camera's at 1 %")
