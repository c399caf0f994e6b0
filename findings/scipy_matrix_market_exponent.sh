#!/usr/bin/env bash
# Version: scipy 1.17.1, numpy 2.4.6.
# Expected: scipy.io.mmread reads 1.75D-07, the double precision number of a Fortran program, as 1.75e-07,
#   or refuses it. It refuses 2.0abc.
# Seen: No error and no warning: 1.75D-07 becomes 1.75, 2.0abc becomes 2.0 and 1,5 becomes 1.0. What follows
#   the longest number on the line is skipped.
# Why: Stiffness and mass matrices of finite element programs in Fortran are handed over as Matrix Market
#   files. An entry of 1.75e-07 that is read as 1.75 makes another structure, and nothing tells.
# Source: The description of the Matrix Market format has decimal numbers as in C and one entry per line,
#   and nothing after it. The reader that scipy had before (the module scipy.io._mmio) refuses such a number
#   with a ValueError; the present one is compiled and looks for the end of the line after the number.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check scipy==1.17.1 numpy==2.4.6

venv/bin/python - <<'END'
import io
from scipy.io import mmread

HEAD = "%%MatrixMarket matrix coordinate real general\n2 2 2\n"
values = {}
for written in ("1.75D-07", "2.0abc", "1,5"):
    matrix = mmread(io.StringIO(f"{HEAD}1 1 {written}\n2 2 3.0\n")).toarray()
    values[written] = float(matrix[0, 0])
    print(f"{written:>9} is read as {matrix[0, 0]}, the next entry as {matrix[1, 1]}")
assert values == {"1.75D-07": 1.75, "2.0abc": 2.0, "1,5": 1.0}, values
END
