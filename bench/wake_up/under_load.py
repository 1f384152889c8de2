#!/usr/bin/env python3
"""Does the 1 ms loop wake up later while others load the owner?
  sudo python3 bench/wake_up/under_load.py [--pairs 4] [--load clients|dds|disk ...] [--gantry build/release/bin/gantry]
One job through `gantry up`, quiet and under a load, the order of the two swapped from pair to pair; the wake-up times are those
of the job's summary. The loads: a client that asks without a pause, a peer that floods the owner's DDS topics and services
(tests' publish_tool), a disk that is filled as soon as the job records (a small tmpfs; needs root) and kept full. Limit: the geometric mean over the pairs of p99 under
load to p99 quiet is at most 1.15, and no more cycles are missed than in the quiet run."""
import argparse, contextlib, json, math, multiprocessing, os, shutil, subprocess, sys, tempfile, time

here = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(os.path.dirname(here), "stop_order"))
from stop_order import OwnerClient, flood, owner_up

LIMIT = 1.15
RECIPE = "recipes/demo-board.yaml"


@contextlib.contextmanager
def clients(state, folder):
    one = multiprocessing.Process(target=flood, args=[state], daemon=True)
    one.start()
    yield None
    one.kill()
    one.join()


@contextlib.contextmanager
def dds(state, folder):
    tool = os.path.join(os.path.dirname(os.path.realpath(options.gantry)), "publish_tool")
    peer = subprocess.Popen([tool, "flood"], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    time.sleep(1)
    if peer.poll() is not None:
        sys.exit("the flooding peer has ended")
    yield None
    peer.kill()
    peer.wait()


def fill(place, job):
    """Fills the file system of `place` once the folder `job` has the first of its large files, and takes what becomes free."""
    while not os.path.exists(os.path.join(job, "setpoints.bin")):
        time.sleep(0.01)
    with open(os.path.join(place, "full"), "wb", buffering=0) as file:
        while True:
            try:
                file.write(bytes(64 * 1024))
            except OSError:
                time.sleep(0.01)


@contextlib.contextmanager
def disk(state, folder):
    place = os.path.join(folder, "small")
    os.mkdir(place)
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64m", "none", place], check=True)  # a job without room is refused
    try:
        job = os.path.join(place, "job")
        filler = multiprocessing.Process(target=fill, args=[place, job], daemon=True)
        filler.start()
        yield job
        filler.kill()
        filler.join()
        with open(os.path.join(job, "summary.json")) as file:
            if not json.load(file)["not_kept"]:
                sys.exit("the disk was not full: the job has lost nothing")
    finally:
        subprocess.run(["umount", "-l", place], check=True)
        os.rmdir(place)


LOADS = {f.__name__: f for f in (clients, dds, disk)}


def run_job(gantry, state, out):
    """The figures of one job, from its own folder or, where nothing could be written, from its answer."""
    shutil.rmtree(out, ignore_errors=True)
    OwnerClient(state).ask(order="reset")
    done = subprocess.run([gantry, "run", RECIPE, "--state", state, "--out", out, "--force", "--json"], capture_output=True, text=True,
                          stdin=subprocess.DEVNULL, timeout=300)
    try:
        with open(os.path.join(out, "summary.json")) as file:
            summary = json.load(file)
    except OSError:
        summary = json.loads(done.stdout)
    if "cycle" not in summary:
        sys.exit(f"the job did not run: {done.stdout}{done.stderr}")
    cycle = summary["cycle"]
    words = summary["result"] if not summary["errors"] else json.dumps(summary["errors"])[:200]
    return words, cycle["wake_us"]["p99"], cycle["skipped"], cycle["deadline_misses"]


def main():
    global options
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=4)
    parser.add_argument("--load", nargs="*", default=list(LOADS), choices=list(LOADS))
    parser.add_argument("--gantry", default="build/release/bin/gantry")
    options = parser.parse_args()
    held = True
    with tempfile.TemporaryDirectory() as folder, owner_up(options.gantry, os.path.join(folder, "state")) as state:
        run_job(options.gantry, state, os.path.join(folder, "first"))  # homes
        for name in options.load:
            logs, missed = [], [0, 0]
            for pair in range(options.pairs):
                got = {}
                for loaded in ((False, True), (True, False))[pair % 2]:
                    with LOADS[name](state, folder) if loaded else contextlib.nullcontext() as place:
                        got[loaded] = run_job(options.gantry, state, place or os.path.join(folder, "job"))
                    missed[loaded] += got[loaded][2] + got[loaded][3]
                logs.append(math.log((got[True][1] + 0.5) / (got[False][1] + 0.5)))
                print(f"{name} {pair + 1}: quiet {got[False]}, under load {got[True]} (result, p99 us, skipped, missed)", flush=True)
            mean = math.exp(sum(logs) / len(logs))
            good = mean <= LIMIT and missed[1] <= missed[0]
            held &= good
            print(f"{name}: p99 x {mean:.2f} over {len(logs)} pairs (limit {LIMIT}); missed quiet {missed[0]}, under load {missed[1]}")
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main())
