#!/usr/bin/env python3
"""Judges durations of state-to-state motion by linear programming; needs python3-scipy.

    profile_cases < cases.csv > results.csv;  lp_judge.py cases.csv results.csv [steps]

For a fixed duration the bounds on v, a, jerk and position are linear in a jerk that is constant over each of `steps`
equal intervals; where 0.999 times the duration has none, the duration is right to 0.1 %. Prints every case where it is
not, and how many were judged.

    lp_judge.py --search cases.csv [steps]      the cases with a column `found`, the least duration that has such a jerk
"""
import csv
import sys

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import csr_matrix


def feasible(case, duration, steps, relax=0.0):
    """Whether a piecewise constant jerk of that duration exists (bounds at the nodes, widened by `relax`)."""
    h = duration / steps
    n = steps
    p0, v0, a0, pf, vf, af = (case[k] for k in ("p0", "v0", "a0", "pf", "vf", "af"))
    k = np.arange(1, n + 1)
    i = np.arange(n)
    after = (k[:, None] > i[None, :])
    left = (k[:, None] - i[None, :] - 1) * h * after  # time from the end of step i to node k
    A_a = h * after
    A_v = (h * left + h * h / 2) * after
    A_p = (h * left**2 / 2 + h * h / 2 * left + h**3 / 6) * after
    t = k * h
    a_free = np.full(n, a0)
    v_free = v0 + a0 * t
    p_free = p0 + v0 * t + a0 * t * t / 2
    rows, rhs = [], []

    def bound(A, free, high, low):
        width = relax * (high - low)
        rows.append(A[:-1]), rhs.append(high + width - free[:-1])
        rows.append(-A[:-1]), rhs.append(free[:-1] - low + width)

    bound(A_a, a_free, case["amax"], case["amin"])
    bound(A_v, v_free, case["vmax"], case["vmin"])
    if np.isfinite(case["pmax"]):
        rows.append(A_p[:-1]), rhs.append(case["pmax"] + relax - p_free[:-1])
    if np.isfinite(case["pmin"]):
        rows.append(-A_p[:-1]), rhs.append(p_free[:-1] - case["pmin"] + relax)
    equal = np.array([A_p[-1], A_v[-1], A_a[-1]])
    target = np.array([pf - p_free[-1], vf - v_free[-1], af - a_free[-1]])
    scale = np.abs(equal).max(axis=1)
    found = linprog(np.zeros(n), A_ub=csr_matrix(np.vstack(rows)), b_ub=np.concatenate(rhs),
                    A_eq=equal / scale[:, None], b_eq=target / scale,
                    bounds=[(case["jmin"], case["jmax"])] * n, method="highs")
    return found.status == 0


def least(case, steps):
    """Least feasible duration, to 1e-4; nan: none up to a generous one."""
    scale = case["vmax"] / case["amax"] + case["amax"] / case["jmax"]
    times = scale * np.geomspace(0.02, 12, 60)
    index = next((i for i, t in enumerate(times) if feasible(case, t, steps)), None)
    if index is None:
        return float("nan")
    low, high = (times[index - 1] if index else 0.0), times[index]
    while high - low > 1e-4 * high:
        middle = (low + high) / 2
        if feasible(case, middle, steps):
            high = middle
        else:
            low = middle
    return high


def case_of(row):
    case = {k: float(v) for k, v in row.items() if k != "id"}
    case.setdefault("jmin", -case["jmax"])
    case.setdefault("pmax", float("inf")), case.setdefault("pmin", float("-inf"))
    return case


def search():
    steps = int(sys.argv[3]) if len(sys.argv) > 3 else 240
    reader = csv.DictReader(open(sys.argv[2]))
    out = csv.writer(sys.stdout, lineterminator="\n")
    out.writerow(reader.fieldnames + ["found"])
    for row in reader:
        out.writerow(list(row.values()) + [f"{least(case_of(row), steps):.6g}"])
    return 0


def main():
    if sys.argv[1] == "--search":
        return search()
    steps = int(sys.argv[3]) if len(sys.argv) > 3 else 240
    results = {r["id"]: r for r in csv.DictReader(open(sys.argv[2]))}
    judged = wrong = unsolved = 0
    for row in csv.DictReader(open(sys.argv[1])):
        result = results[row["id"]]
        case = case_of(row)
        if result["result"] != "0":
            # No motion at all? Tried at durations that leave time for any.
            slowest = case["vmax"] / case["amax"] + case["amax"] / case["jmax"]
            possible = next((t for t in slowest * np.geomspace(0.3, 8, 10) if feasible(case, t, 3 * steps)), None)
            if possible is not None:
                unsolved += 1
                print(f"{row['id']}: unsolved ({result['result']}), but a motion of {possible:.4g} s exists")
            judged += 1
            continue
        duration = float(result["duration"])
        judged += 1
        faster = feasible(case, 0.999 * duration, steps)
        if faster:
            wrong += 1
            print(f"{row['id']}: {duration:.6g} s, but {least(case, steps):.6g} s is possible")
    print(f"{judged} judged, {wrong} longer than 0.1 % over the search, {unsolved} unsolved though possible")
    return 1 if wrong or unsolved else 0


if __name__ == "__main__":
    sys.exit(main())
