#!/usr/bin/env python3
"""Polylines for path_cases, one CSV a family:  polylines.py OUT_DIR [--seed 1] [--only NAME ...]
All are plain functions of the seed; --list names them."""
import argparse
import math
import os
import random

SMOOTH = set()  # families of which the radii are at least a^3/j^2 = 10.8 mm: these have a bound on their time
FAMILIES = {}


def family(smooth=False):
    def keep(make):
        FAMILIES[make.__name__] = make
        if smooth:
            SMOOTH.add(make.__name__)
        return make
    return keep


def sampled(curve, n):
    return [curve(k / n) for k in range(n + 1)]


def circle_points(radius, n, x=0.0, y=0.0, start=0.0, turn=2 * math.pi):
    return sampled(lambda u: (x + radius * math.cos(start + turn * u), y + radius * math.sin(start + turn * u)), n)


def zigzag_points(segments, x=0.0, y=0.0, row=20.0, chord=0.5, step=1.0):
    points, direction = [(x, y)], 1
    while len(points) <= segments:
        for _ in range(round(row / chord)):
            points.append((points[-1][0] + direction * chord, points[-1][1]))
        for _ in range(round(step / chord)):
            points.append((points[-1][0], points[-1][1] + chord))
        direction = -direction
    return points[:segments + 1]


@family()
def circle(_):
    return circle_points(40, 503)


@family()
def zigzag(_):
    return zigzag_points(497)


@family()
def both(_):
    first = circle_points(40, 503)
    return first + zigzag_points(497, *first[-1])[1:]


@family(smooth=True)
def circle_coarse(_):
    return circle_points(30, 180)


@family(smooth=True)
def circle_small(_):
    return circle_points(15, 300)


@family(smooth=True)
def circle_rounded(_):
    """Coordinates of three decimals."""
    return [(round(x, 3), round(y, 3)) for x, y in circle_points(30, 377)]


@family(smooth=True)
def circle_noise(random_):
    return [(x + random_.uniform(-1e-3, 1e-3), y + random_.uniform(-1e-3, 1e-3)) for x, y in circle_points(40, 1500)]


@family(smooth=True)
def spiral(_):
    return sampled(lambda u: ((12 + 28 * u) * math.cos(6 * math.pi * u), (12 + 28 * u) * math.sin(6 * math.pi * u)), 1400)


@family(smooth=True)
def s_curve(_):
    return sampled(lambda u: (120 * u, 12 * math.sin(4 * math.pi * u * 0.75)), 400)


@family(smooth=True)
def ellipse(_):
    return sampled(lambda u: (60 * math.cos(2 * math.pi * u), 30 * math.sin(2 * math.pi * u)), 600)


@family(smooth=True)
def clothoid(_):
    points, x, y, n, length, sharpness = [(0.0, 0.0)], 0.0, 0.0, 4000, 160.0, 1 / (12.0 * 160.0)
    for k in range(n):
        s = (k + 0.5) * length / n
        angle = sharpness * s * s / 2
        x += math.cos(angle) * length / n
        y += math.sin(angle) * length / n
        if (k + 1) % 10 == 0:
            points.append((x, y))
    return points


@family(smooth=True)
def lissajous(_):
    return sampled(lambda u: (80 * math.sin(2 * math.pi * u), 60 * math.sin(4 * math.pi * u)), 1500)


@family(smooth=True)
def sine_of_fine_chords(_):
    return sampled(lambda u: (200 * u, 20 * math.cos(2 * math.pi * 2 * u)), 6000)


@family(smooth=True)
def helix(_):
    return sampled(lambda u: (25 * math.cos(6 * math.pi * u), 25 * math.sin(6 * math.pi * u), 30 * u), 900)


def rounded_rectangle(width, height, radius, chord):
    points = []
    for k, (x, y) in enumerate([(width - radius, radius), (width - radius, height - radius), (radius, height - radius),
                                (radius, radius)]):
        n = max(2, math.ceil(radius * math.pi / 2 / chord))
        points += circle_points(radius, n, x, y, -math.pi / 2 + k * math.pi / 2, math.pi / 2)
    return [(radius, 0.0)] + points


@family(smooth=True)
def rounded_rectangle_12(_):
    return rounded_rectangle(90, 60, 12, 0.5)


@family()
def rounded_rectangle_2(_):
    return rounded_rectangle(30, 20, 2, 0.3)


def sine_points(height, period, length, chord):
    return [(chord * k, height * math.sin(2 * math.pi * chord * k / period)) for k in range(int(length / chord) + 1)]


for chord_ in (0.1, 0.5, 2):
    def sine(_, chord=chord_):
        return sine_points(3, 60, 240, chord)
    sine.__name__ = f"sine_{chord_}"
    family(smooth=True)(sine)


@family(smooth=True)
def circle_as_coarse_as_the_tolerance(_):
    return circle_points(40, 63)


def slot_points(radius, length, chord):
    n = math.ceil(math.pi * radius / chord)
    return ([(0.0, 0.0)] + circle_points(radius, n, length, radius, -math.pi / 2, math.pi) +
            circle_points(radius, n, 0, radius, math.pi / 2, math.pi))


for chord_ in (0.5, 2):
    def slot(_, chord=chord_):
        return slot_points(15, 60, chord)
    slot.__name__ = f"slot_{chord_}"
    family()(slot)


for radius_ in (3, 10, 20):
    def line_arc_line(_, radius=radius_):
        return ([(0.0, 0.0)] + circle_points(radius, 60, 60, radius, -math.pi / 2, math.pi / 2) +
                [(60.0 + radius, 60.0 + radius)])
    line_arc_line.__name__ = f"line_arc_line_{radius_}"
    family()(line_arc_line)


@family()
def line(_):
    return [(0.0, 0.0), (50.0, 20.0)]


@family()
def line_in_chords(_):
    return sampled(lambda u: (50 * u, 20 * u), 5385)


@family()
def line_in_noisy_chords(random_):
    return [(0.0, 0.0)] + [(x + random_.uniform(-1e-3, 1e-3), y + random_.uniform(-1e-3, 1e-3))
                           for x, y in sampled(lambda u: (50 * u, 20 * u), 5385)[1:-1]] + [(50.0, 20.0)]


@family()
def square(_):
    return [(0, 0), (20, 0), (20, 20), (0, 20), (0, 0)]


@family()
def star(_):
    return [((20 if k % 2 == 0 else 8) * math.cos(k * math.pi / 5), (20 if k % 2 == 0 else 8) * math.sin(k * math.pi / 5))
            for k in range(11)]


@family()
def reversals(_):
    return [(0, 0), (30, 0), (10, 0), (25, 0), (25, 12), (25, 3), (40, 3)]


@family()
def spikes(_):
    points = [(0.0, 0.0)]
    for k in range(12):
        points += [(points[-1][0] + 3, 0.0), (points[-1][0] + 3.001, 4.0), (points[-1][0] + 3.002, 0.0)]
    return points


@family()
def duplicates(_):
    out = []
    for p in circle_points(20, 200):
        out += [p, p, (p[0] + 1e-12, p[1])]
    return out


@family()
def letters(_):
    """Strokes as of a plotter: a Z, an S of two arcs, an N."""
    z = [(0, 20), (12, 20), (0, 0), (12, 0)]
    s = circle_points(5, 40, 24, 5, -math.pi * 0.8, math.pi * 1.3) + circle_points(5, 40, 24, 15, -math.pi / 2, -math.pi * 1.3)
    n = [(36, 20), (36, 0), (36, 20), (48, 0), (48, 20)]
    return z + s + n


@family()
def tiny_chords_with_noise(random_):
    return [(x + random_.gauss(0, 3e-4), y + random_.gauss(0, 3e-4))
            for x, y in sampled(lambda u: (40 * u, 6 * math.sin(8 * math.pi * u)), 6000)]


@family()
def random_walk(random_):
    points, angle = [(0.0, 0.0)], 0.0
    for _ in range(150):
        angle += random_.gauss(0, 1.2)
        step = 10 ** random_.uniform(-2, 1.3)
        points.append((points[-1][0] + step * math.cos(angle), points[-1][1] + step * math.sin(angle)))
    return points


@family()
def random_walk_3d(random_):
    points = [(0.0, 0.0, 0.0)]
    for _ in range(80):
        points.append(tuple(c + random_.gauss(0, 3) for c in points[-1]))
    return points


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", nargs="?")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", nargs="*")
    parser.add_argument("--list", action="store_true")
    options = parser.parse_args()
    if options.list or not options.out:
        print("\n".join(name + (" smooth" if name in SMOOTH else "") for name in FAMILIES))
        return
    os.makedirs(options.out, exist_ok=True)
    for name, make in FAMILIES.items():
        if options.only and name not in options.only:
            continue
        points = make(random.Random(f"{options.seed} {name}"))
        with open(os.path.join(options.out, name + ".csv"), "w", encoding="ascii") as out:
            out.write("x,y,z\n" if len(points[0]) == 3 else "x,y\n")
            for p in points:
                out.write(",".join(repr(float(c)) for c in p) + "\n")


if __name__ == "__main__":
    main()
