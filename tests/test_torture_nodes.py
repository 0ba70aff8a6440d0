"""The tortures of nodes in a short form; their times are measured by `make torture` alone."""

import pytest
from ros import rclpy  # noqa: F401 - skips where there is no ROS
from torture_nodes import calls, cancels, frozen, goals, hostile, soak, stops

SHARES = {hostile: 0.03, frozen: 0.1}  # of others the least there is
# Processes are started, ended and stopped. That nodes end with whole logs, and goals with answers, other tests show.
SLOW = (soak, goals, frozen, stops)


@pytest.mark.parametrize(
    ("torture", "share"),
    [
        pytest.param(one, SHARES.get(one, 1e-3), marks=[pytest.mark.environment] if one in SLOW else [])
        for one in (hostile, frozen, goals, calls, cancels, stops, soak)
    ],
    ids=lambda one: getattr(one, "__name__", one),
)
def test_a_short_torture_of_nodes_loses_nothing(torture, share, tmp_path, quick_starts):
    found = torture(share, tmp_path)
    assert found.tried > 0
    assert (found.lost, found.silent) == (0, 0), found.figures
