"""What a driver measures of a conveyor passes the guard, and nothing but numbers does."""

from __future__ import annotations

from typing import Any

import pytest

from pickcli.errors import InputError
from pickcli.simulation.belt_clock import BeltEncoder
from pickcli.simulation.guarded_driver import GuardedDriver
from support.small_cell import small_cell


class BareDriver:
    """As much of a driver as the guard asks for before the first set point."""

    def __init__(self) -> None:
        self.cell, self.time_step = small_cell("home"), 0.004


class MeasuringDriver(BareDriver):
    """A driver with the encoder of a belt, of whatever readings."""

    def __init__(self, travel: Any, latency: Any = 0.004) -> None:
        super().__init__()
        self.travel, self.latency = travel, latency

    def belt_travel(self, conveyor: str) -> Any:
        assert conveyor == "belt"
        return self.travel

    def encoder_latency(self, conveyor: str) -> Any:
        return self.latency


def guarded(driver: Any) -> GuardedDriver:
    return GuardedDriver("mine", driver)


def test_the_readings_of_an_encoder_pass() -> None:
    driver = guarded(MeasuringDriver(1.25))
    assert isinstance(driver, BeltEncoder)
    assert (driver.belt_travel("belt"), driver.encoder_latency("belt")) == (1.25, 0.004)
    assert guarded(MeasuringDriver(None)).belt_travel("belt") is None


def test_a_driver_without_an_encoder_measures_nothing() -> None:
    driver = guarded(BareDriver())
    assert (driver.belt_travel("belt"), driver.encoder_latency("belt")) == (None, 0.0)


@pytest.mark.parametrize("reading", [float("nan"), float("inf"), "1.0", True])
def test_a_reading_that_is_no_number_ends_the_run(reading: Any) -> None:
    with pytest.raises(InputError, match=r"driver mine: the travel of belt is .*, a finite number expected"):
        guarded(MeasuringDriver(reading)).belt_travel("belt")
    with pytest.raises(InputError, match="the latency of the encoder of belt is"):
        guarded(MeasuringDriver(0.0, reading)).encoder_latency("belt")
