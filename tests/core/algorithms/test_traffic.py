"""Rates and sizes of the messages of a topic, over a window."""

import pytest

from bearing_twin.base.units import label_and_unit
from bearing_twin.command.node_command import Traffic


def test_rate_and_sizes_are_those_of_the_window():
    traffic = Traffic(3)
    for time_s, size in ((0.0, 9000), (10.0, 10), (10.5, 20), (11.0, 30), (12.0, 40)):
        traffic.add(time_s, size)
    figures, sizes = traffic.periods(), traffic.sizes()
    assert (figures["messages"], figures["rate_hz"], figures["window"]) == (5, 1.5, 3)
    assert (figures["least_period_s"], figures["greatest_period_s"]) == (0.5, 1.0)
    assert figures["std_of_period_s"] == pytest.approx((2.0 / 36.0) ** 0.5)
    assert label_and_unit("bytes_per_s") == ("bytes", "1/s")  # in the table
    assert [sizes[row] for row in ("bytes_per_s", "mean_bytes", "least_bytes", "greatest_bytes")] == [45, 30, 20, 40]
