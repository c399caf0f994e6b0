"""Pages of the site that are run while it is built: every tutorial with its output, and the gallery of all models."""

from __future__ import annotations

import re
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from shutil import copyfile
from typing import NamedTuple

from docs.generators.cells import ROOT, fenced, run, split

TUTORIALS, MODELS = ROOT / "tutorials", ROOT / "models"
GALLERY = "gallery.md"
_WORKERS = 2
"""Tutorials or models that run at once."""
_GALLERY = """import ffrf

scene = ffrf.read_scene("models/{name}/scene.toml")
run = ffrf.compile(scene).simulate()
run.render("{name}", width=1200)
print(run)"""
_HEAD = """# Gallery

Every model that comes with the project, with the lines that make its pictures: these and others are then in the folder that `render` names.
"""


class Generated(NamedTuple):
    """Texts of pages and places of pictures, by their paths in the site."""

    pages: dict[str, str]
    pictures: dict[str, Path]


def tutorial_names() -> list[tuple[str, str]]:
    """(name, what it is about) of every tutorial, in the order of their index."""
    listed = (TUTORIALS / "README.md").read_text(encoding="utf-8")
    return re.findall(r"^\d+\. \[`(\w+)\.py`\]\(\w+\.py\): (.*?)\.?(?: \(needs [^)]*\)\.?)?$", listed, re.MULTILINE)


def model_names() -> list[tuple[str, str, str]]:
    """(folder, what it is, what it is checked against) of every model, as their index has them."""
    listed = (MODELS / "README.md").read_text(encoding="utf-8")
    return re.findall(r"^\| \[`(\w+)`\]\([^)]*\) \| (.*?) \| (.*?) \|$", listed, re.MULTILINE)


def worked_pages(folder: Path) -> Generated:
    """Run everything; `folder` keeps the pictures until the site is built."""
    with ThreadPoolExecutor(_WORKERS) as pool:
        tutorials = list(pool.map(lambda each: _tutorial(each[0], folder), tutorial_names()))
        models = list(pool.map(lambda each: _model(*each, folder), model_names()))
    pages = {f"tutorials/{name}.md": text for (name, _), (text, _) in zip(tutorial_names(), tutorials, strict=True)}
    pages[GALLERY] = "\n".join([_HEAD, *(text for text, _ in models)])
    return Generated(pages, {place: file for _, pictures in (*tutorials, *models) for place, file in pictures.items()})


def _tutorial(name: str, folder: Path) -> tuple[str, dict[str, Path]]:
    file, own = TUTORIALS / f"{name}.py", folder / "tutorials" / name
    own.mkdir(parents=True)
    cells = split(file.read_text(encoding="utf-8"))
    shown = iter(run([text for kind, text in cells if kind == "code"], own, file))
    title, pictures, lines = name.replace("_", " ").capitalize().replace("python", "Python"), {}, []
    for kind, text in cells:
        if kind == "words":
            lines.append(text)
            continue
        found = next(shown)
        lines += [fenced(text, "python"), fenced(found.output)]
        for picture in _telling(found.pictures):
            place = f"tutorials/{name}-{picture.stem}.png"
            pictures[place] = _kept(picture, folder / place)
            lines.append(f"![{picture.stem}]({name}-{picture.stem}.png)")
    return f"# {title}\n\n" + "\n\n".join(line for line in lines if line) + "\n", pictures


def _telling(pictures: tuple[Path, ...]) -> list[Path]:
    """Pictures without those of single instants that an overview among them shows too."""
    overview = any(picture.stem == "overview" for picture in pictures)
    return [picture for picture in pictures if not (overview and picture.stem.startswith("step-"))]


def _model(name: str, about: str, judge: str, folder: Path) -> tuple[str, dict[str, Path]]:
    own = folder / "gallery" / name
    own.mkdir(parents=True)
    code = _GALLERY.format(name=name)
    (shown,) = run([code.replace('"models/', f'"{ROOT}/models/')], own)
    drawn = {picture.stem: picture for picture in shown.pictures}
    wanted = [stem for stem in ("overview", "curves") if stem in drawn] or sorted(drawn)[:1]
    pictures = {f"gallery/{name}-{stem}.png": drawn[stem] for stem in wanted}
    images = "\n\n".join(f"![{about}, {stem}](gallery/{name}-{stem}.png)" for stem in wanted)
    said = f'??? note "What it prints"\n\n{_indented(fenced(shown.output))}'
    text = f"## {name.replace('_', ' ').capitalize()}\n\n{about[0].upper()}{about[1:]}. Checked against: {judge}.\n\n{images}\n\n"
    return f"{text}{fenced(code, 'python')}\n\n{said}\n", pictures


def _indented(text: str) -> str:
    return "\n".join(f"    {line}" if line else "" for line in text.splitlines())


def _kept(picture: Path, place: Path) -> Path:
    """The picture at another place, which no later cell writes to."""
    place.parent.mkdir(parents=True, exist_ok=True)
    copyfile(picture, place)
    return place


def entries() -> Iterator[dict[str, str]]:
    """The tutorials in the navigation."""
    return ({about[0].upper() + about[1:]: f"tutorials/{name}.md"} for name, about in tutorial_names())
