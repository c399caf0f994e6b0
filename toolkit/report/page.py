"""The page: one HTML file with pictures, tables and numbers inside, which opens without a network."""

from __future__ import annotations

import base64
import json
import math
import re
from collections.abc import Mapping, Sequence
from html import escape
from importlib.resources import files
from itertools import groupby
from pathlib import Path
from string import Template
from typing import NamedTuple

from toolkit.render.readable_units import MINUS
from toolkit.report.answer import AnswerTable

DASH = "\N{EN DASH}"
LONG = 40
"""Letters from which on an entry of a table is broken into lines."""


class PageSection(NamedTuple):
    """Section of the page: a heading and the HTML below it."""

    name: str
    title: str
    body: str
    full: bool = True
    """Whether it needs the whole width; the others fill two columns where there is room."""
    long: bool = False
    """Whether it may go on in the next column, between two pictures."""


def page(title: str, summary: str, *parts: Sequence[PageSection]) -> str:
    """HTML of the whole page; every part begins below the one before it."""
    sections = [section for part in parts for section in part]
    contents = "".join(f'<a href="#{escape(section.name)}">{escape(section.title)}</a>' for section in sections)
    grouped = (groupby(part, lambda section: section.full) for part in parts)
    groups = [(full, "".join(map(_section, some))) for part in grouped for full, some in part]
    bodies = "".join(some if full else f'<div class="halves">{some}</div>' for full, some in groups)
    return _template("page.html").substitute(title=escape(title), summary=escape(summary), contents=contents, sections=bodies)


def _section(section: PageSection) -> str:
    kind = ' class="long"' if section.long else ""
    return f'<section id="{escape(section.name)}"{kind}><h2>{escape(section.title)}</h2>{section.body}</section>'


def _template(name: str) -> Template:
    return Template((files("toolkit.report") / name).read_text(encoding="utf-8"))


def paragraph(text: str) -> str:
    """HTML of a paragraph of plain text."""
    return f"<p>{escape(typeset(text))}</p>"


def bullets(lines: Sequence[str]) -> str:
    """HTML of a list of plain texts."""
    return f"<ul>{''.join(f'<li>{escape(typeset(line))}</li>' for line in lines)}</ul>"


def typeset(text: str) -> str:
    """Text with minus signs before numbers, and dashes between words, instead of hyphens."""
    return re.sub(r"(?<=\s)-(?=\s)", DASH, re.sub(r"(?<![^\s(])-(?=\d)", MINUS, text))


def listing(text: str) -> str:
    """HTML of a text as it is, in letters of equal width."""
    return f"<pre>{escape(text)}</pre>"


def picture(path: Path, caption: str) -> str:
    """HTML of a picture's file inside the page, with its caption.

    A picture of pixels scrolls on its own where its letters could not be read.
    """
    kind = {".svg": "image/svg+xml", ".png": "image/png", ".gif": "image/gif"}[path.suffix]
    data = base64.b64encode(path.read_bytes()).decode()
    words = escape(typeset(caption))
    scrolls = "" if path.suffix == ".svg" else ' class="wide"'
    return f'<figure{scrolls}><img src="data:{kind};base64,{data}" alt="{words}"><figcaption>{words}</figcaption></figure>'


def pictures(parts: Sequence[str]) -> str:
    """HTML of pictures below each other."""
    return f'<div class="figures">{"".join(parts)}</div>'


def viewer(data: Mapping[str, object]) -> str:
    """HTML of the moving picture that the reader can stop at any time."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    return _template("viewer.html").substitute(data=text)


def table(content: AnswerTable) -> str:
    """HTML of a table that scrolls on its own if it is wider than the screen."""
    head = "".join(f"<th>{escape(str(name))}</th>" for name in content.head)
    rows = "".join(f"<tr>{''.join(_cell(value) for value in row)}</tr>" for row in content.rows)
    return (
        f'{paragraph(content.caption)}<div class="wide"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>'
    )


def _cell(value: object) -> str:
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        text = f"{value:.6g}".replace("-", MINUS) if math.isfinite(value) else "does not exist"
        return f'<td class="number">{text}</td>'
    kind = "word" if len(str(value)) < LONG else "long"
    return f'<td class="{kind}">{escape(str(value))}</td>'
