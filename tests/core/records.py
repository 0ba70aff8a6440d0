"""Functions of all writers of records: the file, one line a case."""

import json
from pathlib import Path


def rounded(values, digits: int = 13):
    """Nested lists with so many digits of each number."""
    return [rounded(one, digits) for one in values] if isinstance(values, list) else float(f"{values:.{digits}g}")


def write(path: Path, cases, result) -> None:
    """Write `result(*case)` of every (name, *case); one that a scene refuses is left out, and said."""
    found = {}
    for name, *case in cases:
        try:
            found[name] = result(*case)
        except Exception as error:
            print(name, "refused:", error)
    lines = (f"{json.dumps(name)}: {json.dumps(one, separators=(',', ':'))}" for name, one in found.items())
    path.write_text("{\n" + ",\n".join(lines) + "\n}\n")
