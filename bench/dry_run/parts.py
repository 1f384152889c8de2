#!/usr/bin/env python3
"""What a thousand parts cost: a dry run with them against the same with one, by processor time, the fastest of seven each.
    python3 bench/dry_run/parts.py build/release/bin/gantry [PARTS]      # exit 1 above 1.3 times
The needle works beside the parts and travels over them from one end of the board to the other."""
import argparse, os, resource, subprocess, sys, tempfile

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("gantry")
parser.add_argument("parts", type=int, nargs="?", default=1000)
options = parser.parse_args()
gantry, many = os.path.abspath(options.gantry), options.parts
os.chdir(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../.."))

HEAD = """version: 1
recipe: parts
board: {size: [120 mm, 80 mm], thickness: 12 mm, frame: pallet}
marks:
  front_left: {at: [5 mm, 5 mm], diameter: 1.5 mm}
  front_right: {at: [108 mm, 5 mm], diameter: 1.5 mm}
  back_right: {at: [115 mm, 75 mm], diameter: 1.5 mm}
touches:
  front_left: {at: [12 mm, 12 mm]}
  front_right: {at: [108 mm, 14 mm]}
  back_left: {at: [8 mm, 68 mm]}
materials:
  adhesive: {speed: 20 mm/s, gap: 0.3 mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, dot_time: 60 ms, retract: 4 mm}
features:
  - array: {name: front, material: adhesive, at: [20 mm, 8 mm], rows: 3, columns: 12, pitch: [7 mm, 5 mm]}
  - line: {name: seam, material: adhesive, from: [20 mm, 22 mm], to: [100 mm, 22 mm]}
  - dot: {name: back_1, material: adhesive, at: [20 mm, 76 mm]}
  - dot: {name: front_1, material: adhesive, at: [18 mm, 4 mm]}
  - dot: {name: back_2, material: adhesive, at: [100 mm, 76 mm]}
  - dot: {name: front_2, material: adhesive, at: [100 mm, 4 mm]}
parts:
"""


def recipe(count):
    columns = max(1, round((count * 90 / 36) ** 0.5))
    pitch = min(90 / columns, 36 / -(-count // columns))
    edge = min(0.5 * pitch, 2)
    rows = [f"  p{i}: {{at: [{16 + pitch * (i % columns):.3f} mm, {29 + pitch * (i // columns):.3f} mm], "
            f"size: [{edge:.3f} mm, {edge:.3f} mm, 1 mm]}}" for i in range(count)]
    return HEAD + "\n".join(rows) + "\n"


def seconds(file, folder):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([gantry, "--quiet", "dry-run", file, "--out", folder, "--force"], check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


with tempfile.TemporaryDirectory() as folder:
    fastest = {1: float("inf"), many: float("inf")}
    for count in fastest:
        with open(f"{folder}/{count}.yaml", "w") as file:
            file.write(recipe(count))
    for _ in range(7):
        for count in fastest:
            fastest[count] = min(fastest[count], seconds(f"{folder}/{count}.yaml", f"{folder}/out-{count}"))
print(f"1 part: {fastest[1]:.2f} s, {many} parts: {fastest[many]:.2f} s, {fastest[many] / fastest[1]:.2f} times")
sys.exit(fastest[many] > 1.3 * fastest[1])
