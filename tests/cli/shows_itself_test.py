"""Long work on a terminal.  python3 shows_itself_test.py GANTRY FOLDER"""
import os, re, subprocess, sys

from on_terminal import OnTerminal

gantry, folder = sys.argv[1:3]
failures = 0


def expect(what, good, text=""):
    global failures
    failures += not good
    print(f"ok: {what}" if good else f"FAILED: {what}: {text[-600:]!r}", flush=True)


def on_terminal(words, environment=None, columns=80):
    p = OnTerminal(words, environment, columns)
    status = p.wait()
    return status, p.text


COLOUR = re.compile(r"\x1b\[[0-9;]*m")
BAR = re.compile(r"\[[#.]{16}\] \d+/35 \d+ s")

dry_run = [gantry, "dry-run", "recipes/demo-board.yaml", "--out"]
status, text = on_terminal(dry_run + [os.path.join(folder, "job")])
expect("a dry run on a terminal ends well", status == 0, text)
expect("it shows how far it is", BAR.search(text), text)
expect("and what is left", re.search(r"about \d+ s left", text), text)
expect("its log lines have colour", COLOUR.search(text), text)
# What stands on a line after all that was written over: a log line begins at its first column.
lines = [re.split(r"\r\x1b\[K", line)[-1] for line in text.split("\r\n")]
logged = [line for line in lines if re.search(r"[IWE](?:\x1b\[[0-9;]*m)? \d\d:\d\d:\d\d\.\d\d\d ", line)]
expect("log lines are told", len(logged) > 3, text)
glued = [line for line in logged if not re.match(r"(\x1b\[[0-9;?]*[a-zA-Z])*[IWE](\x1b\[[0-9;]*m)? ", line)]
expect("none is glued to the bar", not glued, repr(glued))

status, text = on_terminal(dry_run + [os.path.join(folder, "plain")], {"NO_COLOR": "1"})
expect("NO_COLOR takes the colours of the log", status == 0 and not COLOUR.search(text), text)

status, text = on_terminal(dry_run + [os.path.join(folder, "narrow")], columns=40)
bars = [re.sub(r"\x1b\[\?7[lh]", "", each) for each in re.findall(r"\r\x1b\[K(\x1b\[\?7l\[.*?)\x1b\[\?7h", text)]
expect("40 columns show what is left", status == 0 and any(re.search(r"about \d+ s left", each[:40]) for each in bars), text)

status, text = on_terminal(dry_run + [os.path.join(folder, "dumb")], {"TERM": "dumb"})
expect("a terminal that cannot write over a line is not asked to", status == 0 and "\x1b" not in text, text)

piped = subprocess.run(dry_run + [os.path.join(folder, "piped")], capture_output=True, text=True)
expect("without a terminal there is no bar", piped.returncode == 0 and "\x1b" not in piped.stderr + piped.stdout
       and not BAR.search(piped.stderr), piped.stderr)

# Many dots: the proof takes longer than a moment.
with open("tests/cli/short-board.yaml") as file:
    board = file.read()
big = os.path.join(folder, "big.yaml")
with open(big, "w") as file:
    file.write(board[:board.index("features:")] + "features:\n  - array: {name: many, material: adhesive, "
               "at: [10 mm, 8 mm], rows: 120, columns: 160, pitch: [0.25 mm, 0.125 mm]}\n")
status, text = on_terminal([gantry, "check", big])
expect("the check of a large recipe shows that it goes on", re.search(r"checking .*big.yaml: \d+\.\d s", text), text)
shares = [int(each) for each in re.findall(r"big.yaml: \d+\.\d s, (\d+) %, about \d+ s left", text)]
expect("how much of it is done, and what is left", len(shares) > 1 and shares == sorted(shares) and shares[-1] > shares[0]
       and shares[-1] <= 100, text)
expect("and clears that line", status != 0 or re.search(r"\r\x1b\[K[^\r]*big.yaml: 19200 features", text) or
       re.search(r"\n[^\r\n]*big.yaml: 19200 features", text), text)
piped = subprocess.run([gantry, "check", big], capture_output=True, text=True)
expect("but not without a terminal", "checking" not in piped.stderr + piped.stdout, piped.stderr)

sys.exit(failures != 0)
