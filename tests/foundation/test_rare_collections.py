"""Python's looks for garbage: rare while work is done, none when a process ends."""

from __future__ import annotations

import gc

from toolkit.foundation.rare_collections import last_work, rare_collections


def test_looks_are_rare_in_the_block_alone():
    before = gc.get_threshold()
    with rare_collections():
        assert gc.get_threshold()[0] > before[0]
    assert gc.get_threshold() == before


def test_what_the_last_work_leaves_is_not_looked_through():
    before = gc.get_freeze_count()  # what was there before all tests
    with last_work():
        left = [[] for _ in range(100)]
    assert gc.get_freeze_count() > before + len(left)
