#!/usr/bin/env python3
"""What the unit tests reach in the flight code: lines, branches and MC/DC, counted by clang 19. Builds the preset
host-coverage, runs the unit tests, and compares with the table of docs/verification.md.

    coverage.py             the folders with limits, from their own unit tests
    coverage.py --all       all of fsw, from the unit tests of all folders
    coverage.py --update    the same, and writes the table and the lists below it anew

In the folders with limits each line, branch and condition that no test reaches stands in coverage.txt with a reason. Two things
the compiler would keep quiet about are found in the source text: functions that no test instantiates (a template that nobody
uses is not compiled), and decisions that clang leaves out."""
import argparse
import bisect
import collections
import concurrent.futures
import json
import os
import pathlib
import re
import tempfile

import common

LIMITED = ["base", "math", "attitude", "geometry", "telemetry"]
OTHERS = ["vision", "estimation", "app"]
LEAST_LINES, LEAST_MCDC = 90.0, 80.0  # percent, of each folder with limits
FLAGS = ["-fprofile-instr-generate", "-fcoverage-mapping", "-fcoverage-mcdc"]
DOCUMENT = common.ROOT / "docs/verification.md"
BEGIN, END = "<!-- coverage: made by tests/arch/coverage.py --update, begin -->\n", "<!-- coverage: end -->\n"


# The source text: where functions begin, and the operators of decisions.

def _back_over(text, opening, closing):
    """`text` without the bracketed piece that it ends with."""
    depth = 0
    for i in range(len(text) - 1, -1, -1):
        depth += (text[i] == closing) - (text[i] == opening)
        if depth == 0:
            return text[:i].rstrip()
    return text


def _is_lambda(text):
    text = re.sub(r"(\b(mutable|constexpr|noexcept)|->[\w\s:<>,&*]+)\s*$", "", text.rstrip()).rstrip()
    if text.endswith(")"):
        text = _back_over(text, "(", ")")
    if text.endswith(">"):
        text = _back_over(text, "<", ">")
    return text.endswith("]") and not re.search(r"[\w)\]]$", _back_over(text, "[", "]"))


def _kind(text, within):
    """What a brace opens: `text` stands before it, since the last statement."""
    if within == "consteval" or re.search(r"\bconsteval\b", text):
        return "consteval"
    if _is_lambda(text):
        return "function"
    if within == "function" or within == "inner":
        return "inner"
    text = text.strip()
    while re.match(r"template\s*<", text):
        end = next(i for i in range(len(text)) if text[i] == ">" and text[:i + 1].count("<") == text[:i + 1].count(">"))
        text = text[end + 1:].strip()
    if re.match(r"(inline\s+)?namespace\b|extern\s*$", text):
        return "namespace"
    if re.match(r"(struct|class|union|enum)\b", text):
        return "class"
    signature = re.sub(r"operator\s*(\(\)|[^\s(]+)", "operator", text)
    if "(" not in signature or re.search(r"[^=!<>]=(?!=)", re.sub(r"\([^()]*(\([^()]*\)[^()]*)*\)", "", signature)):
        return "initialiser"
    if re.search(r"\w$", signature) and not re.search(r"\b(const|noexcept|override|final)$|->[^()]*$", signature):
        return "initialiser"  # of a member, in a list of them too
    return "function"


class Text:
    """Functions (line, column of the opening brace) and operators && and || (line, column) of a source. What is consteval is
    not there when the program runs: its results are tested."""

    def __init__(self, content):
        clean = common.without_comments(content)
        clean = re.sub(r"^[ \t]*#(?:\\\n|[^\n])*", lambda m: re.sub(r"[^\n]", " ", m.group(0)), clean, flags=re.M)
        self.lines = content.splitlines()
        self.functions, self.operators = [], []
        starts = [0] + [m.end() for m in re.finditer("\n", clean)]
        place = lambda at: (bisect.bisect_right(starts, at), at - starts[bisect.bisect_right(starts, at) - 1] + 1)
        stack, statement = ["namespace"], ""
        for token in re.finditer(r"(?<=\s)(?:&&|\|\|)(?=\s)|.", clean, re.S):
            word, kind = token.group(0), stack[-1]
            if word == "{":
                stack.append(_kind(statement, kind))
                if stack[-1] == "function":
                    self.functions.append(place(token.start()))
                statement = "" if stack[-1] != "initialiser" else statement + "{"
            elif word == "}":
                stack.pop()
                statement = "" if kind != "initialiser" else statement + "}"
            elif word == ";":
                statement = ""
            else:
                constant = re.match(r"\s*(static_assert|requires|constexpr|static\s+constexpr|if\s+constexpr)\b", statement)
                if word in ("&&", "||") and ("function" in stack) and not constant:
                    self.operators.append(place(token.start()))
                statement += word


# What the compiler counted.

class Counts:
    """Of one file, merged over all instantiations and executables: what one of them reaches is reached."""

    def __init__(self):
        self.lines = {}                                         # number: reached
        self.branches = collections.defaultdict(set)            # place: outcomes seen
        self.decisions = collections.defaultdict(list)          # place: of each condition, whether its effect was shown
        self.functions = set()                                  # of each function, the places where its regions begin

    def add_segments(self, segments):
        """Lines, as llvm-cov counts them: by the regions that begin on a line, else by the one around it."""
        by_line = collections.defaultdict(list)
        for segment in segments:
            by_line[segment[0]].append(segment)
        around = None
        for line in range(segments[0][0], segments[-1][0] + 1) if segments else []:
            here = by_line[line]
            begun = [s for s in here if s[3] and s[4] and not s[5]]
            skipped = bool(here) and not here[0][3] and here[0][4]
            if not skipped and ((around and around[3]) or begun):
                counts = [s[2] for s in begun] + ([around[2]] if around and around[3] else [])
                self.lines[line] = self.lines.get(line, False) or max(counts) > 0
            around = here[-1] if here else around

    def add_function(self, function):
        own = [region for region in function["regions"] if region[5] == 0]
        self.functions.add(frozenset((region[0], region[1]) for region in own))
        begin, end = min((r[0], r[1]) for r in own), max((r[2], r[3]) for r in own)
        used_in = {region[6]: (region[0], region[1]) for region in function["regions"] if region[7] == 1}  # macros
        conditions = collections.Counter()
        for branch in function["branches"]:
            line, column, _, _, true, false, file_id, _, kind = branch
            if kind == 6:
                conditions[file_id] += 1
                continue
            outcomes = self.branches[used_in[file_id] if file_id in used_in else (line, column)]
            outcomes.update([True] if true else [], [False] if false else [])
        for line, column, last_line, last_column, _, _, shown in function["mcdc_records"]:
            key = (line, column, last_line, last_column, len(shown))  # a fold has as many conditions as there are elements
            if not begin <= (line, column) <= end:  # in a macro: which one is told by its number of conditions
                file_id = next((i for i, n in sorted(conditions.items()) if i in used_in and n == len(shown)), None)
                conditions.pop(file_id, None)
                key = (*used_in.get(file_id, begin), *used_in.get(file_id, begin), len(shown))
            before = self.decisions[key] or [False] * len(shown)
            self.decisions[key] = [a or b for a, b in zip(before, shown)]


def measure(root, executables, work):
    """Runs the executables. Counts of each file below root/fsw, and what went wrong."""
    def counted(executable):
        """What llvm-cov exports, and what went wrong."""
        problems = []
        raw, data = work / f"{executable.name}.%m.profraw", work / f"{executable.name}.profdata"
        # %m: a process that forks, as tests of panic() do, adds to the same file.
        result = common.run([executable], env={**os.environ, "LLVM_PROFILE_FILE": str(raw)}, cwd=root)
        if result.returncode != 0:
            problems.append(f"{executable.name} fails:\n{result.stdout}")
        merged = common.run(["llvm-profdata-19", "merge", "-sparse", "-o", data, *work.glob(f"{executable.name}.*.profraw")])
        export = common.subprocess.run(["llvm-cov-19", "export", executable, "--instr-profile", data, "-sources", root / "fsw"],
                                       capture_output=True, text=True, check=False)
        if merged.returncode != 0 or export.returncode != 0:
            return None, problems + [merged.stdout + export.stderr]
        return export.stdout, problems

    files, problems = collections.defaultdict(Counts), []
    name = lambda path: str(pathlib.Path(path).relative_to(root))
    with concurrent.futures.ThreadPoolExecutor(max_workers=2) as pool:
        for exported, wrong in pool.map(counted, executables):
            problems += wrong
            if exported is None:
                return files, problems
            found = json.loads(exported)["data"][0]
            for file in found["files"]:
                files[name(file["filename"])].add_segments(file["segments"])
            for function in found["functions"]:
                files[name(function["filenames"][0])].add_function(function)
    return files, problems


class Folder:
    """Figures of a folder, and what is not reached: (file, line number, what)."""

    def __init__(self, root, name, files):
        self.lines, self.branches, self.conditions, self.left_out, self.missed = [], [], [], [], []
        for path in common.sources(root, [f"fsw/{name}"]):
            text, counts = Text((root / path).read_text()), files.get(str(path), Counts())
            missed = {}
            self.lines += counts.lines.values()
            missed.update({line: "not run" for line, reached in counts.lines.items() if not reached})
            for (line, _), outcomes in sorted(counts.branches.items()):
                if re.search(r"=\s*default\b", text.lines[line - 1]):
                    continue  # the compiler's own
                self.branches += [True in outcomes, False in outcomes]
                if len(outcomes) == 1:
                    missed.setdefault(line, f"never {str(not outcomes.copy().pop()).lower()}")
                elif not outcomes:
                    missed.setdefault(line, "not decided")
            for (line, *_), shown in sorted(counts.decisions.items()):
                self.conditions += shown
                if not all(shown):
                    which = ", ".join(str(i + 1) for i, done in enumerate(shown) if not done)
                    missed.setdefault(line, f"MC/DC of condition {which} of {len(shown)} not shown")
            for place in text.functions:
                if not any(place in begins for begins in counts.functions):
                    missed[place[0]] = "function that no test instantiates"
                    self.lines.append(False)
            for begins in counts.functions:
                line, column = min(begins)
                if not begins & set(text.functions) and not re.search(r"=\s*default", text.lines[line - 1]):
                    raise SystemExit(f"{path}:{line}:{column}: a function that coverage.py does not see in the text")
            spans = [((a, b), (c, d)) for a, b, c, d, _ in counts.decisions]
            for place in text.operators:
                if not any(start <= place <= end for start, end in spans):
                    # An assertion's decisions stand where its macro is used.
                    if not any(start[0] == end[0] and "RELNAV_ASSERT" in text.lines[start[0] - 1]
                               and start[0] <= place[0] <= start[0] + 2 for start, end in spans):
                        self.left_out.append((str(path), place[0], text.lines[place[0] - 1].strip()))
                        missed.setdefault(place[0], "decision that clang leaves out")
            self.missed += [(str(path), line, what, text.lines[line - 1].strip()) for line, what in sorted(missed.items())]


def percent(reached):
    return 100.0 * sum(reached) / len(reached) if reached else 100.0


def reasons_of(path):
    """(file, text of the line, reason) from lines `file: text  # reason`, one for each place."""
    reasons = []
    for line in path.read_text().splitlines() if path.is_file() else []:
        if line and not line.startswith("#"):
            place, reason = line.split("  # ")
            reasons.append((*place.split(": ", 1), reason))
    return reasons


def judge(folders, reasons):
    problems, unused = [], collections.Counter((path, text) for path, text, _ in reasons)
    for name, folder in folders.items():
        if name not in LIMITED:
            continue
        for path, line, what, text in folder.missed:
            unused[(path, text)] -= 1
            if unused[(path, text)] < 0:
                problems.append(f"{path}:{line}: {what}: {text}")
        for what, figure, least in (("lines", percent(folder.lines), LEAST_LINES),
                                    ("MC/DC", percent(folder.conditions), LEAST_MCDC)):
            if figure < least:
                problems.append(f"fsw/{name}: {figure:.1f} % of {what}, {least:.0f} at least")
    return problems + [f"coverage.txt: reached by now: {path}: {text}" for (path, text), n in unused.items() if n > 0]


# The document.

def row(name, folder):
    cells = [f"fsw/{name}"]
    for reached in (folder.lines, folder.branches, folder.conditions):
        cells += [str(len(reached)), f"{percent(reached):.1f} %"]
    return "| " + " | ".join(cells + [str(len(folder.left_out))]) + " |"


HEADER = ("| folder | lines | run | branches | taken | conditions | MC/DC shown | operators not counted |\n"
          "|---|---:|---:|---:|---:|---:|---:|---:|\n")


def list_of(folders, reasons):
    text = "\nNot reached, and why:\n\n"
    for path, line, reason in reasons:
        text += f"- `{path}`: `{line}`: {reason}\n"
    left_out = [entry for name, folder in folders.items() if name not in LIMITED for entry in folder.left_out]
    if left_out:
        text += "\nDecisions that clang does not count (another operation between their operators):\n\n"
        text += "".join(f"- `{path}`: `{line}`\n" for path, line in dict.fromkeys((path, line) for path, _, line in left_out))
    return text


def compare(rows, document):
    """Figures of the document that are not those found: numbers within 3 %, percentages within half a point."""
    problems = []
    there = {line.split(" | ")[0]: line for line in document.splitlines() if line.startswith("| fsw/")}
    for text in rows:
        key = text.split(" | ")[0]
        numbers, stated = ([float(n) for n in re.findall(r"\d+(?:\.\d+)?", line)] for line in (text, there.get(key, "")))
        near = len(numbers) == len(stated) and all(abs(a - b) <= (0.5 if i % 2 else 0.03 * b) or i == 6 and a == b
                                                   for i, (a, b) in enumerate(zip(numbers, stated)))
        if not near:
            problems.append(f"the document says {there.get(key, 'nothing of ' + key[2:])}; now it is {text}: --update")
    return problems


def build(targets):
    for command in (["cmake", "--preset", "host-coverage"],
                    ["cmake", "--build", "--preset", "host-coverage", "-j", os.environ.get("RELNAV_JOBS", "2"), "--target", *targets]):
        result = common.run(command, cwd=common.ROOT)
        if result.returncode != 0:
            raise SystemExit(result.stdout[-8000:])


def on_tree(arguments):
    everything = arguments.all or arguments.update
    names = LIMITED + (OTHERS if everything else [])
    build([f"test_unit_{name}" for name in names])
    executables = [common.ROOT / f"build/host-coverage/bin/test_unit_{name}" for name in names]
    with tempfile.TemporaryDirectory(prefix="relnav_coverage_") as work:
        own, problems = measure(common.ROOT, executables[:len(LIMITED)], pathlib.Path(work))
        folders = {name: Folder(common.ROOT, name, own) for name in LIMITED}
        if everything:
            files, more = measure(common.ROOT, executables, pathlib.Path(work))
            problems += more
            folders.update({name: Folder(common.ROOT, name, files) for name in OTHERS})
    reasons = reasons_of(pathlib.Path(__file__).parent / "coverage.txt")
    rows = [row(name, folder) for name, folder in folders.items()]
    print(HEADER + "\n".join(rows))
    problems += judge(folders, reasons)
    text = DOCUMENT.read_text()
    begin, end = text.index(BEGIN) + len(BEGIN), text.index(END)
    if arguments.update:
        DOCUMENT.write_text(text[:begin] + HEADER + "\n".join(rows) + "\n" + list_of(folders, reasons) + text[end:])
        return problems
    return problems + compare(rows, text[begin:end])


def check(root):
    """Seeds: test.cpp is the unit test of what lies in fsw."""
    executable = root / "test"
    result = common.run(["clang++-19", "-std=c++20", *FLAGS, f"-I{root}", root / "test.cpp", "-o", executable])
    if result.returncode != 0:
        return ["seed does not compile: " + result.stdout]
    files, problems = measure(root, [executable], root)
    return problems + judge({name: Folder(root, name, files) for name in LIMITED}, reasons_of(root / "coverage.txt"))


def seed(name, header, test, message, reasons=""):
    return common.Seed(name, {"fsw/base/a.hpp": "#pragma once\n" + header + "\n", "coverage.txt": reasons,
                              "test.cpp": '#include "fsw/base/a.hpp"\nint main() {\n' + test + "\n}\n"}, message)


BOTH = "inline bool both(bool a, bool b) {\n  return a && b;\n}"
HALVES = ("template <typename T>\nint size(T t) {\n  if constexpr (sizeof(T) == 1) {\n    return t > 2 && t < 9 ? 1 : 0;\n"
          "  } else {\n    return -1;\n  }\n}")
SEEDS = [
    seed("all reached, a template in two instantiations", BOTH + "\n" + HALVES + "\nstruct S {\n  S() : a{1} {}\n  int a{2};\n};",
         "S s; size(1); for (char c = 0; c < 12; ++c) size(c); return both(1, 1) + both(0, 1) + both(1, 0) + s.a == 99;", None),
    seed("condition without an effect of its own", BOTH, "both(1, 1); both(0, 1);", "a.hpp:3: MC/DC of condition 2 of 2 not shown"),
    seed("condition in the part of one instantiation", HALVES, "size(1); for (char c = 0; c < 9; ++c) size(c);",
         "a.hpp:5: MC/DC of condition 2 of 2"),
    seed("line not run", "inline int f(int a) {\n  if (a > 1)\n    return 2;\n  return 1;\n}", "f(1);", "a.hpp:4: not run"),
    seed("branch taken one way", "inline int f(int a) {\n  return a > 1 ? 2 : 1;\n}", "f(1);", "a.hpp:3: never true"),
    seed("function that nobody calls", "inline int f() { return 1; }", "", "a.hpp:2: not run"),
    seed("template that nobody uses", "template <typename T>\nint f(T a) {\n  return a;\n}", "", "a.hpp:3: function that no test"),
    seed("member of a template that nobody uses", "template <typename T>\nstruct S {\n  int f(T a) { return a; }\n  int g() { return 1; }\n};",
         "S<int>().g();", "a.hpp:4: function that no test"),
    seed("generic lambda that nobody calls", "inline int f() {\n  auto g = [](auto a) {\n    return a;\n  };\n  (void)g;\n  return 1;\n}",
         "f();", "a.hpp:3: function that no test"),
    seed("decision that clang leaves out", BOTH + "\ninline bool f(bool a, bool b, bool c) {\n  return a && both(b || c, true);\n}",
         "for (int i = 0; i < 8; ++i) f(i & 1, i & 2, i & 4), both(i & 1, i & 2);", "a.hpp:6: decision that clang leaves out"),
    seed("the same with !", "inline bool f(bool a, bool b, bool c) {\n  return a && !(b && c);\n}",
         "for (int i = 0; i < 8; ++i) f(i & 1, i & 2, i & 4);", "a.hpp:3: decision that clang leaves out"),
    seed("with a reason", BOTH + "\n" + HALVES, "size(1); for (char c = 0; c < 12; ++c) size(c); both(1, 1); both(0, 1);",
         "75.0 % of MC/DC", "fsw/base/a.hpp: return a && b;  # b is always true\n"),
    seed("reason for one of two", BOTH + BOTH.replace("both", "too").replace("inline", "\ninline"),
         "both(1, 1); both(0, 1); too(1, 1); too(0, 1);", "a.hpp:6: MC/DC of condition 2",
         "fsw/base/a.hpp: return a && b;  # b is always true\n"),
    seed("reason for what is reached", BOTH, "both(1, 1); both(0, 1); both(1, 0);", "reached by now",
         "fsw/base/a.hpp: return a && b;  # b is always true\n"),
    seed("test that fails", BOTH, "both(1, 1); both(0, 1); both(1, 0); return 1;", "test fails"),
]


def add_arguments(parser):
    parser.add_argument("--all", action="store_true", help="the folders without limits too")
    parser.add_argument("--update", action="store_true", help="write the table of docs/verification.md")


if __name__ == "__main__":
    common.main(__doc__, check, SEEDS, add_arguments, on_tree)
