#!/usr/bin/env python3
"""Sources are formatted as .clang-format says (clang-format 14). With --warn, only says how many are not."""
import re
import shutil
import sys

import common

TOOL = shutil.which("clang-format-14") or shutil.which("clang-format") or "clang-format"
FOLDERS = ["fsw", "hal", "platform", "hil", "tests"]


def check(root):
    paths = common.sources(root, FOLDERS)
    if not paths:
        return ["no sources found"]
    result = common.run([TOOL, "--dry-run", "--Werror", f"--style=file:{common.ROOT / '.clang-format'}",
                         *(root / path for path in paths)])
    first = {}  # of each file, the first line that is off
    for path, line in re.findall(r"^(.+?):(\d+):\d+: error: code should be clang-formatted", result.stdout, re.M):
        first.setdefault(path.replace(f"{root}/", ""), line)
    problems = [f"{path}:{line}: not as clang-format writes it" for path, line in first.items()]
    if result.returncode != 0 and not problems:
        problems = [result.stdout.strip() or f"{TOOL} failed"]
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
