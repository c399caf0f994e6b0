"""The house as its folders and imports state it: rooms, what is in them, and the arrows between them."""

from __future__ import annotations

import ast
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).parents[2]
HALVES = ("toolkit", "preprocessing")
Arrows = dict[str, set[str]]
"""Name -> names that it imports from."""


@cache
def files(package: str) -> dict[str, Path]:
    """Dotted name to file of every module and every room of a package."""
    found = {}
    for path in sorted((ROOT / package).rglob("*.py")):
        parts = path.relative_to(ROOT).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def modules(package: str) -> dict[str, Path]:
    """Dotted name to file of every module of a package, without the `__init__` files of its rooms."""
    return {name: path for name, path in files(package).items() if path.name != "__init__.py"}


@cache
def rooms(package: str) -> list[str]:
    """Dotted names of all folders of a package, itself first."""
    return [name for name, path in files(package).items() if path.name == "__init__.py"]


@cache
def tree(path: Path) -> ast.Module:
    """Syntax of a file."""
    return ast.parse(path.read_text(encoding="utf-8"))


def about(name: str) -> str:
    """First line of the docstring of a module or a room."""
    return (ast.get_docstring(tree(files(name.split(".")[0])[name])) or "").partition("\n")[0]


@cache
def imports(path: Path, typing: bool = True) -> frozenset[str]:
    """Everything that a file imports, at its top or inside of functions; without `typing` not what its annotations alone need."""
    found: set[str] = set()
    left_out = set() if typing else {node for block in _for_annotations(tree(path)) for node in ast.walk(block)}
    for node in ast.walk(tree(path)):
        if node in left_out:
            continue
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path} uses a relative import"
            found |= {f"{node.module}.{alias.name}" for alias in node.names} | {str(node.module)}
    return frozenset(found)


def _for_annotations(module: ast.Module) -> list[ast.If]:
    return [node for node in module.body if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"]


def arrows(room: str) -> Arrows:
    """What stands directly in a room, files and rooms: which of them imports from which others, annotations apart."""
    inside = f"{room}."
    known = modules(room.split(".")[0])
    found: Arrows = {name.removeprefix(inside).split(".")[0]: set() for name in known if name.startswith(inside)}
    for name, path in known.items():
        if name.startswith(inside):
            own = name.removeprefix(inside).split(".")[0]
            for used in imports(path, typing=False) & known.keys():
                if used.startswith(inside):
                    found[own] |= {used.removeprefix(inside).split(".")[0]} - {own}
    return found


def ordered(found: Arrows) -> list[str]:
    """All names, each after those that it imports from, by name where there is a choice.

    Raises
    ------
    CycleError
        Some import each other in a circle.
    """
    sorter, order = TopologicalSorter(found), []
    sorter.prepare()
    while sorter.is_active():
        ready = sorted(sorter.get_ready())
        order += ready
        sorter.done(*ready)
    return order
