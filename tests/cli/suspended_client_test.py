"""Ctrl-Z in a client of an owner that is up: held, then suspended; after `fg` keys and Ctrl-C work.
python3 suspended_client_test.py GANTRY RECIPE FOLDER STATE"""
import json, os, subprocess, sys, time

from on_terminal import OnTerminal

gantry, recipe, folder, state = sys.argv[1:5]
failures = 0


def expect(what, got, wanted):
    global failures
    failures += got != wanted
    print(f"ok: {what}" if got == wanted else f"FAILED: {what}: {got!r}, expected {wanted!r}", flush=True)


def status():
    return json.loads(subprocess.run([gantry, "--json", "status", "--state", state], capture_output=True, text=True,
                                     stdin=subprocess.DEVNULL).stdout)


def stands(what):
    """Nothing moves for a second while the shell has its terminal."""
    time.sleep(1)  # the needle is lifted off what the hold has cut
    before = status()
    time.sleep(1)
    after = status()
    expect(f"{what}: held", (before["state"], after["state"]), ("held", "held"))
    apart = max(abs(a["position"] - b["position"]) for a, b in zip(before["axes"], after["axes"]))
    expect(f"{what}: no axis moves", apart < 0.01, True)


def suspend(what):
    shell.type("\x1a")
    shell.wait_for(r"Stopped")
    stands(what)
    shell.wait_for(r"shell> ")
    shell.type("echo the shell is $((40 + 2))\n")
    shell.wait_for(r"the shell is 42")
    shell.type("fg\n")
    shell.wait_for(r"gantry run")
    shell.wait_for(r" held")


def run(name):
    shell.type(f"{gantry} run {recipe} --state {state} --out {os.path.join(folder, name)}\n")


def exit_code():
    shell.wait_for(r"shell> ")
    shell.type("echo status $?\n")
    return shell.wait_for(r"status (\d+)").group(1)


shell = OnTerminal(["bash", "--norc", "--noprofile", "--noediting", "-i"], {"PS1": "shell> "})
shell.wait_for(r"shell> ")
run("done")
shell.wait_for(r" running")
suspend("Ctrl-Z in a job")
shell.type(" ")
shell.wait_for(r" running")
suspend("Ctrl-Z once more")
shell.type(" ")
shell.wait_for(r"3 of 3 features")
expect("resumed and done", exit_code() in ("0", "9"), True)  # 9: a dot that was cut stays a defect
subprocess.run([gantry, "part-removed", "--state", state], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)

run("ended")
shell.wait_for(r" running")
suspend("Ctrl-Z in another job")
shell.type("\x03")
expect("Ctrl-C after fg", exit_code(), "130")
expect("nothing runs any more", status()["busy_with"], None)
sys.exit(failures > 0)
