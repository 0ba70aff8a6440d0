"""The state of what a module is compiled from: a digest of its own text and of all that it imports.

The digest is of syntax trees without comments, docstrings and line numbers, so that an edit of those changes nothing.
It follows the imports at the top of a module through the module's own package, `bearing_twin` and, for a module outside
any package, the files beside it, because a compiled function contains the functions and constants that it takes from
there; Numba itself does not notice when they change.
It knows no paths: two checkouts of equal sources have equal states.
"""

import ast
import hashlib
import importlib.util
import os
import platform
import sys
from pathlib import Path

OWN = "bearing_twin"
# These keep what was compiled and do not change it.
_WITHOUT_EFFECT = {f"{OWN}.code_cache", f"{OWN}.source_state"}

_imported: dict[str, tuple[str, tuple]] = {}  # module: its file and that file's stamp when it was imported


def note_imported(module: str) -> None:
    """Remembers the files of what `module` and its neighbours were imported from, as they are now.

    Called while `module` is imported: a file edited later is no longer what this process compiles.
    """
    if module in _imported:
        return
    tops = {OWN, module.partition(".")[0]}
    for name, found in list(sys.modules.items()):
        if name not in _imported and name.partition(".")[0] in tops and (path := getattr(found, "__file__", None)):
            _imported[name] = (path, _stamp(path))


def state_of(module: str, known: dict) -> str | None:
    """40 hexadecimal digits for what `module` is compiled from; None if that cannot be told from its files.

    `known` holds what parsing gave for each text and is added to. A file that was edited after its import, that is
    not there or that is no Python has no state.
    """
    tops = {OWN, module.partition(".")[0]}
    beside = None if "." in module else _file_of(module)
    trees, outside, wanted = {}, set(), [module]
    while wanted:
        name = wanted.pop()
        if name in trees or name in _WITHOUT_EFFECT:
            continue
        path = _file_of(name)
        if path is None:
            if name == module:
                return None
            continue
        try:
            stamp, text = _stamp(path), Path(path).read_bytes()
            if stamp != _imported.get(name, (path, stamp))[1]:
                return None
            trees[name], imports = _read(text, known)
            package = name if Path(path).stem == "__init__" else name.rpartition(".")[0]
            imports = [(importlib.util.resolve_name(source, package), member) for source, member in imports]
        except (OSError, ValueError, SyntaxError, ImportError):
            return None
        for source, member in imports:
            top = source.partition(".")[0]
            if top in tops or (beside and Path(beside).with_name(f"{top}.py").is_file()):
                tops.add(top)
                inner = f"{source}.{member}"
                wanted.append(inner if member and _file_of(inner) else source)
            else:
                outside.add(top)
    versions = {top: getattr(sys.modules.get(top), "__version__", "") for top in outside}
    whole = repr((sorted(trees.items()), sorted(versions.items())))
    return hashlib.sha256(whole.encode()).hexdigest()[:40]


def _stamp(path) -> tuple:
    try:
        status = os.stat(path)
    except OSError:
        return ()
    return status.st_mtime_ns, status.st_size, status.st_ino


def _file_of(name: str) -> str | None:
    """The file of a module, imported or not; without asking the import system, which would import its parents."""
    if name in _imported:
        return _imported[name][0]
    top, *parts = name.split(".")
    found = sys.modules.get(top)
    if not parts:
        return getattr(found, "__file__", None)
    for folder in getattr(found, "__path__", ()):
        # Thousands of times at a start: paths as objects would take a tenth of a second.
        place = os.path.join(folder, *parts)
        for path in (f"{place}.py", os.path.join(place, "__init__.py")):
            if os.path.isfile(path):
                return path
    return None


def _read(text: bytes, known: dict):
    """(digest of the syntax tree, [(module, member or ""), ...] imported at the top) of one source."""
    # The form of a syntax tree belongs to a version of Python.
    key = hashlib.sha256(platform.python_version().encode() + b"\n" + text).hexdigest()
    if key not in known:
        tree = ast.parse(text)
        imports = sorted(set(_imports(tree.body)))
        for node in ast.walk(tree):
            if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
                first = node.body[0] if node.body else None
                if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
                    del node.body[0]
        known[key] = (hashlib.sha256(ast.dump(tree).encode()).hexdigest(), imports)
    return known[key]


def _imports(statements):
    """(module, member or "") of every import outside functions and classes; leading dots are kept."""
    for node in statements:
        if isinstance(node, ast.Import):
            for alias in node.names:
                parts = alias.name.split(".")
                yield from ((".".join(parts[: n + 1]), "") for n in range(len(parts)))
        elif isinstance(node, ast.ImportFrom):
            source = "." * node.level + (node.module or "")
            yield from ((source, "" if alias.name == "*" else alias.name) for alias in node.names)
        elif isinstance(node, (ast.If, ast.Try, ast.With)):
            handlers = [line for handler in getattr(node, "handlers", ()) for line in handler.body]
            yield from _imports([*node.body, *getattr(node, "orelse", ()), *handlers, *getattr(node, "finalbody", ())])
