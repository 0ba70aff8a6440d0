"""The names in the tables of laws and of friction, for those who only read a scene.

The rows stand beside the functions they name, and those are compiled on import, which takes a second. So the words of
the rows are read off the tables' own text: one row is all that a new law needs, and a scene is read without a compiler.
"""

import ast
import functools
import importlib.util
from typing import NamedTuple

TABLES = {"Law": "bearing_twin.contact.laws", "FrictionModel": "bearing_twin.contact.friction"}

AUTO, POINT = "auto", "point"  # of contact.friction: to be chosen, and without a spot
MEASURED = {"stiffness": ("stiffness", "N/m"), "alpha": ("measured_alpha", "s (m/s)^0.2")}
"""What a law may need that only the user knows: the key of `contact` that gives it, and its unit."""


class Words(NamedTuple):
    """What a row says of itself: its name, a sentence, the contact it `fits` (point, line), and what it `needs`."""

    name: str
    help: str
    fits: str = ""
    needs: tuple[str, ...] = ()


@functools.cache
def words_of(row: str) -> dict[str, Words]:
    """The words of every row of the class `row`, "Law" or "FrictionModel", by name in the table's order."""
    text = importlib.util.find_spec(TABLES[row]).loader.get_source(TABLES[row])
    calls = (node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call))
    found = (call for call in calls if isinstance(call.func, ast.Name) and call.func.id == row)
    told = ({one.arg: one.value for one in call.keywords if one.arg in Words._fields} for call in found)
    rows = [Words(**{key: ast.literal_eval(value) for key, value in one.items()}) for one in told]
    return {one.name: one for one in rows}


def law_names(fits: str, given) -> tuple[str, ...]:
    """Names of the laws of a contact that `fits` "point" or "line", none of which needs more than is `given`."""
    return tuple(row.name for row in words_of("Law").values() if row.fits == fits and set(row.needs) <= set(given))


def friction_names() -> tuple[str, ...]:
    """Names of the friction models."""
    return tuple(words_of("FrictionModel"))


def numbers_missing(contact) -> list[str]:
    """What is wrong with the measured numbers of a scene's section `contact`: one its law needs, or one for no law."""
    rows, problems = words_of("Law"), []
    needs = rows[contact.normal].needs if contact.normal in rows else ()
    for need, (key, unit) in MEASURED.items():
        value = getattr(contact, key, 0.0)
        laws = " or ".join(row.name for row in rows.values() if need in row.needs)
        if need in needs and not value > 0.0:
            problems.append(f"contact.normal = {contact.normal} needs contact.{key} in {unit}; give one above zero")
        if need not in needs and value > 0.0:
            problems.append(f"contact.{key} = {value:g} {unit} needs contact.normal: {laws}; else leave it out")
    return problems
