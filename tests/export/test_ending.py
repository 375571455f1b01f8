"""How signals end the command, where a command with workers would show it by chance only."""

import signal
import subprocess
import sys

import pytest

#: A library's thread takes signals that the main thread blocks.
PROGRAM = """
import os, signal, subprocess, threading, time
from chiasm.export.ending import delayed, ended

threading.Thread(target=time.sleep, args=(60,), daemon=True).start()
with ended():
    with delayed():
        os.kill(os.getpid(), {signal})
        time.sleep(0.2)
        child = subprocess.run(["cat", "/proc/self/status"], capture_output=True, text=True)
        blocked = int(next(line for line in child.stdout.splitlines() if "SigBlk" in line).split()[1], 16)
        print("went on", blocked >> ({signal} - 1) & 1, flush=True)
    print("not ended")
"""


def run(number: int, before: str = "") -> tuple[int, str]:
    program = before + PROGRAM.format(signal=int(number))
    # A shell lets its background jobs ignore interrupts
    default = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
    process = subprocess.run(
        [sys.executable, "-c", default + program], capture_output=True, text=True, timeout=120
    )
    return process.returncode, process.stdout + process.stderr


@pytest.mark.parametrize(
    ("number", "message"),
    [(signal.SIGINT, "interrupted"), (signal.SIGTERM, "terminated"), (signal.SIGHUP, "terminated")],
)
def test_a_delayed_signal_ends_the_command_after_the_block(number: signal.Signals, message: str) -> None:
    assert run(number) == (128 + number, f"went on 1\nError: {message}\n")


def test_what_the_caller_ignores_stays_ignored() -> None:
    ignore = "import signal; signal.signal(signal.SIGHUP, signal.SIG_IGN)\n"
    assert run(signal.SIGHUP, ignore) == (0, "went on 1\nnot ended\n")


def test_a_limit_of_cpu_time_is_named_and_leaves_time_to_clean_up() -> None:
    program = """
import resource, time
from chiasm.export.ending import ended

resource.setrlimit(resource.RLIMIT_CPU, (int(time.process_time()) + 1, resource.RLIM_INFINITY))
with ended():
    try:
        while True:
            pass
    finally:
        start = time.process_time()
        while time.process_time() < start + 1.5:
            pass
        print("cleaned up", flush=True)
"""
    process = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
    assert process.stdout == "cleaned up\n"
    assert process.stderr == "Error: the limit of CPU time is used up (see `ulimit -t`)\n"
    assert process.returncode == 128 + signal.SIGXCPU
