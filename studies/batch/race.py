"""Contenders in turns: a busy moment of the machine hits all of them, and a slow one does not take the
others' time."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping
from typing import NamedTuple

#: seconds that another's threads get to fall asleep in, and those that call too short to wake a machine up
#: take instead
PAUSE = 0.02
LEAST = 3


class Time(NamedTuple):
    """Median milliseconds of a call, of so many."""

    ms: float
    repeats: int


def race(
    calls: Mapping[str, Callable[[], object]], repeats: int, seconds: float, turns: int, pause: bool
) -> dict[str, Time]:
    """Each call `repeats` times, or as often as `seconds` allow, spread evenly over the turns.

    Each turn begins with a call that does not count, which brings what it needs back into the caches, unless
    calls take long.
    """
    wanted, taken, times = {}, {}, {}
    for name, call in calls.items():
        call()  # the first one makes what is kept
        begin = time.perf_counter()
        call()
        taken[name] = time.perf_counter() - begin
        long = taken[name] * LEAST > seconds  # so that this one counts, too
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
