"""python3 tests/calm_host.py COMMAND...: a test in real time. Where the host stood still meanwhile, a run ends rightly, at any
place: then the test is tried again when it goes on, five times at most, and what it said before stays on show. A test that failed on a host
that went on is tried once more and no oftener. Exit code: the last attempt's.

Whether the host stood still is watched, not guessed: a process at real-time priority (where the system allows it) sleeps a
millisecond at a time and notes the longest it took."""
import os
import signal
import subprocess
import sys
import time

ATTEMPTS = 5
CALM_TRIES = 10  # of 2 s each, in which the host may come to itself before the next attempt
STILL_S = 0.015  # longer than this from one wake-up to the next is no scheduling


def watch(out):
    """Until SIGTERM: then writes the longest gap, in seconds."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(95))
    except PermissionError:
        pass
    ending = []
    signal.signal(signal.SIGTERM, lambda *_: ending.append(True))
    longest, last = 0.0, time.monotonic()
    while not ending:
        time.sleep(0.001)
        now = time.monotonic()
        longest, last = max(longest, now - last), now
    os.write(out, str(longest).encode())
    os._exit(0)


def attempt(command):
    """Its exit code, and for how long the host stood still, s."""
    inside, outside = os.pipe()
    sys.stdout.flush()
    watcher = os.fork()
    if watcher == 0:
        os.close(inside)
        watch(outside)
    os.close(outside)
    code = subprocess.call(command)
    os.kill(watcher, signal.SIGTERM)
    with os.fdopen(inside) as said:
        still_s = float(said.read() or 0)
    os.waitpid(watcher, 0)
    return (code if code >= 0 else 128 - code), still_s


for number in range(1, ATTEMPTS + 1):
    code, still_s = attempt(sys.argv[1:])
    if code in (0, 77):
        break
    stood_still = still_s >= STILL_S
    print(f"attempt {number} failed (exit {code}); the host stood still for at most {still_s * 1e3:.1f} ms", flush=True)
    if not stood_still and number >= 2:
        break
    for _ in range(CALM_TRIES):
        if attempt(["sleep", "2"])[1] < STILL_S:
            break
sys.exit(code)
