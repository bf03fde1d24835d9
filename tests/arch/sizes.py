#!/usr/bin/env python3
"""Sizes of the flight core on one target: code and read-only data of its archives, static memory of the flight loop, stack of step().
Compares with the target's line in docs/verification.md, each figure within 3 %; --update writes it anew."""
import pathlib
import re
import shlex

import common
import stack
import static_memory

BEGIN, END = "<!-- sizes: made by tests/arch/sizes.py --update, begin -->\n", "<!-- sizes: end -->\n"
HEADER = ("| target | code | read-only data | writable data | flight loop | stack of `step()` |\n"
          "|---|---:|---:|---:|---:|---:|\n")
DOCUMENT = common.ROOT / "docs/verification.md"
STEP = "relnav::app::FlightLoop::step("


def of_archives(archives, size_tool):
    """Bytes of code, read-only and writable data."""
    code = constants = variables = 0
    for archive in archives:
        for section, size in re.findall(r"^(\.\S+)\s+(\d+)\s+\d+$", common.output([size_tool, "-A", archive]), re.M):
            if section.startswith(".text"):
                code += int(size)
            elif section.startswith((".rodata", ".data.rel.ro")):
                constants += int(size)
            elif section.startswith((".data", ".bss", ".tbss", ".tdata")):
                variables += int(size)
    return code, constants, variables


def of_stack(build):
    """Worst case of step(), as the compiler of this target wrote it down."""
    functions, report = stack.read_graph(stack.call_graphs(build)), {}
    stack.examine(functions, stack.read_rules(pathlib.Path(stack.__file__).parent / "stack.txt"), report)
    return next((size for size, title in report["worst"] if STEP in functions[title].name), 0)


def line_of(target, figures):
    return f"| {target} | " + " | ".join(str(figure) for figure in figures) + " |\n"


def problems_with(target, figures, table):
    """Against the table of the document."""
    there = next((line for line in table.splitlines() if line.startswith(f"| {target} |")), None)
    if there is None:
        return [f"{target} has no line in docs/verification.md; see --update"]
    expected = [int(word) for word in re.findall(r"\d+(?= \|)", there.split("|", 2)[2])]
    names = [name.strip() for name in HEADER.split("\n")[0].split("|")[2:-1]]
    return [f"{target}, {name}: the document says {said}, the build {is_}; see --update"
            for name, said, is_ in zip(names, expected, figures) if abs(said - is_) > 0.03 * said]


def on_tree(arguments):
    modules = sorted({path.parts[1] for path in common.sources(common.ROOT, ["fsw"], {".cpp"})})
    build = arguments.build.resolve()
    loop = static_memory.size_of_loop(common.ROOT, 60, shlex.split(arguments.compiler))
    if isinstance(loop, str):
        return [loop]
    figures = [*of_archives([build / "lib" / f"librelnav_{module}.a" for module in modules], arguments.size), loop, of_stack(build)]
    print(HEADER + line_of(arguments.target, figures))
    document = DOCUMENT.read_text()
    begin, end = document.index(BEGIN) + len(BEGIN), document.index(END)
    if not arguments.update:
        return problems_with(arguments.target, figures, document[begin:end])
    lines = {line.split("|")[1]: line for line in document[begin:end].splitlines(True) if re.search(r"\d \|", line)}
    lines[f" {arguments.target} "] = line_of(arguments.target, figures)
    DOCUMENT.write_text(document[:begin] + HEADER + "".join(lines.values()) + document[end:])
    return []


def check_sources(root):
    """Seeds: a document's line, and the figures of a build."""
    figures = [int(word) for word in (root / "figures").read_text().split()]
    return problems_with("host", figures, (root / "table").read_text())


TABLE = HEADER + "| host | 1000 | 200 | 0 | 5000 | 700 |\n"
SEEDS = [
    common.Seed("as the document says", {"table": TABLE, "figures": "1010 200 0 5000 700"}, None),
    common.Seed("more code", {"table": TABLE, "figures": "1040 200 0 5000 700"}, "code: the document says 1000"),
    common.Seed("writable data", {"table": TABLE, "figures": "1000 200 8 5000 700"}, "writable data: the document says 0"),
    common.Seed("a deeper stack", {"table": TABLE, "figures": "1000 200 0 5000 800"}, "stack of `step()`: the document says 700"),
    common.Seed("no such target", {"table": HEADER, "figures": "1000 200 0 5000 700"}, "no line"),
]


def add_arguments(parser):
    parser.add_argument("--target", default="host")
    parser.add_argument("--build", type=pathlib.Path, default=common.ROOT / "build/host")
    parser.add_argument("--size", default="size", help="the target's tool of that name")
    parser.add_argument("--compiler", default=common.compiler(), help="the target's, with the flags of its machine, in one word")
    parser.add_argument("--update", action="store_true")


if __name__ == "__main__":
    common.main(__doc__, check_sources, SEEDS, add_arguments, on_tree)
