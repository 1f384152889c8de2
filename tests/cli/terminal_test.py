"""What ends a job on a terminal, what does not hold it up, and Ctrl-Z.  python3 terminal_test.py GANTRY RECIPE FOLDER"""
import fcntl, json, os, signal, subprocess, sys, time

from on_terminal import OnTerminal, as_a_user

gantry, recipe, folder = sys.argv[1:4]
failures = 0


def expect(what, got, wanted):
    global failures
    failures += got != wanted
    print(f"ok: {what}" if got == wanted else f"FAILED: {what}: {got!r}, expected {wanted!r}", flush=True)


SHELL = ["bash", "--norc", "--noprofile", "--noediting", "-i"]  # whose job the program then is


def job(name):
    out = os.path.join(folder, name)
    return out, [gantry, "run", recipe, "--state", os.path.join(folder, "none"), "--out", out]


def summary(out):
    try:
        with open(os.path.join(out, "summary.json")) as file:
            return json.load(file)
    except OSError:
        return {"result": "no summary"}


def expect_in_order(what, out, status):
    s = summary(out)
    expect(what, (status, s["result"], s.get("exit_code"), [e["code"] for e in s.get("errors", [])][:1]),
           (130, "interrupted", 130, ["G700"]))


# Signals, to the process that the shell knows.
for number in (signal.SIGHUP, signal.SIGQUIT, signal.SIGTERM, signal.SIGINT, signal.SIGPIPE):
    out, words = job(number.name)
    p = OnTerminal(words)
    p.wait_for(r" running")
    if number == signal.SIGPIPE:  # nobody sends it to a group: it comes to whoever writes, who stands behind the front
        os.kill(p.child(), number)
    else:
        os.kill(p.pid, number)
    expect_in_order(f"{number.name} in a job", out, p.wait())

# The terminal itself goes.
out, words = job("closed")
p = OnTerminal(words)
p.wait_for(r" running")
p.close()
expect_in_order("the terminal is closed", out, p.wait())

# Ctrl-C, typed, once; and twice, which does not wait.
out, words = job("ctrl-c")
p = OnTerminal(words)
p.wait_for(r" running")
p.type("\x03")
expect_in_order("Ctrl-C", out, p.wait())
out, words = job("twice")
p = OnTerminal(words)
p.wait_for(r" running")
p.type("\x03\x03")
expect_in_order("two Ctrl-C that a hand cannot have meant", out, p.wait())

# The log's reader dies, without any terminal: the next line that is logged ends the job.
out, words = job("pipe")
reader, writer = os.pipe()
p = subprocess.Popen([gantry, "-v", *words[1:]], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=writer,
                     preexec_fn=as_a_user, start_new_session=True)
os.close(writer)
said = b""
while b"homing" not in said and p.poll() is None:
    said += os.read(reader, 65536)
os.close(reader)
expect_in_order("nobody reads stderr any more", out, p.wait(60))

# A log that its reader leaves unread, and a terminal that is stopped with Ctrl-S, hold nothing up.
out, words = job("full")
reader, writer = os.pipe()
fcntl.fcntl(writer, fcntl.F_SETPIPE_SZ, 4096)
os.set_blocking(writer, False)
os.write(writer, b"x" * 4096)
os.set_blocking(writer, True)
p = subprocess.Popen([gantry, "-v", *words[1:]], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=writer,
                     preexec_fn=as_a_user)
expect("stderr is a pipe that is full", (p.wait(120), summary(out)["result"]), (0, "done"))
out, words = job("ctrl-s")
p = OnTerminal(words)
p.wait_for(r" running")
p.type("\x13")
end = time.monotonic() + 60
while summary(out)["result"] == "no summary" and time.monotonic() < end:
    time.sleep(0.1)
expect("a terminal that is stopped", summary(out)["result"], "done")
p.type("\x11")
expect("and goes on", p.wait(), 0)

# Ctrl-Z: held, the shell has its terminal; fg: the keys are back, and the job waits for its operator.
out, words = job("suspended")
p = OnTerminal(SHELL, {"PS1": "shell> "})
p.wait_for(r"shell> ")
p.type(" ".join(words) + "\n")
p.wait_for(r" running")
p.type("\x1a")
p.wait_for(r"Stopped")
p.wait_for(r"shell> ")
p.type("echo the shell is $((40 + 2))\n")
p.wait_for(r"the shell is 42")
p.type("fg\n")
p.wait_for(r"gantry run")
p.wait_for(r" held")
p.type(" ")
p.wait_for(r" running")
p.type("\x1a")
p.wait_for(r"Stopped")
p.type("fg\n")
p.wait_for(r" held")
p.type(" ")
p.wait_for(r"done: 3 of 3")
p.wait_for(r"shell> ")
p.type("echo status $?\n")
expect("suspended twice, resumed and done", p.wait_for(r"status (\d+)").group(1), "0")
expect("every shot on its feature", sorted(d["id"] for d in summary(out)["deposits"]), ["a", "b", "corner"])

out, words = job("ended")
p.type(" ".join(words) + "\n")
p.wait_for(r" running")
p.type("\x1a")
p.wait_for(r"Stopped")
p.type("fg\n")
p.wait_for(r" held")
p.type("\x03")
p.wait_for(r"shell> ")
p.type("echo status $?\n")
expect_in_order("Ctrl-C after fg", out, int(p.wait_for(r"status (\d+)").group(1)))

# The shell dies while the job is suspended: nobody will resume it.
out, words = job("forsaken")
p.type(" ".join(words) + "\n")
p.wait_for(r" running")
p.type("\x1a")
p.wait_for(r"Stopped")
p.close()
end = time.monotonic() + 60
while summary(out)["result"] == "no summary" and time.monotonic() < end:
    time.sleep(0.1)
expect("a suspended job whose terminal is closed", summary(out)["result"], "interrupted")

# The front is killed: whoever holds the machine ends in order.
out, words = job("front")
p = OnTerminal(words)
p.wait_for(r" running")
os.kill(p.pid, signal.SIGKILL)
end = time.monotonic() + 60
while summary(out)["result"] == "no summary" and time.monotonic() < end:
    time.sleep(0.1)
expect("the front is killed", summary(out)["result"], "interrupted")
sys.exit(failures > 0)
