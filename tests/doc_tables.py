"""Write the generated tables of README and docs: `python tests/doc_tables.py`.

A table is the text between `<!-- table: NAME -->` and `<!-- end -->`; TABLES maps its name to a function that makes it.
"""

import csv
import importlib.util
import re
import sys
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path

from failure_rows import FAILURES

from bearing_twin.base.parameters import describe
from bearing_twin.base.units import label_and_unit, two_digits, with_unit
from bearing_twin.base.yaml_files import SCENES, STUDIES
from bearing_twin.charts import CHARTS, chart_of
from bearing_twin.charts.contest import COLUMNS, MADE, Row, by_method, cheapest
from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.contact.laws import LAWS, MEASURED
from bearing_twin.kinds import KINDS, SHIPPED
from bearing_twin.kinds.rules import RANGES, RULES
from bearing_twin.log import stream
from bearing_twin.methods import STEPPER_FACTS
from bearing_twin.uq.distributions import DISTRIBUTIONS, FACTS, FORMS
from bearing_twin.uq.sampling import SAMPLERS

ROOT = Path(__file__).resolve().parent.parent
CHARTED = ROOT / "docs" / "charts"  # tables and pictures of charts
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
SHIPPED_KINDS = {name: KINDS[name] for name in SHIPPED}  # not those of tests
_MARKED = re.compile(r"(<!-- table: (\w+) -->\n)(.*?)(<!-- end -->)", flags=re.DOTALL)


def _table(header: tuple[str, ...], rows: Iterable[tuple]) -> str:
    lines = [header, ("---",) * len(header), *rows]
    return "".join(f"|{'|'.join(_cell(cell) for cell in line)}|\n" for line in lines)


def _cell(cell) -> str:
    text = str(cell).replace("|", "\\|")
    return text if "`" in text else text.replace("<", "\\<")


def _scenes() -> str:
    return _table(("scene", "what"), ((f"`{head['name']}`", head["description"]) for head in SCENES.headers()))


def _studies() -> str:
    return _table(("study", "what"), ((f"`{head['name']}`", head["description"]) for head in STUDIES.headers()))


def _kinds() -> str:
    return _table(("kind", "what"), ((f"`{kind.name}`", kind.help) for kind in SHIPPED_KINDS.values()))


def _laws() -> str:
    keys = {need: f"`contact.{key}` [{unit}]" for need, (key, unit) in MEASURED.items()}
    rows = (
        (f"`{name}`", law.fits, law.help, ", ".join(keys[need] for need in law.needs if need in keys) or "-")
        for name, law in LAWS.items()
    )
    return _table(("law", "contact", "what", "required key"), rows)


def _frictions() -> str:
    rows = (
        (f"`{name}`", row.help, f"{100.0 * row.error:.2g} %" if row.error else "-") for name, row in FRICTIONS.items()
    )
    return _table(("friction", "what", "greatest error of force or torque, b/a ≥ 0.1"), rows)


def _ranges() -> str:
    rows = (
        (
            ", ".join(f"`{row.key}: {model}`" for model in row.models),
            row.words.rstrip(","),
            row.limits,
            row.why,
            row.instead,
        )
        for row in RANGES
    )
    return _table(("model", "quantity", "range", "reason", "alternative"), rows)


def _rules() -> str:
    rows = (
        (", ".join(f"`{kind}`" for kind in row.kinds), f"`{row.key}`", f"`{row.choice}`", row.when or "else", row.why)
        for row in RULES
    )
    return _table(("kinds", "key", "choice", "condition", "reason"), rows)


def _unsourced() -> str:
    """Keys whose help says that their default has no source, each once, with the reason for the value."""
    defaults: dict[tuple, dict] = {}
    for kind in SHIPPED_KINDS.values():
        for row in describe(kind.parameters):
            meaning, separator, reason = row.help.partition("; no source: ")
            if separator and row.default:
                key = row.key if row.key.count(".") == 1 else f"material.{row.key.rpartition('.')[2]}"
                defaults.setdefault((key, meaning, reason), {})[f"{row.default:g}{with_unit(row.unit)}"] = None
    rows = ((f"`{key}`", ", ".join(values), reason) for (key, _, reason), values in defaults.items())
    return _table(("key", "default", "reason"), rows)


def _laws_of_kinds() -> str:
    """Laws, frictions and steppers that the parameters of each kind accept."""
    rows = []
    for name, kind in SHIPPED_KINDS.items():
        options = {row.key: row.options for row in describe(kind.parameters)}
        cells = [
            ", ".join(f"`{option}`" for option in options.get(key, ()) if option != "auto") or "no choice"
            for key in ("contact.normal", "contact.friction", "solver.stepper")
        ]
        rows.append((f"`{name}`", *cells))
    return _table(("kind", "`contact.normal`", "`contact.friction`", "`solver.stepper`"), rows)


def _steppers() -> str:
    rows = (
        (f"`{name}`", facts.order, "adaptive" if facts.adaptive else "fixed", facts.treats, facts.source)
        for name, facts in STEPPER_FACTS.items()
    )
    return _table(("stepper", "order", "step", "what it treats implicitly", "source"), rows)


def _costs() -> str:
    """The table of `make bench`."""
    path = ROOT / "docs" / "speed.csv"
    with path.open(newline="", encoding="utf-8") as stream:
        rows = [
            (row["what"], f"{row['found']} {row['unit']}", f"{row['machine']}, {row['day']}")
            for row in csv.DictReader(stream)
        ]
    return _table(("what", "measured", "on"), rows)


def _speeds(steppers: tuple[str, ...] = ()) -> str:
    """The reading of the chart of steppers: times real time within an error of 1e-3; empty without its table."""
    if not (CHARTED / "steppers.csv").is_file():
        return ""
    rows, chart = read_table(CHARTED / "steppers.csv"), chart_of("steppers")
    steppers = steppers or tuple(dict.fromkeys(row.method for row in rows))
    lines = []
    for title, runs in chart.by_title(rows):
        by_stepper = by_method(runs)
        best = (cheapest(by_stepper.get(stepper, ()), chart.requested_error) for stepper in steppers)
        lines.append((title, *(two_digits(1.0 / row.seconds) if row else "never" for row in best)))
    return _table(("8 balls, 16 contacts", *(f"`{stepper}`" for stepper in steppers)), lines)


def read_table(path: Path) -> list[Row]:
    """The rows in a table of a chart."""

    def number(text: str) -> float | str:
        try:
            return float(text)
        except ValueError:
            return text

    with path.open(encoding="utf-8", newline="") as stream:
        lines = list(csv.DictReader(stream))
    return [
        Row(
            **{name: number(line.pop(name)) for name in COLUMNS},
            more={name: number(text) for name, text in line.items() if text and name != MADE},
        )
        for line in lines
    ]


def _charts() -> str:
    return _table(("chart", "what it shows"), ((f"`{name}`", chart.shows) for name, chart in CHARTS.items()))


def _quantities() -> str:
    rows = (
        (kind, f"`{name}`", quantity.unit, quantity.meaning)
        for kind, entry in SHIPPED_KINDS.items()
        for name, quantity in entry.quantities_of().items()
    )
    return _table(("kind", "quantity", "unit", "meaning"), rows)


def _distributions() -> str:
    rows = (
        (f"`{name}`", "; ".join(", ".join(form) for form in row.forms), row.help) for name, row in DISTRIBUTIONS.items()
    )
    return _table(("distribution", "parameters", "use"), rows)


def _knowledge() -> str:
    return _table(("known properties",), ((", ".join(fact for fact in FACTS if fact in form),) for form in FORMS))


def _samplers() -> str:
    return _table(("sampler", "what"), ((f"`{name}`", row.help) for name, row in SAMPLERS.items()))


def _reading(name: str) -> str:
    """Sentences of a chart, from its table or the texts of its sheets; empty where there are none."""
    chart, table = chart_of(name), CHARTED / f"{name}.csv"
    if table.is_file():
        sentences = chart.reading(read_table(table))
    else:
        texts = (CHARTED / f"{name}_{sheet}.txt" for sheet in getattr(chart, "sheets", ()))
        sentences = [line for text in texts if text.is_file() for line in text.read_text("utf-8").splitlines()]
    return "".join(f"* {sentence}\n" for sentence in sentences)


def _failures() -> str:
    """Failures with the command that provokes each; tests/test_failure_rows.py runs these commands."""
    rows = (
        (
            row.fails,
            row.does,
            f"`bearing_twin {row.command}`",
            f"`{row.chart}`",
        )
        for row in FAILURES
    )
    return _table(("what fails", "answer of the software", "command", "chart"), rows)


def _keys() -> str:
    """Every key, once for all kinds that have it with the same default and limits."""
    kinds: dict[tuple, list[str]] = {}
    for name, kind in SHIPPED_KINDS.items():
        for row in describe(kind.parameters):
            cells = (f"`{row.key}`", row.type, f"`{row.default}`", row.unit, row.limits, row.help)
            kinds.setdefault(cells, []).append(f"`{name}`")
    columns = {cells: "all" if len(names) == len(SHIPPED_KINDS) else ", ".join(names) for cells, names in kinds.items()}
    return _table(
        ("key", "type", "default", "unit", "limits", "meaning", "kinds"), ((*cells, columns[cells]) for cells in kinds)
    )


def _figures() -> str:
    rows = (
        (kind, f"`{key}`", label_and_unit(key)[1] or "-", meaning)
        for kind, entry in SHIPPED_KINDS.items()
        for key, meaning in entry.meanings_of().items()
    )
    return _table(("kind", "figure", "unit", "meaning"), rows)


def _node_parameters() -> str:
    """The parameters of the nodes; empty where ROS, which their modules need, is missing."""
    if not all(map(importlib.util.find_spec, ("rclpy", "bearing_twin_msgs"))):
        return ""
    tables = {name: importlib.import_module(f"bearing_twin.nodes.{name}").PARAMETERS for name in NODES}
    rows = (
        (f"`{node}`", f"`{row.name}`", f"`{row.default!r}`", row.unit or "-", "-" if row.read_only else "yes", row.help)
        for node, table in tables.items()
        for row in table
    )
    return _table(("node", "parameter", "default", "unit", "live", "meaning"), rows)


NODES = ("sim_node", "recorder_node", "replay_node", "uq_node", "watch_node")


def _topics() -> str:
    """The topics of every kind, and those that `sim_node` subscribes to."""
    parts = []
    for name, kind in SHIPPED_KINDS.items():
        parts.append(f"## {name}: {kind.help}\n\nNamespace `{kind.namespace}`, frame `{kind.frame}`.\n\n")
        parts.append(_table(stream.TopicRow._fields, (_in_code(*row) for row in stream.kind_rows(name))))
        if commands := kind.commands():
            rows = (
                _in_code(command.name, command.ros_type.replace("/msg/", "/"), command.frame or "-", command.meaning)
                for command in commands
            )
            parts.append("\nSubscribed by `sim_node`:\n\n")
            parts.append(_table(("command", "type", "frame", "meaning"), rows))
        parts.append("\n")
    return "\n" + "".join(parts)


def _in_code(name: str, ros_type: str, *rest: str) -> tuple[str, ...]:
    """A row of topics with name, type and frame as code."""
    *middle, frame, meaning = rest
    return f"`{name}`", f"`{ros_type}`", *middle, frame if frame == "-" else f"`{frame}`", meaning


TABLES: dict[str, Callable[[], str]] = {
    "scenes": _scenes,
    "studies": _studies,
    "kinds": _kinds,
    "laws": _laws,
    "ranges": _ranges,
    "rules": _rules,
    "unsourced": _unsourced,
    "frictions": _frictions,
    "models_of_kinds": _laws_of_kinds,
    "steppers": _steppers,
    "speeds": _speeds,
    "speeds_in_short": partial(_speeds, ("rodas4", "imex", "rk4", "radau")),
    "charts": _charts,
    "costs": _costs,
    "failures": _failures,
    **{f"reading_{name}": partial(_reading, name) for name in CHARTS},
    "quantities": _quantities,
    "distributions": _distributions,
    "knowledge": _knowledge,
    "samplers": _samplers,
    "keys": _keys,
    "figures": _figures,
    "node_parameters": _node_parameters,
    "topics": _topics,
}


def names_in(text: str) -> list[str]:
    """The names of the tables in a page."""
    return [match[1] for match in _MARKED.findall(text)]


def written(text: str) -> str:
    """The text of a page with its tables made again."""
    return _MARKED.sub(lambda match: f"{match[1]}{TABLES[match[2]]() or match[3]}{match[4]}", text)


def main() -> int:
    """Rewrite the pages whose tables have changed; return their number."""
    changed = 0
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        new = written(text)
        if new != text:
            page.write_text(new, encoding="utf-8")
            print(page.relative_to(ROOT))
            changed += 1
    return changed


if __name__ == "__main__":
    main()
    sys.exit(0)
