"""Both ends of a cable: the far one stands still, or is started again; a second owner wants the near one. What a controller did
is judged from its frames (bench/terminal_loss/frames.py).  python3 cable_test.py GANTRY MACHINE CABLE FOLDER"""
import json, os, signal, subprocess, sys, threading, time

sys.path.insert(0, "bench/terminal_loss")
from frames import Capture
from wire import APRD, APWR, BWR, LRW, parse

gantry, machine, cable, folder = sys.argv[1:5]
recipe, world = "tests/cli/short-board.yaml", os.path.join(folder, "world")
near, far = f"{cable}-ctl", f"{cable}-sim"
FRAMES_LOST_MAX = 50  # of this machine file
SLACK = 10            # cycles: a loop that was late sends the next beat, not the one that it missed
IO_POSITION, VALVE_BIT = 0, 0
failures = 0


def expect(what, good, more=""):
    global failures
    failures += not good
    print(f"ok: {what}" if good else f"FAILED: {what}: {more}", flush=True)


def words_of(*words, state="state"):
    own = ["--bus", f"ethercat:{near}", "--world", world] if words[0] in ("run", "up", "home") else []
    return [gantry, "-q", "--machine", machine, *words, *own, "--state", os.path.join(folder, state)]


def program(*words, state="state"):
    """A client; it must not wait for ever."""
    return subprocess.run(words_of(*words, state=state), capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=120)


def summary(name):
    with open(os.path.join(folder, name, "summary.json")) as file:
        return json.load(file)


class Program:
    def __init__(self, words):
        self.log = open(os.path.join(folder, "log"), "w+")
        self.process = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=self.log, stderr=self.log)

    def said(self):
        with open(self.log.name) as file:
            return file.read()

    def end(self, number=signal.SIGTERM):
        self.process.send_signal(number)
        return self.process.wait(60)


def start_sim():
    sim = Program([gantry, "-q", "--machine", machine, "sim", "--interface", far, "--world", world])
    end = time.monotonic() + 20
    while not os.path.exists(world):
        if sim.process.poll() is not None or time.monotonic() > end:
            sys.exit("FAILED: no simulated machine: " + sim.said())
        time.sleep(0.02)
    return sim


def status(state="state"):
    got = program("status", "--json", state=state)
    return json.loads(got.stdout) if got.returncode == 0 else {}


def start_owner():
    owner = Program(words_of("up"))
    wait_until("the owner is up", lambda: status().get("state", "offline") != "offline")
    return owner


def wait_until(what, condition, seconds=60):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        got = condition()
        if got:
            return got
        time.sleep(0.02)
    sys.exit(f"FAILED: {what}: not within {seconds} s")


def reset():
    """Until nothing is latched and nothing more comes: stations come back one after the other."""
    def done():
        if program("reset").returncode != 0:
            return False
        time.sleep(1)
        return status().get("faults") == []
    wait_until("reset", done)


def job_of_owner(name):
    """Of the owner that is up. Frames that a busy host loses say nothing about it: then it is run again."""
    for _ in range(3):
        got = program("run", recipe, "--out", os.path.join(folder, name), "--force")
        if "G102" not in got.stderr:
            break
        reset()
    return got


def start_job(name, capture, state="none"):
    """A job that is in its bead or in a dot: the valve has been open for some frames."""
    for _ in range(5):
        capture.clear()
        job = Program(words_of("run", recipe, "--out", os.path.join(folder, name), "--force", state=state))
        while job.process.poll() is None:
            capture.read()
            if sum(bool(c.valve) for c in capture.cycles[-40:] if not c.answer) >= 10:
                return job
            time.sleep(0.001)
        print("again: the job ended by itself:", job.said()[-400:], flush=True)
        owner = start_owner()
        reset()
        owner.end()
    sys.exit("FAILED: no job comes so far")


def far_end_stands_still(sim, capture):
    job = start_job("still", capture)
    sim.process.send_signal(signal.SIGSTOP)
    stopped = time.monotonic()
    code = job.process.wait(60)
    took = time.monotonic() - stopped
    capture.read()
    said = [c for c in capture.cycles if not c.answer and c.axes]
    last_answer_ns = max(c.at_ns for c in capture.cycles if c.answer)
    unanswered = [c for c in said if c.at_ns > last_answer_ns]
    shut = next((i for i, c in enumerate(unanswered) if not c.valve), None)
    off = next((i for i, c in enumerate(unanswered) if not any(a.control & 0x0F == 0x0F for a in c.axes)), None)
    braked = unanswered[:off]  # where the torque goes, targets become what the drives were last seen at
    at_rest = next((i for i in range(1, len(braked)) if all(
        [a.target for a in c.axes] == [a.target for a in braked[i].axes] for c in braked[i:])), None)
    expect("the valve is told to shut after as many lost frames as are allowed",
           shut is not None and shut <= FRAMES_LOST_MAX + SLACK, (shut, len(unanswered)))
    expect("and stays so", not any(c.valve for c in unanswered[shut:]))
    expect("targets stand still within a second", at_rest is not None and at_rest <= FRAMES_LOST_MAX + 1000, at_rest)
    expect("no drive is left with its torque on", off is not None, hex(unanswered[-1].axes[0].control))
    s = summary("still")
    expect("lost frames end it, exit 5", code == 5 and s["exit_code"] == 5 and s["errors"][0]["code"] == "G102" and
           "did not come back" in job.said(), (code, s["errors"], job.said()))
    expect(f"within 20 s ({took:.1f} s)", took < 20)
    expect("the world's silence is told once", job.said().count("G709") <= 1, job.said())
    print(f"valve shut in frame {shut} without an answer, standing in {at_rest}, torque off in {off}", flush=True)

    sim.process.send_signal(signal.SIGCONT)
    owner = start_owner()
    reset()
    done = job_of_owner("goes-on")
    expect("the far end goes on: a new job is done", done.returncode == 0, done.stderr)
    owner.end()


def a_second_owner(capture):
    job = start_job("first", capture)
    capture.frames_of = []
    dissect, capture.dissect = capture.dissect, lambda data, at_ns, answer: capture.frames_of.append((data, answer))
    most, over = [], threading.Event()

    def watch():  # whoever opens a socket for the bus stands here
        while not over.is_set():
            with open("/proc/net/packet") as file:
                rows = [line.split() for line in file][1:]
            index = open(f"/sys/class/net/{near}/ifindex").read().strip() if os.path.exists(f"/sys/class/net/{near}") else None
            most.append(sum(row[3] == "88a4" and (index is None or row[4] == index) for row in rows))

    capture.read()
    capture.frames_of.clear()
    before = len([line for line in open("/proc/net/packet") if " 88a4 " in line])
    watcher = threading.Thread(target=watch)
    watcher.start()
    refused = [program("run", recipe, "--out", os.path.join(folder, "second"), state="other"), program("up", state="other")]
    running = job.process.poll() is None
    over.set()
    watcher.join()
    capture.read()
    capture.dissect = dissect
    for got, verb in zip(refused, ("run", "up")):
        expect(f"a second {verb} is refused, naming interface and owner", got.returncode == 7 and "G703" in got.stderr and
               near in got.stderr and f"process {job.process.pid}" in got.stderr and "remedy" in got.stderr,
               (got.returncode, got.stderr))
    expect("both while the first one's job ran", running)
    sent = [parse(data) for data, answer in capture.frames_of if not answer]
    kinds = {datagram[0] for frame in sent for datagram in frame}
    expect("meanwhile all frames are cyclic ones", len(sent) > 20 and all(any(d[0] == LRW for d in f) for f in sent) and
           not kinds & {APRD, APWR, BWR}, (len(sent), kinds))
    expect("no socket was opened for the bus", max(most) <= before, (before, max(most)))
    code = job.process.wait(120)
    s = summary("first")
    expect("the first one's job is done, undisturbed", code == 0 and s["result"] == "done" and
           sorted(d["id"] for d in s["deposits"]) == ["a", "b", "corner"], (code, s["result"], job.said()))


def far_end_is_started_again(sim):
    owner = start_owner()
    expect("a job", job_of_owner("before").returncode == 0)
    sim.end()
    wait_until("lost frames are latched", lambda: status().get("state") == "stopped")
    refused = program("run", recipe, "--out", os.path.join(folder, "meanwhile"))
    expect("without a simulated machine a job is refused, with a remedy", refused.returncode in (5, 7) and
           "remedy" in refused.stderr, (refused.returncode, refused.stderr))
    sim = start_sim()
    reset()
    axes = status()["axes"]
    expect("drives that were without supply have lost their references", not any(a["referenced"] for a in axes), axes)
    after = job_of_owner("after")
    expect("started again, a job is done", after.returncode == 0 and len(summary("after")["deposits"]) == 3, after.stderr)
    expect("and the owner ends in order", owner.end() == 0, owner.said())
    return sim


sim = start_sim()
capture = Capture(near, IO_POSITION, VALVE_BIT)
try:
    far_end_stands_still(sim, capture)
    a_second_owner(capture)
    sim = far_end_is_started_again(sim)
finally:
    sim.process.send_signal(signal.SIGCONT)
    sim.end()
sys.exit(failures > 0)
