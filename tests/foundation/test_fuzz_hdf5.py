"""Spoilt and hostile HDF5 files: a result, or one of the program's own errors; never another one, a crash, a hang or endless memory."""

from __future__ import annotations

from collections import Counter

import pytest

from tests.fuzz.good_files import MOST_MEMORY, batch

pytestmark = pytest.mark.robustness


def judged(lines: list[str], memory: int) -> Counter:
    """How often files were refused and accepted, if nothing else came of any."""
    escaped = [line for line in lines if "-> ESCAPED" in line]
    assert not escaped, "\n".join(escaped[:5])
    assert all("Build it again" in line or "Give a" in line or "Run the scene" in line for line in lines if "FileError" in line)
    assert memory < MOST_MEMORY
    return Counter(line.rpartition(" -> ")[2].split(" ")[0] for line in lines)


@pytest.mark.parametrize(("kind", "least"), [("model", 950), ("results", 750)])
def test_a_spoilt_file_is_refused_by_the_program_itself_or_does_no_harm(tmp_path, kind, least):
    counts = judged(*batch(tmp_path, kind))
    assert sum(counts.values()) >= least
    assert 0 < counts["accepted"] < counts["refused"]


@pytest.mark.parametrize("kind", ["model", "results"])
def test_a_changed_file_whose_checksums_are_all_right_does_no_harm_either(tmp_path, kind):
    """`python -m tests.fuzz.sealed_run COUNT SEED` takes as many as one likes; here are some."""
    counts = judged(*batch(tmp_path, kind, 250, 1))
    assert sum(counts.values()) == 250
    assert 0 < counts["accepted"] < counts["refused"]
