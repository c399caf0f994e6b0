"""The command `ffrf export`: results as tables and as a time series for ParaView."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from toolkit.command_line.keeping import Models
from toolkit.command_line.printing import prepare_folder, print_files
from toolkit.foundation.errors import InputError
from toolkit.foundation.terminal import AsJson, Quiet

if TYPE_CHECKING:
    from toolkit.files.results import Results


def export(
    file: Annotated[Path, typer.Argument(metavar="FILE.h5", help="Results that --output kept.")],
    csv: Annotated[Path | None, typer.Option(metavar="DIR", help="Folder for tables, one CSV file per quantity.")] = None,
    paraview: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder for a time series of the deformed bodies with stress (PVD).")
    ] = None,
    models: Models = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Write results as CSV tables, or for ParaView."""
    from toolkit.files.results_file import load_results

    if csv is None and paraview is None:
        raise InputError("nothing to export. Say what is wanted with --csv DIR, --paraview DIR, or both.")
    results, files = load_results(file), list[Path]()
    if csv is not None:
        from toolkit.files.tables import export_csv

        files += export_csv(results, prepare_folder(csv))
    if paraview is not None:
        files.append(_export_paraview(results, prepare_folder(paraview), models))
    print_files(files, results.verdict, as_json, quiet)


def _export_paraview(results: Results, folder: Path, models: Path | None) -> Path:
    from toolkit.render.packages import require

    require("pyvista", "matplotlib")
    from toolkit.analyses.sensitivity.run import restored
    from toolkit.render.paraview import export_paraview

    return export_paraview(restored(results, models).solution, folder)
