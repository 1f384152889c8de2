#!/usr/bin/env python3
"""How much faster than real time a dry run of the demo board is, told by the fastest of five.
    python3 bench/dry_run/dry_run.py build/release/bin/gantry      # exit 1 below 50 times
The program's whole time counts, with loading, proof, homing and report; the job's own is motion alone."""
import argparse, json, os, subprocess, sys, tempfile, time

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("gantry")
gantry = os.path.abspath(parser.parse_args().gantry)
os.chdir(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../.."))
fastest = float("inf")
for _ in range(5):
    with tempfile.TemporaryDirectory() as folder:
        begin = time.monotonic()
        subprocess.run([gantry, "--quiet", "dry-run", "recipes/demo-board.yaml", "--out", folder, "--force"], check=True,
                       stdout=subprocess.DEVNULL)
        fastest = min(fastest, time.monotonic() - begin)
        with open(os.path.join(folder, "summary.json")) as file:
            motion_s = json.load(file)["actual_s"]
print(f"{motion_s:.1f} s of motion in {fastest:.2f} s: {motion_s / fastest:.0f} times faster than real time")
sys.exit(motion_s / fastest < 50)
