"""The operator's keys, on a terminal of the test's own.  python3 keys_test.py GANTRY RECIPE FOLDER"""
import json, os, sys

from on_terminal import OnTerminal

gantry, recipe, folder = sys.argv[1:4]


class Job(OnTerminal):
    def __init__(self, name):
        self.out = os.path.join(folder, name)
        super().__init__([gantry, "run", recipe, "--state", os.path.join(folder, "none"), "--out", self.out])

    def end(self):
        status = self.wait(120)
        with open(os.path.join(self.out, "summary.json")) as file:
            return status, json.load(file)


def expect(what, got, wanted):
    if got != wanted:
        sys.exit(f"FAILED: {what}: {got!r}, expected {wanted!r}")
    print("ok:", what)


job = Job("held")
job.wait_for(r" running")
job.type("-")
job.wait_for(r"running 90 %")
job.type("+")
job.type(" ")
job.wait_for(r" held")
job.type(" ")
job.wait_for(r" running")
status, summary = job.end()
expect("held, resumed and done", (status, summary["result"], summary["counts"]["features_done"]), (0, "done", 3))
expect("every shot on its feature", sorted(d["id"] for d in summary["deposits"]), ["a", "b", "corner"])

job = Job("aborted")
job.wait_for(r" running")
job.type("a")
status, summary = job.end()
expect("aborted", (status, summary["result"], summary["errors"][0]["code"]), (7, "aborted", "G701"))
