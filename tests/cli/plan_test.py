"""gantry plan against closed forms of distance in another language: paths, motions, repeats, and documents that are wrong.

  python3 tests/cli/plan_test.py build/release/bin/gantry FOLDER
"""
import json, math, os, random, subprocess, sys, time

GANTRY = sys.argv[1]
WORK = sys.argv[2]
FAILURES = []


def check(good, what):
    if not good:
        FAILURES.append(what)
        print("FAILED:", what)


def plan(scene, *arguments, text=None):
    path = os.path.join(WORK, "scene.json")
    with open(path, "w") as f:
        f.write(text if text is not None else json.dumps(scene, indent="\t"))
    done = subprocess.run([GANTRY, "plan", "--scene", path, *arguments, "--json"], capture_output=True, text=True, timeout=60)
    return done.returncode, json.loads(done.stdout)


def written(name, rows):
    path = os.path.join(WORK, name)
    with open(path, "w") as f:
        json.dump(rows, f)
    return path


def figure(b):
    """(half x, half y, disc, half height, ball) of an upright body."""
    kind = b["type"]
    if kind == "box":
        return b["size"][0] / 2, b["size"][1] / 2, 0, b["size"][2] / 2, 0
    r, l = b["radius"], b.get("length", 0)
    return (0, 0, r, l / 2, 0) if kind == "cylinder" else (0, 0, 0, l / 2, r)


def corners(b, at):
    hx, hy, *_ = figure(b)
    a = math.radians(b.get("yaw_deg", 0))
    return [(at[0] + x * math.cos(a) - y * math.sin(a), at[1] + x * math.sin(a) + y * math.cos(a))
            for x, y in ((hx, hy), (-hx, hy), (-hx, -hy), (hx, -hy))]


def to_segment(p, a, b):
    d = (b[0] - a[0], b[1] - a[1])
    square = d[0] ** 2 + d[1] ** 2
    t = 0 if square == 0 else min(1, max(0, ((p[0] - a[0]) * d[0] + (p[1] - a[1]) * d[1]) / square))
    return math.hypot(p[0] - a[0] - t * d[0], p[1] - a[1] - t * d[1])


def inside(p, poly):
    return all((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) >= 0
               for a, b in zip(poly, poly[1:] + poly[:1]))


def apart(p, q):
    """Distance of two convex polygons."""
    for one, other in ((p, q), (q, p)):  # an edge that parts them?
        for a, b in zip(one, one[1:] + one[:1]):
            n = (b[1] - a[1], a[0] - b[0])
            if min(n[0] * (c[0] - a[0]) + n[1] * (c[1] - a[1]) for c in other) > 0:
                return min(min(to_segment(c, a2, b2) for c in u for a2, b2 in zip(v, v[1:] + v[:1])) for u, v in ((p, q), (q, p)))
    return 0


def distance(h, tip, o):
    at = [h["center"][i] + tip[i] for i in range(3)]
    to = o["center"]
    _, _, disc_h, up_h, ball_h = figure(h)
    _, _, disc_o, up_o, ball_o = figure(o)
    if h["type"] == "box" and o["type"] == "box":
        flat = apart(corners(h, at), corners(o, to))
    elif h["type"] == "box" or o["type"] == "box":
        poly, point = (corners(h, at), to) if h["type"] == "box" else (corners(o, to), at)
        flat = 0 if inside(point, poly) else min(to_segment(point, a, b) for a, b in zip(poly, poly[1:] + poly[:1]))
    else:
        flat = math.hypot(at[0] - to[0], at[1] - to[1])
    flat = max(0, flat - disc_h - disc_o)
    up = max(0, abs(at[2] - to[2]) - up_h - up_o)
    return math.hypot(flat, up) - ball_h - ball_o


def least(scene, tip):
    return min((distance(h, tip, o) for h in scene["head"] for o in scene["obstacles"]), default=math.inf)


def first_contact(scene, a, b, clearance, step=0.02):
    """The first share of a motion that is within the clearance, by steps as far as there is room; None: there is none."""
    length, at = math.dist(a, b), 0
    while True:
        t = at / length if length else 0
        d = least(scene, [a[i] + t * (b[i] - a[i]) for i in range(3)])
        if d <= clearance:
            return t
        if at >= length:
            return None
        at = min(length, at + max(step, d - clearance))


def least_over(scene, a, b):
    """Least distance over a motion: of each pair it is convex, so thirds end at it."""
    length, best = math.dist(a, b), math.inf
    tip = lambda t: [a[i] + t * (b[i] - a[i]) for i in range(3)]
    for h in scene["head"]:
        for o in scene["obstacles"]:
            if distance(h, tip(0.5), o) - length / 2 > best:
                continue
            low, high = 0, 1
            while (high - low) * length > 1e-7:
                p, q = low + (high - low) / 3, high - (high - low) / 3
                if distance(h, tip(p), o) <= distance(h, tip(q), o):
                    high = q
                else:
                    low = p
            best = min(best, *(distance(h, tip(t), o) for t in (0, low, high, 1)))
    return best


def check_point(scene, tip, row, what):
    """`point` lies in the standing body, and as near to the head's as the two are: in both where they overlap."""
    h, o = (next(b for b in scene[of] if b["name"] == name) for of, name in zip(("head", "obstacles"), row["pair"]))
    at = {"name": "point", "type": "sphere", "center": row["point"], "radius": 0}
    away = distance(h, tip, o)
    check(distance(at, [0, 0, 0], o) <= 1e-9, f"{what}: the point is not in {o}")
    check(distance(h, tip, at) <= max(0, away) + 1e-9, f"{what}: the point is not in the head's body, nor as near as {away}")


def check_within(scene, path, what):
    low, high = scene["workspace_tip"]["min"], scene["workspace_tip"]["max"]
    for p in path:
        check(all(a <= x <= b for a, x, b in zip(low, p, high)), f"{what}: {p} is outside of {low} to {high}")


def random_scene(r):
    def body(name, low, high):
        kind = r.choice(["box", "cylinder", "capsule", "sphere"])
        b = {"name": name, "type": kind, "center": [round(r.uniform(0, x), 3) for x in (100, 80, 20)]}
        size = [round(r.choice([0.05, 0.2, r.uniform(low, high)]), 3) if r.random() < 0.2 else round(r.uniform(low, high), 3) for _ in range(3)]
        if kind == "box":
            b["size"], b["yaw_deg"] = size, r.choice([0, 90, r.uniform(-180, 180)])
        else:
            b["radius"] = size[0] / 2
            if kind != "sphere":
                b["length"] = size[2]
        return b
    head = [{"name": "needle", "type": "capsule", "center": [0, 0, 6], "radius": 0.1, "length": 11.8},
            {"name": "syringe", "type": "cylinder", "center": [0, 0, 22], "radius": 5, "length": 20},
            {"name": "camera", "type": "box", "center": [14, 0, 30], "size": [10, 12, 20], "yaw_deg": 20}]
    return {"workspace_tip": {"min": [0, 0, 0], "max": [100, 80, 40]}, "required_clearance_mm": r.choice([0, 0.3, 1]),
            "head": head[: r.randint(1, 3)], "obstacles": [body(f"part {i}", 1, 15) for i in range(r.randint(1, 25))]}


def paths_and_motions():
    r = random.Random(7)
    seen = {}
    for number in range(24):
        scene = random_scene(r)
        c = scene["required_clearance_mm"]
        somewhere = lambda: [r.uniform(0, 100), r.uniform(0, 80), r.uniform(0, 20)]
        queries = [{"id": f"q{i}", "start": somewhere(), "goal": somewhere()} for i in range(4)]
        motions = [{"id": i, "from": somewhere(), "to": somewhere()} for i in range(4)]
        files = ["--queries", written("q.json", queries), "--motions", written("m.json", motions)]
        code, out = plan(scene, *files)
        check(code == 0 and out["result"] == "ok" and out["exit_code"] == 0 and out["errors"] == [], f"scene {number}: {out.get('errors')}")
        again = plan(scene, *files)[1]
        for q, row, row2 in zip(queries, out["queries"], again["queries"]):
            seen[row["status"]] = seen.get(row["status"], 0) + 1
            check(row["id"] == q["id"] and row["path"] == row2["path"], f"scene {number} {q['id']}: not the same again")
            if row["status"] != "ok":
                check(row["path"] == [], "a path without being ok")
                end = q["start"] if row["status"] == "start_collides" else q["goal"]
                if row["status"] in ("start_collides", "goal_collides"):
                    check(least(scene, end) <= c + 1e-6, f"scene {number} {q['id']}: {row['status']}, but it is free")
                    check_point(scene, end, row, f"scene {number} {q['id']}: {row}")
                continue
            p = row["path"]
            check(p[0] == q["start"] and p[-1] == q["goal"], "a path without its ends")
            check_within(scene, p, f"scene {number} {q['id']}")
            check(abs(sum(math.dist(a, b) for a, b in zip(p, p[1:])) - row["length_mm"]) < 1e-6, "a wrong length")
            nearest = min(least_over(scene, a, b) for a, b in zip(p, p[1:]))
            check(nearest > c, f"scene {number} {q['id']}: collides, {nearest} <= {c}")
            check(abs(nearest - row["min_clearance_mm"]) < 1e-5, f"scene {number} {q['id']}: clearance {row['min_clearance_mm']} and {nearest}")
        for m, row in zip(motions, out["motions"]):
            seen[row["free"]] = seen.get(row["free"], 0) + 1
            nearest, hit = least_over(scene, m["from"], m["to"]), first_contact(scene, m["from"], m["to"], c)
            what = f"scene {number} motion {m['id']}: {row}; nearest {nearest}, first contact {hit}"
            check(row["free"] == (nearest > c) or abs(nearest - c) < 1e-5, what)
            check(row["free"] == (row["distance_mm"] > c) or abs(nearest - c) < 1e-6, what)
            check((nearest <= 0 and row["distance_mm"] <= 0) or abs(nearest - row["distance_mm"]) < 1e-5, what)
            if not row["free"]:
                check_point(scene, [a + row["t"] * (b - a) for a, b in zip(m["from"], m["to"])], row, what)
            if hit is not None and not row["free"]:
                check(-1e-9 <= hit - row["t"] < 0.05 / max(0.05, math.dist(m["from"], m["to"])), what)
    print("seen:", seen)
    check(seen.get("ok", 0) > 30 and seen.get(True, 0) > 20 and seen.get(False, 0) > 20, "too few of a kind")


def workspaces_without_depth():
    """A tip that one axis or two do not move: no path leaves its workspace, not by the last bit of a number."""
    r = random.Random(23)
    found = apart = 0
    for number in range(12):
        flat = [(0,), (1,), (2,), (0, 2)][number % 4]
        at = [r.choice([7.3, 1 / 3, 0.1 + 0.2]), r.choice([41.7, 1e-3]), r.uniform(1, 9)]
        low = [at[i] if i in flat else 0 for i in range(3)]
        high = [at[i] if i in flat else (100, 80, 40)[i] for i in range(3)]
        block = lambda i: {"name": f"block {i}", "type": "box", "size": [r.uniform(2, 12) for _ in range(3)], "yaw_deg": r.uniform(0, 90),
                           "center": [at[k] + r.uniform(-4, 4) if k in flat else r.uniform(0, (100, 80, 30)[k]) for k in range(3)]}
        scene = {"workspace_tip": {"min": low, "max": high}, "required_clearance_mm": 0.2, "obstacles": [block(i) for i in range(12)],
                 "head": [{"name": "needle", "type": "capsule", "center": [0, 0, 6], "radius": 0.1, "length": 11.8}]}
        some = lambda: [r.choice([a, b, r.uniform(a, b)]) for a, b in zip(low, high)]
        queries = [{"id": i, "start": some(), "goal": some()} for i in range(8)]
        for q, row in zip(queries, plan(scene, "--queries", written("q.json", queries))[1]["queries"]):
            found += len(row["path"]) > 2
            check_within(scene, row["path"], f"flat scene {number}, {q}")
            for a, b in zip(row["path"], row["path"][1:]):
                check(least_over(scene, a, b) > 0.2, f"flat scene {number}, {q}: collides")
        beyond = [math.nextafter(x, 1e9) for x in high]
        out = plan(scene, "--queries", written("q.json", [{"id": 1, "start": beyond, "goal": high}, {"id": 2, "start": high, "goal": beyond}]),
                   "--motions", written("m.json", [{"id": 1, "from": high, "to": beyond}, {"id": 2, "from": beyond, "to": high}]))[1]
        check(out["queries"][0]["status"] == "start_collides" and not any(x["free"] for x in out["motions"]), f"the last bit beyond: {out}")
        if out["queries"][1]["status"] != "start_collides":  # where `high` itself is free
            apart += 1
            check(out["queries"][1]["status"] == "goal_collides", f"the last bit beyond: {out['queries']}")
            check(all(x["pair"] == ["tip", "workspace"] for x in out["queries"] + out["motions"]), f"the last bit beyond: {out}")
    check(found > 15 and apart > 5, f"only {found} paths around something in a flat workspace")


GOOD = {"workspace_tip": {"min": [0, 0, 0], "max": [100, 80, 40]}, "required_clearance_mm": 0.5,
        "head": [{"name": "needle", "type": "capsule", "center": [0, 0, 6], "radius": 0.1, "length": 11.8}],
        "obstacles": [{"name": "block", "type": "box", "center": [50, 40, 10], "size": [10, 10, 20]}]}


def altered(change):
    scene = json.loads(json.dumps(GOOD))
    change(scene)
    return scene


def wrong_documents():
    queries = written("q.json", [{"id": 1, "start": [1, 1, 1], "goal": [9, 9, 1]}])
    code, out = plan(GOOD, "--queries", queries)
    check(code == 0 and out["queries"][0]["status"] == "ok", "the good document")
    outside = written("o.json", [{"id": 1, "start": [-1, 1, 1], "goal": [9, 9, 1]}, {"id": 2, "start": [1, 1, 1], "goal": [9, 9, 41]}])
    rows = plan(GOOD, "--queries", outside)[1]["queries"]
    check([(x["status"], x["pair"]) for x in rows] == [("start_collides", ["tip", "workspace"]), ("goal_collides", ["tip", "workspace"])], f"outside: {rows}")
    code, out = plan(None, "--queries", queries, text="""# as YAML
workspace_tip: {min: [0, 0, 0], max: [100, 80, 40]}
required_clearance_mm: 0.5
head:
  - {name: needle, type: sphere, center: [0, 0, 1], radius: 1}
obstacles: []
""")
    check(code == 0 and out["queries"][0]["min_clearance_mm"] is None, "YAML, nothing stands")
    cases = [
        ("a misspelt key", altered(lambda s: s["obstacles"][0].update(yaw=3)), "yaw_deg"),
        ("a negative size", altered(lambda s: s["obstacles"][0].update(size=[10, -10, 20])), "-10"),
        ("no size", altered(lambda s: s["obstacles"][0].pop("size")), "size"),
        ("a radius of a box", altered(lambda s: s["obstacles"][0].update(radius=1)), "radius"),
        ("a type that is none", altered(lambda s: s["obstacles"][0].update(type="cone")), "cone"),
        ("a name that stands twice", altered(lambda s: s["obstacles"].append(s["obstacles"][0])), "block"),
        ("no head", altered(lambda s: s.pop("head")), "head"),
        ("an empty head", altered(lambda s: s.update(head=[])), ""),
        ("no workspace", altered(lambda s: s.pop("workspace_tip")), "workspace_tip"),
        ("a workspace turned over", altered(lambda s: s["workspace_tip"].update(max=[-1, 80, 40])), "max"),
        ("no clearance", altered(lambda s: s.pop("required_clearance_mm")), "required_clearance_mm"),
        ("a negative clearance", altered(lambda s: s.update(required_clearance_mm=-1)), "-1"),
        ("two numbers for three", altered(lambda s: s["obstacles"][0].update(center=[1, 2])), ""),
        ("NaN", altered(lambda s: s["obstacles"][0].update(center=[float("nan"), 2, 3])), "NaN"),
        ("infinity", altered(lambda s: s["obstacles"][0].update(center=[float("inf"), 2, 3])), "Infinity"),
        ("a text for a number", altered(lambda s: s["head"][0].update(radius="x")), "x"),
        ("a list", [], ""),
    ]
    for what, scene, word in cases:
        code, out = plan(scene, "--queries", queries)
        said = json.dumps(out.get("errors", []))
        check(code == 3 and out["exit_code"] == 3 and "scene.json:" in said and word in said, f"{what}: exit {code}, {said}")
    begin = time.time()
    for what, text in (("nothing", ""), ("brackets", "[" * 2000000), ("half a document", json.dumps(GOOD)[:150]), ("bytes", "\x00\x01"),
                       ("too much", json.dumps(altered(lambda s: s.update(obstacles=s["obstacles"] * 60000))))):
        code, out = plan(None, "--queries", queries, text=text)
        check(code == 3, f"{what}: exit {code}")
    check(time.time() - begin < 20, "wrong documents take too long")
    for what, text in (("no JSON", "[{"), ("NaN", '[{"id":1,"start":[NaN,1,1],"goal":[1,1,1]}]'), ("1e999", '[{"id":1,"start":[1e999,1,1],"goal":[1,1,1]}]'),
                       ("no list", "{}"), ("a misspelt key", '[{"id":1,"strat":[1,1,1],"goal":[1,1,1]}]'), ("no id", '[{"start":[1,1,1],"goal":[1,1,1]}]'),
                       ("two numbers", '[{"id":1,"start":[1,1],"goal":[1,1,1]}]'), ("an id twice", '[{"id":1,"start":[1,1,1],"goal":[1,1,1]},{"id":1,"start":[1,1,1],"goal":[1,1,1]}]')):
        path = os.path.join(WORK, "bad.json")
        with open(path, "w") as f:
            f.write(text)
        code, out = plan(GOOD, "--queries", path)
        check(code == 3 and "bad.json" in json.dumps(out["errors"]), f"queries, {what}: exit {code} {out.get('errors')}")
    for what, text, place, word in (
            ("a misspelt key", '[\n {"id": 1, "start": [1,1,1], "goal": [1,1,1]},\n {"id": 2, "strat": [1,1,1], "goal": [1,1,1]}]', ":3:12", "strat"),
            ("two numbers", '[\n {"id": 1,\n  "start": [1,1], "goal": [1,1,1]}]', ":3:3", "three numbers"),
            ("an id twice", '[{"id": 1, "start": [1,1,1], "goal": [1,1,1]},\n {"id": 1, "start": [1,1,1], "goal": [1,1,1]}]', ":2:3", "twice"),
            ("no goal", '[\n  {"id": 1, "start": [1,1,1]}]', ":2:3", "goal"),
            ("a key twice", '[{"id": 1, "start": [1,1,1],\n "goal": [1,1,1], "goal": [2,2,2]}]', ":2:19", "'goal' stands twice"),
            ("a number for a row", '[{"id": 1, "start": [1,1,1], "goal": [1,1,1]},\n 7]', ":2:", "expected"),
            ("1e999", '[\n{"id":1,"start":[1e999,1,1],"goal":[1,1,1]}]', ":2:", "1e999")):
        path = os.path.join(WORK, "bad.json")
        with open(path, "w") as f:
            f.write(text)
        code, out = plan(GOOD, "--queries", path)
        said = [(e["where"], e["message"]) for e in out["errors"]]
        check(code == 3 and any("bad.json" + place in where and word in message for where, message in said), f"queries, {what}: exit {code} {said}")
    for flag, rows, other in (("--motions", [{"id": i, "start": [1, 1, 1], "goal": [2, 2, 2]} for i in range(3)], "--queries"),
                              ("--queries", [{"id": i, "from": [1, 1, 1], "to": [2, 2, 2]} for i in range(3)], "--motions")):
        code, out = plan(GOOD, flag, written("kind.json", rows))
        said = [(e["where"], e["message"]) for e in out["errors"]]
        check(code == 3 and len(said) == 1 and said[0][0].endswith("kind.json:1:2") and other in said[0][1], f"{flag} of the other kind: {code} {said}")
    code, out = plan(altered(lambda s: s["head"][0].update(radius=0)), "--queries", queries)
    check(code == 3 and len(out["errors"]) == 1 and "needs" not in out["errors"][0]["message"], f"a radius of 0 is told once: {out['errors']}")
    code, out = plan(altered(lambda s: s["obstacles"][0].update(size=[10, 0, 10])), "--queries", queries)
    check(code == 3 and len(out["errors"]) == 1 and "needs" not in out["errors"][0]["message"], f"a size of 0 is told once: {out['errors']}")
    tower = altered(lambda s: s["obstacles"][0].update(name="\U0001f600 \\ud83d\\ude00 b\u00e4"))
    row = plan(None, "--queries", written("into.json", [{"id": 1, "start": [1, 1, 1], "goal": [50, 40, 10]}]), text=json.dumps(tower))[1]["queries"][0]
    check(row["status"] == "goal_collides" and row["pair"] == ["needle", tower["obstacles"][0]["name"]], f"a name beyond U+FFFF: {row}")
    code, out = plan(None, "--queries", queries, text=json.dumps(GOOD).replace('"block"', '"\\ud83d alone"'))
    check(code == 3, "half a surrogate pair")
    check(plan(GOOD)[0] == 2, "nothing is asked")
    check(plan(GOOD, "--queries", "/nowhere.json")[0] == 3, "a file that is not there")


def slots_and_pockets():
    wall = lambda name, y0, y1: {"name": name, "type": "box", "center": [50, (y0 + y1) / 2, 20], "size": [5, y1 - y0, 100]}
    scene = altered(lambda s: s.update(obstacles=[wall("front", -50, 39.5), wall("back", 40.8, 130)]))
    queries = written("q.json", [{"id": "slot", "start": [10, 10, 1], "goal": [90, 70, 1]}])
    row = plan(scene, "--queries", queries)[1]["queries"][0]
    check(row["status"] == "ok" and row["min_clearance_mm"] > 0.5, f"a slot of 1.3 mm: {row}")
    scene["obstacles"][1] = wall("back", 40.7, 130)
    row = plan(scene, "--queries", queries)[1]["queries"][0]
    check(row["status"] == "no_path" and row["closed_in"] is None, f"a slot that leaves nothing: {row}")
    shell = lambda yaw: [
        {"name": f"wall {i}", "type": "box", "center": [60 + 15 * x, 40 + 15 * y, 10], "size": [0.05 + 30.05 * (x == 0), 0.05 + 30.05 * (y == 0), 40]}
        for i, (x, y) in enumerate(((1, 0), (-1, 0), (0, 1), (0, -1)))] + [
        {"name": "lid", "type": "box", "center": [60, 40, 35], "size": [31, 31, 0.05]}]
    scene["obstacles"] = shell(0)
    queries = written("q.json", [{"id": "in", "start": [10, 10, 1], "goal": [60, 40, 1]}, {"id": "out", "start": [60, 40, 1], "goal": [10, 10, 1]}])
    begin = time.time()
    rows = plan(scene, "--queries", queries)[1]["queries"]
    check([(x["status"], x["closed_in"]) for x in rows] == [("no_path", "goal"), ("no_path", "start")], f"a pocket of foil: {rows}")
    check(time.time() - begin < 10, "a pocket takes too long")


def turned(scene, c_deg):
    """The head as C has it: about the upright line through the tip, counter-clockwise."""
    a = math.radians(c_deg)
    head = []
    for h in scene["head"]:
        if h.get("on_turn"):
            x, y, z = h["center"]
            h = dict(h, center=[x * math.cos(a) - y * math.sin(a), x * math.sin(a) + y * math.cos(a), z],
                     yaw_deg=h.get("yaw_deg", 0) + c_deg)
        head.append(h)
    return dict(scene, head=head)


def poses(a, b, n):
    for i in range(n + 1):
        q = [a[k] + i / n * (b[k] - a[k]) for k in range(4)]
        yield i / n, q


def what_turns_with_c():
    """Motions and paths of a head with an arm that turns, judged pose by pose."""
    r = random.Random(11)
    head = [{"name": "needle", "type": "capsule", "center": [0, 0, 10], "radius": 0.5, "length": 19},
            {"name": "arm", "type": "box", "center": [14, 2, 12], "size": [24, 3, 6], "yaw_deg": 5, "on_turn": True},
            {"name": "lamp", "type": "cylinder", "center": [-9, 0, 14], "radius": 2, "length": 5, "on_turn": True}]
    reach = 14 + 12 + 4  # of the arm's farthest corner, and more
    free = hits = paths = 0
    for n in range(6):
        obstacles = [{"name": f"block {i}", "type": "box", "center": [r.uniform(20, 180), r.uniform(20, 130), 10],
                      "size": [r.uniform(3, 20), r.uniform(3, 20), 20], "yaw_deg": r.uniform(0, 90)} for i in range(8)]
        scene = {"workspace_tip": {"min": [0, 0, 0], "max": [200, 150, 60]}, "required_clearance_mm": 0.5, "head": head,
                 "obstacles": obstacles}
        some = lambda: [r.uniform(0, 200), r.uniform(0, 150), r.uniform(0, 25), r.uniform(-180, 180)]
        motions = [{"id": i, "from": some(), "to": some()} for i in range(12)]
        for m in motions[:6]:  # short ones that turn far
            m["to"] = [m["from"][k] + r.uniform(-5, 5) for k in range(2)] + [m["from"][2], m["to"][3]]
            m["to"] = [min(max(m["to"][0], 0), 200), min(max(m["to"][1], 0), 150)] + m["to"][2:]
        queries = [{"id": i, "start": some()[:2] + [30, r.uniform(-180, 180)], "goal": some()[:2] + [30, r.uniform(-180, 180)]} for i in range(3)]
        queries += [{"id": "low", "start": some(), "goal": some()}]
        code, out = plan(scene, "--motions", written("m.json", motions), "--queries", written("q.json", queries))
        check(code == 0, f"turning, {n}: {out['errors']}")
        for m, row in zip(motions, out["motions"]):
            steps = 400
            off = math.dist(m["from"][:3], m["to"][:3]) / steps + math.radians(abs(m["to"][3] - m["from"][3])) * reach / steps
            best = min(((least(turned(scene, q[3]), q[:3]), t) for t, q in poses(m["from"], m["to"], steps)))
            if row["free"]:
                free += 1
                check(best[0] > 0.5 - 1e-9, f"turning, {n}: motion {m} is free and comes to {best}")
            else:
                hits += 1
                check(best[0] <= 0.5 + off + 3e-3, f"turning, {n}: motion {m} collides and keeps {best}")
                t = row["t"]
                q = [m["from"][k] + t * (m["to"][k] - m["from"][k]) for k in range(4)]
                if t > 0:
                    check(abs(least(turned(scene, q[3]), q[:3]) - 0.5) < 0.02, f"turning, {n}: contact at {t} of {m}")
            if best[0] > 0:
                check(best[0] - off - 0.011 < row["distance_mm"] < best[0] + 1e-6, f"turning, {n}: {row['distance_mm']} is not {best}")
        for q, row in zip(queries, out["queries"]):
            if row["status"] != "ok":
                check(q["id"] == "low", f"turning, {n}: over all of it nothing stands: {row}")
                continue
            paths += 1
            check(row["path"][0] == q["start"] and row["path"][-1] == q["goal"], f"turning, {n}: ends {row['path']}")
            for a, b in zip(row["path"], row["path"][1:]):
                near = min(least(turned(scene, p[3]), p[:3]) for _, p in poses(a, b, 150))
                check(near > 0.5, f"turning, {n}: a path comes to {near}")
    check(free > 15 and hits > 15 and paths > 15, f"turning: {free} free, {hits} hits, {paths} paths")

    # A slot that lets the needle through, and the arm only along it.
    wall = lambda name, y: {"name": name, "type": "box", "center": [100, y, 30], "size": [80, 60, 60]}
    slot = {"workspace_tip": {"min": [0, 0, 0], "max": [200, 150, 15]}, "required_clearance_mm": 0.5, "head": head,
            "obstacles": [wall("front", 30), wall("back", 120)]}  # 30 mm between them
    ask = written("q.json", [{"id": 1, "start": [20, 75, 2, 90], "goal": [180, 75, 2, 90]}, {"id": 2, "start": [20, 75, 2], "goal": [180, 75, 2]}])
    rows = plan(slot, "--queries", ask)[1]["queries"]
    check([x["status"] for x in rows] == ["ok", "ok"], f"a slot: {rows}")
    check(len(rows[1]["path"]) == 2 and rows[1]["path"][0] == [20, 75, 2, 0], f"without c it stands at 0: {rows[1]['path']}")
    check(min(abs(p[3]) for p in rows[0]["path"]) < 60, f"the arm is turned along the slot: {rows[0]['path']}")
    narrow = dict(slot, turn_deg=[80, 100])
    row = plan(narrow, "--queries", written("q.json", [{"id": 1, "start": [20, 75, 2, 90], "goal": [180, 75, 2, 90]},
                                                       {"id": 2, "start": [20, 75, 2, 70], "goal": [20, 75, 2, 90]}]))[1]["queries"]
    check(row[0]["status"] == "budget", f"where C cannot turn so far, nothing is claimed: {row[0]}")
    check(row[1]["status"] == "start_collides" and row[1]["pair"] == ["tip", "workspace"], f"C outside of its range: {row[1]}")

    # Without a body that turns nothing is as it was not.
    code, out = plan(GOOD, "--queries", written("q.json", [{"id": 1, "start": [1, 1, 1, 0], "goal": [2, 2, 1]}]))
    check(code == 3 and "on_turn" in json.dumps(out["errors"]), f"c where nothing turns: {out}")
    code, out = plan(slot, "--queries", written("q.json", [{"id": 1, "start": [1, 1, 1, 0, 0], "goal": [2, 2, 1]}]))
    check(code == 3 and "[x, y, z, c]" in json.dumps(out["errors"]), f"five numbers: {out}")
    for c in (1.000001e6, -1e300):
        for flag, of in (("--queries", ("start", "goal")), ("--motions", ("from", "to"))):
            rows = [{"id": 1, of[0]: [20, 75, 2, 0], of[1]: [180, 75, 2, c]}]
            code, out = plan(slot, flag, written("q.json", rows))
            place = f"q.json:1:{json.dumps(rows).index(of[1])}"  # of the quote before it, counted from 1
            check(code == 3 and [e["where"].endswith(place) and "degrees" in e["message"] for e in out["errors"]] == [True], f"C at {c}: {place}, {out}")
    code, out = plan(slot, "--motions", written("q.json", [{"id": 1, "from": [20, 75, 2, -1e6], "to": [180, 75, 2, 1e6]}]))
    check(code == 0 and out["motions"][0]["pair"] == ["tip", "workspace"], f"C turns a million degrees: {out}")
    ask = written("q.json", [{"id": 1, "start": [20, 75, 2, 90], "goal": [180, 75, 2, 90]}])
    for what, scene in (("on_turn of an obstacle", dict(slot, obstacles=[dict(wall("front", 30), on_turn=True)])),
                        ("a range of C turned over", dict(slot, turn_deg=[10, -10])),
                        ("a range of C where nothing turns", dict(GOOD, turn_deg=[-10, 10]))):
        code, out = plan(scene, "--queries", ask)
        check(code == 3 and len(out["errors"]) == 1, f"{what}: exit {code} {out.get('errors')}")


def the_same_in_every_order():
    """2000 bodies, some of them zones to keep out of: the order in which a document lists them and their names decide nothing."""
    r = random.Random(5)
    bodies = []
    for i in range(2000):
        h = r.uniform(2, 30)
        b = {"name": f"part {i}", "center": [r.uniform(0, 400), r.uniform(0, 300), h / 2]}
        if i % 3:
            b.update(type="box", size=[r.uniform(2, 6), r.uniform(2, 6), h], yaw_deg=r.choice([0, r.uniform(0, 180)]))
        else:
            b.update(type="cylinder", radius=r.uniform(1, 3), length=h)
        bodies.append(b)
    scene = {"workspace_tip": {"min": [0, 0, 0], "max": [400, 300, 12]}, "required_clearance_mm": 0.3, "head": GOOD["head"],
             "obstacles": bodies[:1900], "keep_out": bodies[1900:]}
    ends = []
    while len(ends) < 24:
        p = [r.uniform(0, 400), r.uniform(0, 300), r.uniform(0, 12)]
        if min(distance(h, p, o) for h in scene["head"] for o in bodies) > 0.31:
            ends.append(p)
    queries = written("q.json", [{"id": i, "start": ends[2 * i], "goal": ends[2 * i + 1]} for i in range(12)])
    code, out = plan(scene, "--queries", queries)
    rows = out["queries"]
    check(code == 0 and all(x["status"] == "ok" for x in rows), f"2000 bodies: {[x['status'] for x in rows]}")
    everything = dict(scene, obstacles=bodies)
    for row in rows[:3]:
        near = min(least_over(everything, a, b) for a, b in zip(row["path"], row["path"][1:]))
        check(near > 0.3, f"2000 bodies, {row['id']}: collides, {near}")
    check(max(x["plan_us"] for x in rows) < 2e6, "2000 bodies take too long")
    other = dict(scene, obstacles=scene["obstacles"][::-1], keep_out=scene["keep_out"][::-1])
    again = plan(other, "--queries", queries)[1]["queries"]
    strip = lambda x: {k: v for k, v in x.items() if k != "plan_us"}
    check([strip(x) for x in again] == [strip(x) for x in rows], "another order, another answer")
    renamed = dict(scene, obstacles=[dict(b, name="other " + b["name"]) for b in scene["obstacles"]])
    check([x["path"] for x in plan(renamed, "--queries", queries)[1]["queries"]] == [x["path"] for x in rows], "other names, another path")
    repeats = written("r.json", [{"id": f"{i}/{n}", "start": ends[2 * i], "goal": ends[2 * i + 1]} for n in range(100) for i in range(4)])
    paths = [x["path"] for x in plan(scene, "--queries", repeats)[1]["queries"]]
    check(all(p == rows[k % 4]["path"] for k, p in enumerate(paths)), "100 repeats differ")


def sealed_among_many():
    """A pocket askew, a wall askew from side to side, among 200 bodies: proved, with the end that is closed in."""
    r = random.Random(9)
    parts = [{"name": f"part {i}", "type": "box", "center": [r.uniform(0, 400), r.uniform(0, 300), 10], "size": [8, 12, 20], "yaw_deg": r.uniform(0, 90)} for i in range(200)]
    turn = lambda x, y, a: [200 + x * math.cos(a) - y * math.sin(a), 150 + x * math.sin(a) + y * math.cos(a)]
    a = math.radians(33)
    pocket = [{"name": f"side {i}", "type": "box", "center": turn(12 * x, 12 * y, a) + [20], "size": [0.05 + 24 * (x == 0), 0.05 + 24 * (y == 0), 60], "yaw_deg": 33}
              for i, (x, y) in enumerate(((1, 0), (-1, 0), (0, 1), (0, -1)))] + [{"name": "lid", "type": "box", "center": [200, 150, 50], "size": [24.05, 24.05, 0.05], "yaw_deg": 33}]
    scene = {"workspace_tip": {"min": [0, 0, 0], "max": [400, 300, 100]}, "required_clearance_mm": 0.3, "head": GOOD["head"]}
    queries = written("q.json", [{"id": "in", "start": [20, 20, 60], "goal": [200, 150, 2]}, {"id": "out", "start": [200, 150, 2], "goal": [20, 20, 60]}])
    rows = plan(dict(scene, obstacles=[b for b in parts if math.dist(b["center"][:2], (200, 150)) > 30] + pocket), "--queries", queries)[1]["queries"]
    check([(x["status"], x["closed_in"]) for x in rows] == [("no_path", "goal"), ("no_path", "start")], f"a pocket askew: {rows}")
    check(max(x["plan_us"] for x in rows) < 2e6, "a pocket askew takes too long")
    for x in (20, 200):
        wall = {"name": "wall", "type": "box", "center": [x, 150, 75], "size": [4, 800, 300], "yaw_deg": 3}
        row = plan(dict(scene, obstacles=parts + [wall]), "--queries", written("q.json", [{"id": 1, "start": [1, 290, 60], "goal": [380, 280, 60]}]))[1]["queries"][0]
        check(row["status"] == "no_path" and row["closed_in"] is None and row["plan_us"] < 2e6, f"a wall from side to side at {x}: {row}")


wrong_documents()
the_same_in_every_order()
workspaces_without_depth()
sealed_among_many()
slots_and_pockets()
what_turns_with_c()
paths_and_motions()
sys.exit(1 if FAILURES else 0)
