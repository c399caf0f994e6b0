"""The rooms of the house: which modules stand together on one page of the reference. New modules need no entry here.

A package inside `toolkit` is a room of its own. A module beside the packages belongs to the room that `BESIDE` names, or else to the
last of these; so nothing is ever missing from the reference.
"""

from __future__ import annotations

import ast
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]

BESIDE = {
    "Scene": (
        "scene", "scene_file", "point", "profile", "design", "run_options", "time_grid", "units", "scene_names", "description",
        "validation_messages", "replaced_file", "errors",
    ),
    "Reduced model": ("reduced_model", "reduced_model_file", "reduced_model_check", "entry_scales", "mode_shapes"),
    "Equations": ("system", "equations", "solution", "component", "planar", "kernel"),
    "Command line": ("cli",),
}  # fmt: skip
"""Rooms of the modules that are not in a package, in the order of the navigation."""
REST = "Equations"
FIRST = ("Scene", "Reduced model", "Bodies", "Joints", "Loads", "Responses", "Equations", "Solvers", "Sensitivity")
"""Rooms in the order that a reader needs them; all others follow by name, `Preprocessing` last."""


@dataclass(frozen=True)
class Room:
    """One page of the reference."""

    title: str
    about: str
    modules: tuple[str, ...]

    @property
    def page(self) -> str:
        """Path of the page inside the documentation."""
        return f"reference/{self.title.lower().replace(' ', '-')}.md"


def modules(package: str) -> dict[str, Path]:
    """Dotted name to file of every module of a package, without empty-handed `__init__` files."""
    found = {}
    for path in sorted((ROOT / package).rglob("*.py")):
        if path.name != "__init__.py":
            found[".".join(path.relative_to(ROOT).with_suffix("").parts)] = path
    return found


def about(path: Path) -> str:
    """First line of a file's docstring."""
    return (ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or "").partition("\n")[0]


def rooms() -> list[Room]:
    """All rooms with all their modules."""
    content: dict[str, list[str]] = {}
    for name in modules("toolkit"):
        content.setdefault(_title(name), []).append(name)
    content["Preprocessing"] = list(modules("preprocessing"))
    ordered = [
        *(title for title in FIRST if title in content),
        *sorted(set(content) - {*FIRST, "Preprocessing"}),
        "Preprocessing",
    ]
    return [Room(title, _about(title), tuple(sorted(content[title], key=_rank))) for title in ordered]


def page(room: Room) -> str:
    """Text of one page: every module with all that is public in it."""
    return f"# {room.title}\n\n{room.about}\n\n" + "\n\n".join(f"::: {name}" for name in room.modules) + "\n"


def overview() -> str:
    """Table of all rooms with their modules."""
    rows = [
        f"| [{room.title}]({room.page}) | " + ", ".join(f"[`{name}`][{name}]" for name in room.modules) + " |" for room in rooms()
    ]
    return "\n".join(["| room | modules |", "|---|---|", *rows])


def _title(module: str) -> str:
    _, first, *inside = module.split(".")
    if inside:
        return {"command_line": "Command line"}.get(first, first.replace("_", " ").capitalize())
    return next((title for title, names in BESIDE.items() if first in names), REST)


def _rank(module: str) -> tuple[int, str]:
    """Modules beside the packages in the order of `BESIDE`, all others by name."""
    names = [name for group in BESIDE.values() for name in group]
    short = module.removeprefix("toolkit.")
    return (names.index(short) if short in names else len(names), module)


def _about(title: str) -> str:
    folder = ROOT / "toolkit" / title.lower().replace(" ", "_")
    folder = ROOT / "preprocessing" if title == "Preprocessing" else folder
    return about(folder / "__init__.py") if folder.is_dir() else ""
