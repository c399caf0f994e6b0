"""Thousands of hostile inputs through the commands: `python -m tests.fuzz.nightly --folder DIR --cases 10000 --seed 1`.

Every case runs in a process with bounded memory and time, most of them in copies of one that has loaded the program, some (`--fresh`) as
pip installs it. Right is a result, or an error of the program in words; wrong is a traceback, a crash, a hang, or a file that is left
over or damaged. What is wrong is kept in DIR/wrong; the figures are printed and written to DIR/figures.json.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import resource
import shutil
import sys
from collections import Counter
from pathlib import Path

import numpy as np

from tests.fuzz import include_cases, matrix_cases, mesh_cases, option_cases, path_cases, run_case, toml_cases
from tests.fuzz.case import RIGHT, Case, Cases, identity, judged, snapshot

KINDS: dict[str, tuple[Cases, int]] = {
    "matrices": (matrix_cases.cases, 20),
    "meshes": (mesh_cases.cases, 47),
    "includes": (include_cases.cases, 8),
    "skins": (toml_cases.skins, 2),
    "bodies": (toml_cases.bodies, 3),
    "airfoils": (toml_cases.airfoils, 3),
    "paths": (path_cases.cases, 5),
    "options": (option_cases.cases, 2),
    "scenes": (toml_cases.scenes, 6),
    "studies": (toml_cases.studies, 4),
}
"""Kind -> its cases, and how many of a hundred are of this kind. Another kind is one more line."""

SHOWN = 250
"""Cases after which the figures so far are printed."""
WITH_SCENES = ("paths", "options", "scenes", "studies")
"""Kinds with commands of the runtime."""


def main() -> None:
    """Run, and exit with 1 if anything is wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", type=Path, required=True)
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--fresh", type=int, default=200, help="every how many cases one runs as pip installs the program")
    parser.add_argument("--minutes", type=float, default=600.0, help="of processor time, after which no new case begins")
    parser.add_argument("--seconds", type=float, default=run_case.SECONDS, help="after which a case hangs")
    given = parser.parse_args()
    os.umask(0o022)
    kinds = given.kinds.split(",")
    share = sum(KINDS[kind][1] for kind in kinds)
    run_case.load(run_case.LOADED)
    figures = {}
    for kind in kinds:
        if kind in WITH_SCENES:
            run_case.load(run_case.SCENES)
        wanted = -(-given.cases * KINDS[kind][1] // share)
        figures[kind] = run_kind(kind, wanted, given.seed, given.folder, given.fresh, given.minutes, given.seconds)
        print(kind, json.dumps(figures[kind]), flush=True)
    total = Counter()
    for found in figures.values():
        total.update(found)
    figures["all"] = dict(total)
    (given.folder / "figures.json").write_text(json.dumps(figures, indent=1))
    print("all", json.dumps(figures["all"]))
    sys.exit(any(name not in (*RIGHT, "distinct", "fresh", "seconds") for name in total))


def run_kind(kind: str, wanted: int, seed: int, folder: Path, every: int, minutes: float, seconds: float) -> dict[str, float]:
    """Outcomes of cases of one kind, and how many of them are distinct, until enough are."""
    found: Counter[str] = Counter()
    seen: set[str] = set()
    rng = np.random.default_rng([seed, *kind.encode()])
    start, attempts = used(), 0
    for case in KINDS[kind][0](rng):
        attempts += 1
        if len(seen) >= wanted or attempts > 5 * wanted or used() > 60 * minutes:
            break
        place = folder / "work" / "case"
        fresh_folder(place)
        case.write(place)
        before = snapshot(place)
        if (key := identity(case, before)) in seen:
            continue
        seen.add(key)
        fresh = len(seen) % every == 0
        ended = (run_case.run_fresh if fresh else run_case.run_forked)(case, place, seconds)
        outcome, why = judged(case, ended, before, snapshot(place))
        found.update({outcome: 1, "fresh": int(fresh)})
        if len(seen) % SHOWN == 0:
            print(f"  {kind}: {json.dumps(found)}", flush=True)
        if outcome not in RIGHT:
            keep(folder / "wrong", kind, case, outcome, why, ended.said, place, len(seen))
    return {**found, "distinct": len(seen), "seconds": round(used() - start, 1)}


def keep(wrong: Path, kind: str, case: Case, outcome: str, why: str, said: str, place: Path, number: int) -> None:
    """Keep what is needed to see it again."""
    target = wrong / re.sub(r"[^\w.-]+", "_", f"{kind}-{number}-{outcome}-{case.name}")[:120]
    target.mkdir(parents=True, exist_ok=True)
    (target / "said").write_text(f"{case.arguments}\n{why}\n{said[-20_000:]}", errors="replace")
    for each in place.iterdir():
        if each.is_file() and not each.is_symlink() and each.stat().st_size < 1_000_000:
            shutil.copy(each, target / f"file-{each.name[:100]}")
    print(f"  {outcome}: {kind} {case.name!r} {why[:300]}", flush=True)


def fresh_folder(place: Path) -> None:
    """An empty folder."""
    if place.parent.exists():
        for root, folders, _ in os.walk(place.parent):
            for name in folders:
                (Path(root) / name).chmod(0o700)
        shutil.rmtree(place.parent)
    place.mkdir(parents=True)


def used() -> float:
    """Seconds of processor time of this process and all that it started."""
    every = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(each.ru_utime + each.ru_stime for each in every)


if __name__ == "__main__":
    main()
