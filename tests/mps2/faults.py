#!/usr/bin/env python3
"""Every way a program can fail ends in the safe state: exit status of its cause, last packet sent, watchdog tripped.

    faults.py --relnav TOOL --work DIR --emulator PROGRAM MACHINE IMAGE"""
import argparse
import json
import pathlib
import subprocess
import sys

CAUSES = {  # test_mps2_faults' argument: exit status, a word on the console
    "stack": (102, "stack overflow"),
    "null": (103, "processor fault"),
    "instruction": (103, "processor fault"),
    "division": (103, "processor fault"),
    "jump": (103, "processor fault"),
    "panic": (104, "faults.cpp:42: a test"),
    "assertion": (104, "zero == 1U"),
    "heap": (104, "memory from the heap"),
    "new": (104, "memory from the heap"),
    "hook": (104, "faults.cpp:43: a test"),
}


def run(words):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False, timeout=60)


def problem_with(cause, arguments):
    expected, word = CAUSES[cause]
    out = arguments.work / f"{cause}.bin"
    out.unlink(missing_ok=True)
    result = run([*arguments.emulator, cause, out])
    console = result.stdout + result.stderr
    print(console, end="")
    if result.returncode != expected:
        return f"exit status {result.returncode}, expected {expected}"
    if word not in console or "watchdog takes no more kicks" not in console:
        return "not said on the console"
    decoded = run([arguments.relnav, "tlm", "decode", out, "--json"])
    events = [json.loads(line) for line in decoded.stdout.splitlines()]
    if len(events) != 1 or "safe_state_entered" not in json.dumps(events):
        return f"last words: {decoded.stdout}{decoded.stderr}"
    return ""


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--relnav", required=True, type=pathlib.Path)
    parser.add_argument("--work", required=True, type=pathlib.Path)
    parser.add_argument("--emulator", required=True, nargs=3)
    arguments = parser.parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    problems = [f"{cause}: {problem}" for cause in CAUSES if (problem := problem_with(cause, arguments))]
    print("\n".join(problems))
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main()
