r"""Formulas of the pages as MathML, which browsers draw by themselves: no script, no font, nothing from the network.

In the source they are `$...$` and fences ```` ```math ````, as forges show them too. A fence with `\tag{2.3}` is an equation with that
number; `(2.3)` in the text leads to it. The formulas pass Markdown inside of attributes, out of its reach.
"""

from __future__ import annotations

import re
from html import escape, unescape
from xml.etree import ElementTree

FENCE = re.compile(r"^```math\n(.*?)^```$", re.DOTALL | re.MULTILINE)
INLINE = re.compile(r"(?<![\\$`])\$([^$\n]+)\$(?![$`])")
TAG = re.compile(r"\\tag\{([\d.]+)\}")
REFERENCE = re.compile(r"(?<![\w\[(])\((\d+\.\d+)\)(?!\])")
HIDDEN = re.compile(r'<(span|div) class="formula" data-tex="([^"]*)"></\1>')

MATHML = "{http://www.w3.org/1998/Math/MathML}"
PRIMES = ("\u2032", "\u2033")
ElementTree.register_namespace("", MATHML[1:-1])


def anchor(number: str) -> str:
    """Name of the place of an equation on its page."""
    return "eq-" + number.replace(".", "-")


def hide_formulas(markdown: str) -> str:
    """Markdown with its formulas in attributes, equations numbered, and references to them as links."""
    pieces = FENCE.split(markdown)
    return "".join(_equation(piece) if k % 2 else _prose(piece) for k, piece in enumerate(pieces))


def show_formulas(html: str) -> str:
    """The formulas of a page as MathML."""
    return HIDDEN.sub(lambda found: mathml(unescape(found[2]), found[1] == "div"), html)


def mathml(tex: str, display: bool) -> str:
    """One formula."""
    from latex2mathml.converter import convert  # by the pages alone, not by the tests

    tree = ElementTree.fromstring(convert(tex, display="block" if display else "inline"))
    for element in list(tree.iter()):
        lower_primes(element)
    return ElementTree.tostring(tree, encoding="unicode")


def lower_primes(element: ElementTree.Element) -> None:
    """Set a prime beside its letter: fonts have it raised already, and raised twice it is too small and too high."""
    if element.tag in (MATHML + "msup", MATHML + "msubsup") and (element[-1].text or "") in PRIMES:
        prime = element[-1]
        prime.tag, prime.attrib = MATHML + "mo", {"lspace": "0", "rspace": "0"}
        element.remove(prime)
        if element.tag == MATHML + "msup":
            element.tag = MATHML + "mrow"
            element.append(prime)
        else:
            base, group = element[0], ElementTree.Element(MATHML + "mrow")
            element.remove(base)
            group.extend([base, prime])
            element.insert(0, group)
            element.tag = MATHML + "msub"


def _prose(markdown: str) -> str:
    markdown = REFERENCE.sub(lambda found: f"[({found[1]})](#{anchor(found[1])})", markdown)
    return INLINE.sub(lambda found: _hidden("span", found[1]), markdown)


def _equation(source: str) -> str:
    tag = TAG.search(source)
    body = _hidden("div", " ".join(TAG.sub("", source).split()))
    if tag is None:
        return f'<div class="equation">{body}</div>\n'
    return f'<div class="equation" id="{anchor(tag[1])}">{body}<a class="number" href="#{anchor(tag[1])}">({tag[1]})</a></div>\n'


def _hidden(element: str, tex: str) -> str:
    return f'<{element} class="formula" data-tex="{escape(tex).replace("|", "&#124;")}"></{element}>'
