"""Size of the sources, as `make size` prints it: `python bench/size.py [--constants]`.

Counted are tokens without comments, docstrings, indentation and line ends, in our own Python, C++ and JavaScript; a
string of more than 100 characters counts as its words. With `--constants`: every tuned number, which is one whose line
ends in `# tuned: REASON` (`// tuned: REASON` in C++ and JavaScript).
"""

import argparse
import ast
import io
import re
import sys
import tokenize
from collections.abc import Iterable, Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LONGEST_STRING = 100  # characters, beyond which a string is a text
SHORT_FILE = 80  # lines
SUFFIXES = (".py", ".cpp", ".hpp", ".h", ".js")
NOT_OURS = ("libraries", "__pycache__", "build")
PARTS = {  # what is counted together: the folders or files of it
    "package": ("bearing_twin", "core"),
    "tests": ("tests",),
    "bench": ("bench",),
    "beside": ("launch", "examples", "docs", ".ci", "setup.py"),
}
GENERATED_PAGES = ("reference.md", "topics.md", "notebook.md")
LAYOUT = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}
F_STRING = tuple(getattr(tokenize, f"FSTRING_{end}", None) for end in ("START", "END"))  # from Python 3.12 on
_C_TOKEN = re.compile(
    r"(?P<comment>//[^\n]*|/\*.*?\*/)|(?P<string>\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'|`(?:\\.|[^`\\])*`)"
    r"|[A-Za-z_$][\w$]*|\.?\d(?:[eEpP][+-]|[\w.'])*|[-+*/%&|^=<>!?:.]+|[^\s\w]",
    flags=re.DOTALL,
)
_GENERATED_TABLE = re.compile(r"<!-- (?:table: \w+|torture[\w: ]*) -->.*?<!-- end -->", flags=re.DOTALL)
_TUNED = re.compile(r"^(?P<code>.*\S)\s*(?:#|//) tuned: (?P<reason>.+)$")


def sources(folders: Iterable[str]) -> Iterator[Path]:
    """Our own source files below these folders of the checkout, sorted."""
    for folder in folders:
        top = ROOT / folder
        for path in [top] if top.is_file() else sorted(top.rglob("*")):
            if path.suffix in SUFFIXES and not set(NOT_OURS) & set(path.relative_to(ROOT).parts):
                yield path


def size_of(text: str, suffix: str) -> int:
    """Number of tokens of a source text, by the suffix of its file."""
    return sum(_python_tokens(text)) if suffix == ".py" else sum(_c_tokens(text))


def _string_tokens(string: str) -> int:
    return len(string.split()) if len(string) > LONGEST_STRING else 1


def _python_tokens(text: str) -> Iterator[int]:
    docstrings, depth, begin = _docstrings(ast.parse(text)), 0, (0, 0)
    lines = text.splitlines(keepends=True)
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == F_STRING[0]:
            begin = begin if depth else token.start
            depth += 1
        elif token.type == F_STRING[1]:
            depth -= 1
            if not depth:
                (first, left), (last, right) = begin, token.end
                rows = lines[first - 1 : last]
                rows[-1] = rows[-1][:right]
                yield _string_tokens("".join(rows)[left:])
        elif token.type == tokenize.STRING and not depth:
            yield 0 if token.start in docstrings else _string_tokens(token.string)
        elif token.type not in LAYOUT and not depth:
            yield 1


def _docstrings(tree: ast.Module) -> set[tuple[int, int]]:
    owners = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    first = [node.body[0] for node in ast.walk(tree) if isinstance(node, owners) and node.body]
    values = [node.value for node in first if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)]
    return {(value.lineno, value.col_offset) for value in values if isinstance(value.value, str)}


def _c_tokens(text: str) -> Iterator[int]:
    for token in _C_TOKEN.finditer(text):
        yield 0 if token["comment"] else _string_tokens(token["string"]) if token["string"] else 1


def room_of(path: Path) -> str:
    """The room of a file of the package: its folder there, of kinds the kind's, of modules at the top none."""
    parts = path.relative_to(ROOT).parts[:-1]
    if parts[0] == "core":
        return "/".join(parts[:2])
    return "/".join(parts[1 : 3 if parts[1:2] == ("kinds",) else 2]) or "(top)"


def row(name: str, paths: list[Path]) -> tuple[str, int, int, int, float]:
    """Name, tokens, files, lines and share of short ones among files that hold anything."""
    texts = {path: path.read_text(encoding="utf-8") for path in paths}
    tokens = sum(size_of(text, path.suffix) for path, text in texts.items())
    lines = [len(text.splitlines()) for text in texts.values()]
    filled = [count for count in lines if count]
    return name, tokens, len(paths), sum(lines), sum(count < SHORT_FILE for count in filled) / max(1, len(filled))


def words_by_hand() -> dict[str, int]:
    """Words of each page that is written by hand, without its generated tables."""
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
    texts = {page: page.read_text(encoding="utf-8") for page in pages if page.name not in GENERATED_PAGES}
    return {str(page.relative_to(ROOT)): len(_GENERATED_TABLE.sub("", text).split()) for page, text in texts.items()}


def constants() -> list[tuple[str, str, str]]:
    """Every tuned number of the package: location, line of code, reason."""
    tuned = []
    for path in sources(PARTS["package"]):
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
            if match := _TUNED.match(line):
                tuned.append((f"{path.relative_to(ROOT)}:{number}", match["code"].strip(), match["reason"]))
    return tuned


def main(arguments: list[str] | None = None) -> int:
    """Print the tables; always 0."""
    parser = argparse.ArgumentParser(prog="python bench/size.py", description="Size of the sources.")
    parser.add_argument("--constants", action="store_true", help="list the tuned numbers with their reasons")
    if parser.parse_args(arguments).constants:
        tuned = constants()
        for location, code, reason in tuned:
            print(f"{location}: {code}\n    {reason}")
        print(f"{len(tuned)} tuned numbers")
        return 0
    rooms: dict[str, list[Path]] = {}
    for path in sources(PARTS["package"]):
        rooms.setdefault(room_of(path), []).append(path)
    rows = [row(f"  {name}", paths) for name, paths in sorted(rooms.items())]
    totals = [row(name, list(sources(folders))) for name, folders in PARTS.items()]
    print(f"{'':24}{'tokens':>9}{'files':>7}{'lines':>8}   files below {SHORT_FILE} lines")
    for name, tokens, files, lines, short in [totals[0], *rows, *totals[1:]]:
        print(f"{name:24}{tokens:9}{files:7}{lines:8}{short:9.0%}")
    pages = words_by_hand()
    print(f"\n{sum(pages.values())} words on {len(pages)} pages by hand; {len(constants())} tuned numbers")
    return 0


if __name__ == "__main__":
    sys.exit(main())
