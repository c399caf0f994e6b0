"""Finished matrices: Matrix Market, the texts of Abaqus and CalculiX, SciPy's archives of every format, coordinates, all spoilt."""

from __future__ import annotations

import io
import tempfile
import zipfile
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy import io as scipy_io
from scipy import sparse

from preprocessing.builders.body_recipe import BodyRecipe
from preprocessing.builders.discrete_body import discrete_body
from tests.fuzz.case import Case
from tests.fuzz.mutations import spoilt
from tests.models.solid_bodies import rectangle, write_body

BODY = """
units = "m-kg-s"
[matrices]
mass = "{mass}"
stiffness = "{stiffness}"
nodes = "{nodes}"
{stress}
[clamp]
nodes = [0, 1, 2]
[interface_points.tip]
nodes = [9, 10, 11]
tie = "rigid"
[basis]
kind = "{basis}"
"""
KINDS = ("csr", "csc", "bsr", "coo", "dia")
TEXTS = ("market", "market-symmetric", "market-array", "abaqus", "coordinate", "calculix")
FACTORS = (0.0, 1e-300, 1e300, 1e60, 1e-60, -1.0, np.nan)


@cache
def matrices() -> tuple[Any, Any, np.ndarray, Any]:
    """Mass, stiffness, nodes and stress of a small rectangle."""
    with tempfile.TemporaryDirectory() as folder:
        path = write_body(Path(folder), rectangle("quad", (3, 2), 1.0, 0.2), "kind = 'static'", tie="rigid")
        body = discrete_body(path, BodyRecipe.read(path).file)
        found = body.parts.at(body.values)
        return found.mass, found.stiffness, body.mesh.nodes, found.stress


@cache
def written(matrix: str, kind: str) -> bytes:
    """A matrix as a file."""
    whole = dict(zip(("mass", "stiffness", "nodes", "stress"), matrices(), strict=True))[matrix]
    stream = io.BytesIO()
    if kind in KINDS:
        converted = sparse.bsr_array(sparse.csr_array(whole), blocksize=(1, 2)) if kind == "bsr" else whole.asformat(kind)
        sparse.save_npz(stream, converted)
    elif kind == "abaqus":
        lower = sparse.tril(whole).tocoo()
        rows = zip(*(lower.row // 2 + 1, lower.row % 2 + 1, lower.col // 2 + 1, lower.col % 2 + 1, lower.data), strict=True)
        return "".join(f"{a},{b}, {c},{d}, {value:.17e}\n" for a, b, c, d, value in rows).encode()
    elif kind in ("coordinate", "calculix"):
        entries = sparse.triu(whole).tocoo() if kind == "calculix" else whole.tocoo()
        rows = zip(entries.row + 1, entries.col + 1, entries.data, strict=True)
        return "".join(f"{row} {column}  {value:.17e}\n" for row, column, value in rows).encode()
    else:
        scipy_io.mmwrite(
            stream,
            whole.toarray() if kind == "market-array" else sparse.coo_array(whole),
            precision=17,
            symmetry="symmetric" if kind == "market-symmetric" else "general",
        )
    return stream.getvalue()


@cache
def written_nodes(kind: str) -> bytes:
    stream = io.BytesIO()
    nodes = matrices()[2]
    if kind == "csv":
        np.savetxt(stream, nodes, delimiter=",", fmt="%.17g")
    elif kind == "npy":
        np.save(stream, nodes)
    else:
        np.savez(stream, nodes)
    return stream.getvalue()


@cache
def written_degrees() -> bytes:
    """What CalculiX writes beside its matrices: the node and the direction of each row."""
    return "".join(f"{node + 1}.{axis + 1}\n" for node, axis in np.ndindex(*matrices()[2].shape)).encode()


def cases(rng: np.random.Generator) -> Iterator[Case]:
    """One of the files is spoilt each time."""
    while True:
        kinds = {name: str(rng.choice(KINDS + TEXTS)) for name in ("mass", "stiffness")} | {"stress": str(rng.choice(KINDS))}
        files = {name: written(name, kind) for name, kind in kinds.items()}
        ending = {name: ending_of(name, kind) for name, kind in kinds.items()} | {
            "nodes": str(rng.choice(["csv", "npy", "npz"])),
            "dof": "dof",
        }
        files["nodes"] = written_nodes(ending["nodes"])
        files |= {"dof": written_degrees()} if "calculix" in kinds.values() else {}
        victims = ["mass", "stiffness", "mass", "stiffness", "nodes", "stress", *(["dof"] if "dof" in files else [])]
        victim = str(rng.choice(victims))
        if ending[victim] == "npz" and rng.random() < 0.6:
            how, files[victim] = spoilt_archive(files[victim], rng)
        else:
            how, files[victim] = spoilt(files[victim], files["nodes" if victim != "nodes" else "mass"], rng)
        names = {
            name: f"body.{ending[name]}" if ending[name] in ("sti", "mas", "dof") else f"{name}.{ending[name]}" for name in files
        }
        text = BODY.format(
            mass=names["mass"],
            stiffness=names["stiffness"],
            nodes=names["nodes"],
            stress=f'stress = "{names["stress"]}"' if victim == "stress" else "",
            basis=rng.choice(["static", "full", 'craig-bampton"\ncount = 2 #']),
        )
        yield Case(
            f"{victim} {kinds.get(victim, ending[victim])} {how}", ("ffrf-preprocess", "body.toml"), files_of(text, names, files)
        )


def ending_of(name: str, kind: str) -> str:
    if kind in KINDS:
        return "npz"
    return {"mass": "mas", "stiffness": "sti"}[name] if kind == "calculix" else "mtx"


def files_of(text: str, names: dict[str, str], files: dict[str, bytes]) -> Callable[[Path], None]:
    def write(folder: Path) -> None:
        (folder / "body.toml").write_text(text)
        for name, content in files.items():
            (folder / names[name]).write_bytes(content)

    return write


WRONG: dict[str, Callable[[np.ndarray, np.random.Generator], Any]] = {
    "empty": lambda a, _: a[:0] if a.ndim else a,
    "shorter": lambda a, _: a[:-1] if a.ndim else a,
    "longer": lambda a, _: np.concatenate([a, a]) if a.ndim else a,
    "negative": lambda a, _: -a if a.dtype.kind in "if" else a,
    "one large": lambda a, rng: changed(a, rng, [2**31 - 1, 2**31, 10**9, 2**62, 1000, 25]),
    "one negative": lambda a, rng: changed(a, rng, [-1, -(2**31), -(2**62), -100]),
    "shuffled": lambda a, rng: rng.permutation(a) if a.ndim else a,
    "float": lambda a, _: a.astype(float) if a.dtype.kind in "iuf" else a,
    "complex": lambda a, _: a.astype(complex) if a.dtype.kind in "iuf" else a,
    "truth": lambda a, _: a.astype(bool) if a.dtype.kind in "iuf" else a,
    "unsigned": lambda a, _: a.astype(np.uint64) if a.dtype.kind in "iu" else a,
    "long double": lambda a, _: a.astype(np.longdouble) if a.dtype.kind in "iuf" else a,
    "half": lambda a, _: a.astype(np.float16) if a.dtype.kind in "iuf" else a,
    "big-endian": lambda a, _: a.astype(a.dtype.newbyteorder(">")),
    "text": lambda *_: np.array("text"),
    "object": lambda *_: np.array([{"a": 1}], object),
    "record": lambda *_: np.zeros(3, [("a", float), ("b", "S3")]),
    "no axes": lambda a, _: a.ravel()[0] if a.size else a,
    "one more axis": lambda a, _: a[None],
    "scaled": lambda a, rng: a * rng.choice(FACTORS) if a.dtype.kind == "f" else a,
    "huge shape": lambda *_: np.array([10**12, 10**12]),
    "nan": lambda a, _: np.full(a.shape, np.nan),
    "zeros": lambda a, _: np.zeros_like(a) if a.dtype.kind in "iuf" else a,
    "bomb": lambda *_: np.zeros(30_000_000),
    "dates": lambda *_: np.zeros(3, "M8[s]"),
}


def changed(array: np.ndarray, rng: np.random.Generator, values: list[int]) -> np.ndarray:
    if array.dtype.kind not in "iuf" or not array.size:
        return array
    found = array.astype(np.int64) if array.dtype.kind in "iu" else array.copy()
    found.reshape(-1)[rng.integers(found.size)] = values[int(rng.integers(len(values)))]
    return found


def spoilt_archive(content: bytes, rng: np.random.Generator) -> tuple[str, bytes]:
    """One of the arrays is another one, or missing, or claims what it is not; the archive itself is right."""
    with np.load(io.BytesIO(content)) as archive:
        arrays = dict(archive)
    name, how = str(rng.choice(list(arrays))), str(rng.choice([*WRONG, "missing", "claims", "twice", "header"]))
    members = {key: saved(array) for key, array in arrays.items()}
    if how == "missing":
        del members[name]
    elif how in ("claims", "header"):
        claim = rng.choice([b"(1000000000000,)", b"(-1,)", b"(3, 0)", b"(99999,99999)", b"('a',)", b"(1e3,)", b"((1,),)"])
        members[name] = claimed(members[name], bytes(claim), how == "header")
    elif how != "twice":
        members[name] = saved(WRONG[how](arrays[name], rng))
    stream = io.BytesIO()
    packing = int(rng.choice([zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA]))
    with zipfile.ZipFile(stream, "w", packing) as packed:
        for key, member in members.items():
            packed.writestr(f"{key}.npy", member)
    return f"archive {name} {how}", stream.getvalue()


def saved(array: Any) -> bytes:
    stream = io.BytesIO()
    np.save(stream, array, allow_pickle=True)
    return stream.getvalue()


def claimed(member: bytes, shape: bytes, broken: bool) -> bytes:
    """The array with another shape in its header, or with a header that is none."""
    start = member.index(b"'shape': ") + len(b"'shape': ")
    end = member.index(b"}", start)
    text = member[10:start] + shape + b", }" + b"(" * 50 * broken
    text = text.ljust(len(member[10 : member.index(b"\n", 10)])) + b"\n"
    return member[:8] + len(text).to_bytes(2, "little") + text + member[member.index(b"\n", end) + 1 :]
