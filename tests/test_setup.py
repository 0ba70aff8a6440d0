"""Parts of `make setup`: stages that tell how long they take, and a ROS prefix that knows the package."""

import concurrent.futures
import importlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


def stage(folder, seconds, *command):
    arguments = [ROOT / ".ci" / "stage", folder / "said.txt", seconds, "a work", *command]
    return subprocess.run([str(argument) for argument in arguments], capture_output=True, text=True, check=False)


def test_a_stage_says_how_long_it_takes_and_keeps_its_output(tmp_path):
    done = stage(tmp_path, 7, "echo", "hello")
    assert (done.returncode, done.stdout) == (0, "")
    assert "a work, about 7 s; its output: " in done.stderr
    assert "a work: done in" in done.stderr
    assert (tmp_path / "said.txt").read_text() == "hello\n"


def test_a_stage_that_fails_shows_its_last_words(tmp_path):
    done = stage(tmp_path, 7, "bash", "-c", "echo this is why; exit 3")
    assert done.returncode == 3
    assert "   | this is why\n" in done.stderr
    assert "run make again" in done.stderr


def test_two_makes_in_one_folder_take_turns(tmp_path):
    alone = f"mkdir {tmp_path}/busy && sleep 0.5 && rmdir {tmp_path}/busy"
    with concurrent.futures.ThreadPoolExecutor() as pool:
        results = list(pool.map(lambda _: stage(tmp_path, 1, "bash", "-c", alone), range(2)))
    assert [result.returncode for result in results] == [0, 0]
    assert any("waits for another make" in result.stderr for result in results)


def test_a_prefix_knows_the_package_after_the_script_twice(tmp_path, monkeypatch):
    import ros  # noqa: F401  (skips where ROS is missing)

    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "sim_node").touch()
    (tmp_path / "share" / "bearing_twin").mkdir(parents=True)
    (tmp_path / "share" / "bearing_twin" / "launch").symlink_to(ROOT / "launch")
    for _ in range(2):
        subprocess.run([sys.executable, ROOT / ".ci" / "ament_index.py", tmp_path], check=True)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    packages = importlib.import_module("ament_index_python.packages")
    share = Path(packages.get_package_share_directory("bearing_twin"))
    walked = {name for _, _, names in os.walk(share) for name in names}  # as `ros2 launch` looks: it follows no links
    assert walked >= {path.name for path in (ROOT / "launch").glob("*.py")}
    assert (share / "config" / "sim_node.yaml").is_file()
    assert (share / "package.xml").samefile(ROOT / "package.xml")
    assert (Path(packages.get_package_prefix("bearing_twin")) / "lib" / "bearing_twin" / "sim_node").samefile(
        tmp_path / "bin" / "sim_node"
    )


@pytest.mark.environment
def test_the_package_is_found_beside_a_checkout_of_its_name(tmp_path):
    """Python looks where it is started first: folders of a checkout there are no part of the package."""
    (tmp_path / "bearing_twin" / "log").mkdir(parents=True)
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    command = [sys.executable, "-c", "import bearing_twin.log.bag as bag; print(bag.__file__)"]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert Path(done.stdout.strip()).name == "bag.py"


SOURCE = """
#include <bearing_twin_msgs/msg/contacts.hpp>
#include <iostream>
int main() {
  bearing_twin_msgs::msg::Contacts contacts;
  contacts.normal_load = {1.0, 2.0};
  std::cout << rosidl_generator_traits::name<bearing_twin_msgs::msg::Contacts>() << contacts.normal_load.size();
}
"""
PROJECT = """
cmake_minimum_required(VERSION 3.20)
project(reader CXX)
find_package(bearing_twin_msgs REQUIRED)
add_executable(reader main.cpp)
target_link_libraries(reader ${bearing_twin_msgs_TARGETS})
"""


@pytest.mark.environment
def test_env_bash_is_enough_for_a_cpp_program_with_our_messages(tmp_path):
    import ros  # noqa: F401

    (tmp_path / "main.cpp").write_text(SOURCE)
    (tmp_path / "CMakeLists.txt").write_text(PROJECT)
    relocate = ROOT / "cmake" / "relocate.cmake"
    lines = (
        f"source {ROOT}/env.bash",
        f"cmake -S . -B build -G Ninja -DCMAKE_PROJECT_INCLUDE={relocate} -Wno-dev >&2",
        "cmake --build build >&2",
        "build/reader",
    )
    environment = {key: os.environ[key] for key in ("PATH", "HOME")}
    bash = shutil.which("bash")
    done = subprocess.run(
        [bash, "-ec", "\n".join(lines)], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout == "bearing_twin_msgs/msg/Contacts2"
