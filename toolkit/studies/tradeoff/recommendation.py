"""A setting as what a person pastes: the scene's table [solver], and tables of skin.toml."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

from toolkit.description.run_options import RunOptions
from toolkit.studies.tradeoff.case import Case, model_bodies, tables_file
from toolkit.studies.tradeoff.frame_axes import framed
from toolkit.studies.tradeoff.setting import Setting, options_with

EVERY_SHAPE = 10_000
"""Modes of a part that no part has: it keeps all its coordinates."""


def solver_fragment(case: Case, setting: Setting) -> str:
    """The table [solver] that takes the place of the scene's; what is the default anyway stands in it only if it did before."""
    scene, plain = case.scene(), RunOptions().model_dump()
    options = options_with(scene, setting.solver).model_dump(exclude_unset=True)
    kept = {key: value for key, value in options.items() if key in scene.solver.model_fields_set or value != plain[key]}
    return toml_table("solver", kept)


def changes(case: Case, setting: Setting) -> dict[str, str]:
    """The same as changes of single values, `ffrf ... --set PATH=VALUE`, of those that differ from the scene's."""
    scene = case.scene()
    mine, theirs = scene.solver.model_dump(), options_with(scene, setting.solver).model_dump(exclude_unset=True)
    solver = {f"solver.{key}": toml_value(value) for key, value in theirs.items() if mine.get(key) != value}
    return {
        **solver,
        **{f"bodies.{name}.{key}": str(n) for name, keys in frames(case, setting).items() for key, n in keys.items()},
    }


def frames(case: Case, setting: Setting) -> dict[str, dict[str, int]]:
    """Body -> its number of floating frames, and of modes in each part, as far as the scene has others."""
    scene, found = case.scene(), {}
    for name, body in framed(scene, setting.frames, setting.modes).bodies.items():
        if body is not scene.bodies[name] and body != scene.bodies[name]:
            new, old = ({key: getattr(each, key) for key in ("frames", "modes_per_frame")} for each in (body, scene.bodies[name]))
            found[name] = {key: EVERY_SHAPE if n is None else n for key, n in new.items() if n != old[key]}
    return found


def skin_fragments(case: Case, setting: Setting) -> dict[str, str]:
    """Body -> the tables of its skin file that take the place of those that are there."""
    found = {}
    for body in model_bodies(case.scene(), setting):
        tables = json.loads(tables_file(case.model_file(body, setting.skin)).read_text(encoding="utf-8"))
        if tables:
            found[body] = "\n\n".join(toml_table(name, table) for name, table in tables.items())
    return found


def next_steps(case: Case, setting: Setting) -> Iterator[str]:
    """What to do with a fragment, in words."""
    if chosen := changes(case, setting):
        yield "To try it: " + " ".join(f"--set '{path}={text}'" for path, text in chosen.items())


def toml_table(name: str, content: Mapping[str, Any]) -> str:
    """A table under its header; tables in it are written inline."""
    return "\n".join([f"[{name}]", *(f"{key} = {toml_value(value)}" for key, value in content.items())])


def toml_value(value: Any) -> str:
    """One value, exactly."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Mapping):
        inside = ", ".join(f"{key} = {toml_value(each)}" for key, each in value.items())
        return f"{{ {inside} }}" if inside else "{}"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(toml_value, value))}]"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)
