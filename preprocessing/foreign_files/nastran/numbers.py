"""Numbers in the fields of cards, many fields at once: each is a whole number, a real number or blank, or it is wrong.

Nastran writes 1.5-7 for 1.5e-7, and D for E. Every field goes through the same states, character by character; what leads to no state is
wrong, so that no text is taken for a number by chance.
"""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np

BLANK, DIGIT, SIGN, POINT, LETTER, OTHER = range(6)
"""Classes of characters."""
START, SIGNED, WHOLE, POINT_FIRST, FRACTION, POWER_LETTER, POWER_SIGN, POWER, WHOLE_END, REAL_END, WRONG = range(11)
"""States: what stands to the left."""
STEPS = {
    START: {BLANK: START, DIGIT: WHOLE, SIGN: SIGNED, POINT: POINT_FIRST},
    SIGNED: {DIGIT: WHOLE, POINT: POINT_FIRST},
    WHOLE: {BLANK: WHOLE_END, DIGIT: WHOLE, POINT: FRACTION, LETTER: POWER_LETTER},
    POINT_FIRST: {DIGIT: FRACTION},
    FRACTION: {BLANK: REAL_END, DIGIT: FRACTION, SIGN: POWER_SIGN, LETTER: POWER_LETTER},
    POWER_LETTER: {DIGIT: POWER, SIGN: POWER_SIGN},
    POWER_SIGN: {DIGIT: POWER},
    POWER: {BLANK: REAL_END, DIGIT: POWER},
    WHOLE_END: {BLANK: WHOLE_END},
    REAL_END: {BLANK: REAL_END},
}
LONGEST_WHOLE = 18
"""Digits of the largest whole numbers that are sure to fit into 64 bits."""
EXACT_POWER, EXACT_WHOLE = 22, 2**53
"""Powers of ten and whole numbers up to these are exact, so that one product or quotient of them is the nearest number."""
TENS = np.array([float(10**k) for k in range(EXACT_POWER + 1)])


def _classes() -> np.ndarray:
    found = np.full(256, OTHER, np.uint8)
    for characters, of in ((b" ", BLANK), (b"0123456789", DIGIT), (b"+-", SIGN), (b".", POINT), (b"eEdD", LETTER)):
        found[list(characters)] = of
    return found


def _steps() -> np.ndarray:
    found = np.full((WRONG + 1, OTHER + 1), WRONG, np.uint8)
    for state, onward in STEPS.items():
        for character, following in onward.items():
            found[state, character] = following
    return found


CLASSES, NEXT = _classes(), _steps()


class Numbers(NamedTuple):
    """Values of fields, all in one shape."""

    values: np.ndarray  # 0 where there is none
    blank: np.ndarray  # whether the field is
    wrong: np.ndarray  # whether it is neither blank nor such a number


class _Scan(NamedTuple):
    state: np.ndarray
    digits: np.ndarray  # all digits ahead of the exponent, as one whole number
    significant: np.ndarray  # how many there are, zeros at the front not among them
    power: np.ndarray  # of ten, by which they count
    negative: np.ndarray


def whole_numbers(text: np.ndarray) -> Numbers:
    """Values (...) of fields (..., characters)."""
    scan = _scan(text)
    good = np.isin(scan.state, (WHOLE, WHOLE_END)) & (scan.significant <= LONGEST_WHOLE)
    blank = scan.state == START
    return Numbers(np.where(good, np.where(scan.negative, -scan.digits, scan.digits), 0), blank, ~good & ~blank)


def real_numbers(text: np.ndarray) -> Numbers:
    """Values (...) of fields (..., characters); a whole number is a real one, too."""
    scan = _scan(text)
    good, blank = np.isin(scan.state, (WHOLE, WHOLE_END, FRACTION, POWER, REAL_END)), scan.state == START
    exact = good & (scan.significant <= LONGEST_WHOLE) & (scan.digits <= EXACT_WHOLE) & (np.abs(scan.power) <= EXACT_POWER)
    digits, ten = np.where(exact, scan.digits, 0).astype(float), TENS[np.where(exact, np.abs(scan.power), 0)]
    values = np.where(scan.power < 0, digits / ten, digits * ten)
    values = np.where(scan.negative & exact, -values, values)
    for place in zip(*np.nonzero(good & ~exact), strict=True):
        values[place] = one_number(text[place].tobytes().decode("ascii"))
    finite = np.isfinite(values)
    return Numbers(np.where(finite, values, 0), blank, (~good & ~blank) | ~finite)


def one_number(text: str) -> float:
    """The value of the text of a real number, whatever its size."""
    return float(re.sub(r"(?<=[0-9.])([+-])", r"E\1", text.upper().strip().replace("D", "E")))


def _scan(text: np.ndarray) -> _Scan:
    """Go through all fields at once, from left to right."""
    shape = text.shape[:-1]
    state, negative, down = np.zeros(shape, np.uint8), np.zeros(shape, bool), np.zeros(shape, bool)
    digits, significant, places, power = (np.zeros(shape, np.int64) for _ in range(4))
    for character in np.ascontiguousarray(np.moveaxis(text, -1, 0)):
        kind = CLASSES[character]
        state = NEXT[state, kind]
        number, value, minus = kind == DIGIT, character - np.uint8(ord("0")), character == ord("-")
        ahead, behind = number & (state <= FRACTION), number & (state == POWER)
        digits = np.where(ahead, 10 * digits + value, digits)
        significant += ahead & ((significant > 0) | (value > 0))
        places += ahead & (state == FRACTION)
        negative |= minus & (state == SIGNED)
        if behind.any():
            power = np.where(behind, np.minimum(10 * power + value, 100_000), power)
        down |= minus & (state == POWER_SIGN)
    return _Scan(state, digits, significant, np.where(down, -power, power) - places, negative)
