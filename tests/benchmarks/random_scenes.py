"""Verdicts of two hundred random scenes, against what their answers are.

`python -m tests.benchmarks.random_scenes` runs every scene of `tests.random_scenes` as it was drawn, asks for its verdict
(`verdict_of`), and compares its values with those of two runs with steps of a tenth, or less, by other formulations
(`tests.random_scenes.reference`), and with those of finer models: four elements in place of each, all of their shapes, four frames. It
prints a line for each scene and then how many wrong answers left without a doubt (there should be none), how many right answers were
doubted (at most 4 %), and by which factor the errors that doubts tell are from true ones.

    python -m tests.benchmarks.random_scenes --seeds 0:200 --folder output/random_scenes [--only 17,23] [--explain] [--strained]

With `--strained` the scenes are those of `tests.random_scenes.strained`, at the edges of what bodies of one frame can tell.

References are kept as JSON lines in the folder, and are found again as long as the scene they are of is the same: another verdict is judged
within seconds. The verdicts of the last call are in `judged.jsonl`, with all errors and measures.

What a scene may be:

    right      every value is known and within 5 % of the largest that it has during the motion
    wrong      a value is off by more, by its steps or by its model
    refused    the toolkit raised an error of its own
    dropped    right as far as is known, but the finer runs disagree about some value (by more than 1 %), or do not exist
    crashed    an error that is none of the toolkit's

A gradient is off if it is known and differs by more than 20 % of the largest that it has during the motion.
"""

from __future__ import annotations

import argparse
import json
import re
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from tests.random_scenes.finer import finer_scene
from tests.random_scenes.reference import (
    AGREED,
    Answers,
    Reference,
    answers,
    confirmed_reference,
    errors,
    model_reference,
    reference,
)
from tests.random_scenes.scene import named_scene
from tests.random_scenes.strained import strained_scene
from toolkit.analyses.sensitivity.compiled import Compiled
from toolkit.analyses.sensitivity.errors.step_cautions import GRADIENT_LIMIT as GRADIENT
from toolkit.analyses.sensitivity.errors.step_cautions import VALUE_LIMIT
from toolkit.analyses.sensitivity.methods import by_method
from toolkit.analyses.sensitivity.run import Run
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.verdict import Verdict
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution
from toolkit.validity.energy_balance import energy_balance

PROMISED = 0.1
"""Error of a gradient that verdicts allow: beyond it a doubt is no false alarm, whatever it names."""
WRONG, OFF = 0.05, 0.2
"""Error of a value above which it is wrong, and of a gradient above which it is off."""
MODEL = frozenset(
    {
        "large-deformation",
        "geometric-gradients",
        "frames",
        "critical-speed",
        "critical-load",
        "reference-condition",
        "snap-through",
        "shear",
        "tension",
        "weight-between-nodes",
        "left-out-shapes",
        "frozen-basis",
    }
)
"""Codes of doubts about a model, which only finer models can judge."""

GRADIENTS = frozenset({"gradient-steps", "geometric-gradients"})
"""Codes of doubts about gradients alone."""
NOTHING = 1e-9
"""Error below which nothing is wrong at all."""
UNJUDGED = frozenset({"curve-overshoot", "stale-model", "tied-extreme"})
"""Codes of doubts about what was meant, or about derivatives that do not exist, which no finer run can judge."""
STEPS = frozenset({"steps", "gradient-steps", "lost-vibrations", "energy"})
"""Codes of doubts about steps."""
MOVED = ("way", "turn", "middle", "end", "most", "cross")
"""How names of responses begin that are displacements."""
PERCENT = re.compile(r"([0-9][0-9.e+]*) ?%")
"""The size of an error in the sentence of a doubt."""

NAMED = re.compile(r"\w+ by x\d+")
"""A derivative in the sentence of a doubt."""

HEAD = f"seed {'kind':15s} {'solver':40s}  steps outcome     error of               gradient   energy    local doubts"


def verdict_of(found: Run) -> Verdict:
    """The verdict of a run."""
    return found.verdict


@dataclass
class Judged:
    """One scene: what was found, and what is true."""

    seed: int
    kind: str
    outcome: str = ""
    error: float = 0.0
    worst: str = ""
    gradient_error: float = 0.0
    worst_gradient: str = ""
    codes: list[str] = field(default_factory=list)
    texts: list[str] = field(default_factory=list)
    solver: str = ""
    steps: int = 0
    values: dict[str, float] = field(default_factory=dict)
    unknown: list[str] = field(default_factory=list)
    measures: dict[str, Any] = field(default_factory=dict)
    seconds: float = 0.0
    model_known: bool = True
    gradients: dict[str, float] = field(default_factory=dict)
    parts: list[float | None] = field(default_factory=list)

    @property
    def judged(self) -> set[str]:
        """Codes of the doubts that the references can judge: not of derivatives that the finer runs disagree about themselves."""
        slopes = {code for code, off in self._slopes_doubted.items() if not off & set(self.gradients)}
        return set(self.codes) - UNJUDGED - slopes - (frozenset() if self.model_known else MODEL)

    @property
    def _slopes_doubted(self) -> dict[str, set[str]]:
        """Code -> the derivatives that are told to be off by the length of the steps, and those that are named of all off by frames."""
        told = self.measures.get("estimated_error", {}).get("gradients", {})
        steps = {f"{name} by {x}" for name, errors_by in told.items() for x, error in errors_by.items() if not error <= GRADIENT}
        texts = [text for text in self.texts if "repeating the run with" in text and "gradient" in text]
        return {"gradient-steps": steps, "geometric-gradients": {each for text in texts for each in NAMED.findall(text)}}

    @property
    def doubted(self) -> bool:
        """Whether a doubt about the accuracy of values was said."""
        return bool(self.judged - GRADIENTS)

    @property
    def alarmed(self) -> bool:
        """Whether a doubt was said about right values with gradients as right as is promised, or about gradients that are right too."""
        return bool(self.judged) and self.gradient_error <= (PROMISED if self.doubted else WRONG)

    @property
    def told(self) -> Iterator[tuple[str, float, float]]:
        """Code, told and true error of each number of a doubt: by responses where they tell of these, otherwise by the largest true error.

        Where both a model and steps are in doubt nobody can tell which of them an error is of.
        """
        by_model, by_steps = self.judged & MODEL, self.judged & STEPS
        if by_steps and not by_model:
            yield from self._told_of_steps()
        if by_model and not by_steps:
            moved = max((off for name, off in self.values.items() if name.startswith(MOVED)), default=0.0)
            for code, part, text in zip(self.codes, self.parts, self.texts, strict=False):
                told = PERCENT.search(text) if code in self.judged and part is None else None
                if code in self.judged and part is not None and moved > 0:
                    yield code, part / (1 + part) if code == "critical-load" else part, moved
                elif told:
                    yield code, float(told[1]) / 100, self.gradient_error if code in GRADIENTS else self.error

    def _told_of_steps(self) -> Iterator[tuple[str, float, float]]:
        told = self.measures.get("estimated_error", {})
        for name, error in told.get("responses", {}).items():
            if VALUE_LIMIT < error < 1 and 0 < self.values.get(name, 0.0) < 1:
                yield "steps", error, self.values[name]
        for name, errors_by in told.get("gradients", {}).items():
            for x, error in errors_by.items():
                if GRADIENT < error < 1 and 0 < self.gradients.get(f"{name} by {x}", 0.0) < 1:
                    yield "gradient-steps", error, self.gradients[f"{name} by {x}"]


def judge(seed: int, folder: Path, known: dict[str, Any], strained: bool = False) -> Judged:
    """Run a scene and compare it with its reference, a known one if there is one for this very scene."""
    kind, scene, fine = strained_scene(seed, folder / "models") if strained else (*named_scene(seed, folder / "models"), None)
    found = Judged(seed, kind, solver=_solver(scene))
    begun = time.perf_counter()
    try:
        run = by_method("direct", Compiled(scene, tuple(scene.design)), "transient")
        solution = run.solution
        mine, verdict = answers(solution, sizes=False), verdict_of(run)
    except ToolkitError as error:
        found.outcome, found.texts = "refused", [f"{type(error).__name__}: {error}"]
        return found
    except (ArithmeticError, AssertionError, AttributeError, LookupError, TypeError, ValueError) as error:
        found.outcome, found.texts = "crashed", [f"{type(error).__name__}: {error}", traceback.format_exc()]
        return found
    found.seconds, found.steps = time.perf_counter() - begun, solution.steps
    found.codes = [each.code for each in verdict.warnings if each.doubt]
    found.texts = [each.text for each in verdict.warnings]  # doubts first
    found.parts = [float(each.part) if each.body and np.isfinite(each.part) else None for each in verdict.warnings if each.doubt]
    found.measures = {**_measures(solution), **dict(verdict.measures)}
    true = _reference(fine or scene, seed, solution.steps, folder, known)
    finer = _finer_model(scene, seed, true.finer * solution.steps, folder, known) if true.answers and fine is None else None
    found = _compared(found, scene, mine, true, finer)
    if finer is not None and found.outcome == "wrong" and not found.doubted:
        finer = _finer_model(scene, seed, true.finer * solution.steps, folder, known, "confirmed")
        found = _compared(found, scene, mine, true, finer)
    return found


def _compared(found: Judged, scene: Scene, mine: Answers, true: Reference, finer: Reference | None) -> Judged:
    """Its errors and its outcome."""
    if true.answers is None:
        found.outcome, found.unknown = "dropped", [true.why]
        return found
    found.unknown = [*true.unknown, *(finer.unknown if finer else [])]
    found.model_known = finer is None or finer.answers is not None
    values, gradients = errors(scene, mine, finer.answers if finer and finer.answers else true.answers)
    found.values = {name: off for name, off in values.items() if name not in found.unknown}
    apart = {name: max(off, finer.gradients.get(name, 0.0) if finer else 0.0) for name, off in true.gradients.items()}
    slopes = {name: off for name, off in gradients.items() if apart.get(name, 1.0) <= AGREED and np.isfinite(off)}
    found.gradients = slopes
    found.worst, found.error = max(found.values.items(), key=lambda item: item[1], default=("", 0.0))
    found.worst_gradient, found.gradient_error = max(slopes.items(), key=lambda item: item[1], default=("", 0.0))
    found.outcome = "wrong" if found.error > WRONG else "dropped" if found.unknown else "right"
    return found


def _measures(solution: Solution) -> dict[str, float]:
    """What a verdict may be made of, for its calibration."""
    return {
        "local_error": float("nan") if solution.local_error is None else solution.local_error,
        "energy": energy_balance(solution).relative_defect,
        "drift": solution.drift,
        "correction": solution.correction,
    }


def _reference(scene: Scene, seed: int, steps: int, folder: Path, known: dict[str, Any]) -> Reference:
    """That of the file, or a new one, which is added to it."""
    key = _key(scene, steps)
    return _known(known, key) or _added(reference(scene, steps), key, seed, folder, known)


def _finer_model(
    scene: Scene, seed: int, steps: int, folder: Path, known: dict[str, Any], confirmed: str = ""
) -> Reference | None:
    """The same of the scene with finer models, by two runs if it is to be confirmed; None where it has none."""
    finer = finer_scene(scene)
    if finer is None:
        return None
    key, found = _key(finer, steps) + confirmed, confirmed_reference if confirmed else model_reference
    return _known(known, key) or _added(found(finer, steps), key, seed, folder, known)


def _key(scene: Scene, steps: int) -> str:
    written = repr(scene.model_copy(update={"directory": Path()}))
    return sha256(f"{steps} {written}".encode()).hexdigest()[:16]


def _known(known: dict[str, Any], key: str) -> Reference | None:
    if key not in known:
        return None
    record = dict(known[key])
    given = record.pop("answers")
    return Reference(Answers(**given) if given else None, **record)


def _added(true: Reference, key: str, seed: int, folder: Path, known: dict[str, Any]) -> Reference:
    known[key] = asdict(true)
    with (folder / "references.jsonl").open("a") as file:
        file.write(json.dumps({"key": key, "seed": seed, **asdict(true)}) + "\n")
    return true


def _solver(scene: Scene) -> str:
    """Its options in short."""
    options = scene.solver
    parts = [options.scheme if options.scheme == "paper" else options.formulation, f"rho {options.rho_inf:g}"]
    parts += ["modified"] if options.newton == "modified" else []
    parts += ["still"] if options.quasi_static else []
    parts += ["uneven"] if options.times else []
    parts += [f"error {options.local_error:g}"] if options.local_error else []
    parts += [f"tolerance {options.tolerance:g}"] if options.tolerance != 1e-10 else []
    parts += ["baumgarte"] if options.baumgarte.damping is not None else []
    return ", ".join(parts)


def known_references(folder: Path) -> dict[str, Any]:
    """Those of the file."""
    path = folder / "references.jsonl"
    lines = path.read_text().splitlines() if path.exists() else []
    records = [json.loads(line) for line in lines]
    return {record.pop("key"): {name: value for name, value in record.items() if name != "seed"} for record in records}


def line(found: Judged) -> str:
    """One row of the table."""
    return (
        f"{found.seed:4d} {found.kind:15s} {found.solver:40s} {found.steps:6d} {found.outcome:8s} {found.error:8.1e} "
        f"{found.worst:16s} {found.gradient_error:8.1e} {found.measures.get('energy', 0):8.1e} {found.measures.get('local_error', 0):8.1e} "
        f"{'DOUBT ' if found.doubted else ''}{','.join(found.codes)}"
    )


def summary(all_found: list[Judged]) -> str:
    """The counts."""
    of = {
        name: [each for each in all_found if each.outcome == name] for name in ("right", "wrong", "dropped", "refused", "crashed")
    }
    silent = [each for each in of["wrong"] if not each.doubted]
    alarmed = [each for each in of["right"] if each.alarmed]
    slopes = [each for each in of["right"] if each.gradient_error > OFF and not each.codes]
    codes = Counter(code for each in alarmed for code in each.codes)
    return "\n".join(
        [
            ", ".join(f"{len(items)} {name}" for name, items in of.items()),
            f"wrong without a doubt about values: {len(silent)} {[each.seed for each in silent]}, "
            f"trusted of these {[each.seed for each in silent if not each.codes]}",
            f"right with a doubt: {len(alarmed)} of {len(of['right'])} {[each.seed for each in alarmed]}, {dict(codes)}",
            f"gradients off without a doubt, values right: {len(slopes)} {[each.seed for each in slopes]}",
            f"crashed: {[each.seed for each in of['crashed']]}",
            *_told_against_true([each for name in ("right", "wrong") for each in of[name]]),
        ]
    )


def _told_against_true(all_found: list[Judged]) -> Iterator[str]:
    """A row for each code: how often it told an error, by which factor at the median, and how often by more than 2."""
    factors: dict[str, list[float]] = {}
    for code, told, true in (row for one in all_found for row in one.told):
        factors.setdefault(code, []).append(max(told, true) / max(min(told, true), NOTHING))
    yield "told against true errors: code, times, median factor, more than twice"
    for code, listed in sorted(factors.items()):
        yield f"  {code:24s} {len(listed):4d} {np.median(listed):9.3g} {sum(factor > 2 for factor in listed):4d}"
    told = [factor for found in factors.values() for factor in found]
    if told:
        yield f"  {'all':24s} {len(told):4d} {np.median(told):9.3g} {sum(factor > 2 for factor in told):4d}"


def main() -> None:
    """Judge, print and store."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="0:200", help="first:last")
    parser.add_argument("--only", help="some seeds, with commas")
    parser.add_argument("--folder", type=Path, default=Path("output/random_scenes"))
    parser.add_argument("--strained", action="store_true", help="scenes at the edges of what bodies of one frame can tell")
    parser.add_argument("--explain", action="store_true", help="texts of the cautions, and all errors")
    given = parser.parse_args()
    first, last = map(int, given.seeds.split(":"))
    seeds = [int(each) for each in given.only.split(",")] if given.only else range(first, last)
    (given.folder / "models").mkdir(parents=True, exist_ok=True)
    known, all_found = known_references(given.folder), []
    print(
        "seed kind            solver                                    steps outcome     error of               gradient   energy    local"
    )
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        for seed in seeds:
            found = judge(seed, given.folder, known, given.strained)
            all_found.append(found)
            print(line(found), flush=True)
            if given.explain or found.outcome == "crashed":
                print("\n".join([f"      {text}" for text in found.texts]), f"\n      {found.values} unknown: {found.unknown}")
    if not given.only:
        text = "".join(json.dumps(asdict(found)) + "\n" for found in all_found)
        (given.folder / "judged.jsonl").write_text(text)
    print(summary(all_found))


if __name__ == "__main__":
    main()
