"""What may brake a truck while it follows a plan, such as sensors that look for people."""

from __future__ import annotations

from typing import Protocol

from pickcli.driving.drive_tracking import TrackingController
from pickcli.geometry import Array


class DriveOverseer(Protocol):
    """Oversees one drive of one truck."""

    def brakes(self, true: Array, believed: Array, controller: TrackingController) -> bool:
        """Tell whether the truck brakes as hard as it can; asked once before each period of control.

        Args:
            true: (3,) m, m, rad: where the truck truly is.
            believed: (3,) m, m, rad: where it believes to be.
            controller: How it moves.

        Returns:
            Whether it brakes, and stands then.
        """

    @property
    def has_given_up(self) -> bool:
        """Whether the drive ends where the truck stands, as it was braked for too long."""
