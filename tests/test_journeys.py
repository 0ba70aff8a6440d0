"""Two newcomers follow README and tutorials literally: one with pip alone, one who owns a ROS 2 Jazzy.

(a) runs in the environment that `make setup` made: every shell line of the ROS part, nodes in shells of their own. What
needs no ROS is installed from a wheel and runs in an environment of its own, by another user, with empty caches and
without a compiler.
(b) is emulated by two Pythons, because PyPI has no Debian packages: one has ROS 2, colcon and the system's numpy, the
other is the virtual environment of the recipe, which sees the packages of the first. There is no ros2: nodes start
from where `ros2 run` looks. What only `ros2` does is not run here.
"""

import contextlib
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from pages import LASTING, NODE, ROOT, TUTORIALS, Shell, blocks, copied_sources

pytestmark = pytest.mark.environment
README = ROOT / "README.md"
ENDLESS = ("topic echo",)  # these end with Ctrl-C; here after one message


@pytest.fixture
def shell(tmp_path):
    import ros  # noqa: F401  (skips where ROS is missing)

    shell = Shell(tmp_path)
    yield shell
    for node in shell.nodes:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(node.pid, signal.SIGKILL)
        node.wait()


def lines_of(section: str) -> list[str]:
    """The shell lines of the first block below this heading of the README."""
    text = README.read_text(encoding="utf-8").partition(f"## {section}\n")[2]
    block = re.search(r"```bash\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE)[1]
    return [line.split("  #")[0].strip() for line in block.splitlines()]


def ended(line: str) -> str:
    """A line that a reader ends with Ctrl-C, ended after one message."""
    return f"{line} --once" if any(command in line for command in ENDLESS) and "--once" not in line else line


def test_the_ros_part_of_the_readme_runs_line_by_line(shell):
    """As it stands; only Ctrl-C, which a comment asks for, is not a line."""
    for line in lines_of("With ROS 2"):
        if "replay_node" in line:
            shell.end()  # sim_node and recorder_node, which completes its log
            assert (shell.folder / "recording.mcap").stat().st_size > 50_000, shell.words_of_nodes()
        output = shell.run(ended(line))
        assert output.strip() or line.startswith(LASTING), line
    shell.end()


@pytest.mark.parametrize(
    "page", [page for page in TUTORIALS if NODE in page.read_text("utf-8")], ids=lambda page: page.stem
)
def test_tutorials_with_nodes_run_literally(page, shell):
    for block in blocks(page):
        if block.file:
            (shell.folder / block.file).write_text(block.text, encoding="utf-8")
        for line in block.lines if block.language == "bash" else ():
            shell.run(ended(line))
    shell.end()


# (a) with pip alone

NOBODY = 65534
SLOW = ("chart ",)  # minutes
TOOLS = ("sh", "bash", "env", "uname", "cat", "ls", "dirname", "mkdir", "rm")  # no compiler


@pytest.fixture
def stranger():
    """A function (words) that runs them as another user where we may, in an empty home, without a compiler."""
    home = Path(tempfile.mkdtemp(prefix="newcomer_"))
    (home / "tools").mkdir()
    for tool in filter(shutil.which, TOOLS):
        (home / "tools" / tool).symlink_to(shutil.which(tool))
    user = {"user": NOBODY, "group": NOBODY, "extra_groups": []} if os.geteuid() == 0 else {}
    if user:
        os.chown(home, NOBODY, NOBODY)
    environment = {"HOME": str(home), "PATH": f"{home}/venv/bin:{home}/tools", "LANG": "C.UTF-8", "MPLBACKEND": "Agg"}

    def run(*command) -> subprocess.CompletedProcess:
        return subprocess.run(command, cwd=home, env=environment, capture_output=True, text=True, check=False, **user)

    run.home = home
    yield run
    shutil.rmtree(home)


def python_of(run) -> str:
    """A Python that this user may run and that makes virtual environments."""
    for python in (sys.executable, "/usr/bin/python3"):
        with contextlib.suppress(OSError):
            result = run(python, "-c", "import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 10))")
            if result.returncode == 0:
                return os.path.realpath(python)
    return pytest.skip("there is no Python 3.10 with venv that another user may run")


def test_what_needs_no_ros_runs_line_by_line_in_a_fresh_environment(stranger, tmp_path):
    copied_sources(tmp_path / "source")
    wheels = stranger.home / "wheels"
    make = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", wheels, tmp_path / "source"]
    result = subprocess.run(make, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    [wheel] = wheels.glob("*.whl")
    for command in (
        [python_of(stranger), "-m", "venv", "venv"],
        ["venv/bin/pip", "install", "--quiet", "--retries", "20", "--timeout", "60", str(wheel)],
    ):
        result = stranger(*command)
        assert result.returncode == 0, result.stdout + result.stderr
    assert stranger("bash", "-c", "command -v cc gcc g++ c++ clang").returncode != 0
    for line in lines_of("Without ROS"):
        if any(command in line for command in SLOW):
            continue
        done = stranger("bash", "-c", line)
        assert done.returncode == 0, f"{line}\n{done.stdout}{done.stderr}"
        assert done.stdout.strip(), line
        assert "Traceback" not in done.stderr, done.stderr


# (b) the workspace


def test_the_workspace_recipe_makes_nodes_that_run(tmp_path):
    """Two Pythons: see the top of this file. The lines are those of the README, but for `ros2`."""
    if shutil.which("g++") is None:
        pytest.skip("there is no C++ compiler here")
    system, source = tmp_path / "system", tmp_path / "ws" / "src" / "bearing_twin"
    keep = {key: os.environ[key] for key in ("HOME", "LANG") if key in os.environ}
    environment = keep | {
        "XDG_CACHE_HOME": str(tmp_path / "cache"),
        "PATH": f"{system}/bin:/usr/local/bin:/usr/bin:/bin",
    }

    def run(line: str, **variables) -> subprocess.CompletedProcess:
        return subprocess.run(
            ["bash", "-c", line],
            cwd=tmp_path / "ws",
            env=environment | variables,
            capture_output=True,
            text=True,
            check=False,
        )

    def done(line: str, **variables) -> str:
        result = run(f"set -e; {line}", **variables)
        assert result.returncode == 0, f"{line}\n{result.stdout[-3000:]}{result.stderr[-3000:]}"
        return result.stdout

    copied_sources(source)
    requirements = source / "requirements"
    done(f"{sys.executable} -m venv {system}", PATH=os.environ["PATH"])
    pip = f"{system}/bin/pip install -q --retries 20 --timeout 60"
    done(
        f"{pip} -r {requirements}/ros.txt -r {requirements}/build.txt "
        "numpy==1.26.4 scipy matplotlib PyYAML setuptools==68.1.2"
    )

    recipe = [line for line in lines_of_workspace() if not line.startswith("ros2")]
    recipe = [line.replace("~/twin_venv", str(tmp_path / "twin_venv")) for line in recipe]
    make, install, build, source_it = recipe
    # what --system-site-packages does for Debian's Python, for one that lives in a virtual environment itself
    seen = f"import site; site.addsitedir({str(next((system / 'lib').glob('python3*')) / 'site-packages')!r})"
    path_file = f"{tmp_path}/twin_venv/lib/python3.{sys.version_info.minor}/site-packages/system.pth"
    # what /opt/ros/jazzy/setup.bash sets; the wheels keep libraries of others in folders of their own
    libraries = ":".join(map(str, [system / "lib", *(system / "lib").glob("python3*/site-packages/ros_*.libs")]))
    environment |= {"AMENT_PREFIX_PATH": str(system), "ROS_DISTRO": "jazzy", "LD_LIBRARY_PATH": libraries}
    (tmp_path / "colcon.yaml").write_text(
        f"build: {{cmake-args: [-DCMAKE_PROJECT_INCLUDE={source}/cmake/relocate.cmake, -DBUILD_TESTING=OFF, -Wno-dev]}}"
    )
    environment["COLCON_DEFAULTS_FILE"] = str(tmp_path / "colcon.yaml")
    make = make.replace("python3 -m venv", f"{system}/bin/python3 -m venv")
    done(f"{make}; echo {seen!r} > {path_file}; {install}; {build}")
    node = tmp_path / "ws" / "install" / "bearing_twin" / "lib" / "bearing_twin" / "sim_node"
    assert node.read_text().startswith(f"#!{tmp_path}/twin_venv/bin/python")
    start = f"{source_it}; {node} --ros-args -p scene:=two_spheres"
    done(f"{start} -p log:={tmp_path}/run.mcap", ROS_DOMAIN_ID=os.environ["ROS_DOMAIN_ID"])
    assert (tmp_path / "run.mcap").stat().st_size > 1000

    node.write_text(node.read_text().replace(f"{tmp_path}/twin_venv/bin/python", f"{system}/bin/python"))
    result = run(start)
    assert result.returncode == 2
    assert re.fullmatch(r"sim_node: the Python package \w+ is not installed for .*rosdep.*\n", result.stderr), (
        result.stderr
    )


def lines_of_workspace() -> list[str]:
    """The block of the README that makes a workspace."""
    text = README.read_text(encoding="utf-8")
    block = next(
        block for block in re.findall(r"```bash\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE) if "colcon" in block
    )
    return [line.split("  #")[0].strip() for line in block.splitlines()]
