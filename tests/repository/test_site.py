"""Pages of the site that are run: how-to pages work as they stand, and scripts are shown with what they print and draw."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import ffrf
from docs.generators.cells import ROOT, fenced, run, split
from docs.generators.public_names import table
from docs.generators.worked_pages import model_names, tutorial_names

SCRIPT = '''"""What it is about."""

# %% [markdown]
# First some words,
# then a picture.

# %%
from pathlib import Path
from tempfile import mkdtemp
from matplotlib.figure import Figure
Figure().savefig("picture.png")
kept = 2
print("drawn beside", Path(__file__).name, Path(mkdtemp()) / "more")

# %%
print(kept + 1)
'''


def test_a_script_is_split_into_words_and_code():
    assert [kind for kind, _ in split(SCRIPT)] == ["words", "words", "code", "code"]
    assert [text for kind, text in split(SCRIPT) if kind == "words"] == [
        "What it is about.",
        "First some words,\nthen a picture.",
    ]


def test_cells_show_what_each_prints_and_draws_and_share_their_names(tmp_path):
    first, second = run([text for kind, text in split(SCRIPT) if kind == "code"], tmp_path, Path("script.py"))
    assert (first.output, [picture.name for picture in first.pictures]) == ("drawn beside script.py more\n", ["picture.png"])
    assert (second.output, second.pictures) == ("3\n", ())
    assert fenced(second.output) == "```\n3\n```"
    assert fenced(" \n") == ""


def test_a_script_that_fails_fails_the_site(tmp_path):
    with pytest.raises(RuntimeError, match="ZeroDivisionError"):
        run(["1 / 0"], tmp_path)


def test_no_tutorial_and_no_model_is_left_out_of_the_site():
    assert {name for name, _ in tutorial_names()} == {path.stem for path in (ROOT / "tutorials").glob("*.py")}
    assert {name for name, *_ in model_names()} == {path.parent.name for path in (ROOT / "models").glob("*/scene.toml")}


def test_the_reference_begins_with_every_name_of_the_door():
    rows = re.findall(r"^\| \[`(\w+)`\][\[(].*?[\])] \| (.+) \|$", table(), re.MULTILINE)
    assert sorted(name for name, about in rows if about) == sorted(ffrf.__all__)
    assert "<!-- names -->" in (ROOT / "docs" / "reference.md").read_text(encoding="utf-8").partition("\n## ")[0]


@pytest.mark.parametrize("page", ["how-to.md", "index.md"])
def test_the_code_of_a_page_runs_from_the_folder_of_the_project(page, tmp_path):
    code = re.findall(r"^```python\n(.*?)^```", (ROOT / "docs" / page).read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    shown = run([f"import os; os.chdir({str(ROOT)!r})", *code], tmp_path)
    assert any("Trusted" in each.output or "leaves the range" in each.output for each in shown)
