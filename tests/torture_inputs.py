"""Mutated scenes, studies, overrides and goals: each is taken or refused in a sentence."""

import functools
import random
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from torture_rows import Found, Row, part_of

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.base.yaml_files import SCENES, STUDIES
from bearing_twin.nodes.studies import Goal, study_of
from bearing_twin.run.scene import load_scene, parse_scene
from bearing_twin.run.simulation import Simulation, cost_of
from bearing_twin.uq.run import refuse_too_large
from bearing_twin.uq.study import load_study, parse_study

NUMBERS = (
    "0", "-0", "-1", "1e308", "1e-308", "5e-324", "1e200", "-1e200", ".inf", "-.inf", ".nan", "1e400", "0x10", "1_000",
    "999999999999999999999999", "2.5", "1e-20", "1e18", "9223372036854775808", "3 mm", "3 parsec", "1:30:00",
)  # fmt: skip
WORDS = (
    "", "null", "true", "~", "[]", "{}", "[1, 2, 3]", "{a: {b: c}}", "'", '"', "!!binary abc", "*a", "&a 1", "\t", "no",
    "bearing", "auto", "2026-01-01", "\u202e", "\x00", "x" * 300, "[.nan, 1e999, -0]", "- - - -", "? a", "%", "@",
)  # fmt: skip


def _mutated(text: str, chance: random.Random) -> str:
    """A text of YAML with some values, lines or characters replaced, doubled, moved, or left out."""
    lines = text.splitlines()
    for _ in range(chance.randint(1, 4)):
        index = chance.randrange(len(lines))
        key, colon, _ = lines[index].partition(":")
        kind = chance.randrange(8)
        if kind < 4 and colon:
            lines[index] = f"{key}: {chance.choice(NUMBERS + WORDS)}"
        elif kind == 4:
            lines.insert(chance.randrange(len(lines)), lines[index])
        elif kind == 5 and len(lines) > 1:
            del lines[index]
        elif kind == 6:
            line, position = lines[index], chance.randrange(len(lines[index]) + 1)
            character = chr(chance.choice((0, 9, 58, 91, 123, 233, 0x202E, 0x1F600)))
            lines[index] = line[:position] + character + line[position:]
        else:
            lines[index] = lines[index].replace(" ", " " * chance.randint(0, 5))
    return "\n".join(lines)


def _keys(text: str) -> list[str]:
    """Dotted keys of a text, as far as two levels go."""
    keys, section = [], ""
    for line in text.splitlines():
        key, colon, _ = line.partition(":")
        if colon and not line.startswith((" ", "#")):
            section = key
        elif colon:
            keys.append(f"{section}.{key.strip()}")
    return keys or ["run.duration"]


@functools.cache
def _texts() -> tuple[dict[str, str], dict[str, str], list[str]]:
    """The shipped scenes and studies by name, and some scenes with all their keys."""
    scenes, studies = (
        {name: shelf.read_text(shelf.find(name)) for name in shelf.names()} for shelf in (SCENES, STUDIES)
    )
    return scenes, studies, [load_scene(name).text for name in ("bearing_6203", "two_spheres", "ellipsoid_rocking")]


def _case(chance: random.Random) -> Callable[[], object]:
    """One thing to try."""
    scenes, studies, resolved = _texts()

    def value():
        return chance.choice(NUMBERS + WORDS)

    def scene():
        text = _mutated(chance.choice([*scenes.values(), *resolved]), chance)
        return lambda: _looked_at(parse_scene(text, "a mutant"))

    def override():
        name = chance.choice(list(scenes))
        arguments = [f"{chance.choice(_keys(scenes[name]))}={value()}" for _ in range(chance.randint(1, 3))]
        arguments += [
            chance.choice(("=", "a", "a.b.c.d=1", "=1", "run=1", "run.=1", "kind=x", "." * 50 + "=1"))
        ] * chance.randint(0, 1)
        return lambda: _looked_at(load_scene(name, arguments))

    def study():
        text = _mutated(chance.choice(list(studies.values())), chance)
        return lambda: refuse_too_large(parse_study(text, "a mutant"))

    def study_override():
        name = chance.choice(list(studies))
        arguments = [f"{chance.choice(_keys(studies[name]))}={value()}"]
        return lambda: refuse_too_large(load_study(name, arguments))

    def goal():
        text = chance.choice(
            [*studies, _mutated(chance.choice(list(studies.values())), chance), value() * 50, "/" + value()]
        )
        overrides = tuple(f"samples={value()}" for _ in range(chance.randint(0, 2)))
        request = Goal(text, overrides, chance.choice((0, -1, 2**31 - 1)))
        return lambda: study_of(request)

    return chance.choice((scene, scene, override, study, study_override, goal))()


def _looked_at(scene) -> None:
    """Start of every run, where it takes no time: its size, its channels, its motion."""
    cost = cost_of(scene)
    assert cost.memory_bytes >= 0.0
    if scene.kind in MADE and len(scene.channels) and sum(channel.width for channel in scene.channels) < 2000:
        Simulation(scene)


MADE = ("two_spheres", "two_discs")  # whose motions are made without any computation


def mutants(share: float, folder: Path) -> Found:
    """Each is read as a command or a node reads it; anything but a value or a sentence is silent."""
    chance, trials = random.Random(6), part_of(3000, share, 100)
    survived = silent = taken = 0
    worst, strange = 0.0, Counter()
    for _ in range(trials):
        work = _case(chance)
        began = time.process_time()
        try:
            work()
            taken += 1
            survived += 1
        except BearingTwinError as error:
            sentence = str(error)
            survived += bool(sentence) and "Traceback" not in sentence
        except Exception as error:
            silent += 1
            strange[f"{type(error).__name__}: {str(error)[:80]}"] += 1
        took = time.process_time() - began
        worst = max(worst, took)
    figures = f"{taken} legal, the others refused; greatest {worst:.2f} s"
    return Found(trials, survived, 0, silent, "; ".join([figures, *(f"{k} x {n}" for k, n in strange.items())]))


ROWS = (Row("mutant", "scenes, studies, overrides and goals, mutated", mutants),)
