#!/usr/bin/env python3
"""How long does an abort take from a client to the loop?
  python3 bench/stop_order/stop_order.py [--runs 100] [--seed 1] [--gantry build/release/bin/gantry]
An owner is up in real time; a client begins a job (the demo, or 50,000 dots, whose planning takes long) or a homing, and at
an instant of the seed another client sends an abort, in half of the runs through a flood of a third one. What is measured is
the time to the owner's answer, which it gives after it has told the loop: an upper bound. Limit: p99 20 ms."""
import argparse, contextlib, json, multiprocessing, os, random, shutil, signal, subprocess, sys, tempfile, threading, time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../tests/cli"))
from owner_client import OwnerClient

LIMIT_MS = 20


@contextlib.contextmanager
def owner_up(gantry, state):
    """An owner of the simulated machine in real time, ended in order."""
    owner = subprocess.Popen([gantry, "-q", "up", "--state", state], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                             stderr=subprocess.DEVNULL)
    try:
        end = time.monotonic() + 60
        while True:
            with contextlib.suppress(OSError, ValueError):
                if OwnerClient(state).ask(order="status")["state"] != "offline":
                    break
            if time.monotonic() > end or owner.poll() is not None:
                sys.exit("no owner came up")
            time.sleep(0.05)
        yield state
    finally:
        owner.send_signal(signal.SIGTERM)
        owner.wait(60)


def flood(state):
    """Asks for the status without a pause, and reads what comes: a process of its own, so that this one can hear."""
    client = OwnerClient(state)
    client.socket.settimeout(0.2)

    def read():
        while True:
            try:
                client.socket.recv(65536)
            except OSError:
                pass

    threading.Thread(target=read, daemon=True).start()
    while True:
        try:
            client.socket.sendall(b'{"order":"status"}\n' * 50)
        except OSError:
            pass


def many_dots(folder):
    """A board of 50,000 dots, none on another."""
    path = os.path.join(folder, "many.yaml")
    with open(path, "w") as file:
        file.write("""version: 1
recipe: many
placement: fixture
board: {size: [162 mm, 100 mm], thickness: 12 mm, frame: pallet, clamp_margin: 3 mm}
materials:
  adhesive: {speed: 15 mm/s, gap: 0.2 mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, dot_time: 60 ms, settle_time: 30 ms, retract: 3 mm}
features:
  - array: {name: many, material: adhesive, at: [5 mm, 5 mm], rows: 200, columns: 250, pitch: [0.6 mm, 0.45 mm]}
""")
    return path


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--gantry", default="build/release/bin/gantry")
    options = parser.parse_args()
    rng = random.Random(options.seed)
    took = {}
    with tempfile.TemporaryDirectory() as folder, owner_up(options.gantry, os.path.join(folder, "state")) as state:
        many = many_dots(folder)
        operator = OwnerClient(state)
        for turn in range(options.runs):
            work = rng.choice(["demo", "many dots", "many dots", "home"])
            flooded = rng.random() < 0.5
            out = os.path.join(folder, "job")
            shutil.rmtree(out, ignore_errors=True)
            words = ["home"] if work == "home" else ["run", many if work == "many dots" else "recipes/demo-board.yaml", "--out", out, "--force"]
            operator.ask(order="reset")
            operator.ask(order="part_removed")  # the one that the abort before has cut
            job = subprocess.Popen([options.gantry, "-q", *words, "--state", state], stdin=subprocess.DEVNULL,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            flooder = multiprocessing.Process(target=flood, args=[state], daemon=True) if flooded else None
            if flooder:
                flooder.start()
            while operator.ask(order="status")["busy_with"] is None and job.poll() is None:
                time.sleep(0.02)
            time.sleep(rng.uniform(0, 20 if work == "many dots" else 6))
            before = operator.ask(order="status")
            asked = time.perf_counter()
            answer = operator.ask(order="abort")
            ms = (time.perf_counter() - asked) * 1e3
            if not answer["ok"]:
                sys.exit(f"an abort was refused: {answer}")
            if flooder:
                flooder.kill()
                flooder.join()
            name = work + (", flood" if flooded else "")
            took.setdefault(name if before["busy_with"] else "nothing to abort", []).append((ms, before["state"]))
            print(f"{sum(map(len, took.values())):4}  {name:18} {before['state']:10} {ms:6.2f} ms", flush=True)
            job.wait(120)
    every = sorted(ms for of in took.values() for ms, _ in of)
    for name, of in sorted(took.items()):
        ms = sorted(m for m, _ in of)
        states = sorted({s for _, s in of})
        print(f"{name:18} {len(ms):4} aborts, p50 {ms[len(ms) // 2]:6.2f} ms, max {ms[-1]:6.2f} ms; states: {', '.join(states)}")
    p99 = every[min(len(every) - 1, int(0.99 * len(every)))]
    print(f"all: {len(every)} aborts, p50 {every[len(every) // 2]:.2f} ms, p99 {p99:.2f} ms, max {every[-1]:.2f} ms (limit: p99 {LIMIT_MS} ms)")
    idle = len(took.get("nothing to abort", []))
    if idle * 2 > len(every):
        sys.exit(f"{idle} of {len(every)} aborts came when nothing was under way: this is no measurement")
    return 0 if p99 <= LIMIT_MS else 1


if __name__ == "__main__":
    sys.exit(main())
