"""The programs that measure paths: what path_cases plans, by differences of its setpoints; slices of the campaigns.
  python3 path_benches_test.py BIN_DIR BENCH FOLDER"""
import json, math, pathlib, subprocess, sys

programs, bench, folder = (pathlib.Path(each).resolve() for each in sys.argv[1:4])
V, A, J, TOLERANCE, TICK = 200.0, 3000.0, 50000.0, 0.05, 1e-3
MOST_S = {"circle": 1.42, "zigzag": 3.05, "both": 4.5}
failures = 0


def expect(what, good, text=""):
    global failures
    failures += not good
    if not good:
        print(f"FAILED: {what}: {text}", flush=True)


def run(program, *words):
    return subprocess.run([programs / program, *map(str, words)], capture_output=True, text=True)


def numbers(path):
    header, *rows = path.read_text().splitlines()
    return header, [[float(each) for each in row.split(",")] for row in rows], rows


def steps(values):
    return [b - a for a, b in zip(values, values[1:])]


def largest_share(axis):
    """Of the limits, by differences; the axis rests before and behind."""
    v = steps([axis[0]] * 3 + axis + [axis[-1]] * 3)
    a, shares = steps(v), []
    for derivative, limit, power in ((v, V, 1), (a, A, 2), (steps(a), J, 3)):
        shares.append(max(map(abs, derivative)) / TICK**power / limit)
    return max(shares)


def distance(p, a, b):
    ab, ap = [y - x for x, y in zip(a, b)], [y - x for x, y in zip(a, p)]
    length = sum(x * x for x in ab)
    share = max(0.0, min(1.0, sum(x * y for x, y in zip(ab, ap)) / length)) if length > 0 else 0.0
    return math.dist(p, [x + share * y for x, y in zip(a, ab)])


def off(points, polyline):
    """The largest distance of any of every 31st point from the polyline: the whole of it is looked through for each."""
    return max(min(distance(p, a, b) for a, b in zip(polyline, polyline[1:])) for p in points[::31])


subprocess.run([sys.executable, bench / "path_cases" / "polylines.py", folder], check=True, capture_output=True)
files = sorted(folder.glob("*.csv"))
expect("there are polylines", len(files) > 10 and MOST_S.keys() <= {file.stem for file in files}, files)
for file in files:
    setpoints = folder / f"{file.stem}.setpoints"
    done = run("path_cases", file, "--v", V, "--a", A, "--j", J, "--tol", TOLERANCE, "--setpoints", setpoints)
    expect(f"{file.stem} is planned", done.returncode == 0, done.stderr)
    told = json.loads(done.stdout)
    expect("JSON has the keys", {"total_s", "v_max", "a_max", "j_max", "deviation_mm", "plan_us", "bound_s"} <= told.keys(), told)
    expect(f"{file.stem}: no faster than its bound", 0 < told["bound_s"] <= told["total_s"], told)
    expect(f"{file.stem}: fast", told["total_s"] <= MOST_S.get(file.stem, math.inf), told)
    header, rows, texts = numbers(setpoints)
    expect("header", header == "t,x,y,z", header)
    expect("%.17g", all("%.17g" % float(each) == each for each in texts[len(texts) // 2].split(",")), texts[len(texts) // 2])
    expect("a row each tick to the end", len(rows) == round(told["total_s"] / TICK) + 1 and rows[0][0] == 0 and
           all(abs(row[0] - k * TICK) < 1e-9 for k, row in enumerate(rows)), len(rows))
    polyline = [(each + [0.0])[:3] for each in numbers(file)[1]]
    points = [row[1:] for row in rows]
    expect(f"{file.stem}: from its first point to its last", math.dist(points[0], polyline[0]) < 1e-9 and
           math.dist(points[-1], polyline[-1]) < 1e-9, (points[0], points[-1]))
    share = max(largest_share([p[axis] for p in points]) for axis in range(3))
    expect(f"{file.stem}: limits", share <= 1.01, share)
    expect(f"{file.stem}: path", off(points, polyline) <= TOLERANCE * 1.001, off(points, polyline))

for words, name in (([folder / "none.csv"], "a file that is not there"), ([files[0], "--tol", "-1"], "a tolerance below 0")):
    refused = run("path_cases", *words)
    expect(f"{name} is refused", refused.returncode != 0 and refused.stderr and not refused.stdout, refused)
(folder / "odd.txt").write_text("x,y\n0,0\n1,nan\n")
refused = run("path_cases", folder / "odd.txt")
expect("a point that is no number is refused", refused.returncode != 0 and refused.stderr, refused)

for program, *words in (("path_campaign", "--cases", 300, "--seed", 4100000), ("bead_speed", "--beads", 20, "--seed", 4100)):
    done = run(program, *words)
    print(done.stdout.splitlines()[-1] if done.stdout else done.stderr, flush=True)
    expect(program, done.returncode == 0, done.stdout + done.stderr)
dots = subprocess.run([sys.executable, bench / "dots" / "dots.py", programs / "gantry"], capture_output=True, text=True)
print(dots.stdout.strip(), flush=True)
expect("a dot's cycle", dots.returncode == 0, dots.stdout + dots.stderr)

print(f"{len(files)} polylines, {failures} failed")
sys.exit(failures > 0)
