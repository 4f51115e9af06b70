"""A calibration as a sensor file: each number with its standard error and its source in a comment."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence

from camsim.measure.calibrate.calibration import Calibration
from camsim.measure.calibrate.tails import Fitted
from camsim.measure.noise import Estimate
from camsim.sensor.companding import points_of

_TYPICAL = "typical: frames do not tell it"
_TYPICAL_PITCH_UM = 4.0
_BAYER = ("RGGB", "BGGR", "GRBG", "GBRG")
_TYPICAL_DARK = 0.5
_LONGEST_S = 1.0
"""Longest time of darks for the black level: longer ones would count dark current twice."""


def profile_text(found: Calibration, *, name: str, pitch_um: float | None = None, hot_file: str | None = None) -> str:
    """Return a ``sensor/1`` file.

    name     : name of the camera
    pitch_um : between photosites; None: as stated in the files, or a typical one
    hot_file : name of the list of hot photosites next to the file; None: their distribution is in the file
    """
    shots = found.shots
    isos = ", ".join(f"{each.iso:g}" for each in found.settings)
    rows, cols = shots.channel_index.shape
    pitch, stated = _pitch(found, pitch_um)
    lines = [
        f"# Calibrated from the {len(shots.shots)} frames of {json.dumps(shots.name, ensure_ascii=False)}: ISO {isos},",
        f"# the middle {rows} × {cols} photosites. A number ± its standard error; “typical”: not from the frames.",
        *(f"# {note}" for note in found.notes),
        "camsim: sensor/1",
        f"name: {json.dumps(name, ensure_ascii=False)}",
        "serial: 1                                  # of the fixed patterns: another number is another specimen",
        f"frame: {{rows: {shots.rows}, cols: {shots.cols}, pitch_um: {pitch:g}}}    # rows, cols: files; "
        f"pitch: {stated}",
        f"photosite: {{kind: square, fill_factor: 1.0}}    # {_TYPICAL}",
        f"cfa: {_cfa(shots.pattern)}",
        *_efficiency(shots.pattern),
        "charge:",
        *_charge(found, hot_file),
        "readout:",
        *_readout(found),
    ]
    return "\n".join(lines) + "\n"


def _pitch(found: Calibration, given_um: float | None) -> tuple[float, str]:
    if given_um is not None:
        return given_um, "--pitch-um"
    if found.shots.pitch_um is not None:
        return found.shots.pitch_um, "the files"
    return _TYPICAL_PITCH_UM, f"{_TYPICAL}; --pitch-um gives it"


def _cfa(pattern: Sequence[str]) -> str:
    if tuple(pattern) == ("Y",):
        return "{kind: mono}"
    if "".join(pattern) in _BAYER and len(pattern) == 2:
        return f"{{kind: bayer, pattern: {''.join(pattern)}}}"
    return f"{{kind: letters, pattern: [{', '.join(pattern)}]}}"


def _efficiency(pattern: Sequence[str]) -> Iterator[str]:
    letters = sorted(set("".join(pattern)))
    yield "quantum_efficiency:"
    if letters == ["B", "G", "R"]:
        yield f"  curves: Nikon 5100 (NPL)                  # {_TYPICAL}: another camera's"
        yield "  per: energy"
        yield "  peak: 0.5                                 # typical"
        return
    yield f"  curves:                                   # {_TYPICAL}"
    for letter in letters:
        yield f"    {letter}: {{wavelength_nm: [380, 780], values: [0.5, 0.5], outside: zero}}"
    yield "  per: photon"
    yield "  peak: as given"


def _stated(key: str, found: Estimate, source: str) -> str:
    """Return a line of a table: the key with its number, or a comment on why there is none."""
    if found.measurable:
        return f"  {key}: {_number(found.value)}    # ± {found.sigma:.2g}; {source}"
    limit = f"at most {found.at_most:.3g}; " if math.isfinite(found.at_most) else ""
    return f"  # {key}: not determined: {limit}{found.why_not}"


def _number(value: float) -> str:
    return f"{value:.6g}" if 1e-4 <= abs(value) < 1e15 or value == 0.0 else f"{value:.6e}"


def _charge(found: Calibration, hot_file: str | None) -> Iterator[str]:
    base = found.settings[0]
    yield _stated("full_well_e", found.full_well_e, f"clipped flats of ISO {base.iso:g}")
    yield _stated("prnu", found.prnu, "flats near half of saturation, after the high-pass of EMVA 1288 R4")
    yield _stated("dsnu_e", found.dsnu_e, "what stays in darks, without the columns'")
    longest = max((shot.time_s or 0.0) for shot in found.shots.shots if shot.kind == "dark")
    current = found.dark_current_e_per_s
    if current.measurable:
        yield _stated("dark_current_e_per_s", current, "means of darks over their time")
        yield f"  dark_current_at_c: {_number(found.dark_current_at_c)}"
        if found.doubling_c.measurable:
            yield _stated("dark_current_doubles_every_c", found.doubling_c, "means of darks over temperature and time")
    else:
        yield _stated("dark_current_e_per_s", current, "")
        typical = 0.0 if longest > _LONGEST_S else min(_TYPICAL_DARK, current.at_most)
        yield f"  dark_current_e_per_s: {_number(typical)}    # {_TYPICAL}"
    if hot_file is not None:
        rows, cols = found.shots.channel_index.shape
        what = f"{len(found.hot)} of the middle {rows} × {cols} photosites, darks of {longest:g} s"
        yield f"  defects: {{hot: {json.dumps(hot_file, ensure_ascii=False)}}}    # {what}"
    elif found.hot:
        yield "  defects:"
        yield "  " + _stated("hot_fraction", found.hot_fraction, f"photosites steadily far above others, {longest:g} s")
        yield "  " + _stated("hot_e_per_s", found.hot_e_per_s, "their mean excess over the time of those darks")


def _readout(found: Calibration) -> Iterator[str]:
    base, *others = found.settings
    gain = base.electrons_per_dn
    black, offsets = _black(found)
    yield f"  bit_depth: {found.bit_depth}    # the fewest that hold the codes; the largest seen is {found.largest_dn}"
    if found.step_dn != 1.0:
        yield f"  code_step_dn: {found.step_dn:.9g}    # between neighbouring codes"
    points = points_of(found.shots.linear_dn)
    if points:
        known, codes = ([point[k] for point in points] for k in (0, 1))
        yield f"  companding: {{linear_dn: {known}, codes: {codes}}}    # the files' table of linearisation"
    yield f"  black_level_dn: {black}    # {found.black_dn.value:.3f} ± {found.black_dn.sigma:.2g}; means of darks"
    if offsets is not None and points:
        yield f"  # black_offsets_dn: {json.dumps(offsets)} are left out, where codes are companded; means of darks"
    elif offsets is not None:
        yield f"  black_offsets_dn: {json.dumps(offsets)}    # means of darks over the filter array"
    yield f"  base_iso: {base.iso:g}    # the lowest setting that was taken"
    yield _stated("electrons_per_dn", gain, "photon transfer")
    if others:
        yield "  gain_at_iso:"
        for each in others:
            one = each.electrons_per_dn
            row = f"{{iso: {each.iso:g}, electrons_per_dn: {_number(one.value)}}}"
            yield f"    - {row}    # ± {one.sigma:.2g}; photon transfer"
    yield from _noise(found)
    yield _stated("row_noise_e", found.row_noise_e, "power of rows' offsets in darks, the white part")
    flicker = found.flicker_rows_e
    if flicker.measurable:
        row = f"{{sigma_e: {_number(flicker.value)}, exponent: 1}}"
        yield f"  flicker_rows: {row}    # ± {flicker.sigma:.2g}; the 1/f part"
    yield _stated("column_noise_e", found.column_noise_e, "columns' offsets that stay in darks")


def _noise(found: Calibration) -> Iterator[str]:
    how = "darks over ISO" if len(found.settings) > 1 else "darks of one ISO, in which noise after the gain is too"
    yield _stated("read_noise_e", found.read_noise_e, f"{how}, before the gain, without jumps")
    if found.law is not None and found.read_noise_e.measurable:
        yield from _law(found.law)
    if found.telegraph_fraction.measurable:
        yield "  telegraph_noise:"
        yield "  " + _stated(
            "fraction", found.telegraph_fraction, "pairs of darks that differ by more than the law gives"
        )
        yield "  " + _stated("amplitude_e", found.telegraph_e, "likewise")
    if found.dual_read_noise_e is not None and found.over_iso.dual_from_iso is not None:
        at = found.over_iso.dual_from_iso
        dual = found.dual_read_noise_e
        if dual.measurable:
            yield "  dual_gain:"
            yield f"    from_iso: {at:g}    # one conversion gain does not fit the darks over ISO"
            yield "  " + _stated("read_noise_e", dual, "darks from that ISO on")
    if found.high is not None:
        yield "  dual_gain:"
        gain = found.high.settings[0].electrons_per_dn
        yield "  " + _stated("electrons_per_dn", gain, "photon transfer of the images of high gain")
        yield "  " + _stated("read_noise_e", found.high.read_noise_e, "their darks")
    yield _stated("output_noise_dn", found.output_noise_dn, "darks over ISO, after the gain")


def _law(law: Fitted) -> Iterator[str]:
    shape, error = law.shape, law.errors["tails"]
    rise = max((by for part, by in law.rises if part in ("student", "tukey")), default=0.0)
    because = f"the likelihood rises by {rise:.0f} of its standard errors over a normal law"
    if shape.law == "student":
        yield f"  read_noise_student_dof: {_number(1.0 / shape.tails)}    # ± {error / shape.tails**2:.2g}; {because}"
    elif shape.law == "tukey":
        yield f"  read_noise_tukey_lambda: {_number(shape.tails)}    # ± {error:.2g}; {because}"
    else:
        yield "  # its law: normal; tails do not raise the likelihood by 4 standard errors of the rise"
    if shape.spread:
        stated = f"± {law.errors['spread']:.2g}; pairs of darks that differ much together"
        yield f"  read_noise_spread: {_number(shape.spread)}    # {stated}"


def _black(found: Calibration) -> tuple[int, list[list[int]] | None]:
    """Return the black level, and its offsets over the filter array if they differ by a code or more."""
    level = round(found.black_dn.value)
    offsets = [[round(float(cell) - found.settings[0].darks.black_dn) for cell in row] for row in found.cells_dn]
    flat = [offset for row in offsets for offset in row]
    if min(flat) == max(flat):
        return level, None
    common = max(min(flat), 0) + min(max(flat), 0)
    return level + common, [[offset - common for offset in row] for row in offsets]
