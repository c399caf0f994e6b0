"""Random bulk files are read as they are meant: places, elements, masses and groups are those of their construction."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from preprocessing.foreign_files.contents import MeshContents
from preprocessing.foreign_files.nastran.bulk_file import read_bulk
from tests.foreign_decks.bulk_decks import Deck, Mass, bulk_deck


def written(deck: Deck, folder: Path) -> Path:
    for name, content in deck.files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    return folder / next(iter(deck.files))


def check(deck: Deck, found: MeshContents) -> None:
    """Everything that the deck says, to the last digits of what turns coordinates."""
    assert sorted(found.labels.tolist()) == sorted(deck.points)
    expected = np.array([deck.points[label] for label in found.labels.tolist()])
    np.testing.assert_allclose(found.points, expected, atol=1e-11 * max(np.abs(expected).max(), 1.0), rtol=0)
    elements = {kind: sorted(map(tuple, found.labels[block].tolist())) for kind, block in found.cells}
    assert elements == {kind: sorted(block) for kind, block in deck.elements.items()}
    groups = {name: {int(k) for _, of in parts for k in found.labels[of].ravel()} for name, parts in found.groups}
    assert set(groups) == set(deck.groups)
    assert {name: nodes for name, nodes in groups.items() if deck.groups[name]} == {k: v for k, v in deck.groups.items() if v}
    assert {each.what for each in found.left_out} == deck.left_out
    check_masses(sorted(deck.masses, key=lambda each: tuple(each.place)), found)


def check_masses(expected: list[Mass], found: MeshContents) -> None:
    masses = sorted(found.masses, key=lambda each: tuple(each.place))
    assert len(masses) == len(expected)
    for one, other in zip(masses, expected, strict=True):
        xx, yy, zz, xy, xz, yz = one.inertia
        assert one.mass == other.mass
        np.testing.assert_allclose(one.place, other.place, atol=1e-9 * max(np.abs(other.place).max(), 1), rtol=0)
        np.testing.assert_allclose([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], other.inertia, atol=1e-12)
        assert set(found.labels[one.carriers].tolist()) == set(other.carriers)
        assert one.rigid == other.rigid


def run(seeds: range, folder: Path) -> None:
    for seed in seeds:
        deck = bulk_deck(seed)
        try:
            check(deck, read_bulk(written(deck, folder / str(seed)), frozenset()))
        except Exception as error:
            raise AssertionError(f"deck of seed {seed}") from error


def test_a_hundred_random_decks_are_read_as_they_are_meant(tmp_path):
    run(range(100), tmp_path)


@pytest.mark.robustness
def test_a_thousand_more_are_too(tmp_path):
    run(range(100, 1100), tmp_path)


def test_the_generator_writes_every_way_of_writing(tmp_path):
    """Otherwise the decks would show nothing."""
    decks = [bulk_deck(seed) for seed in range(100)]
    text = b"".join(content for deck in decks for content in deck.files.values())
    for piece in (
        b"GRID*",
        b"GRID,",
        b"GRID\t",
        b"grid",
        b"GRDSET",
        b"CORD1",
        b"CORD2",
        b"RBE3",
        b"include",
        b"+FARAWAY",
        b"THRU",
        b"\r\n",
    ):
        assert piece in text
    kinds = {kind for deck in decks for kind in deck.elements}
    assert len(kinds) == 10
    assert any(mass.inertia.any() and len(mass.carriers) > 1 for deck in decks for mass in deck.masses)
