"""Axes of the reduced models: how many modes, how many elements; every choice is preprocessed afresh from the skin's file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from toolkit.analyses.sensitivity.certificate.fresh_models import rebuildable
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.toml_file import read_toml
from toolkit.foundation.processes import is_installed
from toolkit.scene.scene import Scene
from toolkit.studies.tradeoff.setting import Choice

AXES = {
    "modes": "full/32/16/8/4: all coordinates, or so many Craig-Bampton modes; also static, eigenmodes-16",
    "elements": "15/30/60: elements of the skin",
}
MODES = ("full", "32", "16", "8", "4")
KINDS = ("craig-bampton", "eigenmodes")


def choices(scene: Scene, axis: str, given: Sequence[str]) -> list[Choice]:
    """Choices of one of `AXES`; those by default if none are given.

    Raises
    ------
    InputError
        The preprocessing is not installed, no body has a skin file, or a value is invalid.
    """
    skins = [_skin(path) for path in sources(scene, axis).values()]
    return (_modes if axis == "modes" else _elements)(skins, given)


def sources(scene: Scene, axis: str) -> dict[str, Path]:
    """Flexible body -> the skin file that its model is built from; all such bodies follow the axis together."""
    if not is_installed():
        raise InputError(
            f"--axes: {axis} needs the preprocessing, which builds the models. Install it: pip install "
            "'ffrf-toolkit[preprocessing]'; or leave the axis out."
        )
    found = rebuildable(scene)
    if not found:
        raise InputError(
            f"--axes: {axis} needs a flexible body with a skin file (NAME.toml beside its model NAME.h5); this scene has none. Leave "
            "the axis out."
        )
    return found


def _skin(path: Path) -> dict[str, Any]:
    return read_toml(path, "a skin.toml")


def _modes(skins: list[dict[str, Any]], given: Sequence[str]) -> list[Choice]:
    tables = [skin.get("basis", {"kind": "full"}) for skin in skins]
    own = tables[0] if all(table == tables[0] for table in tables) else None
    words = given or [*([] if own is None or _word(own) in MODES else [_word(own)]), *MODES]
    return [_mode(word, own) for word in dict.fromkeys(words)]


def _mode(word: str, own: dict[str, Any] | None) -> Choice:
    mine = own is not None and word == _word(own)
    table = own if mine and own is not None else _basis(word)
    return Choice(word, skin={"basis": table}, own=mine)


def _basis(word: str) -> dict[str, Any]:
    """The table [basis] that a word stands for."""
    kind, _, count = word.rpartition("-")
    if word in ("full", "static"):
        return {"kind": word}
    if not count.isdecimal() or kind not in ("", *KINDS):
        raise InputError(f"--axes: modes={word!r} is invalid; possible: full, static, 16 (Craig-Bampton modes), eigenmodes-16.")
    return {"kind": kind or "craig-bampton", "count": int(count)}


def _word(table: dict[str, Any]) -> str:
    """The word that stands for a table [basis]."""
    kind, count = table.get("kind", "full"), table.get("count")
    if set(table) <= {"kind", "count"}:
        return str(kind) if count is None else str(count) if kind == "craig-bampton" else f"{kind}-{count}"
    return "own"


def _elements(skins: list[dict[str, Any]], given: Sequence[str]) -> list[Choice]:
    counts = [skin["skin"]["elements"] for skin in skins]
    own = counts[0] if len(set(counts)) == 1 else None
    if not given and own is None:
        raise InputError("--axes: the skins have different numbers of elements; say which to try, for example elements=20/40.")
    if wrong := [word for word in given if not word.isdecimal() or int(word) < 2]:
        raise InputError(
            f"--axes: elements={wrong[0]!r} is invalid; give whole numbers from 2 up, for example elements=15/30/60."
        )
    numbers = [int(word) for word in given] if given or own is None else [max(own // 2, 2), own, 2 * own]
    return [Choice(str(n), skin={"skin.elements": n}, own=n == own) for n in dict.fromkeys(numbers)]
