#!/usr/bin/env python3
"""Two things that have to be so of any path, by the total times that path_cases tells:
  - a higher set speed is never slower, by more than a tick or 0.1 %
  - a line in chords, of 0.01 mm and more and any number, takes as long as the line in one piece, within a tick
    bench/path_cases/pairs.py build/release/bin [--pairs 800] [--lines 200] [--seed 1]      # exit 1 where one is not
Limits of each axis: 200 mm/s, 3000 mm/s2, 50000 mm/s3."""
import argparse, json, math, os, random, subprocess, sys, tempfile

TICK_S = 0.001
options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
options.add_argument("bin_dir")
options.add_argument("--pairs", type=int, default=800)
options.add_argument("--lines", type=int, default=200)
options.add_argument("--seed", type=int, default=1)
options = options.parse_args()


def seconds(points, tolerance, speed, folder):
    """None where path_cases refuses."""
    file = os.path.join(folder, "p.csv")
    with open(file, "w") as out:
        out.write("x,y\n" + "".join("%.17g,%.17g\n" % p for p in points))
    done = subprocess.run([os.path.join(options.bin_dir, "path_cases"), file, "--tol", str(tolerance), "--speed", str(speed)],
                          capture_output=True, text=True)
    return json.loads(done.stdout)["total_s"] if done.returncode == 0 else None


def walk(r):
    """Arcs, waves, lines and corners, in chords."""
    points, x, y, heading = [(0.0, 0.0)], 0.0, 0.0, r.uniform(0, 6.28)
    chord = 10 ** r.uniform(-1.5, 0.7)
    for _ in range(r.randint(1, 6)):
        kind, count = r.choice(("line", "arc", "wave", "steps")), r.randint(2, 60)
        bend = r.choice((-1, 1)) * chord / 10 ** r.uniform(0.3, 2)
        for k in range(count):
            heading += {"line": 0, "arc": bend, "wave": bend * math.cos(k / 4), "steps": r.uniform(-1, 1)}[kind]
            x, y = x + chord * math.cos(heading), y + chord * math.sin(heading)
            points.append((x, y))
        heading += r.choice((0, 0, r.uniform(-2.5, 2.5)))
    return points


failures = refused = 0
worst = 0.0
with tempfile.TemporaryDirectory() as folder:
    for seed in range(options.seed, options.seed + options.pairs):
        r = random.Random(seed)
        points, tolerance = walk(r), r.choice((0.01, 0.05, 0.05, 0.2, 1))
        slow = 10 ** r.uniform(0.5, 2.3)
        fast = slow * r.choice((1.01, 1.1, 1.5, 3))
        a, b = seconds(points, tolerance, slow, folder), seconds(points, tolerance, fast, folder)
        if a is None or b is None:
            refused += 1
            print(f"seed {seed}: refused at {slow if a is None else fast:.4g} mm/s")
            continue
        worst = max(worst, b - a)
        if b - a > max(TICK_S, 0.001 * a) + 1e-9:
            failures += 1
            print(f"seed {seed}: {a:.3f} s at {slow:.4g} mm/s, {b:.3f} s at {fast:.4g} mm/s, tolerance {tolerance}")
    print(f"{options.pairs} pairs of speeds: {failures} slower, {refused} refused; the faster one takes {worst * 1000:.1f} ms more at most")
    apart = 0
    for seed in range(options.seed, options.seed + options.lines):
        r = random.Random(-seed)
        length, angle = 10 ** r.uniform(-1, 2.3), r.uniform(0, 6.28)
        count = max(1, min(20000, int(length / 10 ** r.uniform(-2, math.log10(length)))))
        at = [k / count for k in range(count + 1)]
        if r.random() < 0.5 and length / count > 0.02:  # uneven chords
            at[1:-1] = [share + r.uniform(-0.24, 0.24) / count for share in at[1:-1]]
        line = [(share * length * math.cos(angle), share * length * math.sin(angle)) for share in at]
        tolerance, speed = r.choice((0.001, 0.01, 0.05, 0.2)), 10 ** r.uniform(0.5, 2.5)
        whole, chords = (seconds(points, tolerance, speed, folder) for points in ((line[0], line[-1]), line))
        if whole is None or chords is None or abs(whole - chords) > TICK_S + 1e-9:
            apart += 1
            print(f"line {seed}: {whole} s in one piece, {chords} s in {count} chords of {length / count:.4g} mm at {speed:.4g} mm/s")
    print(f"{options.lines} lines: {apart} take another time in chords")
sys.exit(failures + refused + apart > 0)
