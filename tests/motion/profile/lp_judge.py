#!/usr/bin/env python3
"""Judges durations of state-to-state motion by linear programming; needs python3-scipy.

    lp_judge.py cases.csv results.csv      where results.csv is what profile_cases says to cases.csv
    lp_judge.py --search cases.csv [results.csv]
                                           the cases with a column `found`: the least duration, nan: there is none.
                                           Results only save time: they tell where to look after shorter ones

Columns as in bench/profile/case_table.hpp: one axis, or several with suffixes, and min_duration. For a fixed duration the
bounds on position, speed, acceleration and jerk are linear in a jerk that is constant over each of equal steps. Bounds
are asked for at the ends of steps, so that a coarse grid finds too much and is asked first; what it finds counts when a
fine one (STEP_S, at least FINE steps) finds it too. A duration is right when 0.999 times it is not possible, nor any of
a few shorter ones down to min_duration.
"""
import csv
import sys

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import bmat, diags, eye

COARSE, FINE, STEP_S = 300, 1000, 0.004
NAMES = ("p0", "v0", "a0", "pf", "vf", "af", "vmax", "vmin", "amax", "amin", "jmax", "jmin", "pmin", "pmax")


def axis_feasible(x, duration, steps):
    """Unknowns: p, v, a at the ends of steps and the jerks, each in units of its bound."""
    n, h = steps, duration / steps
    V, A, J = max(x["vmax"], -x["vmin"]), max(x["amax"], -x["amin"]), max(x["jmax"], -x["jmin"])
    P = max(abs(x["p0"]), abs(x["pf"]), V * V / A)
    one, before = eye(n, format="csr"), diags([np.ones(n - 1)], [-1], format="csr")
    step = one - before
    equal = bmat([[step, -h * V / P * before, -h * h / 2 * A / P * before, -(h**3) / 6 * J / P * one],
                  [None, step, -h * A / V * before, -h * h / 2 * J / V * one],
                  [None, None, step, -h * J / A * one]], format="csr")
    right = np.zeros(3 * n)
    right[0] = (x["p0"] + h * x["v0"] + h * h / 2 * x["a0"]) / P
    right[n], right[2 * n] = (x["v0"] + h * x["a0"]) / V, x["a0"] / A
    low, high = [], []
    for name, end, unit in (("p", "pf", P), ("v", "vf", V), ("a", "af", A), ("j", None, J)):
        l, u = np.full(n, x[name + "min"] / unit), np.full(n, x[name + "max"] / unit)
        if end:
            l[-1] = u[-1] = x[end] / unit
        low.append(l), high.append(u)
    bounds = np.column_stack([np.concatenate(low), np.concatenate(high)])
    return linprog(np.zeros(4 * n), A_eq=equal, b_eq=right, bounds=bounds, method="highs").status == 0


def feasible(axes, duration):
    fine = max(FINE, int(duration / STEP_S))
    return all(axis_feasible(x, duration, n) for n in (COARSE, fine) for x in axes)


def durations(axes, least):
    scale = max(x["vmax"] / x["amax"] + x["amax"] / x["jmax"] for x in axes)
    return np.concatenate([[least] if least > 0 else [], least + scale * np.geomspace(0.05, 10, 32)])


def search(axes, least, hint=None):
    """Least feasible duration, to 1e-4; with a hint that proves right, to 1e-3."""
    low, times = 0.0, durations(axes, least)
    if hint:
        times = [t for t in times if t < 0.999 * hint] + [max(0.999 * hint, least), 1.0005 * hint]
        times += [t for t in durations(axes, least) if t > 1.0005 * hint]
    for high in times:
        if feasible(axes, high):
            break
        low = high
    else:
        return float("nan")
    while high > least and high - low > (2e-3 if hint else 1e-4) * high:
        middle = (low + high) / 2
        low, high = (low, middle) if feasible(axes, middle) else (middle, high)
    return high


def case_of(row):
    suffixes = [f"_{i}" for i in range(8) if f"p0_{i}" in row] or [""]
    axes = []
    for suffix in suffixes:
        x = {name: float(row[name + suffix]) for name in NAMES if name + suffix in row}
        x.setdefault("jmin", -x["jmax"]), x.setdefault("pmax", float("inf")), x.setdefault("pmin", float("-inf"))
        axes.append(x)
    least = float(row.get("min_duration", "nan"))
    return axes, 0.0 if np.isnan(least) else least


def main():
    if sys.argv[1] == "--search":
        reader = csv.DictReader(open(sys.argv[2]))
        rows = csv.DictReader(open(sys.argv[3])) if len(sys.argv) > 3 else []
        hints = {r["id"]: float(r["duration"]) for r in rows if r["result"] == "0"}
        out = csv.writer(sys.stdout, lineterminator="\n")
        out.writerow(reader.fieldnames + ["found"])
        for row in reader:
            out.writerow(list(row.values()) + [f"{search(*case_of(row), hints.get(row['id'])):.6g}"])
            sys.stdout.flush()
        return 0
    results = {r["id"]: r for r in csv.DictReader(open(sys.argv[2]))}
    judged = long = unsolved = 0
    for row in csv.DictReader(open(sys.argv[1])):
        result, (axes, least) = results[row["id"]], case_of(row)
        judged += 1
        duration = float(result["duration"]) if result["result"] == "0" else float("inf")
        shorter = [t for t in durations(axes, least) if t < 0.999 * duration]
        if np.isfinite(duration) and 0.999 * duration > least:
            shorter.insert(0, 0.999 * duration)
        found = next((t for t in shorter if feasible(axes, t)), None)
        if found is not None:
            long, unsolved = long + np.isfinite(duration), unsolved + np.isinf(duration)
            print(f"{row['id']}: {duration:.6g} s ({result['result']}), but {found:.6g} s is possible", flush=True)
    print(f"{judged} judged, {long} longer than 0.1 % over the search, {unsolved} unsolved though possible")
    return 1 if long or unsolved else 0


if __name__ == "__main__":
    sys.exit(main())
