"""The report of a capture as text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from camsim.camera.frame import ChannelSignal, Frame
from camsim.cli.outputs import Output
from camsim.config.yaml_text import yaml_text
from camsim.core.memory import readable
from camsim.core.words import percent

_WIDTH_OF_A_LOG = 1000
_LONGEST_LIST = 12


def print_report(
    frame: Frame, outputs: Sequence[Output], seconds: Mapping[str, float], total_s: float, *, verbose: bool
) -> None:
    """Print the report of a capture on stderr."""
    console = Console(stderr=True, highlight=False, markup=False, emoji=False)
    if not console.is_terminal:
        # Lines of a log are not wrapped.
        console.width = _WIDTH_OF_A_LOG
    report = frame.report
    rows, cols = frame.shape
    lines = Table.grid(padding=(0, 2))
    lines.add_column(style="bold")
    lines.add_column()
    lines.add_row("scene", f"{report.scene}, {rows} × {cols} photosites of {frame.pitch_um:g} µm")
    lines.add_row("camera", f"{frame.camera_name}, {frame.bit_depth} bits, {frame.electrons_per_dn:.4g} e⁻ per DN")
    lines.add_row("exposure", f"{frame.time_s:.6g} s, ISO {frame.iso:g}, seed {frame.seed}")
    lines.add_row("optics", " → ".join(report.optics))
    if report.electronics:
        lines.add_row("electronics", " → ".join(report.electronics))
    lines.add_row("wavelengths", report.wavelengths)
    if rendered := report.method != "none":
        lines.add_row("method", f"{report.method}, tolerance {report.tolerance:g}")
        lines.add_row(
            "error",
            f"{report.error_estimate:.2g}, the worst of {report.checked_photosites} photosites recomputed",
        )
    if rendered and report.truth_error_estimate is not None:
        lines.add_row("", f"{report.truth_error_estimate:.2g} in the truth, every channel at every photosite")
    lines.add_row("signal", _signal(frame))
    for note in report.notes:
        lines.add_row("note", note.text)
    if report.standard_error is not None:
        lines.add_row("", f"{report.standard_error:.2g}, standard error of the samples' mean, the worst of those")
    if verbose:
        lines.add_row("work", ", ".join(f"{name.replace('_', ' ')} {count}" for name, count in report.work.items()))
    stages = ", ".join(f"{stage} {value:.3f}" for stage, value in seconds.items())
    lines.add_row("time", f"{total_s:.2f} s in all ({stages})")
    for output in outputs:
        size = readable(Path(output.path).stat().st_size)
        lines.add_row("written", f"{output.path} ({output.product}, {size})")
    with console.capture() as printed:
        console.print(lines)
    # The grid pads its last column with spaces.
    console.file.writelines(f"{line.rstrip()}\n" for line in printed.get().splitlines())
    if verbose:
        console.file.write(f"computed:\n{yaml_text(_shortened(frame.description))}")


def _signal(frame: Frame) -> Table:
    table = Table.grid(padding=(0, 2))
    for _ in range(5):
        table.add_column(justify="right")
    table.add_row("", "mean e⁻", "max e⁻", "mean DN", f"clipped at {frame.white_level_dn} DN")
    for channel in frame.report.signal:
        table.add_row(
            channel.name,
            f"{channel.mean_e:.1f}",
            f"{channel.max_e:.1f}",
            f"{channel.mean_dn:.1f}",
            _clipped(channel),
        )
    return table


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
