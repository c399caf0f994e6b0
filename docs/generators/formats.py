"""Tables of the file formats, made from the classes that read the files: a key that exists is documented, and no other."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping

from pydantic import BaseModel

from docs.generators.comments import words
from docs.generators.file_layout import layout
from docs.generators.key_tables import key_table
from preprocessing.recipes.frame.frame_file import FrameFile
from preprocessing.recipes.frame.frame_tables import BeamTable, FrameMaterial, FramePoint, FrameSection
from preprocessing.recipes.skin.skin_file import SkinFile
from preprocessing.recipes.skin.skin_tables import (
    Airfoil,
    ContourPoint,
    ElementGroup,
    Material,
    Place,
    SectionTable,
    ShapeMode,
    SkinCut,
)
from preprocessing.recipes.solids.body_file import BodyFile
from preprocessing.recipes.solids.body_tables import (
    MatricesTable,
    MeshTable,
    Region,
    ShapeVariable,
    SolidMaterial,
    SolidSection,
    StressTable,
    TiedRegion,
)
from preprocessing.recipes.tables import BasisTable, Damping
from toolkit.curves.catalogue import Curve
from toolkit.description.design import CommonVariable
from toolkit.description.point import BodyPoint
from toolkit.description.run_options import Baumgarte, RunOptions
from toolkit.responses.catalogue import Response
from toolkit.scene.kinds import kinds_of
from toolkit.scene.scene import Scene

PLACE = re.compile(r"^<!-- table: ([\w-]+) -->$", re.MULTILINE)
"""Where a page wants a table."""


def fill(markdown: str) -> str:
    """The page with its tables."""
    return PLACE.sub(lambda found: TABLES[found[1]](), markdown)


def kinds() -> dict[str, dict[str, type[BaseModel]]]:
    """All kinds that the toolkit knows by a `type` in a scene file, by group and in the order of their names; those in space apart."""
    groups: dict[str, Mapping[str, type]] = {
        **kinds_of(2),
        **{f"spatial-{group}": found for group, found in kinds_of(3).items()},
        "responses": Response.kinds,
        "curves": Curve.kinds,
    }
    return {
        group: {name: found[name] for name in sorted(found) if found[name].__module__.startswith("toolkit.")}
        for group, found in groups.items()
    }


def kind_sections(group: str) -> str:
    """One section per kind: what its class says, and its keys."""
    return "\n\n".join(
        f"### {name} {{ #{group}-{name} }}\n\n{words(kind)}\n\n{_reference(kind)}\n\n{key_table(kind)}"
        for name, kind in kinds()[group].items()
    )


def table(model: type[BaseModel], without: Iterable[str] = ()) -> Callable[[], str]:
    """What a class says, and its keys."""
    return lambda: f"{words(model)}\n\n{_reference(model)}\n\n{key_table(model, without)}"


def _reference(kind: type) -> str:
    return f"In the reference: [`{kind.__name__}`][{kind.__module__}.{kind.__name__}]."


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
    "airfoil": table(Airfoil),
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
    "frame-beams": table(BeamTable),
    "frame-sections": table(FrameSection),
    "frame-materials": table(FrameMaterial),
    "frame-points": table(FramePoint),
    "reduced-model": layout,
}
"""What a page can ask for."""
