"""The names of the steppers, for those who only read a scene.

The methods stand beside functions that are compiled on import, which takes a second; so the keys of the table are read
off its text.
"""

import ast
import functools
import importlib.util

TABLE, HOME = "STEPPER_FACTS", "bearing_twin.numerics.steppers"


@functools.cache
def stepper_names() -> tuple[str, ...]:
    """Names of the integration methods, in the table's order."""
    tree = ast.parse(importlib.util.find_spec(HOME).loader.get_source(HOME))
    [table] = [
        node.value
        for node in tree.body
        if isinstance(node, ast.Assign) and any(isinstance(one, ast.Name) and one.id == TABLE for one in node.targets)
    ]
    return tuple(ast.literal_eval(key) for key in table.keys)
