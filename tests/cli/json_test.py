"""Every verb with --json.  python3 json_test.py GANTRY FOLDER; an owner is up with the state FOLDER/state"""
import json, os, re, subprocess, sys

gantry, folder = sys.argv[1:3]
state, nobody = os.path.join(folder, "state"), os.path.join(folder, "nobody")
demo = "recipes/demo-board.yaml"
failures = 0


def expect(what, good, text=""):
    global failures
    failures += not good
    if not good:
        print(f"FAILED: {what}: {text[-400:]}", flush=True)


def asked(words):
    done = subprocess.run([gantry, "--json", *words], capture_output=True, text=True, stdin=subprocess.DEVNULL)
    return done.returncode, done.stdout


def look_at(words, wanted=None):
    status, out = asked(words)
    what = " ".join(words)
    try:
        document = json.loads(out)
    except ValueError:
        return expect(what, False, "no JSON document: " + out)
    expect(what, isinstance(document, dict), "no object")
    keys = list(document)
    expect(f"{what}: what stands in front", {"result", "exit_code", "errors"} <= set(keys[:5]), str(keys))
    expect(f"{what}: the exit code is that of the program", document.get("exit_code") == status,
           f"{document.get('exit_code')}, and {status}")
    expect(f"{what}: result is a word", isinstance(document.get("result"), str))
    errors = document.get("errors", [])
    expect(f"{what}: errors", all({"code", "message", "where", "remedy"} <= set(e) for e in errors), str(errors))
    expect(f"{what}: an error has a reason", wanted in (None, status) and (status not in (2, 3, 4, 7) or errors), out)
    return document


def path(name):
    return os.path.join(folder, name)


with open(path("wrong.yaml"), "w") as file:
    file.write("version: 1\n")
with open(path("scene.json"), "w") as file:
    json.dump({"clearance_mm": 1, "obstacles": []}, file)

# For each verb what ends well where that can be had here, and what does not.
rows = {
    "init": [(["init", path("mine")], 0), (["init", path("mine")], 7)],
    "doctor": [(["doctor", "--state", nobody], None), (["doctor", "--interface", "nope0", "--state", nobody], None)],
    "check": [(["check"], 0), (["check", demo], 0), (["check", path("wrong.yaml")], 3)],
    "dry-run": [(["dry-run", demo, "--out", path("a")], 0), (["dry-run", path("wrong.yaml")], 3)],
    "run": [(["run", path("wrong.yaml"), "--state", nobody], 3)],
    "up": [(["up", "--state", state], 7)],
    "home": [(["home", "--bus", "profibus", "--state", nobody], 2)],
    "plan": [(["plan", "--scene", path("scene.json")], 2)],
    "commission": [(["commission", "--bus", "profibus", "--state", nobody], 2)],
    "trace": [(["trace", "diff", path("a"), path("a")], 0), (["trace", "diff", path("a"), path("none")], 3)],
    "explain": [(["explain"], 0), (["explain", "G207"], 0), (["explain", "std402ec"], 0),
                (["explain", "std402ec:8611"], 0), (["explain", "G99999"], 2)],
    "status": [(["status", "--state", state], 0), (["status", "--state", nobody], 7)],
    "part-removed": [(["part-removed", "--state", nobody], 0)],
    "jog": [(["jog", "X", "1", "--state", nobody], None)],
}
for order in ("hold", "resume", "abort", "reset", "enable", "disable", "park", "down"):
    rows[order] = [([order, "--state", nobody], 7)]
rows["override"] = [(["override", "50", "--state", nobody], 7)]
for bus in ("scan", "sdo", "errors", "dc", "capture"):
    rows["bus " + bus] = [(["bus", bus, "--bus", "profibus"], 2)]
rows["bus scan"].append((["bus", "scan"], 0))
rows["bus errors"].append((["bus", "errors"], 0))

for verb, commands in rows.items():
    for words, wanted in commands:
        look_at(words, wanted)
explained = look_at(["explain", "G207"])
expect("the fault's exit code has a name of its own", explained and explained["fault_exit_code"] == 5)

# A verb that is not in the table is one of these: streams, pages, and what belongs to another process.
others = {"monitor", "publish", "sim", "keys", "man", "completion", "pages", "bus", "dashboard", "schema"}
text = subprocess.run([gantry, "--help"], capture_output=True, text=True).stdout
verbs = re.findall(r"^  ([a-z][a-z-]*)", re.search(r"^Subcommands:\n((?:  .*\n?)+)", text, re.M).group(1), re.M)
for verb in verbs:
    expect(f"{verb} is looked at", verb in rows or verb in others)
print(f"{sum(map(len, rows.values()))} documents of {len(rows)} verbs")
sys.exit(failures != 0)
