"""The pages of the reference: one for every room of the house, in the order of the arrows between them. New rooms need no entry here."""

from __future__ import annotations

from dataclasses import dataclass

from docs.generators.house import HALVES, about, arrows, modules, ordered
from docs.generators.house import rooms as folders


@dataclass(frozen=True)
class Room:
    """One page of the reference."""

    name: str
    about: str
    modules: tuple[str, ...]

    @property
    def half(self) -> str:
        """The package that it belongs to."""
        return self.name.split(".")[0]

    @property
    def title(self) -> str:
        """Its name for people."""
        return self.name.split(".")[-1].replace("_", " ").capitalize()

    @property
    def page(self) -> str:
        """Path of the page inside the documentation."""
        return f"reference/{self.name.replace('.', '-')}.md"


def rooms() -> list[Room]:
    """All rooms with all their modules, each room after those that it imports from."""
    return [_room(f"{half}.{name}") for half in HALVES for name in ordered(arrows(half))]


def _room(name: str) -> Room:
    half = name.split(".")[0]
    return Room(name, about(name), tuple(each for each in modules(half) if each == name or each.startswith(f"{name}.")))


def page(room: Room) -> str:
    """Text of one page: every module with all that is public in it, those of an inner room below what that is for."""
    inner = {name: "" for name in room.modules}
    for folder in folders(room.half):
        first = next((name for name in room.modules if name.startswith(f"{folder}.")), None)
        if first and folder not in (room.name, room.half):
            inner[first] += f"*`{folder}`: {about(folder)}*\n\n"
    return f"# {room.title}\n\n{room.about}\n\n" + "\n\n".join(f"{text}::: {name}" for name, text in inner.items()) + "\n"


def navigation() -> list[dict]:
    """The reference in the navigation: both halves, each with its rooms."""
    return [{half.capitalize(): [{room.title: room.page} for room in rooms() if room.half == half]} for half in HALVES]


def overview() -> str:
    """Table of all rooms with what they are for."""
    rows = [f"| [`{room.name}`]({room.page}) | {room.about} |" for room in rooms()]
    return "\n".join(["| room | what it is for |", "|---|---|", *rows])
