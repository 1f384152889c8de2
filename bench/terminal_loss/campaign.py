#!/usr/bin/env python3
"""Ends jobs the way terminals do, over a virtual network cable, and judges by the frames on it.
  python3 bench/terminal_loss/campaign.py [--runs 100] [--seed 1] [--gantry build/release/bin/gantry]
Each case: `gantry run` on a terminal of its own, a `gantry sim` at the other end of the cable; at an instant of the seed (in
mid dot or bead, or anywhere from the first torque on) the terminal is lost in one of the ways in WAYS. What must then be
seen on the cable is said in verdict.py. Cases at which the host ended the job before its instant are run again. Needs root (a
network namespace). Exit code 0: every case held; 77: no cable can be made here."""
import argparse, collections, ctypes, json, os, random, re, shutil, signal, socket, subprocess, sys, tempfile, time

here = os.path.dirname(os.path.abspath(__file__))
top = os.path.dirname(os.path.dirname(here))
sys.path[:0] = [os.path.join(top, "tests/cli"), os.path.join(top, "bench"), here]
import quick_machine
from frames import Capture
from verdict import judge, read_stations, what_was_on
from on_terminal import OnTerminal

ATTEMPTS = 5
ANYWHERE_S = 7.0  # from the first torque to the end of the job on the machine below, nearly
WATCHDOG_S = 0.1  # of the stations
PR_SET_CHILD_SUBREAPER = 36
Loss = collections.namedtuple("Loss", "way at_ns last_act_ns stage")


def signal_to_front(number):
    return lambda p: os.kill(p.pid, number)


def twice_apart(p):
    p.type("\x03")
    time.sleep(0.25)
    if p.ended_as is None:
        p.type("\x03")


# SIGPIPE comes to whoever writes, and that is the process behind the front.
WAYS = {
    "SIGHUP": signal_to_front(signal.SIGHUP),
    "closed": OnTerminal.close,
    "SIGPIPE": lambda p: os.kill(p.behind, signal.SIGPIPE),
    "front killed": signal_to_front(signal.SIGKILL),
    "Ctrl-C twice": twice_apart,
    "Ctrl-C": lambda p: p.type("\x03"),
    "SIGQUIT": signal_to_front(signal.SIGQUIT),
    "SIGTERM": signal_to_front(signal.SIGTERM),
    "SIGINT": signal_to_front(signal.SIGINT),
    "Ctrl-C bounced": lambda p: p.type("\x03\x03"),
}
# Nobody is left to say a last word: a judge that lets this pass sees nothing.
CONTROL = {"all killed": lambda p: (os.kill(p.behind, signal.SIGKILL), os.kill(p.pid, signal.SIGKILL))}


def valve_output():
    """Where the I/O station of the reference machine stands, and which bit of it is the valve, read from the text."""
    with open(quick_machine.REFERENCE) as file:
        text = file.read()
    station, bit = re.search(r"^  valve:\s*\{station: (\w+), bit: (\d+)\}", text, re.M).groups()
    position = re.search(rf"^  {station}:.*position: (\d+)", text, re.M).group(1)
    return int(position), int(bit)


def ask_world(path, question):
    with socket.socket(socket.AF_UNIX) as world:
        world.settimeout(10)
        world.connect(path)
        world.sendall((json.dumps(question) + "\n").encode())
        answer = b""
        while not answer.endswith(b"\n"):
            answer += world.recv(65536)
        return json.loads(answer)


def instant(rng):
    """In the second, say, opening of the valve, or that long after the first torque."""
    if rng.random() < 0.5:
        return {"opening": rng.choice([1, 2, 3]), "after_s": rng.uniform(0, 0.06)}
    return {"opening": 0, "after_s": rng.uniform(0, ANYWHERE_S)}


class Case:
    def __init__(self, rig, way, when):
        self.rig, self.way, self.when = rig, way, when
        self.out = os.path.join(rig.folder, "job")
        shutil.rmtree(self.out, ignore_errors=True)
        shutil.rmtree(os.path.join(rig.folder, "none"), ignore_errors=True)  # the part of a program that was killed
        rig.capture.clear()
        self.p = OnTerminal([rig.gantry, "--machine", rig.machine, "run", rig.recipe, "--bus", f"ethercat:{rig.name}-ctl",
                             "--world", rig.world, "--state", os.path.join(rig.folder, "none"), "--out", self.out, "--force"])
        self.p.ended_as = None

    def follow(self, seconds):
        """Hears terminal and cable, and sees the end of the program."""
        self.p.read(seconds)
        self.rig.capture.read()
        if self.p.ended_as is None:
            self.p.ended_as = self.p.ended()

    def reach_the_instant(self):
        """False when the program ends before it."""
        seen, openings, was_open, torque_ns, due_ns = 0, 0, False, None, None
        give_up = time.monotonic() + 90
        while self.p.ended_as is None and time.monotonic() < give_up:
            self.follow(0.0005)
            cycles = self.rig.capture.cycles
            for c in cycles[seen:]:
                if c.answer:
                    continue
                if torque_ns is None and any(a.control & 0x0F == 0x0F for a in c.axes):
                    torque_ns = c.at_ns
                openings += bool(c.valve) and not was_open
                was_open = bool(c.valve)
                if due_ns is None and self.when["opening"] and openings == self.when["opening"]:
                    due_ns = c.at_ns + int(1e9 * self.when["after_s"])
                elif due_ns is None and not self.when["opening"] and torque_ns is not None:
                    due_ns = torque_ns + int(1e9 * self.when["after_s"])
            seen = len(cycles)
            if due_ns is not None and time.time_ns() >= due_ns and self.p.ended_as is None:
                return True
        return False

    def run(self):
        """What is wrong (None: the instant was not reached), and the figures."""
        rig, p = self.rig, self.p
        if not self.reach_the_instant():
            self.end_it()
            return None, f"exit {p.ended_as}: {p.text[-200:]!r}"
        p.behind = p.child()
        stage = what_was_on(rig.capture.cycles)
        at_ns = time.time_ns()
        rig.ways[self.way](p)
        last_act_ns = time.time_ns()
        status = self.wait_for_the_end()
        time.sleep(3 * WATCHDOG_S)
        rig.capture.read()
        if status == 0 and not any(c.at_ns > at_ns for c in rig.capture.cycles):
            self.p.close()
            return None, "the bus was down already, and the files of a job that was done were being written"
        wrong, figures = judge(rig.capture.cycles, Loss(self.way, at_ns, last_act_ns, stage), rig.capture.lost())
        wrong += read_stations(f"{rig.name}-ctl", rig.capture.position_of, rig.capture.io_position)
        wrong += self.judge_result(status)
        wrong += self.judge_world()
        return wrong, f"{stage:15} {figures}"

    def wait_for_the_end(self):
        """Exit status of who held the machine."""
        end = time.monotonic() + 30
        while self.p.ended_as is None and time.monotonic() < end:
            self.follow(0.002)
        if self.p.ended_as != -signal.SIGKILL or self.p.behind == self.p.pid:
            if self.p.ended_as is None:
                self.end_it()
                return "it does not end"
            return self.p.ended_as
        while time.monotonic() < end:  # the front was killed, and its child is ours now
            self.rig.capture.read()
            done, status = os.waitpid(self.p.behind, os.WNOHANG)
            if done:
                return os.waitstatus_to_exitcode(status)
            time.sleep(0.002)
        os.kill(self.p.behind, signal.SIGKILL)
        return "it does not end"

    def end_it(self):
        if self.p.ended_as is None:
            os.kill(self.p.pid, signal.SIGKILL)
            os.waitpid(self.p.pid, 0)
        self.p.close()

    def judge_result(self, status):
        wrong = [] if status == 130 else [f"exit {status}: {self.p.text[-300:]!r}"]
        self.p.close()
        try:
            with open(os.path.join(self.out, "summary.json")) as file:
                result = json.load(file)["result"]
        except OSError:
            result = "missing"
        # The second Ctrl-C ends the program at once: it may have no time for a summary.
        if result != "interrupted" and not (self.way == "Ctrl-C twice" and result == "missing"):
            wrong.append(f"the summary is {result}")
        return wrong

    def judge_world(self):
        deposits = ask_world(self.rig.world, {"do": "deposits"})["deposits"]
        wrong = ["a deposit is not closed"] if any(d["closed_cycle"] < d["opened_cycle"] for d in deposits) else []
        time.sleep(WATCHDOG_S)
        if len(ask_world(self.rig.world, {"do": "deposits"})["deposits"]) != len(deposits):
            wrong.append("something was dispensed later")
        return wrong


class Rig:
    """The cable and the simulated machine at its other end."""

    def __init__(self, given, folder):
        self.gantry, self.recipe, self.name, self.folder = given.gantry, given.recipe, given.name, folder
        self.ways = CONTROL if given.control else WAYS
        self.world = os.path.join(folder, "world")
        self.machine = quick_machine.write(folder, [("frames_lost_max: 3\n", "frames_lost_max: 50\n"), ("sim: 50}", "sim: 1000}")])
        io_position, valve_bit = valve_output()
        self.capture = Capture(f"{self.name}-ctl", io_position, valve_bit)
        self.sim = subprocess.Popen([self.gantry, "-q", "--machine", self.machine, "sim", "--interface", f"{self.name}-sim",
                                     "--world", self.world], stdin=subprocess.DEVNULL)
        while not os.path.exists(self.world):
            if self.sim.poll() is not None:
                sys.exit("the simulated machine does not start")
            time.sleep(0.05)

    def reset(self):
        """A bus that was left in disorder, by a host that stood still, has faults that are latched."""
        state = os.path.join(self.folder, "state")
        common = [self.gantry, "--machine", self.machine]
        up = subprocess.Popen([*common, "up", "--bus", f"ethercat:{self.name}-ctl", "--world", self.world, "--state", state],
                              stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for _ in range(100):
            if subprocess.run([*common, "reset", "--state", state], capture_output=True).returncode == 0:
                break
            time.sleep(0.1)
        up.terminate()
        up.wait()


def campaign(given):
    folder = tempfile.mkdtemp()
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1)
    rig = Rig(given, folder)
    rng, failed, again, worst_ms = random.Random(given.seed), 0, 0, []
    try:
        for number in range(given.runs):
            way, wrong = list(rig.ways)[number % len(rig.ways)], None
            for _ in range(ATTEMPTS):
                case = Case(rig, way, instant(rng))
                wrong, figures = case.run()
                if wrong is not None:
                    break
                again += 1
                print(f"{number:3} {way:15} again: {figures}", flush=True)
                if case.p.ended_as != 0:
                    rig.reset()
            else:
                wrong, figures = ["the instant was never reached"], ""
            failed += bool(wrong)
            worst_ms += [float(x) for x in re.findall(r"valve ([\d.]+) ms", figures)]
            print(f"{number:3} {way:15} {figures} {'; '.join(wrong) or 'ok'}", flush=True)
            if wrong:
                rig.reset()
        print(f"seed {given.seed}: {given.runs - failed} of {given.runs} held; {len(worst_ms)} with the valve open, shut after "
              f"{max(worst_ms, default=0):.1f} ms at the latest; {again} run again because the job ended before its instant")
        return 1 if failed else 0
    finally:
        rig.sim.terminate()
        rig.sim.wait()
        shutil.rmtree(folder, ignore_errors=True)


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--runs", type=int, default=100)
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--gantry", default=os.path.join(top, "build/release/bin/gantry"))
    options.add_argument("--recipe", default=os.path.join(top, "tests/cli/short-board.yaml"))
    options.add_argument("--name", default=f"gtl{os.getpid()}", help="of the network namespace")
    options.add_argument("--control", action="store_true", help="kill -9, which must not hold")
    options.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    given = options.parse_args()
    given.gantry, given.recipe = os.path.abspath(given.gantry), os.path.abspath(given.recipe)
    os.chdir(top)
    if given.inside:
        return campaign(given)
    if subprocess.run(["scripts/veth-pair", "up", given.name]).returncode != 0:
        print("no virtual network cable can be made here: it needs root")
        return 77
    try:
        return subprocess.run(["scripts/veth-pair", "exec", given.name, "--", sys.executable, __file__, "--inside",
                               "--runs", str(given.runs), "--seed", str(given.seed), "--gantry", given.gantry,
                               "--recipe", given.recipe, "--name", given.name,
                               *["--control"] * given.control]).returncode
    finally:
        subprocess.run(["scripts/veth-pair", "down", given.name])


if __name__ == "__main__":
    sys.exit(main())
