"""The tortures of nodes in a short form; their times are measured by `make torture` alone."""

import pytest
from ros import rclpy  # noqa: F401 - skips where there is no ROS
from torture_nodes import cancels, ends, frozen, goals, hostile, restarts, soak

SLOW = (goals, 0.1), (cancels, 0.03), (ends, 0.1), (restarts, 0.1), (soak, 0.01)


@pytest.mark.parametrize(
    ("torture", "share"),
    [
        (hostile, 0.03),
        (frozen, 0.1),
        *(pytest.param(one, share, marks=pytest.mark.environment) for one, share in SLOW),
    ],
    ids=lambda one: getattr(one, "__name__", one),
)
def test_a_short_torture_of_nodes_loses_nothing(torture, share, tmp_path):
    found = torture(share, tmp_path)
    assert found.tried > 0
    assert (found.lost, found.silent) == (0, 0), found.figures
