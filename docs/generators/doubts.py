"""The page of all codes of cautions, made from the docstrings of the checks and from `toolkit/foundation/codes.toml`.

`python -m docs.generators.doubts` writes the table into docs/doubts.md, so that the page is read in the repository as it is.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from docs.generators.house import HALVES, files, tree
from toolkit.foundation.files.safe_files import write_whole
from toolkit.foundation.verdict import checks, codes

PAGE = Path(__file__).parents[1] / "doubts.md"
PLACE = re.compile(r"^<!-- codes -->\n(?:.*?^<!-- end of codes -->\n)?", re.MULTILINE | re.DOTALL)
"""Where the page wants the table, with the table if it is there."""


def fill(markdown: str) -> str:
    """The page with its table as it is now."""
    return PLACE.sub(lambda _: f"<!-- codes -->\n\n{table()}\n\n<!-- end of codes -->\n", markdown)


def table() -> str:
    """A row for every code, in the order of the alphabet."""
    said = kinds()
    rows = [
        f'| <a id="{code}"></a>`{code}` | {said.get(code, "")} | {each.means} | {each.limit} | {each.remedy} |'
        for code, each in sorted(codes().items())
    ]
    return "\n".join(["| code | kind | what it means | limit | what helps |", "|---|---|---|---|---|", *rows])


def kinds() -> dict[str, str]:
    """Code -> whether it is a doubt, a remark, or either, by the places in the sources that say it."""
    found: dict[str, set[str]] = {}
    for code, doubt in literal_codes():
        found.setdefault(code, set()).add(doubt)
    return {code: said.pop() if len(said) == 1 else "either" for code, said in found.items()}


def literal_codes() -> Iterator[tuple[str, str]]:
    """Every code that stands in a source where a caution is made, and "doubt", "remark" or "either"."""
    of_checks = {each.measure.__name__: each.code for each in checks() if each.measure is not None}
    for call in _calls():
        if isinstance(call.func, ast.Attribute):
            yield of_checks[ast.unparse(call.func.value)], _doubt(call, 1)
        else:
            for literal in _literals(call.args[0]):
                yield literal, _doubt(call, 2)


def other_codes() -> Iterator[ast.expr]:
    """What stands for a code where it is no literal."""
    for call in _calls():
        if not isinstance(call.func, ast.Attribute) and not _literals(call.args[0]):
            yield call.args[0]


def _literals(code: ast.expr) -> list[str]:
    """What an expression may be: a text, one of two by a condition, or a constant of a module."""
    if isinstance(code, ast.IfExp):
        return [*_literals(code.body), *_literals(code.orelse)]
    if isinstance(code, ast.Name):
        return [_constants()[code.id]] if code.id in _constants() else []
    return [code.value] if isinstance(code, ast.Constant) and isinstance(code.value, str) else []


@cache
def _constants() -> dict[str, str]:
    """Name -> text of the modules' constants that hold a code."""
    found = {}
    for half in HALVES:
        for path in files(half).values():
            for node in tree(path).body:
                text = node.value.value if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant) else None
                if isinstance(text, str) and text in codes():
                    found |= {target.id: text for target in node.targets if isinstance(target, ast.Name)}
    return found


def _calls() -> Iterator[ast.Call]:
    for half in HALVES:
        for path in files(half).values():
            for node in ast.walk(tree(path)):
                if isinstance(node, ast.Call) and re.fullmatch(r"Caution|\w+\.caution", ast.unparse(node.func)):
                    yield node


def _doubt(call: ast.Call, place: int) -> str:
    stated = [each.value for each in call.keywords if each.arg == "doubt"] or call.args[place : place + 1]
    if not stated or (isinstance(stated[0], ast.Constant) and stated[0].value is True):
        return "doubt"
    return "remark" if isinstance(stated[0], ast.Constant) else "either"


if __name__ == "__main__":
    write_whole(PAGE, fill(PAGE.read_text(encoding="utf-8")).encode())
    print(f"{PAGE} written.")
