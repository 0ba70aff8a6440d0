"""Architecture: the order of imports, where ROS is imported, no path outside the checkout."""

import ast
import functools
import re
from collections.abc import Iterable
from pathlib import Path

import pytest
from sources import PACKAGE, ROOT, nodes_of, package_trees, tree_of

import bearing_twin

# A module may import from its own room and from those above it in this list, never from those below.
ROOMS = (
    "base",
    "core",
    "methods",
    "coefficients",
    "shapes",
    "pictures",
    "contact",
    "vibration",
    "kinds",
    "run",
    "uq",
    "log",
    "charts",
    "view",
    "nodes",
    "command",
    "__main__",
)

CORE_ROOMS = (
    "math",
    "contact",
    "shapes",
    "methods",
    "bearing",
    "shaft",
    "bodies",
    "beam",
    "soft_discs",
    "api.cpp",
)  # in C++

NEVER_IMPORT = {
    ("nodes", "command"),
    ("command", "nodes"),
}
REACH_ROS = {"command/node_command.py"}  # imports rooms with ROS inside functions, when one of them runs
PHYSICS = ("methods", "coefficients", "shapes", "contact", "kinds")
NUMERICS_OF_UQ = {  # these know no files and no plots either
    *("distributions", "inputs", "sampling", "propagation", "statistics"),
}
NO_PHYSICS = {"datetime", "io", "logging", "matplotlib", "mcap", "os", "pathlib", "random", "rich", "time", "yaml"}
LATE_ROOMS = {
    "charts",
    "log",
    "nodes",
    "run",
    "uq",
    "vibration",
    "view",
}  # the command line imports these inside functions alone

ONLY_TESTS_REACH = {  # path below bearing_twin/: names, and their purpose
    "core.py": ("version", "the library in use, for logs and users"),
    "kinds/soft_discs/motion.py": ("elastic_forces", "the core's forces, for tests of them alone"),
    "contact/elasticity.py": ("CURVATURE_RATIO_MAX", "the range of the ellipse, which tests use"),
    "run/report.py": ("STATUSES", "every status and its meaning; tests compare runs with it"),
    "log/cdr.py": ("JOINT_STATE", "the name of a type; kinds name theirs in topics.py"),
}

SOURCES = sorted(PACKAGE.rglob("*.py"))


def room_of(path: Path) -> str:
    return path.relative_to(PACKAGE).with_suffix("").parts[0]


def imported(nodes: Iterable[ast.AST], path: Path):
    """(line, full module name) of every import among these nodes of a file's tree, `from a import b` as a.b."""
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}:{node.lineno}: write the full name of the module"
            yield from ((node.lineno, f"{node.module}.{alias.name}") for alias in node.names)


@functools.cache
def imports_of(path: Path) -> tuple[tuple[int, str], ...]:
    """(line, full module name) of every import in a file."""
    return tuple(imported(nodes_of(path), path))


def imports_at_top(path: Path) -> list[ast.AST]:
    return [node for node in tree_of(path).body if isinstance(node, (ast.Import, ast.ImportFrom))]


def own_rooms(imports):
    for line, name in imports:
        parts = name.split(".")
        if parts[0] == "bearing_twin" and len(parts) > 1 and not parts[1].startswith("__"):
            yield line, parts[1]


def test_imports_point_one_way():
    wrong = []
    for path in package_trees():
        for line, room in own_rooms(imports_of(path)):
            importer = room_of(path)
            allowed = importer != "__init__" and room in ROOMS and ROOMS.index(room) <= ROOMS.index(importer)
            reaches_ros = path.relative_to(PACKAGE).as_posix() in REACH_ROS and room == "nodes"
            if not allowed or ((importer, room) in NEVER_IMPORT and not reaches_ros):
                wrong.append(f"{path.relative_to(ROOT)}:{line} imports {room}")
    assert wrong == []


def test_modules_do_not_import_each_other_in_a_circle():
    """Imports inside functions count, too."""
    names = {".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path for path in SOURCES}
    imports = {}
    for name, path in names.items():
        full_names = {full_name for _, full_name in imports_of(path)}
        modules = {name if name in names else name.rpartition(".")[0] for name in full_names}
        imports[name] = modules & set(names) - {"bearing_twin"}
    while imports:
        free = [name for name, modules in imports.items() if not modules & set(imports) - {name}]
        assert free, f"these modules import each other in a circle: {sorted(imports)}"
        for name in free:
            del imports[name]


def test_a_kind_plots_in_its_picture_and_names_ros_types_in_its_topics():
    wrong = []
    for path in package_trees():
        if room_of(path) != "kinds":
            continue
        if path.stem != "picture":
            wrong += [f"{path}:{line}" for line, room in own_rooms(imports_of(path)) if room == "pictures"]
        if path.stem not in ("topics", "markers"):
            texts = [node for node in nodes_of(path) if isinstance(node, ast.Constant) and isinstance(node.value, str)]
            wrong += [f"{path}:{node.lineno}" for node in texts if re.fullmatch(r"\w+/(msg|srv)/\w+", node.value)]
    assert wrong == []


def test_ros_is_imported_only_by_the_nodes():
    ros = re.compile(r"rclpy|ament_\w+|rosidl\w*|launch\w*|builtin_interfaces|\w+_msgs|std_srvs|rcl_interfaces|tf2\w*")
    wrong = [
        f"{path.relative_to(ROOT)}:{line} imports {name}"
        for path in package_trees()
        for line, name in imports_of(path)
        if ros.fullmatch(name.split(".")[0]) and room_of(path) != "nodes"
    ]
    assert wrong == []


def test_physics_knows_no_files_no_clock_and_no_plots():
    wrong = [
        f"{path.relative_to(ROOT)}:{line} imports {name}"
        for path in package_trees()
        if (room_of(path) in PHYSICS and path.stem != "picture")
        or (room_of(path) == "uq" and path.stem in NUMERICS_OF_UQ)
        for line, name in imports_of(path)
        if name.split(".")[0] in NO_PHYSICS
    ]
    assert wrong == []


@pytest.mark.parametrize(
    "module",
    [
        "cli",
        "commands",
        "chart_command",
        "contact_command",
        "outcome",
        "study_command",
        "terminal",
        "view_commands",
        "scene_commands",
        "node_command",
    ],
)
def test_the_command_line_imports_late(module):
    path = PACKAGE / "command" / f"{module}.py"
    top = imports_at_top(path)
    assert {room for _, room in own_rooms(imported(top, path))} & LATE_ROOMS == set()
    assert {name.split(".")[0] for _, name in imported(top, path)} & {"scipy", "matplotlib", "rich"} == set()


def test_includes_of_the_core_point_one_way():
    wrong = []
    for path in (ROOT / "core").rglob("*.[ch]pp"):
        room = path.relative_to(ROOT / "core").parts[0]
        assert room in CORE_ROOMS, path
        for name in re.findall(r'^\s*#\s*include\s+"([^"]+)"', path.read_text(encoding="utf-8"), flags=re.MULTILINE):
            candidates = (path.parent / name, ROOT / "core" / name)
            header = next((candidate for candidate in candidates if candidate.is_file()), path)
            included = header.resolve().relative_to(ROOT / "core").parts[0]
            if CORE_ROOMS.index(included) > CORE_ROOMS.index(room):
                wrong.append(f"{path.relative_to(ROOT)} includes {name}")
    assert wrong == []


def test_public_functions_and_classes_have_a_sentence():
    undocumented = []
    for path, tree in package_trees().items():
        public = [node for node in tree.body if isinstance(node, (ast.FunctionDef, ast.ClassDef))]
        undocumented += [
            f"{path.relative_to(ROOT)}:{node.lineno} {node.name}"
            for node in public
            if not node.name.startswith("_") and not ast.get_docstring(node)
        ]
        if path.name != "__init__.py" and not ast.get_docstring(tree):
            undocumented.append(f"{path.relative_to(ROOT)}")
    assert undocumented == []


def names_used(node: ast.AST) -> set[str]:
    """The names used below a node, also those in texts such as "module:name", which tables have in place of imports."""
    names = set()
    for child in ast.walk(node):
        if isinstance(child, (ast.Name, ast.Attribute)):
            names.add(child.id if isinstance(child, ast.Name) else child.attr)
        elif isinstance(child, ast.Constant) and isinstance(child.value, str):
            names |= {match[1] for match in [re.search(r"[\w}.]*:(\w+)$", child.value)] if match}
    return names


def test_what_only_tests_reach_is_listed_or_gone():
    """Reached is what the public API, entry points, launch files and imports use."""
    defined, entries = (ast.FunctionDef, ast.ClassDef), PACKAGE / "nodes" / "entry.py"
    reached = {
        "main",
        "CONTESTS",
        *dir(bearing_twin),
        *(node.name for node in tree_of(entries).body if isinstance(node, defined)),
    }
    for path in (ROOT / "launch").glob("*.py"):
        reached |= {node.attr for node in nodes_of(path) if isinstance(node, ast.Attribute)}
    used_by, defined_in = {}, {}
    for path, tree in package_trees().items():
        for node in tree.body:
            names = names_used(node)
            if isinstance(node, ast.Assign):
                constants = {
                    target.id for target in node.targets if isinstance(target, ast.Name) and target.id.isupper()
                }
                defined_in.setdefault(path, set()).update(constants)
                names -= constants
            if isinstance(node, defined):
                used_by.setdefault(node.name, set()).update(names)
                defined_in.setdefault(path, set()).add(node.name)
            else:
                reached |= names
    waiting = list(reached)
    while waiting:
        new = used_by.get(waiting.pop(), set()) - reached
        reached |= new
        waiting += new
    listed = {name for names, _ in ONLY_TESTS_REACH.values() for name in names.split()}
    unreached = {}
    for path, names in defined_in.items():
        dead = {name for name in names - reached - listed if not name.startswith("_")}
        if dead and room_of(path) != "__init__":
            unreached[path.relative_to(PACKAGE).as_posix()] = dead
    assert unreached == {}


def test_nothing_points_outside_the_checkout():
    outside = re.compile(r"\.\./" + r"shared|(?<![\w./])/(home|root|Users|work)/\w")
    generated = {"build", "install", "log"}
    tops = [top for top in ROOT.iterdir() if top.name not in generated and (top.name[0] != "." or top.name == ".ci")]
    files = [path for top in tops for path in (top.rglob("*") if top.is_dir() else [top]) if path.is_file()]
    matches = []
    for path in files:
        content = path.read_bytes()
        if "__pycache__" not in path.parts and not path.parent.name.endswith(".egg-info") and b"\0" not in content:
            text = content.decode("utf-8", errors="replace")
            matches += [f"{path.relative_to(ROOT)}: {match.group()}" for match in outside.finditer(text)]
    assert len(files) > 10
    assert matches == []


def test_public_names_of_the_package_exist():
    import bearing_twin.run.simulation

    assert bearing_twin.simulate is bearing_twin.run.simulation.simulate
    for name in dir(bearing_twin):
        assert getattr(bearing_twin, name)
    with pytest.raises(AttributeError, match="no attribute 'simulat'"):
        bearing_twin.simulat  # noqa: B018


def test_tests_named_in_pages_and_code_exist():
    name = re.compile(r"\btests/[\w/]+\.py\b")
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]
    programs = [*PACKAGE.rglob("*.py"), *(ROOT / "bench").glob("*.py")]
    names = {path: name.findall(path.read_text(encoding="utf-8")) for path in (*pages, *programs)}
    assert sum(map(len, names.values())) > 10
    assert {str(path): test for path, tests in names.items() for test in tests if not (ROOT / test).exists()} == {}


# Rooms, whose docstring names the modules that others may import, deeper ones first.
FACES = sorted(
    (".".join(path.parent.relative_to(PACKAGE).parts) for path in PACKAGE.rglob("*/__init__.py")), reverse=True
)
BELOW_FACES = ("tests/core/", "tests/reference/")  # these may import any name


def folder_of(room: str) -> Path:
    return PACKAGE / room.replace(".", "/")


def face_of(room: str) -> dict[str, set[str]]:
    """The modules in a face, a line "* `module`: sentence." each, with the only names that others may use, if any."""
    text = ast.get_docstring(tree_of(folder_of(room) / "__init__.py"))
    entries = re.findall(r"^\* `(\w+)`: (.+?)(?=^\S|^$|\Z)", text, flags=re.MULTILINE | re.DOTALL)
    return {module: set(re.findall(r"`(\w+)`", sentence)) for module, sentence in entries}


def references(path: Path):
    """(line, full name) of what a file imports, takes from an imported module, or names in a text.

    By texts such as "bearing_twin.room.module:name" tables import and tests replace names.
    """
    yield from imports_of(path)
    imports = (node for node in nodes_of(path) if isinstance(node, ast.ImportFrom))
    modules = {alias.asname or alias.name: f"{node.module}.{alias.name}" for node in imports for alias in node.names}
    for node in nodes_of(path):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in modules:
            yield node.lineno, f"{modules[node.value.id]}.{node.attr}"
        elif isinstance(node, ast.Constant) and re.fullmatch(r"bearing_twin(\.\w+)+(:\w+)?", str(node.value)):
            yield node.lineno, node.value.replace(":", ".")


def uses_of_rooms(path: Path):
    """(line, room, module or name in its __init__, name or "") of what a file uses of other rooms."""
    own = next((room for room in FACES if path.is_relative_to(folder_of(room))), "")
    for line, full_name in references(path):
        room = next((room for room in FACES if f"{full_name}.".startswith(f"bearing_twin.{room}.")), own)
        if room != own:
            module, name, *_ = [*full_name.removeprefix(f"bearing_twin.{room}").lstrip(".").split("."), "", ""]
            yield line, room, module, name


def users() -> Iterable[Path]:
    """The package, its tests, but for those of algorithms, benchmarks and launch files."""
    paths = (
        path for folder in (PACKAGE, *map(ROOT.joinpath, ("tests", "bench", "launch"))) for path in folder.rglob("*.py")
    )
    return (path for path in paths if not path.relative_to(ROOT).as_posix().startswith(BELOW_FACES))


@functools.cache
def uses_of_faces() -> dict[tuple[str, str, str], list[str]]:
    """The places at which each module, or name of a module, is used from other rooms and tests."""
    uses = {}
    for path in users():
        for line, *use in uses_of_rooms(path):
            uses.setdefault(tuple(use), []).append(f"{path.relative_to(ROOT)}:{line}")
    return uses


def test_rooms_and_tests_import_what_faces_name():
    wrong = []
    for (room, module, name), places in uses_of_faces().items():
        names = face_of(room).get(module)
        if not (folder_of(room) / f"{module}.py").exists():
            allowed = not module.startswith("_")  # a name of __init__
        elif names:
            allowed = name in names | {""}
        else:
            allowed = names is not None and not name.startswith("_")
        if not allowed:
            used = ".".join(filter(None, (room, module, name)))
            wrong += [f"{place} uses {used}, which the docstring of {room} does not name" for place in places]
    assert wrong == []


@pytest.mark.parametrize("room", FACES)
def test_what_faces_name_is_used(room):
    used = {use[1:] for use in uses_of_faces() if use[0] == room}
    for module, names in face_of(room).items():
        assert module in {module for module, _ in used}
        assert names <= {name for used_module, name in used if used_module == module}


def imported_names(path: Path) -> set[str]:
    """Names that a module of the package has from others of it."""
    nodes = (node for node in imports_at_top(path) if isinstance(node, ast.ImportFrom))
    ours = (node for node in nodes if f"{node.module}.".startswith("bearing_twin."))
    return {alias.asname or alias.name for node in ours for alias in node.names}


def test_names_are_imported_from_the_module_that_defines_them():
    wrong = []
    for path in users():
        for line, full_name in imports_of(path):
            module, _, name = full_name.rpartition(".")
            folder = ROOT / module.replace(".", "/")
            home = folder / "__init__.py" if folder.is_dir() else folder.with_suffix(".py")
            if home.is_relative_to(PACKAGE) and home.exists() and name in imported_names(home):
                wrong.append(f"{path.relative_to(ROOT)}:{line} imports {full_name}")
    assert wrong == []
