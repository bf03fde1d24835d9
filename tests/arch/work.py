#!/usr/bin/env python3
"""Instructions of each FlightLoop::step() on the host, counted by valgrind's callgrind: over the captures, median and maximum (at
most three times the median); over constructed worst cases (tests/target/worst_case.py), at most what work.txt allows.

Counted is the whole of step(), the camera's acquire() included: here it reads a PNG file, on a flight board it is DMA. The figures
without it stand beside. --update writes the table of docs/work.md."""
import argparse
import pathlib
import re
import statistics
import sys

import common

sys.path.insert(0, str(common.ROOT / "tests/target"))
import bit_identity  # noqa: E402
import worst_case  # noqa: E402

STEP = "relnav::app::FlightLoop::step()"
CAMERA = "ReplayCamera::acquire("
MOST_OVER_MEDIAN = 3.0
BEGIN, END = "<!-- work: made by tests/arch/work.py --update, begin -->\n", "<!-- work: end -->\n"
FRAMES = {"noncoop": 80, "coop-mono": 20, "coop-stereo": 12}


def counts(command, folder):
    """(instructions, those of the camera) of each step."""
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("callgrind.*"):
        old.unlink()
    # The exit status is not looked at: a worst case finds no pose.
    common.run(["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder}/callgrind", f"--toggle-collect={STEP}",
                f"--dump-after={STEP}", *command])
    return [count_of(path.read_text()) for path in
            sorted(folder.glob("callgrind.*"), key=lambda path: int(path.suffix[1:]))]


def count_of(dump):
    names, total, camera, called, counts_calls = {}, 0, 0, "", False
    for line in dump.splitlines():
        name = re.match(r"c?fn=\((\d+)\)(?: (.*))?$", line)
        if name:
            names.setdefault(name.group(1), name.group(2) or "")
            called = names[name.group(1)] if line.startswith("c") else called
        elif line.startswith("calls="):
            counts_calls = True
        elif counts_calls:
            counts_calls = False
            camera += int(line.split()[1]) if CAMERA in called else 0
        elif line.startswith("summary:"):
            total = int(line.split()[1])
    return total, camera


def figures(steps):
    """Median and maximum of the whole steps, and of what is not the camera's."""
    whole, own = [total for total, _ in steps], [total - camera for total, camera in steps]
    return round(statistics.median(whole)), max(whole), round(statistics.median(own)), max(own)


def problems_with(name, steps, limit=None):
    """limit: of the maximum without the camera; None: of the ratio."""
    if not steps:
        return [f"{name}: no step was counted"]
    median, most, _, own_most = figures(steps)
    if limit is None:
        return [f"{name}: {most} instructions at most, {most / median:.2f} times the median"] if most > MOST_OVER_MEDIAN * median else []
    return [f"{name}: {own_most} instructions at most, {limit} are allowed"] if own_most > limit else []


def row(name, steps):
    median, most, own_median, own_most = figures(steps)
    millions = [f"{value / 1e6:.2f}" for value in (median, most)]
    own = [f"{value / 1e6:.2f}" for value in (own_median, own_most)]
    return (f"| {name} | {len(steps)} | {millions[0]} | {millions[1]} | {most / median:.2f} | {own[0]} | {own[1]} | "
            f"{own_most / own_median:.2f} |\n")


HEADER = ("| run | steps | median, million | maximum | ratio | without the camera: median | maximum | ratio |\n"
          "|---|---:|---:|---:|---:|---:|---:|---:|\n")


def limits(column):
    """Of work.txt: 1 the host's, 2 those of the Cortex-M7."""
    lines = (line.split() for line in common.list_file(pathlib.Path(__file__).parent / "work.txt"))
    return {words[0]: int(words[column]) for words in lines}


def differing(here, document):
    """Figures of the document that are more than 10 % off: memset and the like are others on another processor."""
    rows = {line.split("|")[1].strip(): line for line in document.splitlines() if line.startswith("| ")}
    problems = []
    for line in here.splitlines():
        name = line.split("|")[1].strip()
        there = rows.get(name)
        pairs = list(zip(re.findall(r"[\d.]+", line.split("|", 2)[2]), re.findall(r"[\d.]+", there.split("|", 2)[2]))) if there else []
        if not pairs and re.search(r"\d", line) or any(abs(float(a) - float(b)) > 0.1 * float(b) + 0.02 for a, b in pairs):
            problems.append(f"docs/work.md: {name}: {there or 'no such line'} but counted: {line}; see --update")
    return problems


def on_tree(arguments):
    arguments.work.mkdir(parents=True, exist_ok=True)
    allowed, problems, table = limits(1), [], HEADER
    for mode, (capture, _, options) in bit_identity.RUNS.items():
        folder = arguments.work / mode
        common.run(["rm", "-rf", folder])
        data = bit_identity.beginning(bit_identity.CAPTURES / capture, FRAMES[mode], folder / "data")
        runs = [(f"`{capture}`, {mode}", data, options, None)]
        data = folder / "worst"
        runs.append((f"constructed, {mode}", data, worst_case.write(data, mode), allowed[mode]))
        for name, dataset, words, limit in runs:
            out = folder / f"run_{dataset.name}"
            steps = counts([arguments.relnav, "replay", "--dataset", dataset, "--mode", mode, *words, "--out", out],
                           folder / "counts")
            problems += problems_with(name, steps, limit)
            table += row(name, steps) if steps else ""
    print(table)
    path = common.ROOT / "docs/work.md"
    document = path.read_text()
    begin, end = document.index(BEGIN) + len(BEGIN), document.index(END)
    if arguments.update and not problems:
        path.write_text(document[:begin] + table + document[end:])
        return []
    return problems + differing(table, document[begin:end])


STEPPER = """#include <cstdlib>
namespace relnav::app { struct FlightLoop { int n; volatile int sum; void step(); };
__attribute__((noinline)) void FlightLoop::step() { for (int i = 0; i < n; ++i) sum = sum + i; } }
int main() { relnav::app::FlightLoop loop{10000, 0}; for (int k = 0; k < 9; ++k) { loop.n = k == 4 ? %d : 10000; loop.step(); } }
"""


def check_sources(root):
    source, limit = root / "steps.cpp", root / "limit.txt"
    result = common.run([common.compiler(), "-O1", source, "-o", root / "steps"])
    if result.returncode != 0:
        return ["seed does not compile: " + result.stdout]
    steps = counts([root / "steps"], root / "counts")
    if len(steps) != 9:
        return [f"{len(steps)} steps counted"]
    return problems_with("steps", steps, int(limit.read_text()) if limit.exists() else None)


SEEDS = [
    common.Seed("a step of twice the work", {"steps.cpp": STEPPER % 20000}, None),
    common.Seed("a step of four times the work", {"steps.cpp": STEPPER % 40000}, "times the median"),
    common.Seed("within the limit", {"steps.cpp": STEPPER % 40000, "limit.txt": "400000"}, None),
    common.Seed("over the limit", {"steps.cpp": STEPPER % 40000, "limit.txt": "100000"}, "are allowed"),
    common.Seed("no steps", {"steps.cpp": "int main() {}"}, "0 steps counted"),
]


def add_arguments(parser):
    parser.add_argument("--relnav", type=pathlib.Path, default=common.ROOT / "build/host/bin/relnav")
    parser.add_argument("--work", type=pathlib.Path, default=common.ROOT / "build/host/work")
    parser.add_argument("--update", action="store_true", help="write the table of docs/work.md anew")


if __name__ == "__main__":
    common.main(__doc__, check_sources, SEEDS, add_arguments, on_tree)
