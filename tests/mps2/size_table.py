#!/usr/bin/env python3
"""The size table of docs/cortex-m7.md against an image: what lies in which memory, how much is free. Each figure within 3 %.

    size_table.py --image IMAGE --document FILE [--update]   --update writes the table anew"""
import argparse
import pathlib
import re
import subprocess
import sys

BEGIN, END = "<!-- sizes: made by tests/mps2/size_table.py --update, begin -->\n", "<!-- sizes: end -->\n"
MEMORIES = {"code": (0x00000000, 4 << 20), "RAM": (0x20000000, 4 << 20), "PSRAM": (0x60000000, 16 << 20)}
OBJECTS = {  # symbols with a line of their own: part of a demangled name -> what it is
    "fly(char const*, char const*)::loop": "the flight loop, all three modes",
    "::frames0": "frames of the first camera, 3 leases",
    "::frames1": "frames of the second camera, 3 leases",
}


def tool(name, *words):
    return subprocess.run([f"arm-none-eabi-{name}", *map(str, words)], check=True, capture_output=True, text=True).stdout


def rows(image):
    """(memory, what, bytes)"""
    sections = [(name, int(size), int(address))
                for name, size, address in re.findall(r"^(\.\S+)\s+(\d+)\s+(\d+)$", tool("size", "-A", image), re.M)]
    symbols = {name: int(address, 16) for address, name in re.findall(r"^([0-9a-f]+) \w (\S+)$", tool("nm", image), re.M)}
    objects = {name: int(size, 16) for size, name in re.findall(r"^[0-9a-f]+ ([0-9a-f]+) \w (.*)$", tool("nm", "-CS", image), re.M)}
    size_of = dict((name, size) for name, size, _ in sections)
    table = [("code", "instructions and constants", size_of[".text"] + sum(s for n, s in size_of.items() if "ARM.ex" in n)),
             ("code", "start values of variables", size_of.get(".data", 0))]
    named = {"RAM": 0, "PSRAM": 0}
    for part, what in OBJECTS.items():
        size = max((size for name, size in objects.items() if part in name and "guard" not in name), default=0)
        if size == 0:
            sys.exit(f"no object {part} in the image")
        memory = "PSRAM" if "frames" in part else "RAM"
        named[memory] += size
        table.append((memory, what, size))
    table.append(("RAM", "other variables", size_of.get(".data", 0) + size_of[".bss"] - named["RAM"]))
    table.append(("RAM", "stack of the program", symbols["__stack_top"] - symbols["__stack_bottom"]))
    table.append(("RAM", "stack of the handlers, guard",
                  symbols["__handler_stack_top"] - symbols["__stack_top"] + symbols["__stack_bottom"] - symbols["__guard_start"]))
    return table


def text_of(table):
    lines = ["| memory | what | bytes |", "|---|---|---:|"]
    for memory, (_, size) in MEMORIES.items():
        own = [row for row in table if row[0] == memory]
        lines += [f"| {name} | {what} | {bytes_} |" for name, what, bytes_ in own]
        lines.append(f"| {memory} | free of {size >> 20} MiB | {size - sum(row[2] for row in own)} |")
    return "\n".join(lines) + "\n"


def differences(expected, found):
    """Lines that are not the same, figures within 3 %."""
    def split(text):
        return {line.rsplit("|", 2)[0]: line.rsplit("|", 2)[1].strip() for line in text.strip().splitlines()}
    here, there = split(expected), split(found)
    problems = [f"only on one side: {key}" for key in here.keys() ^ there.keys()]
    for key in here.keys() & there.keys():
        if here[key].isdigit() and abs(int(here[key]) - int(there[key])) > 0.03 * int(there[key]) + 64:
            problems.append(f"{key}| the document says {there[key]}, the image {here[key]}")
    return problems


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--image", required=True, type=pathlib.Path)
    parser.add_argument("--document", required=True, type=pathlib.Path)
    parser.add_argument("--update", action="store_true")
    arguments = parser.parse_args()
    text = text_of(rows(arguments.image))
    document = arguments.document.read_text()
    begin, end = document.index(BEGIN) + len(BEGIN), document.index(END)
    if arguments.update:
        arguments.document.write_text(document[:begin] + text + document[end:])
        return
    print(text)
    problems = differences(text, document[begin:end])
    if problems:
        sys.exit("\n".join(problems) + "\nsizes have changed; see --update")


if __name__ == "__main__":
    main()
