from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = "bearing_twin"


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
    long_description=Path("README.md").read_text(encoding="utf-8"),
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
        "numba>=0.59",
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
        "rerun": ["rerun-sdk>=0.41"],
        "view": ["playwright>=1.40", "imageio-ffmpeg>=0.5"],
    },
    package_data={PACKAGE: ["py.typed", "*.pyi"], f"{PACKAGE}.view": ["*.js", "*.css", "*.html", "libraries/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        *shared("config", "launch", "msg_schemas/msg", "msg_schemas/srv", "msg_schemas/action"),
    ],
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "bearing_twin = bearing_twin.command.cli:program",
            "sim_node = bearing_twin.nodes.entry:sim_node",
            "recorder_node = bearing_twin.nodes.entry:recorder_node",
            "replay_node = bearing_twin.nodes.entry:replay_node",
            "uq_node = bearing_twin.nodes.entry:uq_node",
            "watch_node = bearing_twin.nodes.entry:watch_node",
        ],
    },
)
