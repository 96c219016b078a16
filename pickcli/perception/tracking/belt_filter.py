"""Kalman filter of a belt and of what rides on it.

All items ride on one belt, so there is one speed for all of them: whatever tells the speed, an item far
ahead or the encoder, tells where all items are. Cowley et al. (2013, III-E) gave new tracks the speed of
earlier ones; with the speed as a common state, their estimates and their errors stay connected throughout.
"""

from __future__ import annotations

import numpy as np

from pickcli.cell.conveyor import Conveyor
from pickcli.geometry import Array

STEADY = 1e-6  # (m/s2)2 s: the speed wanders by 1 mm/s in a second, about as the PR2's belt did (VI-A)
MANOEUVRE = 4.0  # standard deviations of mean speeds from which on the belt changes its speed
_SPEED, _TRAVEL, _N_BELT = 0, 1, 2  # components of the state that belong to the belt


class BeltFilter:
    """Estimates the speed and the travel of a belt, and the places of items along it.

    The state is (speed, travel, place of every item). The acceleration of the belt is white noise; items rest
    on it. If the mean speeds between readings of the encoder differ by more than those of a steady belt, it
    changes its speed by up to its greatest acceleration (manoeuvre detection: Bar-Shalom, Li, Kirubarajan,
    Estimation with Applications to Tracking and Navigation, 2001, section 11.2).

    Attributes:
        t: s, time of the state.
        t_read: s, time of the last reading of the encoder.

    Args:
        t: s, time of the first reading of the encoder.
        travel: m, that reading.
        belt: Figures of the conveyor.
        density: (m/s2)2 s, spectral density of the acceleration of a belt that runs steadily.
    """

    def __init__(self, t: float, travel: float, belt: Conveyor, density: float = STEADY) -> None:
        self.t = self.t_read = t
        self._read = travel
        self._before: tuple[float, float] | None = None  # mean speed and time between the last two readings
        self._density, self._max_acceleration = density, belt.max_acceleration
        self._reading_variance = belt.encoder_resolution**2 / 12.0
        self._mean: Array = np.array([0.0, travel])
        self._covariance: Array = np.diag([belt.max_speed**2, self._reading_variance])

    def copy(self) -> BeltFilter:
        """Return an independent filter in the same state."""
        other = object.__new__(BeltFilter)
        other.__dict__ |= self.__dict__
        return other

    @property
    def speed(self) -> tuple[float, float]:
        """Speed of the belt and its standard deviation, m/s."""
        return float(self._mean[_SPEED]), float(np.sqrt(self._covariance[_SPEED, _SPEED]))

    def place(self, k: int) -> tuple[float, float]:
        """Return where an item is along the belt.

        Args:
            k: Its number among the items.

        Returns:
            m from the infeed, and the standard deviation.
        """
        i = _N_BELT + k
        return float(self._mean[i]), float(np.sqrt(self._covariance[i, i]))

    def advance(self, t: float) -> None:
        """Predict the state at a later time, of a belt that runs steadily.

        Args:
            t: s.
        """
        self._predict(t, self._density)

    def read_encoder(self, t: float, travel: float) -> None:
        """Advance to a reading of the encoder, and correct the state by it.

        Args:
            t: s.
            travel: m.
        """
        dt = t - self.t_read
        if dt > 0.0:
            mean = (travel - self._read) / dt
            # White noise of this density changes the speed in that time as the greatest acceleration does.
            density = self._density if self._is_usual(mean, dt) else self._max_acceleration**2 * dt
            self._predict(t, density)
            self._before = mean, dt
        self._correct(_TRAVEL, travel, self._reading_variance)
        self.t_read, self._read = t, travel

    def _is_usual(self, mean: float, dt: float) -> bool:
        """Whether a mean speed over dt (s) differs from the one before no more than on a steady belt."""
        if self._before is None:
            return True
        before, dt_before = self._before
        per_reading = np.array([1.0 / dt, 1.0 / dt + 1.0 / dt_before, 1.0 / dt_before])
        variance = self._reading_variance * float(per_reading @ per_reading)
        return (mean - before) ** 2 <= MANOEUVRE**2 * (variance + self._density * (dt + dt_before) / 3.0)

    def _predict(self, t: float, density: float) -> None:
        dt, n = t - self.t, len(self._mean)
        F = np.eye(n)
        F[_TRAVEL:, _SPEED] = dt
        # The integrals of one acceleration move speed and places together.
        Q = np.full((n, n), dt**3 / 3.0)
        Q[_SPEED, :] = Q[:, _SPEED] = dt**2 / 2.0
        Q[_SPEED, _SPEED] = dt
        self._mean = F @ self._mean
        self._covariance = F @ self._covariance @ F.T + density * Q
        self.t = t

    def see(self, k: int, place: float, deviation: float) -> None:
        """Correct the state by the place of an item that was seen at its time.

        Args:
            k: Number of the item.
            place: m along the belt.
            deviation: m, standard deviation of the error.
        """
        self._correct(_N_BELT + k, place, deviation**2)

    def add(self, place: float, deviation: float) -> None:
        """Add an item that is seen for the first time, as the last one.

        Args:
            place: m along the belt.
            deviation: m, standard deviation of the error.
        """
        n = len(self._mean)
        self._mean = np.append(self._mean, place)
        covariance = np.zeros((n + 1, n + 1))
        covariance[:n, :n], covariance[n, n] = self._covariance, deviation**2
        self._covariance = covariance

    def remove(self, k: int) -> None:
        """Remove an item; those after it get the numbers before theirs.

        Args:
            k: Its number.
        """
        keep = np.arange(len(self._mean)) != _N_BELT + k
        self._mean, self._covariance = self._mean[keep], self._covariance[np.ix_(keep, keep)]

    def _correct(self, i: int, value: float, variance: float) -> None:
        """Correct the state by a measured component; Joseph's form keeps the covariance positive."""
        gain = self._covariance[:, i] / (self._covariance[i, i] + variance)
        self._mean = self._mean + gain * (value - self._mean[i])
        left = np.eye(len(gain))
        left[:, i] -= gain
        self._covariance = left @ self._covariance @ left.T + variance * np.outer(gain, gain)
