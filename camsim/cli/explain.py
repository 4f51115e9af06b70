"""``camsim explain``: what a capture will compute, what it leaves out, why, and at what cost. Nothing is rendered."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from camsim.cli.options import AsJson, Changes, Force, SensorName, Sensors
from camsim.errors import CamsimError, InvalidValueError, UnknownNameError

if TYPE_CHECKING:
    from camsim.camera.capture import Capture
    from camsim.camera.frame import Products
    from camsim.rendering.engine import Decision

# Seconds of one core: set-up, a random number with its processing, a photosite's code, a byte of a file.
BEFORE_SECONDS, NOISE_SECONDS, CODE_SECONDS, FILE_SECONDS = 0.01, 20e-9, 12e-9, 8e-9
PLOTS = ("mtf", "psf", "qe", "spectra", "noise", "field")
HELD_BYTES = 16.0  # of a photosite, besides its light: electrons, code and temporaries
BYTES_OF = {"mosaic": 2.0, "electrons": 8.0, "truth": 12.0, "preview": 3.0, "spectral": 4.0 * 31, "frame": 30.0}


def explain(
    scene: Annotated[str, typer.Argument(metavar="SCENE", help="A scene file, or the name of a shipped scene.")],
    sensor: SensorName = None,
    sensors: Sensors = None,
    changes: Changes = None,
    outputs: Annotated[
        list[str] | None,
        typer.Option("-o", "--output", metavar="FILE[:PRODUCT]", help="As if this were to be written; repeatable."),
    ] = None,
    as_json: AsJson = False,
    plot: Annotated[
        tuple[str, str] | None,
        typer.Option(
            "--plot",
            metavar="mtf|psf|qe|spectra|noise|field FILE",
            help="Draw transfers or patterns of the stages, quantum efficiencies, spectra, the noise by its sources, "
            "or what a field lens does over the frame (needs matplotlib).",
        ),
    ] = None,
    at: Annotated[
        str | None,
        typer.Option("--at", metavar="X,Y", help="With --plot psf: a field lens's pattern there, µm from the axis."),
    ] = None,
    force: Force = False,
) -> None:
    """Print what a capture will compute and what it leaves out, each with its reason, time, memory and error."""
    from camsim.api import load
    from camsim.cli.outputs import check

    if plot is not None:
        _check_plot(*plot, force=force)
    at_um = _place(at, plot)
    texts = outputs or (f"{Path(scene).stem}.dng",)
    files, errors = check(texts, force=True)
    if errors:
        raise CamsimError("\n".join(map(str, errors)))
    products = {file.product for file in files}
    capture = load(scene, sensor=sensor, overrides=changes or (), products=products, sensors=sensors or ())
    stated = explained(capture, products, [(file.path, file.product) for file in files])
    if plot is not None:
        from camsim.cli.explain_plot import draw
        from camsim.files.atomic import write_whole

        write_whole(plot[1], draw(capture, plot[0], plot[1], at_um))
    if as_json:
        print(json.dumps(stated, indent=2, ensure_ascii=False))
    else:
        _print(stated)


def explained(capture: Capture, products: Products, files: list[tuple[str, str]]) -> dict[str, Any]:
    """Return every decision about a capture and its expected cost, as a plain tree."""
    from camsim.core.memory import needed_bytes
    from camsim.rendering.decisions import expectation, rendering_decisions

    choice = capture.plan()
    camera, grid = capture.camera, capture.grid
    decisions = [
        *rendering_decisions(
            choice, light_samples=capture.samples.wavelength_nm.size, shapes=len(capture.scene.shapes)
        ),
        *_of_channels(capture, products),
        *_of_camera(capture),
        *_of_files(files),
    ]
    expected = expectation(choice)
    photosites = float(grid.rows * grid.cols)
    images = len(camera.cfa.channels) if "truth" in products else 1
    seconds = {
        "set up": BEFORE_SECONDS,
        "render": expected["seconds"] * images,
        "noise": NOISE_SECONDS * capture.random_numbers,
        "adc": CODE_SECONDS * photosites,
        "write": FILE_SECONDS * photosites * sum(BYTES_OF[product] for _, product in files),
    }
    window = (grid.rows, grid.cols, len(camera.cfa.channels))
    # The memory of a mosaic alone is HELD_BYTES; needed_bytes is rounded up, for refusals.
    more = needed_bytes(*window, products) - needed_bytes(*window, ("mosaic",))
    memory = expected["memory_bytes"] + HELD_BYTES * photosites + more
    return {
        "scene": capture.scene_name,
        "camera": camera.name,
        "rows": grid.rows,
        "cols": grid.cols,
        "pitch_um": camera.pitch_um,
        "tolerance": capture.tolerance,
        "method": choice.method,
        "decisions": [asdict(decision) for decision in decisions],
        "notes": [asdict(note) for note in capture.notes(choice, products)],
        "expected": {"seconds": seconds, "memory_bytes": memory, "error": expected["error"]},
        "work": {**choice.plan.work(images).counts(), "random_numbers": capture.random_numbers},
    }


def _of_channels(capture: Capture, products: Products) -> Iterator[Decision]:
    from camsim.rendering.engine import Decision

    channels = capture.camera.cfa.channels
    if len(channels) == 1:
        return
    if "truth" in products:
        yield Decision(
            topic="channels", decision=f"all {len(channels)} everywhere", reason="the truth is to be written"
        )
    else:
        yield Decision(
            topic="channels",
            decision="each photosite in its own",
            reason=f"nobody reads the other {len(channels) - 1}: no truth is written",
        )


def _of_camera(capture: Capture) -> Iterator[Decision]:
    from camsim.core.words import brief
    from camsim.rendering.engine import Decision

    camera = capture.camera
    yield _of_falloff(capture)
    yield _of_glare(capture)
    if camera.crosstalk is None:
        yield Decision(
            topic="crosstalk", decision="left out", reason="the sensor has none: no photosite beyond the window"
        )
    if not capture.noise:
        yield Decision(topic="noise", decision="no random number", reason="noise is switched off")
    else:
        stages = [brief(stage) for stage in capture.electronics]
        yield Decision(
            topic="noise",
            decision=f"{capture.random_numbers} random numbers",
            reason=f"{' → '.join(stages)}" if stages else "no stage draws any",
        )


def _of_falloff(capture: Capture) -> Decision:
    from camsim.camera.window import rows_of
    from camsim.core.words import brief
    from camsim.optics.protocols import Illuminates
    from camsim.rendering.engine import Decision

    window, falloff = capture.window, capture.camera.falloff
    if window.on_sensor:
        reason = "the light is given as it falls on the sensor, where no lens dims it"
        return Decision(topic="fall-off", decision="left out", reason=reason)
    if not window.falls_off:
        return Decision(topic="fall-off", decision="left out", reason="the lens has none: even light")
    first_and_last = [window.falloff(rows_of(capture.grid, row, 1)) for row in (0, capture.grid.rows - 1)]
    dimmest = min(float(row[0, end]) for row in first_and_last for end in (0, -1))
    one = ["the lens's own"] if isinstance(capture.camera.lens, Illuminates) else []
    return Decision(
        topic="fall-off",
        decision=f"{dimmest:.4g} of the axis's light in the window's dimmest corner",
        reason=" and ".join([*one, *([] if falloff is None else [brief(falloff)])]),
    )


def _of_glare(capture: Capture) -> Decision:
    from camsim.core.words import percent
    from camsim.rendering.engine import Decision

    camera = capture.camera
    if not camera.veil.there:
        return Decision(topic="veiling glare", decision="left out", reason="the lens has none: black stays black")
    white_e = camera.electrons_per_reflectance(capture.samples, capture.radiant_exposure_j_per_m2).sum(axis=1)
    shares = ", ".join(
        f"{name} {percent(veil / white if white else 0.0)}"
        for name, veil, white in zip(camera.cfa.channels, capture.veil_e, white_e, strict=True)
    )
    return Decision(
        topic="veiling glare",
        decision=f"the same on every photosite: {shares} of a perfect diffuser",
        reason="its fraction of the mean light of the scene over the whole frame; the image has the rest",
    )


def _of_files(files: list[tuple[str, str]]) -> Iterator[Decision]:
    from camsim.rendering.engine import Decision

    if any(path.lower().endswith(".dng") or product == "preview" for path, product in files):
        yield Decision(topic="colour matrix", decision="fitted", reason="a DNG or a preview is written")
    else:
        yield Decision(topic="colour matrix", decision="none", reason="no DNG and no preview is written")


def _print(stated: dict[str, Any]) -> None:
    from rich.console import Console
    from rich.table import Table

    from camsim.core.memory import readable

    console = Console(highlight=False, markup=False, emoji=False)
    if not console.is_terminal:
        console.width = 200
    console.print(
        f"{stated['scene']}: {stated['rows']} × {stated['cols']} photosites of {stated['pitch_um']:g} µm, "
        f"camera {stated['camera']}, tolerance {stated['tolerance']:g}"
    )
    table = Table(box=None, pad_edge=False, show_header=False)
    for style in ("bold", "", "dim"):
        table.add_column(style=style, overflow="fold")
    for line in stated["decisions"]:
        table.add_row(line["topic"], line["decision"], line["reason"])
    expected = stated["expected"]
    seconds = expected["seconds"]
    parts = ", ".join(f"{name} {value:.2g}" for name, value in seconds.items())
    table.add_row("time", f"about {sum(seconds.values()):.2g} s of one core", f"kernels compiled: {parts}")
    table.add_row("memory", f"about {readable(expected['memory_bytes'])}", "beyond what the program itself holds")
    table.add_row("error", f"at most {expected['error']:g}", "of a perfect diffuser, or of the brightest surface")
    for note in stated["notes"]:
        table.add_row("note", note["text"])
    with console.capture() as printed:
        console.print(table)
    print("\n".join(line.rstrip() for line in printed.get().splitlines()))


def _place(at: str | None, plot: tuple[str, str] | None) -> tuple[float, float] | None:
    """Return the requested place, µm."""
    if at is None:
        return None
    if plot is None or plot[0] != "psf":
        raise InvalidValueError("is of a pattern; write --plot psf FILE with it", key="--at")
    try:
        x_um, y_um = (float(part) for part in at.split(","))
    except ValueError:
        message = f"must be two numbers, µm from the axis, such as 8000,5000, not {at!r}"
        raise InvalidValueError(message, key="--at") from None
    return x_um, y_um


def _check_plot(kind: str, file: str, *, force: bool) -> None:
    """Raise early for plots that cannot be drawn."""
    from camsim.cli.plot import check_drawing

    if kind not in PLOTS:
        raise UnknownNameError("plot", kind, PLOTS)
    check_drawing(file, force=force)
