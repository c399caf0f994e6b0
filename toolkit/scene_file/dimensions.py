"""The dimension of every number of a scene, read from what stands beside its field."""

from __future__ import annotations

from collections.abc import Iterator

from toolkit.description.description import Description
from toolkit.foundation.units import Dimension
from toolkit.responses.response import Response
from toolkit.scene.measures import measure_in, number_measure
from toolkit.scene.names import GROUPS
from toolkit.scene.scene import Scene


def dimensions(scene: Scene) -> dict[str, Dimension]:
    """Path -> dimension of every number that the scene writes.

    Raises
    ------
    InputError
        Nobody has said what the number of a component is: names class and field.
    """
    found = dict(_below("solver", scene.solver, scene))
    for group in GROUPS:
        for name, item in getattr(scene, group).items():
            found |= _below(f"{group}.{name}", item, scene)
    return found


def number_dimension(scene: Scene, path: str) -> Dimension:
    """Dimension of one number: one that the scene writes, or a parameter of a reduced model that it leaves at its nominal value.

    Raises
    ------
    InputError
        As `dimensions`.
    """
    return number_measure(scene, path).dimension


def response_dimension(response: Response) -> Dimension:
    """Dimension of a response's value."""
    return response.physical_dimension


def _below(where: str, item: Description, scene: Scene) -> Iterator[tuple[str, Dimension]]:
    for path, _ in item.numbers():
        yield f"{where}.{path}", measure_in(item, path.split("."), scene).dimension
