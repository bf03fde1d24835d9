"""What the checks of tests/arch share: finding and cleaning sources, and proving on seeded violations that a check bites."""
import argparse
import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys
import tempfile

SOURCE_SUFFIXES = {".hpp", ".h", ".cpp", ".c"}
ROOT = pathlib.Path(__file__).resolve().parents[2]


def sources(root, folders, suffixes=SOURCE_SUFFIXES):
    """Files below the folders, sorted, as paths relative to root."""
    found = []
    for folder in folders:
        for path in (root / folder).rglob("*"):
            if path.is_file() and path.suffix in suffixes:
                found.append(path.relative_to(root))
    return sorted(found)


_TOKEN = re.compile(
    r'R"(?P<delim>[^ ()\\\t\n]*)\(.*?\)(?P=delim)"'  # raw string
    r'|"(?:\\.|[^"\\\n])*"'                           # string
    r"|(?<![0-9A-Za-z_])'(?:\\.|[^'\\\n])*'"          # character, not a digit separator
    r"|//(?:\\\n|[^\n])*"
    r"|/\*.*?\*/",
    re.S)


def without_comments(text, keep_strings=False):
    """The same text, line for line, with comments (and the inside of strings) blanked."""
    def blank(match):
        token = match.group(0)
        if keep_strings and not token.startswith("/"):
            return token
        return re.sub(r"[^\n]", " ", token)
    return _TOKEN.sub(blank, text)


def list_file(path):
    """Lines of a list file, comments and empty lines dropped."""
    lines = (line.split("#")[0].strip() for line in path.read_text().splitlines())
    return [line for line in lines if line]


def compiler():
    return os.environ.get("CXX", "g++")


def strict_flags(root=ROOT):
    """Language, determinism and warning flags as the build uses them, read from the top CMakeLists.txt."""
    text = (root / "CMakeLists.txt").read_text()
    return ["-std=c++20"] + sorted(set(re.findall(r"(?<=\s)-[Wf][\w=-]+(?=[\s)])", text)))


def eigen_flags(root=ROOT):
    text = (root / "CMakeLists.txt").read_text()
    definitions = sorted(set(re.findall(r"\bEIGEN_(?:NO|DONT)_\w+", text)))
    return ["-isystem", "/usr/include/eigen3"] + ["-D" + name for name in definitions]


def run(command, **options):
    return subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          stdin=subprocess.DEVNULL, check=False, **options)


def output(command):
    """Of a tool that has to work."""
    result = run(command)
    if result.returncode != 0:
        raise SystemExit(f"{' '.join(str(part) for part in command)}: {result.stdout}")
    return result.stdout


def add_archive_arguments(parser):
    """Of the checks that look into archives, of any target."""
    parser.add_argument("--archives", type=pathlib.Path, default=ROOT / "build/host/lib")
    parser.add_argument("--nm", default="nm")
    parser.add_argument("--readelf", default="readelf")


class Seed:
    """A small tree, and a piece of the message that the check must give for it (None: it must pass)."""

    def __init__(self, name, files, message):
        self.name, self.files, self.message = name, files, message


def prove(check, seeds):
    """Runs check(root) on every seed, two at a time. Returns the number of seeds that did not come out as they should."""
    def problems_of(seed):
        with tempfile.TemporaryDirectory(prefix="relnav_arch_") as folder:
            root = pathlib.Path(folder)
            for name, content in seed.files.items():
                path = root / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(content)
            return check(root)

    wrong = 0
    with concurrent.futures.ThreadPoolExecutor(max_workers=2) as pool:
        for seed, problems in zip(seeds, pool.map(problems_of, seeds)):
            if seed.message is None:
                good = not problems
            else:
                good = any(seed.message in problem for problem in problems)
            print(("caught  " if seed.message else "passed  ") if good else "NOT SO  ", seed.name)
            if not good:
                wrong += 1
                print("   expected:", seed.message or "no problem", "\n   got:", "\n        ".join(problems) or "no problem")
    return wrong


def main(description, check, seeds, add_arguments=None, on_tree=None):
    """Command line of a check: on the tree, or with --self-test on its seeds. Exit status 0 or 1."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--self-test", action="store_true", help="run on seeded violations, each must be caught")
    parser.add_argument("--root", type=pathlib.Path, default=ROOT)
    if add_arguments:
        add_arguments(parser)
    arguments = parser.parse_args()
    if arguments.self_test:
        wrong = prove(check, seeds)
        print(f"{len(seeds) - wrong} of {len(seeds)} seeds as expected")
        sys.exit(1 if wrong else 0)
    problems = on_tree(arguments) if on_tree else check(arguments.root)
    for problem in problems:
        print(problem)
    if problems:
        print(f"{len(problems)} problem{'s' if len(problems) > 1 else ''}")
    sys.exit(1 if problems else 0)
