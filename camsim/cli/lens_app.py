"""``camsim lens``: lens files from prescriptions."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from camsim.cli.options import Force

lens_app = typer.Typer(no_args_is_help=True, help="Lens files from prescriptions.")


@lens_app.callback()
def _lens() -> None:
    """Lens files from prescriptions."""


@lens_app.command("import")
def import_lens(
    file: Annotated[str, typer.Argument(metavar="FILE.zmx", help="A sequential Zemax prescription.")],
    output: Annotated[str, typer.Option("-o", "--output", metavar="LENS.yaml", help="The lens file to write.")],
    field: Annotated[
        float | None, typer.Option("--field", metavar="DEG", min=1e-3, max=89.0, help="Largest field, from the axis.")
    ] = None,
    field_mm: Annotated[
        float | None, typer.Option("--field-mm", metavar="MM", min=1e-3, help="Instead: as a height in the image.")
    ] = None,
    mtf_within: Annotated[
        float,
        typer.Option("--mtf-within", metavar="X", min=0.0, max=1.0, help="How far the MTF may be from the rays'."),
    ] = 0.01,
    force: Force = False,
) -> None:
    """Trace a prescription and write a lens file, with its PSF over the frame (needs optiland for its glasses)."""
    from camsim.cli.new import check_yaml_output
    from camsim.config.lens_import import trace_zemax
    from camsim.errors import InvalidValueError
    from camsim.files.atomic import write_whole

    if field is not None and field_mm is not None:
        raise InvalidValueError("given together with '--field'; leave one of the two out", key="--field-mm")
    check_yaml_output(output, force=force)
    traced = trace_zemax(Path(file), field_deg=field, field_mm=field_mm)
    traced.check_mtf(mtf_within, Path(file).name)
    write_whole(output, traced.text.encode("utf-8"))
    for note in traced.notes:
        print(f"{output}: note: {note}")
    print(f"{output}: {traced.stated}")
    print(f"{output}: lens: {{kind: field, file: {Path(output).name}}} takes it")
