"""Meshes of several files: includes in circles, in rows, of pipes and devices, in spellings that only the reader of meshes knows."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from tests.fuzz.case import Case
from tests.fuzz.mesh_cases import body, good

NODES = b"*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n"
ELEMENTS = b"*ELEMENT, TYPE=CPS4\n1,1,2,3,4\n"
SETS = b"*NSET, NSET=left\n1,4\n*NSET, NSET=right\n2,3\n"
SPELLINGS = [
    b"*INCLUDE, INPUT=", b"*Include,input = ", b"INCLUDE, INPUT=", b"*IN*CLUDE, A=B=", b" * include , x=", b"*INCLUDE, ",
    b"*INCLUDE\n, INPUT=",
    "*ıNCLUDE, INPUT=".encode(), b"*INCLUDE, INPUT='", b"*INCLUDE, INPUT=./", b"*INCLUDE, INPUT=../case/",
    b"*INCLUDE, INPUT=\xff",
]  # fmt: skip
ENDS = [b"\n", b"\r\n", b"\r", b"\x0c\n", b""]
SPECIAL = [
    "/dev/zero",
    "/dev/urandom",
    "/proc/self/mem",
    "pipe",
    "folder",
    "missing",
    "x" * 300,
    "terabyte",
    ".",
    "/",
    "",
    "circle",
    "a\0b",
]
BULK = (
    b"GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\n",
    b"CQUAD4,1,1,1,2,3,4\n",
    b"SET1,1,1,4\nSET1,2,2,3\n",
)
BULK_SPELLINGS = [
    b"INCLUDE '%s'", b'include "%s"', b"Include %s", b"INCLUDE='%s'", b"  INCLUDE '%s' $ words", b"INCLUDE '%s", b"INCLUDE '\n %s'",
    b"INCLUDE",
    b"INCLUDE 'deep\\..\\%s'", b"INCLUDE './%s'", b"INCLUDE '../case/%s'", b"INCLUDE\t'%s'", b"INCLUDE\xff '%s'",
]  # fmt: skip
GENERATED = [
    b"1,4,1",
    b"1,1000000000000,1",
    b"1,4,0",
    b"4,1,1",
    b"1,4,-1",
    b"1,500000000",
    b"-5,5,1",
    b"1,2,3,4,5",
    b"x,y,z",
    b"1,4,1e9",
]
XDMF = ["body.xdmf", "body.h5", "/dev/zero", "pipe", "folder", "missing", "terabyte", "circle", "x" * 300, ""]


def cases(rng: np.random.Generator) -> Iterator[Case]:
    """Five sorts in turn."""
    while True:
        yield _tree(rng)
        yield _generated(rng)
        yield _special(rng)
        yield _xdmf(rng)
        yield _bulk(rng)


def _bulk(rng: np.random.Generator) -> Case:
    """Up to thirty files of bulk data that include each other at random, or what is no file."""
    n = int(rng.choice([1, 2, 3, 5, 30]))
    names = [b"part%d.blk" % k for k in range(n)] + ([each.encode() for each in SPECIAL] if rng.random() < 0.3 else [])
    files = {}
    for file in ["body.bdf", *(f"part{k}.blk" for k in range(n))]:
        statements = []
        for _ in range(int(rng.integers(3)) if file != "body.bdf" else 1):
            spelling = BULK_SPELLINGS[int(rng.integers(len(BULK_SPELLINGS)))]
            name = names[int(rng.integers(len(names)))]
            statements.append(spelling.replace(b"%s", name) + ENDS[int(rng.integers(len(ENDS)))])
        cards = BULK if file == "body.bdf" or rng.random() < 0.1 else BULK[:1]  # copies of nodes count for nothing
        files[file] = _text([*cards, *statements], rng)
    text = body("body.bdf", True, rng, True).replace('"left"', '"SET1 1"').replace('"right"', '"SET1 2"')
    return Case(f"{n} files of bulk data", ("ffrf-preprocess", "body.toml"), files_of(text, files, special))


def _text(parts: list[bytes], rng: np.random.Generator) -> bytes:
    return b"".join(parts[k] for k in (rng.permutation(len(parts)) if rng.random() < 0.3 else range(len(parts))))


def _tree(rng: np.random.Generator) -> Case:
    """Up to thirty files that include each other at random."""
    n = int(rng.choice([1, 2, 3, 5, 30]))
    files = {}
    for k in range(n):
        lines = [
            SPELLINGS[int(rng.integers(len(SPELLINGS)))] + b"part%d.inp" % rng.integers(n) + ENDS[int(rng.integers(len(ENDS)))]
            for _ in range(int(rng.integers(3)))
        ]
        files[f"part{k}.inp"] = _text([NODES, ELEMENTS, SETS, *lines], rng)
    files["body.inp"] = _text([NODES, ELEMENTS, SETS, b"*INCLUDE, INPUT=part0.inp\n"], rng)
    return Case(f"{n} files", ("ffrf-preprocess", "body.toml"), files_of(body("body.inp", True, rng, True), files))


def _generated(rng: np.random.Generator) -> Case:
    """Sets that are generated."""
    span = GENERATED[int(rng.integers(len(GENERATED)))]
    if rng.random() < 0.5:
        span = b",".join(b"%d" % rng.integers(-3, 10 ** rng.integers(1, 13)) for _ in range(int(rng.integers(1, 5))))
    kind = [b"*NSET, NSET=left, GENERATE\n", b"*ELSET, ELSET=left, GENERATE\n", b"*NSET, GENERATE\n"][int(rng.integers(3))]
    files = {"body.inp": _text([NODES, ELEMENTS, SETS, kind + span + b"\n"], rng)}
    return Case(f"generate {span[:30]!r}", ("ffrf-preprocess", "body.toml"), files_of(body("body.inp", True, rng, True), files))


def _special(rng: np.random.Generator) -> Case:
    """An include of what is no file."""
    what = SPECIAL[int(rng.integers(len(SPECIAL)))]
    line = SPELLINGS[int(rng.integers(len(SPELLINGS)))] + what.encode() + ENDS[int(rng.integers(len(ENDS)))]
    files = {"body.inp": _text([NODES, ELEMENTS, SETS, line], rng)}
    text = body("body.inp", True, rng, True)
    return Case(f"include {what[:30]!r} {line[:20]!r}", ("ffrf-preprocess", "body.toml"), files_of(text, files, special))


def _xdmf(rng: np.random.Generator) -> Case:
    """Data of XDMF from elsewhere, and hostile XML."""
    what = XDMF[int(rng.integers(len(XDMF)))]
    name = str(rng.choice(["xdmf-hdf", "xdmf-binary", "xdmf-xml"]))
    files = dict(good()[name, str(rng.choice(["quad", "triangle"]))])
    text = files["body.xdmf"]
    how = int(rng.integers(5))
    if how == 0:
        text = text.replace(b"body.h5", what.encode()).replace(b"body0.bin", what.encode())
    elif how == 1:
        path = [b":/data0", b":", b":/", b":/x:/y", b":data0/data1", b"::"][int(rng.integers(6))]
        text = text.replace(b":/data0", path)
    elif how == 2:
        entities = b"".join(b'<!ENTITY e%d "%s">' % (k, b"&e%d;" % (k - 1) * 10 if k else b"x" * 10) for k in range(12))
        text = b'<!DOCTYPE Xdmf [%s<!ENTITY f SYSTEM "%s">]>' % (entities, what.encode()) + text.replace(
            b"</Domain>", b"&e11;&f;</Domain>"
        )
    elif how == 3:
        depth = int(rng.choice([100, 3000, 100_000]))
        text = text.replace(b"</Domain>", b"<a>" * depth + b"</a>" * depth + b"</Domain>")
    else:
        link = b'<xi:include xmlns:xi="http://www.w3.org/2001/XInclude" href="%s"/>' % what.encode()
        text = text.replace(b"</Domain>", link + b"</Domain>")
    files["body.xdmf"] = text
    return Case(
        f"{name} {how} {what[:30]!r}",
        ("ffrf-preprocess", "body.toml", "--output", "out.h5"),
        files_of(body("body.xdmf", True, rng), files, special),
    )


def special(folder: Path) -> None:
    """What names may lead to."""
    os.mkfifo(folder / "pipe")
    (folder / "folder").mkdir()
    (folder / "circle").symlink_to("circle")
    with (folder / "terabyte").open("wb") as file:
        file.truncate(10**12)


def files_of(text: str, files: dict[str, bytes], more: Callable[[Path], None] = lambda _: None) -> Callable[[Path], None]:
    def write(folder: Path) -> None:
        (folder / "body.toml").write_text(text)
        for name, content in files.items():
            (folder / name).write_bytes(content)
        more(folder)

    return write
