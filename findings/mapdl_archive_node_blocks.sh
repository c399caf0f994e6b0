#!/usr/bin/env bash
# Version: mapdl-archive 0.4.2.
# Expected: NBLOCK is a command that reads nodes into the model, and an input file may have several, one for
#   every part. Eight nodes in two blocks of four are eight nodes.
# Seen: The nodes of the first block are there, those of the second are gone, while the element goes on to
#   name them. No error and no warning. Several blocks of elements are read.
# Why: Files that are put together of several archives lose nodes. Whoever turns numbers of nodes into
#   places in the array fails, or takes other nodes.
# Source: MAPDL command reference, NBLOCK and EBLOCK. The documentation of mapdl-archive speaks of input
#   files of Workbench too, and does not restrict them to one block.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check mapdl-archive==0.4.2 numpy==2.4.6

venv/bin/python - <<'END'
from pathlib import Path
from mapdl_archive import Archive

CORNERS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]


def block(numbers):
    """An NBLOCK with these nodes, in the fields of CDWRITE."""
    rows = "".join(f"{n:9}{0:9}{0:9}" + "".join(f"{x:20.13E}".replace("E+", "E+0") for x in CORNERS[n - 1]) + "\n" for n in numbers)
    return f"NBLOCK,6,SOLID,{numbers[-1]:10},{len(numbers):10}\n(3i9,6e21.13e3)\n{rows}N,R5.3,LOC,       -1,\n"


fields = [1, 1, 1, 1, 0, 0, 0, 0, 8, 0, 1, 1, 2, 3, 4, 5, 6, 7, 8]
elements = "EBLOCK,19,SOLID,1,1\n(19i9)\n" + "".join(f"{n:9}" for n in fields) + "\n       -1\n"
found = []
for nodes in (block(range(1, 9)), block(range(1, 5)) + block(range(5, 9))):
    Path("brick.cdb").write_text("/PREP7\nET,1,185\n" + nodes + elements)
    archive = Archive("brick.cdb", parse_vtk=False)
    found.append(archive.nnum.tolist())
print("nodes of one block of eight:", found[0])
print("nodes of two blocks of four:", found[1], "- nodes of the element:", archive.elem[0][-8:].tolist())
assert found == [[1, 2, 3, 4, 5, 6, 7, 8], [1, 2, 3, 4]], found
END
