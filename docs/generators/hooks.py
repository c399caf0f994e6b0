"""What MkDocs calls while it builds: generated pages, generated tables and pictures, formulas."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from mkdocs.structure.files import File

from docs.generators.formats import for_the_site
from docs.generators.formulas import hide_formulas, show_formulas
from docs.generators.house_picture import picture
from docs.generators.public_names import table
from docs.generators.rooms import navigation, overview, page, rooms
from docs.generators.worked_pages import entries, worked_pages

_RUNS = TemporaryDirectory()
"""Where tutorials and models leave their pictures until the site is built."""


def on_config(config: Any) -> Any:
    """Put the pages of the tutorials and of the reference into the navigation."""
    for entry in config.nav:
        if "Tutorials" in entry:
            entry["Tutorials"] = [*entries()]
        if "Reference" in entry:
            entry["Reference"] = [{"Names and rooms": "reference.md"}, *navigation()]
    return config


def on_files(files: Any, config: Any) -> Any:
    """Add the pages that are run, those of the reference, and the font of the formulas, which comes with a package."""
    for room in rooms():
        files.append(File.generated(config, room.page, content=page(room)))
    generated = worked_pages(Path(_RUNS.name))
    for place, text in generated.pages.items():
        files.append(File.generated(config, place, content=text))
    for place, file in generated.pictures.items():
        files.append(File.generated(config, place, abs_src_path=str(file)))
    fonts = Path(str(find_spec("ziamath").origin)).parent / "fonts"  # type: ignore[union-attr]
    files.append(File.generated(config, "STIXTwoMath-Regular.ttf", abs_src_path=str(fonts / "STIXTwoMath-Regular.ttf")))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Put generated tables in their places, and formulas out of Markdown's reach; leave out columns that would stand empty."""
    if page.parent is None:
        page.meta["hide"] = ["navigation"]  # its only entry would be the page itself
    elif page.file.src_uri.startswith("tutorials/"):
        page.meta["hide"] = ["toc"]  # they have no headings
    written = {
        "formats.md": for_the_site,
        "house.md": lambda text: hide_formulas(text.replace("<!-- house -->", picture())),
        "theory.md": hide_formulas,
        "reference.md": lambda text: text.replace("<!-- names -->", table()).replace("<!-- rooms -->", overview()),
    }
    return written.get(page.file.src_uri, str)(markdown)


def on_page_content(html: str, **_: Any) -> str:
    """Draw the formulas."""
    return show_formulas(html)
