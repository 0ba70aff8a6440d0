import os
import sys
from pathlib import Path

from setuptools import Extension, find_packages, setup
from setuptools.command.build_ext import build_ext

try:
    from setuptools.command.bdist_wheel import bdist_wheel
except ImportError:  # setuptools before 70.1, as that of ROS 2 Jazzy's system, where colcon makes no wheels
    bdist_wheel = object

PACKAGE = "bearing_twin"
HERE = Path(__file__).resolve().parent  # colcon runs a link to this file elsewhere
CORE = HERE / "core"
sys.path.insert(0, str(CORE))  # builds by pip do not look here
import build as core  # noqa: E402


class CoreLibrary(build_ext):
    """The compiled core, built by core/build.py into the package: in place for editable and symlinked installations.

    For the machine at hand, or for the instruction sets of $BEARING_TWIN_MARCH, with blanks between; "all" for a wheel.
    """

    def run(self):
        """Build it; without a compiler the installation ends with a sentence."""
        in_place = self.inplace or getattr(self, "editable_mode", False)
        target = Path("" if in_place else self.build_lib, PACKAGE, core.PACKAGE.name)
        if not core.compiler():
            sys.exit(
                f"{PACKAGE} has a core in C++ and no compiler is found: install one (Debian: apt install g++), or a "
                "wheel, which `make wheel` makes in a checkout on another machine"
            )
        core.build(target, os.environ.get("BEARING_TWIN_MARCH", "native").split())

    def get_outputs(self):
        """Files that are installed, beyond those of build_py."""
        return [str(path) for path in Path(self.build_lib, PACKAGE, core.PACKAGE.name).glob("*.so")]

    def get_output_mapping(self):
        """None of them stands for a file of the sources."""
        return {}

    def get_source_files(self):
        """What an archive of the sources must hold."""
        return [str(path.relative_to(HERE)) for path in core.sources()]


class PlatformWheel(bdist_wheel):
    """A wheel for every Python of a platform: the library knows nothing of Python."""

    def get_tag(self):
        """Python, its binary interface, platform."""
        return "py3", "none", super().get_tag()[2]


def shared(*folders: str) -> list[tuple[str, list[str]]]:
    """The files of `folders`, with those of every folder below, as data files under share/bearing_twin."""
    by_folder: dict[str, list[str]] = {}
    for path in sorted(file for folder in folders for file in Path(folder).rglob("*") if file.is_file()):
        if "__pycache__" not in path.parts:
            by_folder.setdefault(f"share/{PACKAGE}/{path.parent}", []).append(str(path))
    return sorted(by_folder.items())


setup(
    name=PACKAGE,
    version="0.1.0",
    description="Digital twin of a ball bearing: ball wrenches and contact ellipses on ROS 2 topics and in MCAP logs.",
    long_description=(HERE / "README.md").read_text(encoding="utf-8"),
    long_description_content_type="text/markdown",
    author="bearing_twin developers",
    author_email="bearing-twin@example.org",
    maintainer="bearing_twin developers",
    maintainer_email="bearing-twin@example.org",
    license="Apache-2.0",
    license_files=["LICENSE"],
    keywords=["ball bearing", "digital twin", "contact mechanics", "Hertz", "ROS 2", "MCAP", "uncertainty"],
    classifiers=[
        "Development Status :: 4 - Beta",
        "Environment :: Console",
        "Intended Audience :: Science/Research",
        "Intended Audience :: Manufacturing",
        "Natural Language :: English",
        "Operating System :: POSIX :: Linux",
        "Programming Language :: Python :: 3",
        *(f"Programming Language :: Python :: 3.{minor}" for minor in range(10, 14)),
        "Topic :: Scientific/Engineering :: Physics",
    ],
    python_requires=">=3.10,<3.14",
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    install_requires=[
        "setuptools",
        "numpy>=1.26",
        "scipy>=1.11",
        "matplotlib>=3.6",
        "PyYAML>=6.0",
        "mcap>=1.2",
        "rosbags>=0.11",
        "lz4>=4.0",
        "zstandard>=0.22",
        "rich>=13.0",
    ],
    extras_require={
        "chaos": ["chaospy>=4.3"],
        "completion": ["argcomplete>=3.1"],
        "dask": ["distributed>=2024.1"],
        "fast": ["zlib-ng>=1.0"],  # CRC of logs
        "export": ["pandas>=2.2", "pyarrow>=15.0", "xarray>=2024.3", "h5netcdf>=1.3", "h5py>=3.10"],
        "view": ["playwright>=1.40"],
    },
    package_data={PACKAGE: ["py.typed", "*.pyi"], f"{PACKAGE}.view": ["*.js", "*.css", "*.html", "libraries/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        *shared("config", "launch", "msg_schemas/msg", "msg_schemas/srv", "msg_schemas/action"),
    ],
    ext_modules=[Extension(f"{PACKAGE}.{core.PACKAGE.name}", [])],
    cmdclass={"build_ext": CoreLibrary} | ({} if bdist_wheel is object else {"bdist_wheel": PlatformWheel}),
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "bearing_twin = bearing_twin.__main__:program",
            "sim_node = bearing_twin.nodes.entry:sim_node",
            "recorder_node = bearing_twin.nodes.entry:recorder_node",
            "replay_node = bearing_twin.nodes.entry:replay_node",
            "uq_node = bearing_twin.nodes.entry:uq_node",
            "watch_node = bearing_twin.nodes.entry:watch_node",
        ],
    },
)
