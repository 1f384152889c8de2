"""Orders and signals while the world says nothing.  python3 silent_world_test.py GANTRY MACHINE FOLDER BUS
Between the owner and the world in FOLDER/world stands a wire that can be told to swallow what the world says."""
import json, os, signal, socket, subprocess, sys, threading, time

from owner_client import OwnerClient

gantry, machine, work, bus = sys.argv[1:5]
recipe = os.path.abspath("tests/cli/short-board.yaml")
state = os.path.join(work, "state")
PATIENCE = 10  # seconds for which an owner waits for a world that nobody has given up
failed = 0


def expect(what, good, more=""):
    global failed
    print("ok:" if good else "FAILED:", what, "" if good else more)
    failed += not good


class Wire:
    """A socket in front of the world's."""

    def __init__(self, path):
        self.path = path
        self.swallow = None  # what is asked from there on is not passed on
        self.silent = threading.Event()
        self.listening = socket.socket(socket.AF_UNIX)
        self.listening.bind(path)
        self.listening.listen(8)
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        while True:
            here, _ = self.listening.accept()
            there = socket.socket(socket.AF_UNIX)
            there.connect(os.path.join(work, "world"))
            threading.Thread(target=self.pass_questions, args=(here, there), daemon=True).start()
            threading.Thread(target=self.pass_answers, args=(there, here), daemon=True).start()

    def pass_questions(self, here, there):
        for line in here.makefile("rb"):
            if self.swallow and self.swallow in line:
                self.silent.set()
            if self.silent.is_set():
                continue
            there.sendall(line)
        there.close()

    @staticmethod
    def pass_answers(there, here):
        try:
            while part := there.recv(65536):
                here.sendall(part)
        except OSError:
            pass

    def keep_silent(self, about):
        self.silent.clear()
        self.swallow = about

    def speak(self):
        self.swallow = None
        self.silent.clear()


def up():
    owner = subprocess.Popen([gantry, "--machine", machine, "up", "--state", state, "--bus", bus, "--world", wire.path],
                             stdout=log, stderr=log, stdin=subprocess.DEVNULL)
    end = time.monotonic() + 60
    while time.monotonic() < end:
        try:
            if OwnerClient(state).ask(order="status")["state"] != "offline":
                return owner
        except (OSError, ValueError):
            time.sleep(0.05)
    sys.exit("FAILED: no owner came up: " + open(log.name).read()[-2000:])


def job(out):
    return subprocess.Popen([gantry, "--machine", machine, "--json", "run", recipe, "--state", state, "--out",
                             os.path.join(work, out)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                            stdin=subprocess.DEVNULL)


log = open(os.path.join(work, "up.log"), "a+")
wire = Wire(os.path.join(work, "wire"))
owner = up()
for about, where in ((b'"fetch"', "at a mark"), (b'"holds_board"', "before anything moves"), (b'"deposits"', "at the end")):
    wire.keep_silent(about)
    out = "silent-" + about.decode().strip('"')
    running = job(out)
    expect(f"the world falls silent {where}", wire.silent.wait(120), open(log.name).read()[-2000:])
    took, stood = [], set()
    client = OwnerClient(state)
    for _ in range(20):
        begin = time.monotonic()
        seen = client.ask(order="status")
        took.append(time.monotonic() - begin)
        stood.add(tuple(round(axis["position"], 2) for axis in seen["axes"]))  # but for what drives settle by
        time.sleep(0.01)
    expect(f"orders are answered while it is silent {where}", sorted(took)[10] <= 0.02, took)
    expect(f"nothing moves and nothing is dispensed {where}", len(stood) == 1 and seen["feature"] is None, (stood, seen))
    begin = time.monotonic()
    told = client.ask(order="abort")
    heard_s = time.monotonic() - begin
    answer = json.loads(running.communicate(timeout=60)[0])
    over_s = time.monotonic() - begin
    expect(f"an abort is heard {where}", told["ok"] and heard_s < 0.2, (told, heard_s))
    expect(f"and the job is over soon {where}", over_s < PATIENCE / 2, over_s)
    codes = [e["code"] for e in answer["errors"]]
    if about == b'"deposits"':  # everything was done by then, and the world alone has not said what lies there
        expect("the job says that the world is gone", codes == ["G709"], codes)
    else:
        expect(f"it ends as aborted {where}", codes[:1] == ["G701"], codes)
    wire.speak()
    OwnerClient(state).ask(order="part_removed")

done = job("after").communicate(timeout=120)
expect("the next job finds the world again", json.loads(done[0])["result"] == "done", done)

wire.keep_silent(b'"fetch"')
running = job("signal")
wire.silent.wait(120)
time.sleep(0.3)
begin = time.monotonic()
owner.send_signal(signal.SIGTERM)
code = owner.wait(60)
over_s = time.monotonic() - begin
expect("SIGTERM is heard while the world is silent", over_s < PATIENCE / 2, over_s)
expect("the owner ends in order", code in (0, 130), code)
running.communicate(timeout=60)

# The whole simulated machine stands still, its bus as well: nobody has to say that its world is not waited for.
wire.speak()
simulated = int(open(os.path.join(work, "sim.pid")).read())
for signalled in (False, True):
    owner = up()
    client, end = OwnerClient(state), time.monotonic() + 60
    while not client.ask(order="reset")["ok"] and time.monotonic() < end:  # stations whose bus stood still have stopped
        time.sleep(0.1)
    running = job(f"stands-{signalled}")
    while client.ask(order="status")["state"] != "homing" and time.monotonic() < end:
        time.sleep(0.01)
    os.kill(simulated, signal.SIGSTOP)
    begin = time.monotonic()
    try:
        if signalled:
            owner.send_signal(signal.SIGTERM)
        answer = json.loads(running.communicate(timeout=60)[0])
        over_s = time.monotonic() - begin
        expect("a job whose machine stands still is over soon", over_s < PATIENCE / 2, (signalled, over_s))
        first = [e["code"] for e in answer["errors"]][:1]
        expect("and says why it ended", first == ["G102"] or (signalled and first == ["G700"]), (signalled, answer["errors"]))
        if not signalled:
            owner.send_signal(signal.SIGTERM)
        owner.wait(60)
        expect("its owner, too", time.monotonic() - begin < PATIENCE, (signalled, time.monotonic() - begin))
    finally:
        os.kill(simulated, signal.SIGCONT)
sys.exit(1 if failed else 0)
