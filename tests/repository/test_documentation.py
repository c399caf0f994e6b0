"""The documentation, without building it: what it links to exists, and what exists is in it.

`make docs` builds it, with warnings as errors.
"""

from __future__ import annotations

import ast
import builtins
import re
from collections.abc import Iterator
from importlib import import_module
from itertools import combinations, pairwise
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from docs.generators import doubts
from docs.generators.comments import meanings, trailing_comment
from docs.generators.formats import PAGE, PLACE, TABLES, fill, for_the_site, kinds
from docs.generators.formulas import FENCE, REFERENCE, TAG, hide_formulas
from docs.generators.house import about, modules, ordered, tree
from docs.generators.house_picture import WIDE, house, layers, needed, picture, places, ways
from docs.generators.rooms import page, rooms
from docs.generators.worked_pages import GALLERY
from toolkit.analyses.sensitivity.preparation import prepare, solve
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.verdict import REGISTRY, codes
from toolkit.responses.stress import design_rates

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(path.name for path in DOCS.glob("*.md"))
THEORY = (DOCS / "theory.md").read_text(encoding="utf-8")
FORMATS = PAGE.read_text(encoding="utf-8")
TARGET = re.compile(r"\]\[((?:toolkit|preprocessing)[\w.]*)\]")
MODULES = [*modules("toolkit"), *modules("preprocessing")]


BANNED = {
    "cannot be meant": "is invalid",
    "came from nowhere": "gained",
    "as far as the steps are concerned": "estimated time-step error",
    "What helps:": "Fix:",
    "the price of this check": "what the check cost",
    "was interrupted goes on": "interrupted ... resume",
    "brings to life": "what changes",
    "into so many parts": "the number of parts",
}
"""Phrase that a stranger would not look for -> what is written instead."""
POINTING = {
    "As",
    "At",
    "By",
    "For",
    "From",
    "In",
    "It",
    "Its",
    "Of",
    "On",
    "That",
    "Their",
    "These",
    "Those",
    "To",
    "Whose",
    "With",
}
"""First words of docstrings that point at a class or a folder around them instead of saying what something is."""
TREES = {name: tree(path) for half in ("toolkit", "preprocessing") for name, path in modules(half).items()}
"""Syntax of every module by its dotted name."""


def find(name: str) -> Any:
    """The object of a dotted name: in the longest part of it that is a module."""
    parts = name.split(".")
    depth = max(k for k in range(1, len(parts) + 1) if ".".join(parts[:k]) in {*MODULES, "toolkit", "preprocessing"})
    found: Any = import_module(".".join(parts[:depth]))
    for part in parts[depth:]:
        found = getattr(found, part)
    return found


@pytest.mark.parametrize("name", PAGES)
def test_every_function_that_a_page_links_to_exists(name):
    for target in TARGET.findall((DOCS / name).read_text(encoding="utf-8")):
        assert find(target) is not None


def test_every_equation_of_the_theory_is_numbered_in_order_and_names_its_functions_and_the_paper():
    numbers = []
    for equation in FENCE.finditer(THEORY):
        number = TAG.search(equation[1])
        assert number, f"this equation has no number: {equation[1]}"
        numbers.append(tuple(map(int, number[1].split("."))))
        below = THEORY[equation.end() :].lstrip().split("\n\n")[0]
        assert below.startswith("> "), f"equation {number[1]} does not say what implements it"
        assert TARGET.search(below), f"equation {number[1]} links to no function"
        assert re.match(r"> (Paper eqs?\. \d|Own form|The paper)", below), (
            f"equation {number[1]} does not say where the paper has it"
        )
    assert numbers
    for (chapter, number), following in pairwise(numbers):
        assert following in ((chapter, number + 1), (chapter + 1, 1))


def test_every_equation_that_the_theory_refers_to_is_there():
    anchors = set(re.findall(r'id="(eq-[\d-]+)"', hide_formulas(THEORY)))
    wanted = REFERENCE.findall(FENCE.sub("", THEORY))
    assert wanted
    assert {"eq-" + number.replace(".", "-") for number in wanted} <= anchors


def test_every_page_of_the_navigation_exists_and_no_page_is_left_out():
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8").split("\nnav:\n")[1].split("\n\n")[0]
    assert sorted({*re.findall(r"- [\w ]+: (\S+\.md)", navigation)} - {GALLERY}) == PAGES


def test_every_file_that_the_settings_name_exists():
    settings = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    for name in re.findall(r"- (docs/\S+\.py)", settings):
        assert (ROOT / name).is_file()


def test_every_module_stands_in_the_reference_once():
    listed = [name for room in rooms() for name in room.modules]
    assert sorted(listed) == sorted(MODULES)
    assert sorted(re.findall(r"^::: (\S+)$", "\n".join(map(page, rooms())), re.MULTILINE)) == sorted(MODULES)
    assert len({room.page for room in rooms()}) == len(rooms())


def declared_kinds() -> set[str]:
    """Values of `kind = "..."` of classes, and of `type: Literal["..."]` of curves, as they stand in the source."""
    found = set()
    for name, module in TREES.items():
        for node in ast.walk(module) if name.startswith("toolkit") else ():
            for item in node.body if isinstance(node, ast.ClassDef) else ():
                target = item.targets[0] if isinstance(item, ast.Assign) else getattr(item, "target", None)
                if isinstance(target, ast.Name) and target.id in ("kind", "type") and isinstance(item.value, ast.Constant):
                    found.add(item.value.value)
    return found - {""}


def test_every_kind_and_every_key_of_it_is_in_the_page_on_file_formats():
    documented = {(group, name) for group, found in kinds().items() for name in found}
    assert {name for _, name in documented} == declared_kinds()
    for group, name in documented:
        section = FORMATS.split(f'### <a id="{group}-{name}"></a>{name}\n')[1].split("\n##")[0]
        places = kinds()[group][name]
        for place, key in [(place, key) for place, kind in places.items() for key in set(kind.model_fields) - {"type"}]:
            others = tuple(f"{other}: " for other in places if other != place)
            rows = [line for line in section.splitlines() if line.startswith(f"| `{key}` |")]
            (row,) = [row for row in rows if not row.split(" | ")[-1].startswith(others)]
            assert row.removesuffix(f"{place}:  |").rstrip(" |").count("|") == 4, (
                f"{group}.{name}.{key} has no meaning: state it in the docstring's Attributes"
            )


def test_the_page_on_file_formats_asks_for_every_table_and_for_no_other():
    assert sorted(PLACE.findall(FORMATS)) == sorted(TABLES)


def test_the_page_on_file_formats_has_the_tables_of_the_classes_as_they_are():
    assert fill(FORMATS) == FORMATS, "run: python -m docs.generators.formats"


def test_the_page_on_file_formats_links_to_the_reference_on_the_site():
    site = for_the_site(FORMATS)
    assert "### revolute { #joints-revolute }\n" in site
    assert "In the reference: [`Revolute`][toolkit.components.joints.revolute.Revolute]." in site
    assert "<a id" not in site


def test_every_code_that_a_caution_has_in_the_sources_is_registered_and_no_other():
    said = {code for code, _ in doubts.literal_codes()}
    assert sorted(said - set(codes())) == [], f"add a line to {REGISTRY.name}, and run: python -m docs.generators.doubts"
    assert sorted(set(codes()) - said) == [], f"no check has these codes any more: take their lines out of {REGISTRY.name}"


def test_codes_that_are_no_literals_are_those_of_other_cautions_or_begin_like_one_that_is():
    for code in doubts.other_codes():
        begins = code.values[0].value if isinstance(code, ast.JoinedStr) else None
        assert re.fullmatch(r"\w+\.code|each\['code'\]", ast.unparse(code)) or any(each.startswith(begins) for each in codes())


def test_every_code_has_a_line_of_sentences_in_the_order_of_the_alphabet():
    assert [*codes()] == sorted(codes())
    for code, each in codes().items():
        assert each.means.endswith("."), code
        assert each.remedy.endswith("."), code
        assert each.limit, code


def test_the_page_of_doubts_is_the_registry_as_it_is():
    page = doubts.PAGE.read_text(encoding="utf-8")
    assert doubts.fill(page) == page, "run: python -m docs.generators.doubts"
    assert re.findall(r'^\| <a id="([\w-]+)"></a>', page, re.MULTILINE) == [*codes()]


def test_every_table_that_a_table_points_to_has_its_section():
    for section in re.findall(r"\]\(#([\w-]+)\)", FORMATS):
        assert f'<a id="{section}"></a>' in FORMATS


def test_the_page_on_file_formats_says_what_numbers_measure_as_the_program_reads_it():
    assert "| `velocity` | [number, number, number]: length/time, length/time, angle/time |" in FORMATS
    assert "| `inertia` | number &gt; 0: mass length^2 | required |" in FORMATS


def test_the_meaning_of_a_key_is_what_the_docstring_says():
    assert meanings(RunOptions)["rho_inf"].startswith("Spectral radius")


@pytest.mark.parametrize(
    ("source", "comment"),
    [
        ("q: float  # (n_t,)", "(n_t,)"),
        ("q: str = '# no comment'", ""),
        ("q = f(\n    1,  # one\n    2,\n)  # fmt: skip", ""),
        ("q: float", ""),
    ],
)
def test_a_comment_behind_a_field_is_found_unless_it_is_for_a_tool(source, comment):
    assert trailing_comment(source) == comment


def test_the_picture_of_the_house_has_every_room_and_its_arrows_lead_down_past_all_boxes():
    found = needed(house())
    where, drawing = places(found), ElementTree.fromstring(picture())
    boxes = {element.find("{*}title").text: element for element in drawing.iter("{http://www.w3.org/2000/svg}a")}
    assert sorted(boxes) == sorted(f"{name}: {about(name)}" for name in found)
    assert {element.get("href") for element in boxes.values()} == {room.page.replace(".md", ".html") for room in rooms()}
    assert len(drawing.findall(".//{*}path[@class='arrow']")) == sum(map(len, found.values()))
    for (one, (x, y)), (other, (a, b)) in combinations(where.items(), 2):
        wide = sum((WIDE if name in found else 0) / 2 for name in (one, other))
        assert y != b or abs(x - a) > wide, f"{one} stands on {other}"
    for path in ways(found).values():
        assert all(where[upper][1] < where[lower][1] for upper, lower in pairwise(path))


def test_arrows_that_are_left_out_follow_from_others():
    every, few = house(), needed(house())
    assert sum(map(len, few.values())) < sum(map(len, every.values())) / 3
    reached: dict[str, set[str]] = {}
    for name in ordered(few):
        reached[name] = few[name].union(*(reached[other] for other in few[name]))
    assert all(every[name] <= reached[name] for name in every)
    assert needed({"a": {"b", "c"}, "b": {"c"}, "c": set()}) == {"a": {"b"}, "b": {"c"}, "c": set()}
    assert layers({"a": {"b", "c"}, "b": {"c"}, "c": set()}) == {"a": 2, "b": 1, "c": 0}


def test_the_way_of_a_number_tells_the_numbers_of_the_code():
    text = " ".join((DOCS / "house.md").read_text(encoding="utf-8").split())
    scene = read_scene(ROOT / "models" / "morphing_wing" / "scene.toml")
    system = prepare(scene, ["t_w"])
    (variable,) = system.design
    assert (scene.design["t_w"], variable.path, variable.value) == ("bodies.skin.thickness", "bodies.skin.thickness", 1.5)
    plan, solution = system.plan, solve(system, "transient")
    assert (
        f"{plan.n_q} coordinates $q$, {plan.n - plan.n_q} multipliers, so {plan.n} unknowns, {len(solution.times)} times" in text
    )
    entries = {len(getattr(system.values.constant[1], name)) for name in ("mass", "damping", "stiffness")}
    assert entries == {len(plan.constant.design_stiffness.value)} == {792}
    assert text.count("792") == 2
    assert f"Only {len(np.unique(plan.touched_row))} of the {plan.n} equations" in text
    assert f"is {solution.dq.shape} in the end" in text
    response = scene.responses["max_stress"]
    partials = response.partials(solution)
    assert f"the derivative by every coordinate at every time, {partials.q.shape}" in text
    assert f"{partials.design[0]:.4f} MPa/mm, from {len(design_rates(solution, 'skin', 'stress_operator').value)} entries" in text
    through = np.einsum("ti,tix->x", partials.q, solution.dq)[0]
    assert f"{through:.4f} MPa/mm, to that" in text
    assert f"with its unit: {response.gradient(solution)[0]:.6g} MPa / mm." in text


SECTIONS = ("Parameters", "Returns", "Yields", "Raises", "Attributes", "Notes", "Examples", "See Also")


def docstrings(*kinds: type[ast.AST]) -> Iterator[tuple[str, list[str]]]:
    """Where every docstring stands, and its lines."""
    for name, module in TREES.items():
        for node in ast.walk(module):
            if isinstance(node, kinds or (ast.Module, ast.ClassDef, ast.FunctionDef)):
                yield f"{name}:{getattr(node, 'name', '')}", (ast.get_docstring(node) or "").splitlines()


def test_sections_of_docstrings_are_underlined_as_numpydoc_wants():
    for place, lines in docstrings():
        for k, line in enumerate(lines):
            if line in SECTIONS:
                assert lines[k + 1] == "-" * len(line), place
                assert lines[k - 1] == "", place
                assert lines[k + 2].strip(), place


def test_every_formula_of_the_pages_is_set():
    """A formula in the text stands in one line of the file: of one that is broken the page would show the source."""
    for file in (ROOT / "docs").glob("*.md"):
        hidden = re.sub(
            r"^```.*?^```$|`[^`\n]*`", "", hide_formulas(file.read_text(encoding="utf-8")), flags=re.MULTILINE | re.DOTALL
        )
        assert "$" not in hidden.replace(r"\$", ""), file.name


def test_formulas_in_rows_are_indented_so_that_they_stay_in_rows():
    for place, lines in docstrings():  # what is common to all lines does not count as indentation
        assert [line for line in lines if re.search(r"^\S.*\S {3,}\S", line)] == [], place


DEFINED = {node.name for tree in TREES.values() for node in tree.body if isinstance(node, ast.ClassDef)}
ERRORS = {name for name in DEFINED | set(vars(builtins)) if name.endswith("Error")}


def test_every_error_that_a_docstring_announces_exists():
    for place, lines in docstrings(ast.FunctionDef):
        announced = re.search(r"Raises\n-+\n(.*?)(?:\n\n|\Z)", "\n".join(lines), re.DOTALL)
        told = announced[1].splitlines() if announced else []
        assert {error.strip() for line in told if not line.startswith(" ") for error in line.split(",")} <= ERRORS, place


def test_no_text_has_a_phrase_that_nobody_would_look_for():
    folders = (
        ("ffrf", "*.py"),
        ("toolkit", "*.py"),
        ("preprocessing", "*.py"),
        ("toolkit", "*.toml"),
        ("docs", "*.md"),
        ("tutorials", "*.py"),
    )
    files = [path for folder, pattern in folders for path in (ROOT / folder).rglob(pattern)] + [ROOT / "README.md"]
    found = [
        f"{path.relative_to(ROOT)}: {phrase!r}, write {instead!r}"
        for path in files
        for phrase, instead in BANNED.items()
        if phrase in path.read_text(encoding="utf-8")
    ]
    assert len(files) > 500
    assert found == []


def test_the_first_line_of_every_docstring_can_be_read_alone():
    found = [
        f"{name}.{node.name}: {text.splitlines()[0]}"
        for name, module in TREES.items()
        for node in ast.walk(module)
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and (text := ast.get_docstring(node))
        if text.split()[0].rstrip(",") in POINTING
    ]
    assert found == []
