"""The commands of ``camsim measure`` and their options."""

from __future__ import annotations

from typing import Annotated, TypeAlias

import typer

from camsim.cli.options import AsJson, CfaOf, Changes, ChartName, Corners, Force, SensorName, Sensors

GammaOf: TypeAlias = Annotated[
    str | None, typer.Option("--gamma", metavar="G", help="Undo an encoding: srgb, 2.2 …; 1 when data is linear.")
]
CsvFile: TypeAlias = Annotated[str | None, typer.Option("--csv", metavar="FILE", help="Write the figures as a table.")]
PlotFile: TypeAlias = Annotated[
    str | None, typer.Option("--plot", metavar="FILE.png|svg", help="Draw the figures (needs matplotlib).")
]
ChangesOfBench: TypeAlias = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Of sensor.…, or exposure.temperature_c, .iso, noise.seed."),
]

measure_app = typer.Typer(help="Measure what a file really holds.", no_args_is_help=True)


@measure_app.command("mtf")
def measure_mtf(
    files: Annotated[
        list[str],
        typer.Argument(metavar="FILE…", help="A maker's raw file, DNG, TIFF, PNG, EXR, NPY … with linear data."),
    ],
    rois: Annotated[
        list[str] | None,
        typer.Option(
            "--roi",
            metavar="ROW,COL,ROWS,COLS",
            help="A region with one edge; repeatable. Edges are looked for when left out.",
        ),
    ] = None,
    by: Annotated[
        str | None,
        typer.Option(
            "--by",
            metavar="KEY",
            help="What tells several files apart: aperture, iso, time, olpf, or any key that camsim info --full shows.",
        ),
    ] = None,
    unit: Annotated[
        str, typer.Option("--unit", metavar="UNIT", help="Of table and plots: cycles/px, lp/mm or lw/ph.")
    ] = "cycles/px",
    channel: Annotated[str, typer.Option("--channel", metavar="NAME", help="R, G1, G2, B, Y or all.")] = "all",
    no_tail: Annotated[
        bool, typer.Option("--no-tail", help="Leave out the line spread beyond the region: the plain ISO 12233 figure.")
    ] = False,
    no_theory: Annotated[
        bool, typer.Option("--no-theory", help="Leave out the curve that the file's own lens and sensor should have.")
    ] = False,
    gamma: GammaOf = None,
    cfa: Annotated[
        str | None,
        typer.Option("--cfa", metavar="RGGB", help="The filter array of a file that does not say it, or x-trans."),
    ] = None,
    layer: Annotated[str | None, typer.Option("--layer", metavar="NAME", help="Of an EXR or NPZ with several.")] = None,
    as_json: AsJson = False,
    csv: Annotated[str | None, typer.Option("--csv", metavar="FILE", help="Write the curves as a table.")] = None,
    plot: PlotFile = None,
    map_: Annotated[
        str | None,
        typer.Option("--map", metavar="FILE.png|svg", help="Draw sagittal and tangential MTF50 over the frame."),
    ] = None,
    force: Force = False,
) -> None:
    """Measure the MTF on slanted edges, with theory if the file says what it was taken with."""
    from camsim.cli.measure import MtfRequest, measure
    from camsim.cli.measured import Outputs

    measure(
        MtfRequest(
            files=tuple(files),
            rois=tuple(rois or ()),
            by=by,
            unit=unit,
            channel=channel,
            tail=not no_tail,
            theory=not no_theory,
            gamma=gamma,
            cfa=cfa,
            layer=layer,
            map=map_,
            outputs=Outputs(as_json=as_json, csv=csv, plot=plot, force=force),
        )
    )


@measure_app.command("truth")
def measure_truth(
    source: Annotated[str, typer.Argument(metavar="SCENE|FILE", help="A scene, or a file of camsim's.")],
    output: Annotated[str, typer.Option("-o", "--output", metavar="FILE.exr|npy", help="Where to write the planes.")],
    space: Annotated[
        str, typer.Option("--space", metavar="NAME", help="electrons, camera-rgb, xyz or srgb (linear).")
    ] = "srgb",
    sensor: SensorName = None,
    changes: Changes = None,
    sensors: Sensors = None,
    as_json: AsJson = False,
    force: Force = False,
) -> None:
    """Write what a perfect camera would give at every photosite: electrons, balanced channels, XYZ, linear sRGB."""
    from camsim.cli.measure_truth import TruthRequest, measure

    measure(
        TruthRequest(
            source=source,
            space=space,
            output=output,
            sensor=sensor,
            sensors=tuple(sensors or ()),
            changes=tuple(changes or ()),
            as_json=as_json,
            force=force,
        )
    )


@measure_app.command("demosaic")
def measure_demosaic(
    files: Annotated[
        list[str],
        typer.Argument(metavar="TRUTH RESULT… | SCENE…", help="A truth and results; with --all or --run: scenes."),
    ],
    published: Annotated[
        bool, typer.Option("--all", help="Capture scenes; run colour-demosaicing's methods and LibRaw's on them.")
    ] = False,
    programs: Annotated[
        list[str] | None,
        typer.Option(
            "--run",
            metavar="'CMD {in} {out}'",
            help="Capture scenes; run a program on a DNG ({in}) or the codes ({tiff}, {npy}); repeatable.",
        ),
    ] = None,
    result: Annotated[
        str, typer.Option("--result", metavar="SUFFIX", help="What {out} is: .tiff, .png, .exr or .npy.")
    ] = ".tiff",
    sensor: SensorName = None,
    changes: Changes = None,
    sensors: Sensors = None,
    gamma: GammaOf = None,
    cfa: Annotated[str | None, typer.Option("--cfa", metavar="RGGB", help="Of a truth that does not say them.")] = None,
    white: Annotated[
        float | None,
        typer.Option("--white", metavar="N", help="A perfect diffuser's number in a truth; 1, or the type's largest."),
    ] = None,
    border: Annotated[int, typer.Option("--border", metavar="PX", help="Left out all around.")] = 8,
    as_json: AsJson = False,
    csv: CsvFile = None,
    html: Annotated[
        str | None, typer.Option("--html", metavar="FILE", help="A page with linked crops and error maps.")
    ] = None,
    plot: PlotFile = None,
    force: Force = False,
) -> None:
    """Compare demosaiced pictures with the truth, name their faults, and rank them."""
    from camsim.cli.measure_demosaic import DemosaicRequest, measure
    from camsim.cli.measured import Outputs

    measure(
        DemosaicRequest(
            files=tuple(files),
            published=published,
            programs=tuple(programs or ()),
            result=result,
            sensor=sensor,
            sensors=tuple(sensors or ()),
            changes=tuple(changes or ()),
            gamma=gamma,
            cfa=cfa,
            white=white,
            border=border,
            html=html,
            outputs=Outputs(as_json=as_json, csv=csv, plot=plot, force=force),
        )
    )


@measure_app.command("colour")
def measure_colour(
    file: Annotated[
        str, typer.Argument(metavar="FILE", help="A raw file: camsim's of any patches, anybody's of a ColorChecker.")
    ],
    light: Annotated[
        str | None,
        typer.Option(
            "--light",
            metavar="NAME|FILE.csv",
            help="Light on a ColorChecker: an illuminant, or its measured power over nm; D50 when left out.",
        ),
    ] = None,
    corners: Corners = None,
    reflectances: ChartName = "ISO 17321-1",
    cfa: CfaOf = None,
    as_json: AsJson = False,
    csv: CsvFile = None,
    plot: PlotFile = None,
    picture: Annotated[
        str | None,
        typer.Option("--picture", metavar="FILE.png", help="The chart, the right half of each patch as it should be."),
    ] = None,
    force: Force = False,
) -> None:
    """Measure ΔE2000, white balance and noise of a ColorChecker, or of the patches that the file's scene shows.

    A file of camsim's says what its scene shows. In any other, and with --light or --corners, a ColorChecker is looked
    for, and developed by the file's own white balance and matrix.
    """
    from camsim.cli.measure_colour import ChartRequest, measure
    from camsim.cli.measured import Outputs

    request = ChartRequest(light=light, corners=corners, reflectances=reflectances, cfa=cfa)
    measure(file, picture, request, Outputs(as_json=as_json, csv=csv, plot=plot, force=force))


@measure_app.command("texture")
def measure_texture(
    file: Annotated[str, typer.Argument(metavar="FILE", help="A raw file of camsim's, of a texture.")],
    as_json: AsJson = False,
    csv: CsvFile = None,
    plot: PlotFile = None,
    force: Force = False,
) -> None:
    """Measure the MTF on any texture, dead leaves say, against the spectrum of the file's own scene."""
    from camsim.cli.measure_target import measure
    from camsim.cli.measured import Outputs

    measure(file, "texture", Outputs(as_json=as_json, csv=csv, plot=plot, force=force))


@measure_app.command("star")
def measure_star(
    file: Annotated[str, typer.Argument(metavar="FILE", help="A raw file of camsim's, of the chart siemens-star.")],
    as_json: AsJson = False,
    csv: CsvFile = None,
    plot: PlotFile = None,
    force: Force = False,
) -> None:
    """Measure the MTF on the Siemens star of the file's scene, with theory."""
    from camsim.cli.measure_target import measure
    from camsim.cli.measured import Outputs

    measure(file, "star", Outputs(as_json=as_json, csv=csv, plot=plot, force=force))


@measure_app.command("distortion")
def measure_distortion(
    file: Annotated[
        str,
        typer.Argument(
            metavar="FILE", help="A raw file: camsim's of a dot-grid or checkerboard, anybody's of a grid of dots."
        ),
    ],
    cfa: CfaOf = None,
    as_json: AsJson = False,
    csv: CsvFile = None,
    plot: PlotFile = None,
    force: Force = False,
) -> None:
    """Measure distortion and lateral colour: where dots or corners are seen, against the places of the scene.

    In a file that does not say what it was taken of a square grid of dots is looked for, seen in perspective.
    """
    from camsim.cli.measure_distortion import measure
    from camsim.cli.measured import Outputs

    measure(file, cfa, Outputs(as_json=as_json, csv=csv, plot=plot, force=force))


@measure_app.command("moire")
def measure_moire(
    file: Annotated[str, typer.Argument(metavar="FILE", help="A raw file, camsim's or anybody's, of a zone plate.")],
    cfa: CfaOf = None,
    rim: Annotated[
        float | None,
        typer.Option("--rim", metavar="PX", help="Radius of the plate, in files that do not say what they show."),
    ] = None,
    as_json: AsJson = False,
    csv: CsvFile = None,
    plot: PlotFile = None,
    force: Force = False,
) -> None:
    """Measure the moiré of a zone plate: how much of its contrast comes back as ghosts, with theory.

    In a file that does not say what it was taken of a plate is looked for about the picture's middle.
    """
    from camsim.cli.measure_moire import measure
    from camsim.cli.measured import Outputs

    measure(file, cfa, rim, Outputs(as_json=as_json, csv=csv, plot=plot, force=force))


@measure_app.command("noise")
def measure_noise(
    folder: Annotated[str | None, typer.Argument(metavar="FOLDER", help="Flats and darks with an index.csv.")] = None,
    sensor: Annotated[
        str | None, typer.Option("--sensor", metavar="NAME", help="Take flats and darks of this sensor instead.")
    ] = None,
    changes: ChangesOfBench = None,
    sensors: Sensors = None,
    side: Annotated[int, typer.Option("--side", metavar="N", help="Photosites a side that it takes.")] = 400,
    frames: Annotated[int, typer.Option("--frames", metavar="N", help="Frames of each level that it takes.")] = 16,
    iso: Annotated[float | None, typer.Option("--iso", metavar="N", help="Its base ISO when left out.")] = None,
    seed: Annotated[
        int | None, typer.Option("--seed", metavar="N", help="Of the noise: another one takes it all again.")
    ] = None,
    keep: Annotated[
        str | None, typer.Option("--keep", metavar="DIR", help="Write the frames of --sensor and their index here.")
    ] = None,
    cfa: CfaOf = None,
    as_json: AsJson = False,
    csv: CsvFile = None,
    plot: PlotFile = None,
    xml: Annotated[
        str | None,
        typer.Option("--xml", metavar="FILE.xml", help="Results after EMVA 1288; of several channels FILE-R.xml …"),
    ] = None,
    force: Force = False,
) -> None:
    """Measure gain, noise, full well, dark current, non-uniformities and linearity after EMVA 1288."""
    from camsim.cli.measure_noise import NoiseRequest, measure
    from camsim.cli.measured import Outputs

    measure(
        NoiseRequest(
            folder=folder,
            sensor=sensor,
            sensors=tuple(sensors or ()),
            changes=tuple(changes or ()),
            side=side,
            frames=frames,
            iso=iso,
            seed=seed,
            keep=keep,
            cfa=cfa,
            xml=xml,
            outputs=Outputs(as_json=as_json, csv=csv, plot=plot, force=force),
        )
    )
