"""``camsim lens``: lens files from prescriptions."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

lens_app = typer.Typer(no_args_is_help=True, help="Lens files from prescriptions.")


@lens_app.callback()
def _lens() -> None:
    """Lens files from prescriptions."""


@lens_app.command("import")
def import_lens(
    file: Annotated[str, typer.Argument(metavar="FILE.zmx", help="A sequential Zemax prescription, fields by angle.")],
    output: Annotated[str, typer.Option("-o", "--output", metavar="LENS.yaml", help="The lens file to write.")],
    force: Annotated[bool, typer.Option("--force", help="Overwrite a file that exists.")] = False,
) -> None:
    """Trace a prescription and write what it does at every place as a lens file (needs optiland)."""
    from camsim.cli.new import check_yaml_output
    from camsim.config.lens_import import import_zemax
    from camsim.files.atomic import write_whole

    check_yaml_output(output, force=force)
    write_whole(output, import_zemax(Path(file)).encode("utf-8"))
    print(f"{output}: lens: {{kind: field, file: {Path(output).name}}} takes it")
