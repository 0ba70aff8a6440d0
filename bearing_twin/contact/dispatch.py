"""From a table of functions to one compiled function that chooses among them by a row's place."""

from bearing_twin.code_linking import dispatcher
from bearing_twin.compiled import INLINED


def chosen(functions):
    """One compiled function of (place in the table, *arguments) that calls the function there."""
    names = {f"function_{place}": function for place, function in enumerate(functions)}
    lines = [f"    if number == {place}:\n        return {name}(*arguments)\n" for place, name in enumerate(names)]
    # Written out, as Numba calls no function that it takes from a list; the last stands for all numbers that are none.
    text = f"def choose(number, *arguments):\n{''.join(lines[:-1])}    return {list(names)[-1]}(*arguments)\n"
    exec(compile(text, __file__, "exec"), names)
    return dispatcher(names["choose"], INLINED)
