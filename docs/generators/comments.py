"""What the code says about the fields of a class: comments behind them, and the section `Attributes` of its docstring."""

from __future__ import annotations

import ast
import inspect
import io
import re
import textwrap
import tokenize
from functools import cache

SECTION = re.compile(r"\n\nAttributes\n-+\n(.*?)(?=\n\n|\Z)", re.DOTALL)
ENTRY = re.compile(r"^(\w+)[^\n]*\n((?:[ \t]+[^\n]*\n?)+)", re.MULTILINE)


def trailing_comment(source: str) -> str:
    """The comment at the end of a statement; empty if there is none, or if it is for a tool and not for the reader."""
    try:
        tokens = list(tokenize.generate_tokens(io.StringIO(source).readline))
    except (tokenize.TokenError, IndentationError):
        return ""
    comments = [token.string.lstrip("# ") for token in tokens if token.type == tokenize.COMMENT]
    return "" if not comments or re.match(r"(fmt|type|noqa)\b", comments[-1]) else comments[-1]


def words(kind: type) -> str:
    """Docstring of a class without its section on attributes."""
    return SECTION.sub("", inspect.cleandoc(kind.__doc__ or ""))


def meanings(kind: type) -> dict[str, str]:
    """What the fields of a class mean, its bases' fields included."""
    found: dict[str, str] = {}
    for each in reversed(kind.__mro__):
        if each.__module__.split(".")[0] in ("toolkit", "preprocessing"):
            found |= _commented(each) | _described(each)
    return found


@cache
def _commented(kind: type) -> dict[str, str]:
    source = textwrap.dedent(inspect.getsource(kind))
    lines = source.splitlines()
    (definition,) = ast.parse(source).body
    assert isinstance(definition, ast.ClassDef)
    found = {}
    for node in definition.body:
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            statement = "\n".join(line.strip() for line in lines[node.lineno - 1 : node.end_lineno])
            found[node.target.id] = trailing_comment(statement)
    return {name: comment for name, comment in found.items() if comment}


def _described(kind: type) -> dict[str, str]:
    section = SECTION.search(inspect.cleandoc(kind.__dict__.get("__doc__") or ""))
    return {} if section is None else {name: " ".join(text.split()) for name, text in ENTRY.findall(section[1])}
