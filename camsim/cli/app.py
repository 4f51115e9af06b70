"""The commands and their options. Heavy modules are imported by the commands that need them."""

from __future__ import annotations

import copy
import errno
import gc
import sys
import time
from typing import Annotated, Any, cast

import typer
from typer.core import TyperGroup
from typer.main import get_command_name
from typer.models import CommandInfo

from camsim.cli.bench import bench
from camsim.cli.calibrate_app import calibrate_app
from camsim.cli.dataset import dataset
from camsim.cli.explain import explain
from camsim.cli.expose import expose
from camsim.cli.lens_app import lens_app
from camsim.cli.measure_app import measure_app
from camsim.cli.options import (
    AllowOddCfa,
    AsJson,
    Changes,
    Compress,
    Force,
    Quiet,
    SensorName,
    Sensors,
    say_how_to_set,
)
from camsim.cli.sensor_app import sensor_app
from camsim.cli.sweep import sweep
from camsim.errors import AccuracyError, CamsimError, InvalidValueError, UnknownNameError

_BEGAN_S = time.perf_counter()
_MOST_LINES = 200


class _Commands(TyperGroup):
    """Conversion of errors to messages and exit codes."""

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except CamsimError as error:
            _say(str(error))
            code = 1 if isinstance(error, AccuracyError) else 2
        except KeyboardInterrupt:
            _say("camsim: interrupted")
            code = 130
        except OSError as error:
            if error.errno == errno.EPIPE:
                raise
            _say(f"camsim: the system says: {error}")
            code = 1
        except MemoryError:
            _say("camsim: out of memory; capture a smaller region")
            code = 1
        except Exception as error:
            if hasattr(error, "option_name"):  # of click, which typer may vendor
                say_how_to_set(error)
                raise
            error.add_note("This is a bug of camsim: please report it with the lines above.")
            raise
        raise typer.Exit(code)


app = typer.Typer(
    name="camsim",
    cls=_Commands,
    help="A spectral camera that runs from a YAML file: exact optics, honest noise, raw files.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _one_of(known: tuple[str, ...], kind: str) -> Any:
    """Return an argument that is one of a few names; any other is refused as files and Python refuse it."""

    def validated(name: str) -> str:
        if name not in known:
            raise UnknownNameError(kind, name, known)
        return name

    return typer.Argument(metavar="WHAT", help=f"One of {', '.join(known)}.", callback=validated)


LISTS = ("sensors", "scenes", "lenses", "illuminants", "reflectances", "sensitivities")
TEMPLATES = ("scene", "sensor", "study", "dataset")
SCHEMAS = ("scene", "sensor", "lens", "study", "dataset")


def run() -> None:
    """Run the command line."""
    for stream in (sys.stdout, sys.stderr):
        # A terminal without µ must not end a capture.
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    try:
        _ready_for(sys.argv[1:2])()
    finally:
        gc.freeze()  # or the collector looks at all modules at exit


def _ready_for(first: list[str]) -> typer.Typer:
    """Return the commands, but only the one or the group that the first argument names: each takes 2 ms to make."""
    ready = copy.copy(app)
    ready.registered_commands = [each for each in app.registered_commands if [_name_of(each)] == first]
    ready.registered_groups = [each for each in app.registered_groups if [each.name] == first]
    return ready if ready.registered_commands or ready.registered_groups else app


def _name_of(command: CommandInfo) -> str:
    return command.name or get_command_name(getattr(command.callback, "__name__", ""))


def _say(text: str) -> None:
    lines = text.splitlines()
    displayed = lines[:_MOST_LINES]
    if len(lines) > len(displayed):
        displayed.append(f"… and {len(lines) - len(displayed)} more")
    print("\n".join(displayed), file=sys.stderr)


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        print(f"camsim {version('camsim-spectral')}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """A spectral camera that runs from a YAML file: exact optics, honest noise, raw files."""


@app.command()
def capture(
    scene: Annotated[str, typer.Argument(metavar="SCENE", help="A scene file, or the name of a shipped scene.")],
    sensor: SensorName = None,
    sensors: Sensors = None,
    changes: Changes = None,
    seed: Annotated[
        int | None,
        typer.Option("--seed", metavar="N", min=0, help="Seed of the noise, instead of the scene's."),
    ] = None,
    frames: Annotated[
        int,
        typer.Option(
            "--frames",
            metavar="N",
            min=1,
            max=100_000,
            help="Exposures of the same scene: the same fixed patterns, fresh noise; FILE-0, FILE-1, … are written.",
        ),
    ] = 1,
    outputs: Annotated[
        list[str] | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE[:PRODUCT]",
            help="A file to write; the suffix chooses its format. Repeatable; NAME.dng when left out.",
        ),
    ] = None,
    pairs: Annotated[
        str | None,
        typer.Option(
            "--pairs",
            metavar="FOLDER",
            help="Write noisy and clean mosaics with their truth, in every phase and at every level, and an index.",
        ),
    ] = None,
    levels: Annotated[
        str | None,
        typer.Option("--levels", metavar="A,B,…", help="Light of the pairs relative to the scene's: 1,0.25,0.0625."),
    ] = None,
    allow_odd_cfa: AllowOddCfa = False,
    compress: Compress = False,
    strict: Annotated[
        bool, typer.Option("--strict", help="Write nothing, and exit with 1, if an error above the tolerance is found.")
    ] = False,
    force: Force = False,
    as_json: AsJson = False,
    quiet: Quiet = False,
    verbose: Annotated[bool, typer.Option("-v", "--verbose", help="Also print what was computed, in full.")] = False,
) -> None:
    """Take a picture of a scene and write it."""
    from camsim.cli.take import Request, take, take_pairs

    (take if pairs is None and levels is None else take_pairs)(
        Request(
            scene=scene,
            sensor=sensor,
            sensors=tuple(sensors or ()),
            changes=(*(changes or ()), *(("render.strict=true",) if strict else ())),
            seed=seed,
            frames=frames,
            outputs=tuple(outputs or ()),
            pairs=pairs,
            levels=levels,
            allow_odd_cfa=allow_odd_cfa,
            compress=compress,
            force=force,
            as_json=as_json,
            quiet=quiet,
            verbose=verbose,
            began_s=_BEGAN_S,
        )
    )


@app.command()
def info(
    file: Annotated[
        str, typer.Argument(metavar="FILE", help="A DNG, NPZ, EXR, TIFF or PNG of camsim, or a camera's raw file.")
    ],
    full: Annotated[bool, typer.Option("--full", help="Also print every stage with all its parameters.")] = False,
    as_json: AsJson = False,
) -> None:
    """Print what a file of camsim holds and what was computed to make it, or what a camera noted in its raw file."""
    from camsim.cli.info import json_of_file, text_of_file

    print(json_of_file(file) if as_json else text_of_file(file, full=full))


@app.command("recapture")
def recapture_file(
    file: Annotated[str, typer.Argument(metavar="FILE", help="A DNG, NPZ, EXR, TIFF or PNG of camsim.")],
    outputs: Annotated[
        list[str] | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE[:PRODUCT]",
            help="A file to write, of any product; repeatable. FILE-again, with the same product, when left out.",
        ),
    ] = None,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Take the picture of a file once more, from that file alone: the same bytes."""
    from camsim.cli.recapture import recapture

    recapture(file, outputs or (), force=force, quiet=quiet)


app.add_typer(measure_app, name="measure")
app.add_typer(lens_app, name="lens")
app.add_typer(sensor_app, name="sensor")
app.add_typer(calibrate_app, name="calibrate")
app.command()(bench)
app.command()(explain)
app.command()(expose)
app.command()(sweep)
app.command()(dataset)


@app.command("list")
def list_names(what: Annotated[str, _one_of(LISTS, "list")], sensors: Sensors = None) -> None:
    """List the names that files and options can use; with the place of each sensor, yours included."""
    from camsim.cli.show import lines_of_list

    for line in lines_of_list(what, sensors or ()):
        print(line)


@app.command()
def show(
    name: Annotated[str, typer.Argument(metavar="NAME", help="A sensor, scene or lens: a name or a file.")],
    expand: Annotated[
        bool, typer.Option("--expand", help="Of a scene: its charts as the shapes that they stand for, in µm.")
    ] = False,
    sensors: Sensors = None,
) -> None:
    """Print a sensor, scene or lens, and figures that follow from it (as comments: the output is valid YAML)."""
    if expand:
        from camsim.cli.expand import expanded

        for line in expanded(name, sensors or ()):
            print(line)
        return
    from camsim.cli.show import text_of

    print(text_of(name, sensors or ()))


@app.command()
def schema(what: Annotated[str, _one_of(SCHEMAS, "kind of file")]) -> None:
    """Print the JSON Schema of scenes, sensors, lenses, studies or data sets, for editors that complete and check."""
    import json

    from camsim.config.reference import Kind, json_schema

    print(json.dumps(json_schema(cast(Kind, what)), indent=2, ensure_ascii=False))


@app.command()
def validate(
    files: Annotated[list[str], typer.Argument(metavar="FILE…", help="Scene, sensor and lens files.")],
    sensors: Sensors = None,
    draw: Annotated[
        str | None,
        typer.Option(
            "--draw",
            metavar="FILE.png|svg|pdf|-",
            help="Draw a scene's outlines over the window, with photosites and a scale; - draws on the terminal.",
        ),
    ] = None,
    overrides: Changes = None,
    force: Force = False,
) -> None:
    """Print all faults of scene and sensor files; draw a scene."""
    from camsim.cli.validate import draw_scene, validate_files

    if draw is not None:
        draw_scene(files, draw, sensors or (), overrides or (), force=force)
    elif overrides:
        raise InvalidValueError("changes what is drawn, and nothing is; give --draw", key="--set")
    else:
        validate_files(files, sensors or ())


@app.command()
def new(
    what: Annotated[str, _one_of(TEMPLATES, "kind of file")],
    output: Annotated[
        str | None, typer.Option("-o", "--output", metavar="FILE", help="scene.yaml, sensor.yaml … when left out.")
    ] = None,
    picture: Annotated[
        str | None,
        typer.Option("--picture", metavar="FILE", help="A scene that shows it, its window and size fitted to it."),
    ] = None,
    force: Force = False,
) -> None:
    """Write a scene, a sensor, a study or a data set to start from, with a comment to every line."""
    from camsim.cli.new import write_template

    print(write_template(what, output, picture=picture, force=force))
