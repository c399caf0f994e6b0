"""Ways to spoil the bytes of any file, binary or text."""

from __future__ import annotations

import re

import numpy as np

TOKENS = [
    b"0", b"-1", b"1", b"2", b"99", b"500000000", b"2147483647", b"2147483648", b"4294967296", b"1000000000000",
    b"9223372036854775807",
    b"-9223372036854775808", b"99999999999999999999", b"1e308", b"-1e308", b"1e-300", b"1e155", b"5e-324", b"nan", b"inf",
    b"-inf", b"1e999",
    b"0x10", b"1d5", b"x", b"", b"\0", b"\xff\xfe", b",", b"*", b"$", b"<", b"&", b"9" * 500, b"1" * 5000, b"\n", b"1.5", b"0 0",
]  # fmt: skip
NUMBER = re.compile(rb"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
WORD = re.compile(rb"[^\s,]+")
BYTES = [0, 1, 9, 10, 13, 32, 48, 57, 127, 128, 255]


def spoilt(content: bytes, other: bytes, rng: np.random.Generator) -> tuple[str, bytes]:
    """The content with one to three mistakes of one sort, and which; `other` is another file of the same kind."""
    name = str(rng.choice(list(MISTAKES)))
    for _ in range(int(rng.integers(1, 4))):
        content = MISTAKES[name](content, other, rng)
    return name, content


def _place(content: bytes, rng: np.random.Generator) -> int:
    """More often at the beginning, where headers are."""
    end = max(1, len(content))
    return int(rng.integers(min(end, 400) if rng.random() < 0.5 else end))


def _bytes(content: bytes, _: bytes, rng: np.random.Generator) -> bytes:
    changed = bytearray(content)
    for _unused in range(int(rng.integers(1, 20)) if content else 0):
        changed[_place(content, rng)] = int(rng.choice(BYTES) if rng.random() < 0.5 else rng.integers(256))
    return bytes(changed)


def _bit(content: bytes, _: bytes, rng: np.random.Generator) -> bytes:
    changed = bytearray(content)
    if content:
        changed[_place(content, rng)] ^= 1 << int(rng.integers(8))
    return bytes(changed)


def _token(content: bytes, _: bytes, rng: np.random.Generator) -> bytes:
    """A number or a word becomes another one."""
    found = list((NUMBER if rng.random() < 0.7 else WORD).finditer(content))
    if not found:
        return content
    one = found[int(rng.integers(min(len(found), 12) if rng.random() < 0.4 else len(found)))]  # declared counts come first
    return content[: one.start()] + TOKENS[int(rng.integers(len(TOKENS)))] + content[one.end() :]


def _scale(content: bytes, _: bytes, rng: np.random.Generator) -> bytes:
    """Every number with a point gets another exponent."""
    power = rng.choice([b"e300", b"e-300", b"e-160", b"e160", b"e20"])
    return re.sub(rb"(\d\.\d*)(?:[eE][-+]?\d+)?", rb"\g<1>" + power, content)


def _cut(content: bytes, _: bytes, rng: np.random.Generator) -> bytes:
    return content[: _place(content, rng)]


def _remove(content: bytes, _: bytes, rng: np.random.Generator) -> bytes:
    start = _place(content, rng)
    return content[:start] + content[start + int(rng.integers(1, 80)) :]


def _insert(content: bytes, _: bytes, rng: np.random.Generator) -> bytes:
    start = _place(content, rng)
    return content[:start] + TOKENS[int(rng.integers(len(TOKENS)))] + content[start:]


def _lines(content: bytes, _: bytes, rng: np.random.Generator) -> bytes:
    """Lines exchanged, doubled or removed."""
    lines = content.split(b"\n")
    i, j = (int(rng.integers(len(lines))) for _unused in range(2))
    what = rng.integers(3)
    if what == 0:
        lines[i], lines[j] = lines[j], lines[i]
    elif what == 1:
        lines[i:i] = [lines[j]] * int(rng.integers(1, 50))
    else:
        del lines[min(i, j) : max(i, j)]
    return b"\n".join(lines)


def _splice(content: bytes, other: bytes, rng: np.random.Generator) -> bytes:
    return content[: _place(content, rng)] + other[_place(other, rng) :]


MISTAKES = {
    "bytes": _bytes, "bit": _bit, "token": _token, "tokens": _token, "scale": _scale, "cut": _cut, "remove": _remove,
    "insert": _insert,
    "lines": _lines, "splice": _splice,
}  # fmt: skip
