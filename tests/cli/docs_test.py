"""What README.md and docs/ name must be there: verbs and options of `gantry`, files, faults, exit codes, topics, headings
that links lead to. Every command line stands in a fence that says whether it is run here or why not, and those that are
marked `runnable` are run."""
import os
import re
import subprocess
import sys
import tempfile

gantry, source = sys.argv[1], sys.argv[2]
failures = []


def fail(place, why):
    failures.append(f"{place}: {why}")


def said(*words):
    done = subprocess.run([gantry, *words], capture_output=True, text=True, stdin=subprocess.DEVNULL)
    return done.stdout + done.stderr


def verbs_of(help_text):
    listed = re.search(r"^Subcommands:\n((?:  .*\n?)+)", help_text, re.M)
    return re.findall(r"^  ([a-z][a-z-]*)", listed.group(1), re.M) if listed else []


def options_of(help_text):
    return set(re.findall(r"(?<![\w-])(--?[a-zA-Z][a-z-]*)", re.split(r"\n\n(?=[A-Z][^\n]*[^:]\n)", help_text)[0]))


class Verb:
    """The program, or one of its verbs, by its own help."""

    def __init__(self, words):
        text = said(*words, "--help")
        self.options = options_of(text)
        self.verbs = {v: Verb([*words, v]) for v in verbs_of(text)}

    def all_options(self):
        return self.options.union(*(v.all_options() for v in self.verbs.values()))


program = Verb([])
if len(program.verbs) < 20 or "--machine" not in program.options:
    sys.exit(f"the help cannot be read: {sorted(program.verbs)}, {sorted(program.options)}")
faults = set(re.findall(r"\bG\d{3}\b", open(os.path.join(source, "docs/faults.md")).read()))


def pages():
    for folder, _, names in os.walk(os.path.join(source, "docs")):
        for name in sorted(names):
            if name.endswith(".md"):
                yield os.path.relpath(os.path.join(folder, name), source)
    yield "README.md"


def check_command(place, line):
    """One `gantry ...` command: its verbs and options exist."""
    words = re.sub(r"\s+#.*", "", line).replace("|", " ").split()
    known, at, i = set(program.options), program, 0
    while i < len(words):
        word = words[i]
        if word.startswith("-") and not re.match(r"-[\d.]", word):
            option = word.split("=")[0]
            if option not in known | at.all_options():
                fail(place, f"`gantry {line.strip()}`: no option {option}")
        elif word in at.verbs:
            at = at.verbs[word]
            known |= at.options
        elif at is program and not words[max(i - 1, 0)].startswith("-") and re.fullmatch(r"[a-z-]+", word):
            fail(place, f"`gantry {line.strip()}`: no verb '{word}'")
        i += 1


def scripts_exist(place, line):
    for path in re.findall(r"(?<![\w./-])(?:scripts|tests|bench)/[\w./-]+\w", line):
        if not os.path.exists(os.path.join(source, path)):
            fail(place, f"there is no {path}")


def check_recipe(place, lines):
    """A whole recipe that a page shows is right."""
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
        file.write("\n".join(lines) + "\n")
        file.flush()
        done = subprocess.run([gantry, "check", file.name], capture_output=True, text=True, stdin=subprocess.DEVNULL)
        if done.returncode != 0:
            fail(place, f"the recipe that ends here is wrong: {done.stdout + done.stderr}")
    return 1


def run_fence(place, lines):
    """In a folder where the project's recipes and configuration are, with the program on the path."""
    with tempfile.TemporaryDirectory() as folder:
        for name in ("recipes", "config"):
            os.symlink(os.path.join(source, name), os.path.join(folder, name))
        os.mkdir(os.path.join(folder, "bin"))
        os.symlink(gantry, os.path.join(folder, "bin", "gantry"))
        env = dict(os.environ, PATH=os.path.join(folder, "bin") + ":" + os.environ["PATH"],
                   XDG_STATE_HOME=os.path.join(folder, "state"))
        done = subprocess.run(["bash", "-euc", "\n".join(lines)], cwd=folder, env=env, capture_output=True, text=True,
                              stdin=subprocess.DEVNULL)
        if done.returncode != 0:
            fail(place, f"exit {done.returncode}: {done.stderr.strip().splitlines()[-3:]}")
        return len(lines)


headings = {}
for page in pages():
    text = open(os.path.join(source, page)).read()
    titles = re.findall(r"^#+ (.*)$", re.sub(r"```.*?```", "", text, flags=re.S), re.M)
    headings[page] = {re.sub(r"[^\w -]", "", t.lower()).replace(" ", "-") for t in titles}

run = recipes = 0
commands = re.compile(r"^(?:sudo )?(?:gantry |scripts/|build/release/|bash tests|ctest |cmake )")
for page in pages():
    lines = open(os.path.join(source, page)).read().split("\n")
    fence, inside = None, []
    for number, line in enumerate(lines, 1):
        place = f"{page}:{number}"
        if line.startswith("```"):
            if fence is None:
                fence, inside = line[3:].strip(), []
                if fence.startswith("sh") and not re.fullmatch(r"sh (runnable|not run: .+)", fence):
                    fail(place, "a fence of commands says 'runnable' or 'not run: WHY' behind sh")
            else:
                if fence == "sh runnable":
                    run += run_fence(place, inside)
                if fence == "yaml" and inside[:1] == ["version: 1"] and any(i == "features:" or i.startswith("features: ") for i in inside):
                    recipes += check_recipe(place, inside)
                fence = None
            continue
        if fence is not None:
            inside.append(line)
            if fence.startswith("sh"):
                for command in re.findall(r"(?:^|&& )(?:sudo )?gantry ([^&]*)", line):
                    check_command(place, command)
                scripts_exist(place, line)
            continue
        if line.startswith("    ") and commands.match(line.strip()):
            fail(place, "a command line stands in a fence (```sh runnable, or ```sh not run: WHY)")
        for code in re.findall(r"`([^`]+)`", line):
            if code.startswith("gantry "):
                check_command(place, code[len("gantry "):])
            elif re.match(r"--[a-z]", code) and not page.startswith("docs/decisions"):
                option = re.match(r"--[a-z-]+", code).group()
                bench = any(f in line for f in ("bench/", "build/release/bin", "scripts/")) or "bench/" in "".join(lines[max(number - 5, 0):number])
                if option not in program.all_options() and not bench:
                    fail(place, f"no verb has the option {option}")
            if re.fullmatch(r"(?:app|config|core|devices|motion|recipes|scripts|sim|tests|bench|vision|docs|cmake|packaging)/[\w./-]+", code):
                path = os.path.join(source, code)
                if not any(os.path.exists(path + end) for end in ("", ".hpp", ".cpp")):
                    fail(place, f"there is no {code}")
        for code in re.findall(r"\bG\d{3}\b", line):
            if code not in faults:
                fail(place, f"there is no fault {code}")
        for code in re.findall(r"\bexit(?: code)? (\d+)", line):
            if int(code) not in {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 77, 130}:
                fail(place, f"there is no exit code {code}")
        for target, heading in re.findall(r"\]\(([\w./-]*)(?:#([\w-]+))?\)", line):
            if target.startswith("http"):
                continue
            at = os.path.normpath(os.path.join(os.path.dirname(page), target)) if target else page
            if not os.path.exists(os.path.join(source, at)):
                fail(place, f"the link leads to {at}, which is not there")
            elif heading and heading not in headings.get(at, set()):
                fail(place, f"{at} has no heading #{heading}")

if recipes < 1:
    fail("docs", "no whole recipe was checked")
topics = re.findall(r'"((?:gantry|rt)/\w+)"', open(os.path.join(source, "app/monitor/dds.hpp")).read() +
                    open(os.path.join(source, "app/monitor/topics.hpp")).read() +
                    open(os.path.join(source, "app/monitor/publish.cpp")).read())
for topic in re.findall(r"`((?:gantry|rt)/\w+)`", open(os.path.join(source, "docs/monitoring.md")).read()):
    if topic not in topics:
        fail("docs/monitoring.md", f"there is no topic {topic}; there are {sorted(set(topics))}")

if run < 8:
    fail("docs", f"only {run} command lines were run")
print(f"{run} command lines run, {recipes} recipes checked, {len(list(pages()))} pages read")
for line in failures:
    print("FAILED:", line)
sys.exit(1 if failures else 0)
