"""Contenders take turns: a busy moment of the machine affects all of them, and a slow contender does not use
the others' time."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping
from typing import NamedTuple

#: seconds until another contender's threads sleep; contenders with calls too short to wake up the machine
#: call for as long
PAUSE = 0.02
LEAST = 3


class Time(NamedTuple):
    """The median milliseconds of a call, and the number of calls."""

    ms: float
    repeats: int


def race(
    calls: Mapping[str, Callable[[], object]], repeats: int, seconds: float, turns: int, pause: bool
) -> dict[str, Time]:
    """Each call `repeats` times, or as often as `seconds` allow, spread evenly over the turns.

    Each turn begins with a call that does not count, which fills the caches, unless calls take long.
    """
    wanted, taken, times = {}, {}, {}
    for name, call in calls.items():
        call()  # the first call makes the objects that are reused
        begin = time.perf_counter()
        call()
        taken[name] = time.perf_counter() - begin
        long = taken[name] * LEAST > seconds  # then this call counts too
        times[name] = [taken[name]] if long else []
        wanted[name] = LEAST - 1 if long else min(int(seconds / max(taken[name], 1e-7)), repeats)
    for turn in range(turns):
        for name, call in calls.items():
            count = wanted[name] * (turn + 1) // turns - wanted[name] * turn // turns
            if count == 0:
                continue
            if pause:
                time.sleep(PAUSE)
            until = time.perf_counter() + (PAUSE / 2 if pause else 0)
            while taken[name] < PAUSE:
                call()
                if time.perf_counter() >= until:
                    break
            for _ in range(count):
                begin = time.perf_counter()
                call()
                times[name].append(time.perf_counter() - begin)
    return {name: Time(1e3 * statistics.median(t), len(t)) for name, t in times.items()}
