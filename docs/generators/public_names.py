"""Public names, `import ffrf`: what each is, in the order of the use that most people make of them."""

from __future__ import annotations

import ast

from docs.generators.house import files, tree
from toolkit import _PLACES

NAMES = {**_PLACES, "preprocessing": "preprocessing:"}
"""Public name -> module and what it is called there; without a name the module itself."""

FIRST = (
    "read_scene",
    "compile",
    "Model",
    "Run",
    "Verdict",
    "Caution",
    "Outcome",
    "Scene",
    "RunOptions",
    "plane",
    "space",
    "extend",
)
"""What a run needs, and a scene in Python; others follow in the order of the alphabet."""


def table() -> str:
    """A row for every name that `import ffrf` brings, linked to its place in the reference."""
    names = [*FIRST, *(name for name in NAMES if name not in FIRST)]
    rows = [f"| [`{name}`]{_link(name)} | {_about(name)} |" for name in names]
    return "\n".join(["| `import ffrf` | what it is |", "|---|---|", *rows])


def _link(name: str) -> str:
    """Its place in the reference: a page where it is a room."""
    module, _, attribute = NAMES[name].partition(":")
    if files(module.split(".")[0])[module].name == "__init__.py":
        room = module if "." in module else f"{module}.builders"  # a half has no page of its own
        return f"(reference/{room.replace('.', '-')}.md)"
    return f"[{module}.{attribute}]" if attribute else f"[{module}]"


def _about(name: str) -> str:
    """First paragraph of its docstring."""
    module, _, attribute = NAMES[name].partition(":")
    node: ast.AST = tree(files(module.split(".")[0])[module])
    if attribute:
        node = next(each for each in tree(files(module.split(".")[0])[module]).body if getattr(each, "name", None) == attribute)
    assert isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
    return " ".join((ast.get_docstring(node) or "").partition("\n\n")[0].split()).replace("|", "\\|")
