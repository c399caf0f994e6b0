"""The house as a picture: rooms as boxes in layers, and the arrows between them that no others imply; made from the code."""

from __future__ import annotations

from html import escape
from itertools import accumulate, pairwise

from docs.generators.house import HALVES, Arrows, about, arrows, imports, modules, ordered

WIDE, HIGH, GAP, LEVEL, EDGE = 112, 26, 12, 58, 10
"""Of a box: width and height; between boxes; between layers; round everything. In pixels."""
_BEND, _SWEEPS = 10, 24
"""Width that a bend of a long arrow takes; rounds of the placement."""
Place = tuple[float, float]


def house() -> Arrows:
    """Rooms of both halves by their dotted names -> the rooms that they import from."""
    found = {f"{half}.{name}": {f"{half}.{other}" for other in used} for half in HALVES for name, used in arrows(half).items()}
    for name, path in modules("preprocessing").items():
        for used in imports(path, typing=False) & modules("toolkit").keys():
            found[_room(name)].add(_room(used))
    return found


def _room(module: str) -> str:
    return ".".join(module.split(".")[:2])


def needed(found: Arrows) -> Arrows:
    """The arrows that do not follow from others: from a to c there is none beside those from a to b and from b to c."""
    below: Arrows = {}
    for name in ordered(found):
        below[name] = found[name].union(*(below[other] for other in found[name]))
    return {name: used - set().union(*(below[other] for other in used)) for name, used in found.items()}


def layers(found: Arrows) -> dict[str, int]:
    """The longest way down from every room: a room stands above all that it imports from."""
    level: dict[str, int] = {}
    for name in ordered(found):
        level[name] = 1 + max((level[other] for other in found[name]), default=-1)
    return level


def ways(found: Arrows) -> dict[tuple[str, str], list[str]]:
    """Arrow -> what it runs through, from top to bottom: both rooms, and a bend in every layer between them."""
    level = layers(found)
    return {
        (name, used): [name, *(f"{name}>{used}@{k}" for k in range(level[name] - 1, level[used], -1)), used]
        for name in found
        for used in sorted(found[name])
    }


def places(found: Arrows) -> dict[str, Place]:
    """Middle of every room and every bend; x to the right, y downwards, the highest layer at 0. Preprocessing stands on the right."""
    level, paths = layers(found), ways(found).values()
    level |= {each: level[path[0]] - k for path in paths for k, each in enumerate(path)}
    beside: dict[str, set[str]] = {each: set() for each in level}
    for path in paths:
        for upper, lower in pairwise(path):
            beside[upper].add(lower)
            beside[lower].add(upper)
    top = max(level.values())
    rows = [sorted((each for each in level if level[each] == top - k), key=_side) for k in range(top + 1)]
    x = {each: 100.0 * k for row in rows for k, each in enumerate(row)}
    for sweep in range(_SWEEPS):
        for row in rows if sweep % 2 else rows[::-1]:
            wanted = {each: sum(x[other] for other in beside[each]) / max(len(beside[each]), 1) for each in row}
            if sweep < _SWEEPS // 2:
                row.sort(key=lambda each: (_side(each)[0], round(wanted[each], 6), each))
            x |= dict(zip(row, _apart([wanted[each] for each in row], [_width(each) for each in row]), strict=True))
    left = min(x[each] - _width(each) / 2 for each in x)
    return {each: (x[each] - left, LEVEL * (top - level[each]) + HIGH / 2) for each in x}


def _side(each: str) -> tuple[bool, str]:
    return each.startswith("preprocessing"), each


def _width(each: str) -> float:
    return (_BEND if "@" in each else WIDE) + GAP


def _apart(wanted: list[float], widths: list[float]) -> list[float]:
    """Places in order that do not overlap and are nearest to the wanted ones in the least squares (pool adjacent violators)."""
    offsets = list(accumulate(((a + b) / 2 for a, b in pairwise(widths)), initial=0.0))
    blocks: list[tuple[float, int]] = []
    for value in (want - offset for want, offset in zip(wanted, offsets, strict=True)):
        blocks.append((value, 1))
        while len(blocks) > 1 and blocks[-2][0] > blocks[-1][0]:
            (a, n), (b, m) = blocks[-2:]
            blocks[-2:] = [((a * n + b * m) / (n + m), n + m)]
    return [value + offset for value, offset in zip((value for value, n in blocks for _ in range(n)), offsets, strict=True)]


def picture() -> str:
    """The picture as an element of a page; every box leads to the page of its room and says what it is for."""
    found = needed(house())
    where = places(found)
    wide = max(x + _width(each) / 2 for each, (x, _) in where.items()) - GAP / 2 + EDGE
    high = max(y for _, y in where.values()) + HIGH / 2 + EDGE
    lines = [_arrow([where[each] for each in path]) for path in ways(found).values()]
    boxes = [_box(name, where[name]) for name in found]
    head = '<defs><marker id="head" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
    defined = f'{head}<path class="head" d="M0,0L8,4L0,8Z"/></marker></defs>'
    size = f'viewBox="{-EDGE:g} {-EDGE:g} {wide + EDGE:.0f} {high + EDGE:.0f}"'
    return f'<div class="house"><svg xmlns="http://www.w3.org/2000/svg" {size}>{defined}{"".join([*lines, *boxes])}</svg></div>'


def _arrow(points: list[Place]) -> str:
    """A line from the lower edge of a box through the bends, upright beside other boxes, to the upper edge of another."""
    (x, y), half = points[0], HIGH / 2
    curve = f"M{x:.1f},{y + half:.1f}"
    for (a, b), (c, d) in pairwise(points):
        middle = (b + d) / 2
        curve += f"V{b + half:.1f}C{a:.1f},{middle:.1f} {c:.1f},{middle:.1f} {c:.1f},{d - half:.1f}"
    return f'<path class="arrow" d="{curve}" marker-end="url(#head)"/>'


def _box(name: str, place: Place) -> str:
    half, room = name.split(".")
    x, y = place
    box = f'<rect x="{x - WIDE / 2:.1f}" y="{y - HIGH / 2:.1f}" width="{WIDE}" height="{HIGH}" rx="4"/>'
    words = f'<text x="{x:.1f}" y="{y:.1f}">{escape(room)}</text><title>{escape(f"{name}: {about(name)}")}</title>'
    return f'<a class="{half}" href="reference/{half}-{room}.html">{box}{words}</a>'
