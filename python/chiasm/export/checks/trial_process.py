"""Runs the self-tests of the bundles that standard input names, and writes their rows (checks/trial.py)."""

import sys

sys.path[:] = [path for path in sys.path if path]  # the working folder may hold a json.py

import contextlib  # noqa: E402
import json  # noqa: E402
import os  # noqa: E402
import threading  # noqa: E402
import time  # noqa: E402


def watch(parent: int) -> None:
    """End with the parent, whichever of its threads began this process, even while an artifact does not
    end."""
    while os.getppid() == parent:
        time.sleep(1)
    os._exit(1)


threading.Thread(target=watch, args=(int(sys.argv[1]),), daemon=True).start()

# Output of engines must not mix with the answers.
answers = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)

with contextlib.suppress(Exception):  # the first request reports it
    import chiasm.runtime

    chiasm.runtime.backends()  # which loads their libraries

for line in sys.stdin:
    request = json.loads(line)
    try:
        import chiasm.runtime

        rows = chiasm.runtime.open(request["bundle"]).self_test(request["backend"])
        answer = {
            "rows": [
                {key: getattr(row, key) for key in ("method", "dtype", "artifact", "passed", "message")}
                for row in rows
            ]
        }
    except Exception as error:
        answer = {"error": str(error)}
    print(json.dumps(answer), file=answers, flush=True)
