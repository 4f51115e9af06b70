"""The report of a capture as text."""

from __future__ import annotations

import shutil
import sys
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from camsim.camera.frame import ChannelSignal, Frame
from camsim.cli.outputs import Output
from camsim.config.yaml_text import yaml_text
from camsim.core.memory import readable
from camsim.core.words import percent

_NARROWEST = 40  # characters
_LONGEST_LIST = 12


def print_report(
    frame: Frame, outputs: Sequence[Output], seconds: Mapping[str, float], total_s: float, *, verbose: bool
) -> None:
    """Print the report of a capture on stderr."""
    report = frame.report
    rows, cols = frame.shape
    lines = [
        ("scene", f"{report.scene}, {rows} × {cols} photosites of {frame.pitch_um:g} µm"),
        ("camera", f"{frame.camera_name}, {frame.bit_depth} bits, {frame.electrons_per_dn:.4g} e⁻ per DN"),
        ("exposure", f"{frame.time_s:.6g} s, ISO {frame.iso:g}, seed {frame.seed}"),
        ("optics", " → ".join(report.optics)),
    ]
    if report.electronics:
        lines.append(("electronics", " → ".join(report.electronics)))
    lines.append(("wavelengths", report.wavelengths))
    if rendered := report.method != "none":
        lines.append(("method", f"{report.method}, tolerance {report.tolerance:g}"))
        checked = f"the worst of {report.checked_photosites} photosites recomputed"
        lines.append(("error", f"{report.error_estimate:.2g}, {checked}"))
    if rendered and report.truth_error_estimate is not None:
        lines.append(("", f"{report.truth_error_estimate:.2g} in the truth, every channel at every photosite"))
    lines += zip(("signal", *[""] * len(report.signal)), _signal(frame), strict=True)
    lines += [("note", note.text) for note in report.notes]
    if report.standard_error is not None:
        lines.append(("", f"{report.standard_error:.2g}, standard error of the samples' mean, the worst of those"))
    if verbose:
        work = ", ".join(f"{name.replace('_', ' ')} {count}" for name, count in report.work.items())
        lines.append(("work", work))
    stages = ", ".join(f"{stage} {value:.3f}" for stage, value in seconds.items())
    lines.append(("time", f"{total_s:.2f} s in all ({stages})"))
    for output in outputs:
        size = readable(Path(output.path).stat().st_size)
        lines.append(("written", f"{output.path} ({output.product}, {size})"))
    sys.stderr.writelines(_in_columns(lines))
    if verbose:
        sys.stderr.write(f"computed:\n{yaml_text(_shortened(frame.description))}")


def _in_columns(lines: Sequence[tuple[str, str]]) -> Iterator[str]:
    """Yield lines of a heading and a text, wrapped to a terminal's width; those of a log are not wrapped."""
    margin = 2 + max(len(heading) for heading, _ in lines)
    terminal = sys.stderr.isatty()
    width = max(shutil.get_terminal_size().columns - margin, _NARROWEST)
    for heading, text in lines:
        shown = heading.ljust(margin)
        first = f"\x1b[1m{shown}\x1b[0m" if terminal and heading else shown
        parts = (textwrap.wrap(text, width, drop_whitespace=False) or [""]) if terminal else [text]
        for number, part in enumerate(parts):
            yield f"{first if number == 0 else ' ' * margin}{part}".rstrip() + "\n"


def _signal(frame: Frame) -> list[str]:
    """Return the lines of the table of signals."""
    table = [("", "mean e⁻", "max e⁻", "mean DN", f"clipped at {frame.white_level_dn} DN")]
    for channel in frame.report.signal:
        numbers = f"{channel.mean_e:.1f}", f"{channel.max_e:.1f}", f"{channel.mean_dn:.1f}"
        table.append((channel.name, *numbers, _clipped(channel)))
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    return ["  ".join(text.rjust(width) for text, width in zip(row, widths, strict=True)) for row in table]


def _clipped(channel: ChannelSignal) -> str:
    if not channel.clipped_photosites:
        return "none"
    share = channel.clipped_photosites / channel.photosites
    return f"{channel.clipped_photosites} of {channel.photosites} ({percent(share)})"


def _shortened(tree: object) -> object:
    """Return a readable description: long lists are abbreviated."""
    if isinstance(tree, Mapping):
        return {str(key): _shortened(value) for key, value in tree.items()}
    if isinstance(tree, list | tuple):
        if len(tree) > _LONGEST_LIST:
            return f"{len(tree)} items, {_shortened(tree[0])} … {_shortened(tree[-1])}"
        return [_shortened(value) for value in tree]
    return tree
