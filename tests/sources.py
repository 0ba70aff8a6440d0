"""Python files of the checkout as syntax trees, each parsed once in a session, when the first test asks for it."""

import ast
import functools
import gc
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "bearing_twin"


@functools.cache
def tree_of(path: Path) -> ast.Module:
    """A file's tree, which nobody may change; to look for garbage in it would take longer than to parse."""
    gc.disable()
    try:
        return ast.parse(path.read_text(encoding="utf-8"))
    finally:
        gc.freeze()
        gc.enable()


@functools.cache
def nodes_of(path: Path) -> tuple[ast.AST, ...]:
    """All nodes of a file's tree, outer ones first."""
    return tuple(ast.walk(tree_of(path)))


@functools.cache
def package_trees() -> dict[Path, ast.Module]:
    """The trees of all files of the package by their paths, sorted."""
    return {path: tree_of(path) for path in sorted(PACKAGE.rglob("*.py"))}
