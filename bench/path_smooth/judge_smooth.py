#!/usr/bin/env python3
"""Plans smooth curves, each in chords of several lengths, and judges what comes out; shares no code with the planner.

  judge_smooth.py BIN_DIR [--only KIND ...] [--chords 0.1 0.3 1 2]

For each curve two lower bounds of its time, computed here: without jerk (no speed above the one from which the axes'
acceleration could have come, nor above the one that it can still take down), and with the jerk of the start and of the
stop: until the tool has passed length s, one axis has gone |q_i(s) - q_i(0)| - tolerance from rest, which takes it so
long at its own jerk; what is left takes no less than it does without jerk. Both count curves of 0.6 s or more.
path_judge differentiates the setpoints and measures their distance to the polyline. Ends with 1 where that finds
something wrong, or a time is more than 1.10 times the bound with jerk."""
import argparse
import json
import math
import os
import random
import subprocess
import sys
import tempfile

V, A, J, TOLERANCE = 200.0, 3000.0, 50000.0, 0.05
LEAST_RADIUS = A ** 3 / J ** 2
LEAST_BOUND, MOST = 0.6, 1.10
STEP = 0.05  # mm between dense points


def minus(a, b):
    return tuple(x - y for x, y in zip(a, b))


def norm(a):
    return math.sqrt(sum(x * x for x in a))


def evenly(at, end, step):
    """Points of a parametric curve at even lengths: fine chords, walked along."""
    n = 40000
    fine = [at(end * k / n) for k in range(n + 1)]
    out, left = [fine[0]], step
    for p, q in zip(fine, fine[1:]):
        d = norm(minus(q, p))
        on = 0.0
        while d - on >= left:
            on += left
            out.append(tuple(a + (b - a) * on / d for a, b in zip(p, q)))
            left = step
        left -= d - on
    return out


def least_radius(at, end):
    n, least = 4000, math.inf
    for k in range(1, n):
        a, b, c = (at(end * (k + i) / n) for i in (-1, 0, 1))
        u, v = minus(b, a), minus(c, b)
        cross = math.sqrt(max(0.0, (norm(u) * norm(v)) ** 2 - sum(x * y for x, y in zip(u, v)) ** 2))
        if cross > 0:
            least = min(least, norm(u) * norm(v) * norm(minus(c, a)) / (2 * cross))
    return least


def scaled(at, end, times):
    by = 1.0001 * times * LEAST_RADIUS / least_radius(at, end)
    return evenly(lambda t: tuple(by * x for x in at(t)), end, STEP)


def of_curvature(curvature, length, angle=0.3):
    out, x, y = [(0.0, 0.0, 0.0)], 0.0, 0.0
    for k in range(int(length / STEP)):
        bend = curvature((k + 0.5) * STEP) * STEP
        angle += bend / 2
        x, y = x + STEP * math.cos(angle), y + STEP * math.sin(angle)
        angle += bend / 2
        out.append((x, y, 0.0))
    return out


def spline(seed, times):
    """A uniform cubic B-spline through random controls that turn gently."""
    rng, p, angle, controls = random.Random(seed), (0.0, 0.0), 0.0, []
    for _ in range(14):
        controls.append(p)
        angle += rng.uniform(-0.9, 0.9)
        p = (p[0] + math.cos(angle), p[1] + math.sin(angle))

    def at(t):
        k = min(int(t), len(controls) - 4)
        u = t - k
        w = ((1 - u) ** 3 / 6, (3 * u ** 3 - 6 * u ** 2 + 4) / 6, (-3 * u ** 3 + 3 * u ** 2 + 3 * u + 1) / 6, u ** 3 / 6)
        return tuple(sum(w[n] * controls[k + n][i] for n in range(4)) for i in (0, 1)) + (0.0,)
    return scaled(at, len(controls) - 3.0, times)


def superellipse(power, times):
    def at(t):
        c, s = math.cos(t), math.sin(t)
        r = (abs(c) ** power + abs(s) ** power) ** (-1 / power)
        return (1.4 * r * c, r * s, 0.0)
    return scaled(at, 2 * math.pi, times)


def rounded(radius, straight):
    quarter = radius * math.pi / 2
    return of_curvature(lambda s: 0 if s % (straight + quarter) < straight else 1 / radius, 4 * (straight + quarter))


def curves():
    r = 1 / LEAST_RADIUS
    for length in (120, 160, 240):
        yield "clothoid", of_curvature(lambda s: r * s / length, length)
        yield "clothoid S", of_curvature(lambda s: r * (2 * s / length - 1), 1.5 * length)
        yield "sine of curvature", of_curvature(lambda s: r * math.sin(2 * math.pi * s / length), 2 * length)
    for times in (1, 1.5, 2.5):
        for rise in (0.05, 0.2):
            yield "helix", scaled(lambda t: (math.cos(t), math.sin(t), rise * t), 9.0, times)
        yield "circle", scaled(lambda t: (math.cos(t), math.sin(t), 0.0), 2 * math.pi, times * 1.5)
        yield "spiral", scaled(lambda t: ((1 + 0.08 * t) * math.cos(t), (1 + 0.08 * t) * math.sin(t), 0.0), 9.0, times)
        yield "lissajous", scaled(lambda t: (math.sin(t), math.sin(2 * t + 0.2), 0.0), 2 * math.pi, times)
        yield "superellipse", superellipse(2.5, times)
        yield "ellipse", scaled(lambda t: (math.cos(t), 0.6 * math.sin(t), 0.0), 2 * math.pi, times)
        yield "sine", scaled(lambda t: (t, 0.2 * math.sin(t), 0.0), 12.0, times)
        for seed in (1, 2, 3):
            yield "B-spline", spline(seed, times)
        yield "lines and arcs", rounded(times * LEAST_RADIUS, 25.0)


def derivatives(p):
    """q' and q'' by even differences over 0.5 mm."""
    wide, out = 10, []
    w = wide * STEP
    for k in range(len(p)):
        m = min(max(k, wide), len(p) - 1 - wide)
        a, b, c = p[m - wide], p[m], p[m + wide]
        out.append((tuple((z - x) / (2 * w) for x, z in zip(a, c)),
                    tuple((z - 2 * y + x) / (w * w) for x, y, z in zip(a, b, c))))
    return out


def speeds(d):
    """The highest speed squared at each place that acceleration alone allows, from rest to rest."""
    def gain(at, b, sign):
        d1, d2 = at
        most = math.inf
        for x, y in zip(d1, d2):
            if abs(x) > 1e-9:
                most = min(most, (A - sign * math.copysign(1, x) * y * b) / abs(x))
        return max(0.0, most)
    b = []
    for d1, d2 in d:
        most = math.inf
        for x, y in zip(d1, d2):
            if x:
                most = min(most, (V / x) ** 2)
            if y:
                most = min(most, A / abs(y))
        b.append(most)
    b[0] = b[-1] = 0.0
    for k in range(1, len(b)):
        b[k] = min(b[k], b[k - 1] + 2 * gain(d[k - 1], b[k - 1], 1) * STEP)
    for k in range(len(b) - 2, -1, -1):
        b[k] = min(b[k], b[k + 1] + 2 * gain(d[k + 1], b[k + 1], -1) * STEP)
    return b


def from_rest(distance):
    """The least time in which one axis goes so far from rest, whatever speed it has then."""
    if distance <= 0:
        return 0.0
    t = A / J
    if distance <= J * t ** 3 / 6:
        return (6 * distance / J) ** (1 / 3)
    v = J * t * t / 2
    left = distance - J * t ** 3 / 6
    return t + (math.sqrt(v * v + 2 * A * left) - v) / A  # above V it would take longer


def start_gain(p, times):
    """By how much an end costs more with jerk than without."""
    best = 0.0
    for k in range(1, min(len(p), 600)):
        far = max(abs(x - y) for x, y in zip(p[k], p[0])) - TOLERANCE
        best = max(best, from_rest(far) - times[k])
    return best


def bounds(p):
    b = speeds(derivatives(p))
    times = [0.0]
    for x, y in zip(b, b[1:]):
        times.append(times[-1] + 2 * STEP / (math.sqrt(x) + math.sqrt(y)))
    end = [times[-1] - t for t in reversed(times)]
    plain = times[-1]
    return plain, plain + start_gain(p, times) + start_gain(p[::-1], end)


def in_chords(p, chord):
    every = max(1, round(chord / STEP))
    out = p[::every]
    if out[-1] != p[-1]:
        out.append(p[-1])
    return out


def planned(bin_dir, points, folder):
    polyline, setpoints = os.path.join(folder, "p.csv"), os.path.join(folder, "s.csv")
    with open(polyline, "w") as out:
        out.write("x,y,z\n")
        for q in points:
            out.write("%.17g,%.17g,%.17g\n" % q)
    limits = ["--v", str(V), "--a", str(A), "--j", str(J), "--tol", str(TOLERANCE)]
    subprocess.run([os.path.join(bin_dir, "path_cases"), polyline, *limits, "--setpoints", setpoints], check=True,
                   capture_output=True)
    judged = subprocess.run([os.path.join(bin_dir, "path_judge"), polyline, setpoints, *limits], capture_output=True,
                            text=True)
    return json.loads(judged.stdout)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir")
    parser.add_argument("--only", nargs="*")
    parser.add_argument("--chords", nargs="*", type=float, default=[0.1, 0.3, 1.0, 2.0])
    args = parser.parse_args()
    rows, failed = [], 0
    with tempfile.TemporaryDirectory() as folder:
        for kind, dense in curves():
            if args.only and kind not in args.only:
                continue
            plain, with_jerk = bounds(dense)
            if plain < LEAST_BOUND:
                continue
            for chord in args.chords:
                found = planned(args.bin_dir, in_chords(dense, chord), folder)
                seconds = found["seconds"]
                rows.append((seconds / plain, seconds / with_jerk, found["j"], found["off_mm"]))
                bad = found["wrong"] or seconds > MOST * with_jerk
                failed += bool(bad)
                print("%-18s %4.1f mm: %.3f s, bounds %.3f %.3f, ratios %.3f %.3f, jerk %.4f, off %.4f %s" % (
                    kind, chord, seconds, plain, with_jerk, seconds / plain, seconds / with_jerk, found["j"],
                    found["off_mm"], found["wrong"]), flush=True)
    for n, name in enumerate(("without jerk", "with jerk at the ends")):
        ratios = sorted(r[n] for r in rows)
        print("%d plans, times the bound %s: median %.3f, 90 %% %.3f, most %.3f, %d above %.2f" % (
            len(rows), name, ratios[len(ratios) // 2], ratios[int(0.9 * (len(ratios) - 1))], ratios[-1],
            sum(r > MOST for r in ratios), MOST))
    print("jerk at most %.4f of its limit, %.4f mm off at most, %d wrong or too slow" % (
        max(r[2] for r in rows), max(r[3] for r in rows), failed))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
