"""Subscriptions that are looked after by hand: cheaper than an executor that wakes for every message.

They can also be ended at any time, which an executor that waits for them would take for a fault.
"""

from collections.abc import Iterator
from contextlib import suppress

from rclpy._rclpy_pybind11 import InvalidHandle
from rclpy.callback_groups import CallbackGroup
from rclpy.subscription import Subscription


class TakenAside(CallbackGroup):
    """Subscriptions that no executor serves."""

    def can_execute(self, entity) -> bool:
        """Never."""
        return False

    def beginning_execution(self, entity) -> bool:
        """Never."""
        return False

    def ending_execution(self, entity) -> None:
        """Nothing was executed."""


def taken(subscription: Subscription) -> Iterator[tuple[bytes, dict]]:
    """Every message that waits, as bytes, with what the middleware says of it."""
    handle, message = subscription.handle, subscription.msg_type
    with suppress(InvalidHandle), handle:
        while (found := handle.take_message(message, True)) is not None:
            yield found
