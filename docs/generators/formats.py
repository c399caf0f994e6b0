"""Tables of the file formats, made from the classes that read the files: a key that exists is documented, and no other.

`python -m docs.generators.formats` writes them into docs/formats.md, so that the page is read in the repository as it is.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from pydantic import BaseModel

from docs.generators.comments import words
from docs.generators.file_layout import layout
from docs.generators.key_tables import key_table
from preprocessing.builders.body_file import (
    BodyFile,
    MatricesTable,
    MeshTable,
    Region,
    ShapeVariable,
    SolidMaterial,
    SolidSection,
    StressTable,
    TiedRegion,
)
from preprocessing.builders.frame_file import FrameFile
from preprocessing.builders.frame_tables import BeamTable, FrameMaterial, FramePoint, FrameSection, PolarNode
from preprocessing.builders.skin_file import (
    AirfoilTable,
    ContourPoint,
    ElementGroup,
    Material,
    Place,
    SectionTable,
    ShapeMode,
    SkinCut,
    SkinFile,
)
from preprocessing.builders.tables import BasisTable, Damping
from toolkit.components.curves.catalogue import Curve
from toolkit.description.design import BodyPoint, CommonVariable
from toolkit.description.run_options import Baumgarte, RunOptions
from toolkit.foundation.files.safe_files import write_whole
from toolkit.responses.catalogue import Response
from toolkit.scene.kinds import kinds_of
from toolkit.scene.scene import Scene
from toolkit.studies.distributions import Correlation, Uncertain, Uncertainty
from toolkit.studies.study_file import Limit, Objective, Search, Study, StudyVariable, Sweep

PAGE = Path(__file__).parents[1] / "formats.md"
PLACE = re.compile(r"^<!-- table: ([\w-]+) -->\n(?:.*?^<!-- end of table -->\n)?", re.MULTILINE | re.DOTALL)
"""Where the page wants a table, with the table if it is there."""
ANCHOR, CLASS = (
    re.compile(r"^(#+) <a id=\"([\w-]+)\"></a>(.*)$", re.MULTILINE),
    re.compile(r"^Class `(([\w.]+)\.(\w+))`\.$", re.MULTILINE),
)
"""A heading with the name that links use; what class a table is made from."""


def fill(markdown: str) -> str:
    """The page with its tables as they are now."""
    return PLACE.sub(lambda found: f"<!-- table: {found[1]} -->\n\n{TABLES[found[1]]()}\n\n<!-- end of table -->\n", markdown)


def for_the_site(markdown: str) -> str:
    """The page with headings and links to the reference as MkDocs writes them."""
    return CLASS.sub(r"In the reference: [`\3`][\1].", ANCHOR.sub(r"\1 \3 { #\2 }", markdown))


def kinds() -> dict[str, dict[str, dict[str, type[BaseModel]]]]:
    """All kinds that the toolkit knows by a `type` in a scene file: group -> name, in order -> where it is there -> class."""
    plane, space = kinds_of(2), kinds_of(3)
    groups: dict[str, dict[str, Mapping[str, type]]] = {
        **{group: {"In the plane": plane[group], "In space": space[group]} for group in plane},
        "responses": {"": Response.kinds},
        "curves": {"": Curve.kinds},
    }
    return {
        group: {
            name: {where: found[name] for where, found in places.items() if _brought(found.get(name))}
            for name in sorted({name for found in places.values() for name in found if _brought(found[name])})
        }
        for group, places in groups.items()
    }


def _brought(kind: type | None) -> bool:
    """Whether the toolkit brings a class, and no file of a user."""
    return kind is not None and kind.__module__.startswith("toolkit.")


def kind_sections(group: str) -> str:
    """One section per kind: what its class says, and its keys; once for the plane and space where both are alike."""
    return "\n\n".join(
        f'### <a id="{group}-{name}"></a>{name}\n\n{_said(places)}\n\n{key_table(*places.values(), marks=places)}'
        for name, places in kinds()[group].items()
    )


def _said(places: Mapping[str, type]) -> str:
    """What the classes of a kind in the plane and in space say, and their places in the reference."""
    references = "\n".join(map(_reference, places.values()))
    texts = {words(kind) for kind in places.values()}
    if "" in places or (len(places) > 1 and len(texts) == 1):
        return f"{texts.pop()}\n\n{references}"
    return "\n\n".join([*(f"{where}: {words(kind)}" for where, kind in places.items()), references])


def table(model: type[BaseModel], without: Iterable[str] = ()) -> Callable[[], str]:
    """What a class says, and its keys."""
    return lambda: f"{words(model)}\n\n{_reference(model)}\n\n{key_table(model, without=without)}"


def _reference(kind: type) -> str:
    return f"Class `{kind.__module__}.{kind.__name__}`."


def _sections(group: str) -> Callable[[], str]:
    return lambda: kind_sections(group)


TABLES: dict[str, Callable[[], str]] = {
    "scene": table(Scene, without=("directory",)),
    "points": table(BodyPoint),
    "design": table(CommonVariable),
    "solver": table(RunOptions),
    "baumgarte": table(Baumgarte),
    **{group: _sections(group) for group in kinds()},
    "skin-file": table(SkinFile),
    "airfoil": table(AirfoilTable),
    "skin": table(SkinCut),
    "start-and-end": table(ContourPoint),
    "section": table(SectionTable),
    "material": table(Material),
    "damping": table(Damping),
    "places": table(Place),
    "shape-modes": table(ShapeMode),
    "groups": table(ElementGroup),
    "basis": table(BasisTable),
    "body-file": table(BodyFile),
    "body-mesh": table(MeshTable),
    "body-matrices": table(MatricesTable),
    "body-material": table(SolidMaterial),
    "body-section": table(SolidSection),
    "body-clamp": table(Region),
    "body-interface-points": table(TiedRegion),
    "body-pressure-surfaces": table(Region),
    "body-shape-variables": table(ShapeVariable),
    "body-stress": table(StressTable),
    "frame-file": table(FrameFile),
    "frame-polar-nodes": table(PolarNode),
    "frame-beams": table(BeamTable),
    "frame-sections": table(FrameSection),
    "frame-materials": table(FrameMaterial),
    "frame-points": table(FramePoint),
    "study": table(Study, without=("directory",)),
    "study-variables": table(StudyVariable),
    "study-objective": table(Objective),
    "study-constraints": table(Limit),
    "study-search": table(Search),
    "study-sweep": table(Sweep),
    "study-uncertain": table(Uncertain),
    "study-uncertainty": table(Uncertainty),
    "study-correlations": table(Correlation),
    "reduced-model": layout,
}
"""What a page can ask for."""


if __name__ == "__main__":
    write_whole(PAGE, fill(PAGE.read_text(encoding="utf-8")).encode())
    print(f"{PAGE} written.")
