#!/usr/bin/env python3
"""How long the machine takes from dot to dot: rows of dots at 4 mm pitch on the demo's board, between its parts.
    python3 bench/dots/dots.py build/release/bin/gantry      # exit 1 above 0.33 s
A direct cycle is travel, wait and shot of a dot whose neighbour in its row was made before it, by the summary's feature_times."""
import argparse, json, os, statistics, subprocess, sys, tempfile

TARGET_S = 0.33
ROWS = """features:
  - array: {name: middle, material: adhesive, at: [36 mm, 34 mm], rows: 4, columns: 11, pitch: [4 mm, 4 mm]}
  - array: {name: by_relay, material: adhesive, at: [78 mm, 16 mm], rows: 2, columns: 6, pitch: [4 mm, 4 mm]}
"""

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("gantry")
gantry = os.path.abspath(parser.parse_args().gantry)
os.chdir(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../.."))
with tempfile.TemporaryDirectory() as folder:
    recipe = os.path.join(folder, "dots.yaml")
    with open("recipes/demo-board.yaml") as demo, open(recipe, "w") as file:
        file.write(demo.read().split("\nfeatures:")[0] + "\n" + ROWS)
    out = os.path.join(folder, "out")
    subprocess.run([gantry, "--quiet", "dry-run", recipe, "--out", out], check=True, stdout=subprocess.DEVNULL)
    with open(os.path.join(out, "summary.json")) as file:
        summary = json.load(file)

times = {f["id"]: f for f in summary["feature_times"]}
cycles = []
for name, f in times.items():
    array, row, column = name[:-1].replace("]", "").split("[")
    row, column = int(row), int(column)
    # Rows are made to and fro: its neighbour in the row came before it, or it begins a row.
    neighbour = column - 1 if row % 2 == 0 else column + 1
    if f"{array}[{row}][{neighbour}]" in times:
        cycles.append(f["travel_actual_s"] + f["actual_s"])
print(f"{len(cycles)} direct cycles: {min(cycles):.3f} .. {max(cycles):.3f} s, median {statistics.median(cycles):.3f} s; "
      f"{summary['collisions']} collisions, {summary['result']}")
sys.exit(max(cycles) > TARGET_S or summary["collisions"] > 0)
