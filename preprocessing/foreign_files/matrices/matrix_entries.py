"""Entries of a sparse matrix, whatever the format of its file: rows, columns and values, of which equal places add up."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from preprocessing.foreign_files.matrices.archive_entries import of_archive
from preprocessing.foreign_files.matrices.market_entries import MATRIX_MARKET, of_matrix_market
from preprocessing.foreign_files.matrices.number_lines import plain_text
from preprocessing.foreign_files.matrices.number_table import archive
from preprocessing.foreign_files.matrices.program_entries import of_program


def matrix_entries(path: str, n: str, dimension: str, degrees: str = "") -> dict[str, Any]:
    """Shape, rows, columns and values of SciPy's .npz, Matrix Market, or the text of Abaqus or CalculiX for n coordinates of nodes.

    The text of the last two also tells `labels`, the numbers of the nodes in whose order its rows are, or None.
    """
    file = Path(path)
    text = b"" if file.suffix == ".npz" else plain_text(file.read_bytes())
    is_market = text.lstrip()[: len(MATRIX_MARKET)].lower() == MATRIX_MARKET.lower()
    if file.suffix != ".npz" and not is_market:
        return of_program(text, int(n), int(dimension), Path(degrees).read_bytes() if degrees else None)
    if degrees:
        raise ValueError("a .dof file says what the rows of CalculiX's text are, and this is none; leave matrices.dof out")
    shape, row, column, value = of_matrix_market(text) if is_market else of_archive(archive(file))
    return {"shape": [int(size) for size in shape], "row": row, "column": column, "value": value}
