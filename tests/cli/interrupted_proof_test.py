"""Ctrl-C while a recipe is proved.  python3 interrupted_proof_test.py GANTRY FOLDER
Each time at a known point of it: when the terminal shows that a part is done."""
import json, os, resource, signal, sys

from on_terminal import OnTerminal

gantry, folder = sys.argv[1:3]
failures = 0
MOST_CPU_S = 0.3  # of a proof of some seconds


def expect(what, good, text=""):
    global failures
    failures += not good
    print(f"ok: {what}" if good else f"FAILED: {what}: {str(text)[-600:]!r}", flush=True)


with open("tests/machine/many-dots.yaml") as file:
    many = file.read().replace("rows: 50, columns: 80, pitch: [0.5 mm, 0.5 mm]", "rows: 200, columns: 250, pitch: [0.15 mm, 0.15 mm]")
recipe = os.path.join(folder, "very-many-dots.yaml")
with open(recipe, "w") as file:
    file.write(many)


def cpu_s(pid):
    with open(f"/proc/{pid}/stat") as file:
        fields = file.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def ended_cpu_s():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def interrupted(words, what, send, board):
    before = ended_cpu_s()
    p = OnTerminal([gantry, *words])
    p.wait_for(r"[1-9]\d? %, about")
    used = cpu_s(p.child())
    send(p)
    status = p.wait()
    expect(f"{what}: exit code 130", status == 130, (status, p.text))
    expect(f"{what}: it says so", "interrupted while the recipe was prepared; nothing has moved" in p.text, p.text)
    after = ended_cpu_s() - before - used
    expect(f"{what}: at once", after <= MOST_CPU_S, f"{after:.2f} s of CPU time after it was asked to end")
    if board is None:
        return
    with open(os.path.join(board, "summary.json")) as file:
        summary = json.load(file)
    told = {key: summary[key] for key in ("result", "exit_code", "board")}
    expect(f"{what}: its folder tells it", told == {"result": "interrupted", "exit_code": 130, "board": "untouched"}, told)


def sends(number):
    return lambda p: os.kill(p.child(), number)


interrupted(["check", recipe], "check, Ctrl-C", lambda p: p.type("\x03"), None)
for verb, more in (("dry-run", []), ("run", ["--state", os.path.join(folder, "state")])):
    for name, send in (("Ctrl-C", lambda p: p.type("\x03")), ("SIGTERM", sends(signal.SIGTERM))):
        out = os.path.join(folder, f"{verb}-{name}")
        interrupted([verb, recipe, "--out", out, *more], f"{verb}, {name}", send, out)
sys.exit(failures != 0)
