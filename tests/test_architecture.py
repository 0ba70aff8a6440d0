"""The house: imports point one way, ROS stays in its room, nothing points outside the checkout."""

import ast
import functools
import importlib
import re
from collections.abc import Iterable
from pathlib import Path

import pytest
from sources import PACKAGE, ROOT, nodes_of, package_trees, tree_of

import bearing_twin

# A module may import from its own room and from those above it in this list, never from those below.
GROUND = ("base", "core")
ROOMS = (
    *GROUND,
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
    *(
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
    ),
)  # in C++

APART = {
    ("nodes", "command"),
    ("command", "nodes"),
}
REACH_ROS = {"command/node_command.py"}  # of the command line, inside functions: ROS is imported when one of them runs
PHYSICS = ("methods", "coefficients", "shapes", "contact", "kinds")
NUMBERS_OF_UQ = {  # these know no files and no plots either
    *("distributions", "inputs", "sampling", "propagation", "statistics", "histories"),
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
}  # what the command line may only import inside functions

ONLY_TESTS_REACH = {  # path below bearing_twin/: names, and until when, or what for
    "core.py": ("version", "the library in use, for logs and those who ask"),
    "kinds/soft_discs/motion.py": ("elastic_forces", "the core's forces, for tests of them alone"),
    "contact/elasticity.py": ("CURVATURE_RATIO_MAX", "how far the ellipse is known; tests go to that end"),
    "run/report.py": ("STATUSES", "what a status may say and means; tests hold every run to it"),
    "log/cdr.py": ("JOINT_STATE", "one of the names of types; kinds name theirs in topics.py"),
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
            here = room_of(path)
            allowed = here != "__init__" and room in ROOMS and ROOMS.index(room) <= ROOMS.index(here)
            reaches = path.relative_to(PACKAGE).as_posix() in REACH_ROS and room == "nodes"
            if not allowed or ((here, room) in APART and not reaches):
                wrong.append(f"{path.relative_to(ROOT)}:{line} imports {room}")
    assert wrong == []


def test_a_room_does_not_import_itself_in_a_circle():
    """Within a room, too: modules can be put in an order where each imports only earlier ones, also late."""
    names = {".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path for path in SOURCES}
    needs = {}
    for name, path in names.items():
        found = {one for _, one in imports_of(path)}
        needs[name] = {one if one in names else one.rpartition(".")[0] for one in found} & set(names) - {"bearing_twin"}
    while needs:
        free = [name for name, wanted in needs.items() if not wanted & set(needs) - {name}]
        assert free, f"these modules import each other in a circle: {sorted(needs)}"
        for name in free:
            del needs[name]


def test_a_kind_plots_in_its_picture_and_names_ros_types_in_its_topics():
    """`contract` names the default picture by its place."""
    wrong = []
    for path in package_trees():
        if room_of(path) != "kinds":
            continue
        if path.stem != "picture":
            wrong += [f"{path}:{line}" for line, room in own_rooms(imports_of(path)) if room == "pictures"]
        if path.stem not in ("topics", "markers"):
            texts = [one for one in nodes_of(path) if isinstance(one, ast.Constant) and isinstance(one.value, str)]
            wrong += [f"{path}:{one.lineno}" for one in texts if re.fullmatch(r"\w+/(msg|srv)/\w+", one.value)]
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
        or (room_of(path) == "uq" and path.stem in NUMBERS_OF_UQ)
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
        here = path.relative_to(ROOT / "core").parts[0]
        assert here in CORE_ROOMS, path
        for name in re.findall(r'^\s*#\s*include\s+"([^"]+)"', path.read_text(encoding="utf-8"), flags=re.MULTILINE):
            found = next((one for one in (path.parent / name, ROOT / "core" / name) if one.is_file()), path)
            room = found.resolve().relative_to(ROOT / "core").parts[0]
            if CORE_ROOMS.index(room) > CORE_ROOMS.index(here):
                wrong.append(f"{path.relative_to(ROOT)} includes {name}")
    assert wrong == []


def test_public_functions_and_classes_have_a_sentence():
    silent = []
    for path, tree in package_trees().items():
        public = [node for node in tree.body if isinstance(node, (ast.FunctionDef, ast.ClassDef))]
        silent += [
            f"{path.relative_to(ROOT)}:{node.lineno} {node.name}"
            for node in public
            if not node.name.startswith("_") and not ast.get_docstring(node)
        ]
        if path.name not in ("__init__.py",) and not ast.get_docstring(tree):
            silent.append(f"{path.relative_to(ROOT)}")
    assert silent == []


def words_of(node: ast.AST) -> set[str]:
    """The names used below a node.

    Those behind the colon of texts such as "module:name", too, which rows of tables give in place of imports.
    """
    words = set()
    for one in ast.walk(node):
        if isinstance(one, (ast.Name, ast.Attribute)):
            words.add(one.id if isinstance(one, ast.Name) else one.attr)
        elif isinstance(one, ast.Constant) and isinstance(one.value, str):
            words |= {found[1] for found in [re.search(r"[\w}.]*:(\w+)$", one.value)] if found}
    return words


def test_what_only_tests_reach_is_listed_or_gone():
    """From the public API, entry points, launch files and what runs on import."""
    defined, entries = (ast.FunctionDef, ast.ClassDef), PACKAGE / "nodes" / "entry.py"
    reached = {
        "main",
        "CONTESTS",
        *dir(bearing_twin),
        *(node.name for node in tree_of(entries).body if isinstance(node, defined)),
    }
    for path in (ROOT / "launch").glob("*.py"):
        reached |= {one.attr for one in nodes_of(path) if isinstance(one, ast.Attribute)}
    inside, named = {}, {}
    for path, tree in package_trees().items():
        for node in tree.body:
            words = words_of(node)
            if isinstance(node, ast.Assign):
                constants = {one.id for one in node.targets if isinstance(one, ast.Name) and one.id.isupper()}
                named.setdefault(path, set()).update(constants)
                words -= constants
            if isinstance(node, defined):
                inside.setdefault(node.name, set()).update(words)
                named.setdefault(path, set()).add(node.name)
            else:
                reached |= words
    waiting = list(reached)
    while waiting:
        new = inside.get(waiting.pop(), set()) - reached
        reached |= new
        waiting += new
    listed = {name for names, _ in ONLY_TESTS_REACH.values() for name in names.split()}
    found = {}
    for path, names in named.items():
        dead = {name for name in names - reached - listed if not name.startswith("_")}
        if dead and room_of(path) != "__init__":
            found[path.relative_to(PACKAGE).as_posix()] = dead
    assert found == {}


def test_nothing_points_outside_the_checkout():
    outside = re.compile(r"\.\./" + r"shared|(?<![\w./])/(home|root|Users|work)/\w")
    made = {"build", "install", "log"}
    tops = [top for top in ROOT.iterdir() if top.name not in made and (top.name[0] != "." or top.name == ".ci")]
    files = [path for top in tops for path in (top.rglob("*") if top.is_dir() else [top]) if path.is_file()]
    found = []
    for path in files:
        content = path.read_bytes()
        if "__pycache__" not in path.parts and not path.parent.name.endswith(".egg-info") and b"\0" not in content:
            text = content.decode("utf-8", errors="replace")
            found += [f"{path.relative_to(ROOT)}: {match.group()}" for match in outside.finditer(text)]
    assert len(files) > 10
    assert found == []


def test_public_names_of_the_package_are_what_they_say():
    import bearing_twin.run.simulation

    assert bearing_twin.simulate is bearing_twin.run.simulation.simulate
    for name in dir(bearing_twin):
        assert getattr(bearing_twin, name)
    with pytest.raises(AttributeError, match="no attribute 'simulat'"):
        bearing_twin.simulat  # noqa: B018


def test_tests_that_are_named_are_there():
    named = re.compile(r"\btests/\w+\.py\b")
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]
    programs = [*PACKAGE.rglob("*.py"), *(ROOT / "bench").glob("*.py")]
    texts = {path: named.findall(path.read_text(encoding="utf-8")) for path in (*pages, *programs)}
    assert sum(map(len, texts.values())) > 10
    assert {str(path): one for path, found in texts.items() for one in found if not (ROOT / one).exists()} == {}


FACES = ("bearing_twin.kinds.bearing",)  # rooms whose __init__.py names what others use, also other kinds


def test_tests_and_other_rooms_go_through_the_faces():
    wrong = []
    for path in (*(ROOT / "tests").glob("*.py"), *SOURCES, *(ROOT / "bench").glob("*.py")):
        for line, name in imports_of(path):
            for face in FACES:
                if path.is_relative_to(ROOT / face.replace(".", "/")):
                    continue
                below = name.removeprefix(f"{face}.").split(".") if name.startswith(f"{face}.") else []
                if len(below) > 1 or (below and (PACKAGE.parent / face.replace(".", "/") / f"{below[0]}.py").exists()):
                    wrong.append(f"{path.relative_to(ROOT)}:{line} imports {name}")
    assert wrong == []


@pytest.mark.parametrize("face", FACES)
def test_faces_name_what_is_there(face):
    room = importlib.import_module(face)
    assert all(getattr(room, name) is not None for name in room.__all__)
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        room.nothing  # noqa: B018
