#!/usr/bin/env python3
"""Sources are formatted as .clang-format says (clang-format 14). With --warn, only says how many are not."""
import shutil
import sys

import common

TOOL = shutil.which("clang-format-14") or shutil.which("clang-format") or "clang-format"
FOLDERS = ["fsw", "hal", "platform", "hil", "tests"]


def check(root):
    problems = []
    for path in common.sources(root, FOLDERS):
        text = (root / path).read_text()
        result = common.run([TOOL, f"--style=file:{common.ROOT / '.clang-format'}", root / path])
        if result.returncode != 0:
            problems.append(f"{path}: {result.stdout.strip()}")
        elif result.stdout != text:
            line = next((number for number, (a, b) in enumerate(zip(text.splitlines(), result.stdout.splitlines()), 1) if a != b), 0)
            problems.append(f"{path}:{line}: not as clang-format writes it")
    return problems


SEEDS = [
    common.Seed("well formed", {"fsw/base/a.cpp": "int one() { return 1; }\n"}, None),
    common.Seed("badly formed", {"fsw/base/a.cpp": "int a;\nint  one( ){return 1;}\n"}, "fsw/base/a.cpp:2: not as clang-format"),
]


def add_arguments(parser):
    parser.add_argument("--warn", action="store_true", help="exit status 0 whatever is found")


def on_tree(arguments):
    problems = check(arguments.root)
    if arguments.warn and problems:
        print("\n".join(problems) + f"\nwarning: {len(problems)} files are not formatted (clang-format-14 -i FILE)")
        sys.exit(0)
    return problems


if __name__ == "__main__":
    common.main(__doc__, check, SEEDS, add_arguments, on_tree)
