#!/usr/bin/env python3
"""What the archives of the flight core need from outside, and what they must not hold: undefined symbols are our own (in a
module below) or in symbols.txt; no writable data, no static construction. On any target: --nm, --readelf of its tools."""
import pathlib
import re

import common

# Modules whose symbols a module may use (design: direction of includes), lowest first.
USES = {
    "base": [],
    "math": ["base"],
    "attitude": ["base", "math"],
    "geometry": ["base", "math", "attitude"],
    "vision": ["base", "math", "attitude", "geometry"],
    "estimation": ["base", "math", "attitude", "geometry"],
    "telemetry": ["base"],
    "app": ["base", "math", "attitude", "geometry", "vision", "estimation", "telemetry"],
}
SECTION = re.compile(r"^\s*\[\s*\d+\]\s+(\S+)\s+\S+\s+[0-9a-f]+\s+[0-9a-f]+\s+([0-9a-f]+)\s+\S+\s+([A-Za-z]*)\s+\d")


def symbols(nm, archive, *options):
    """(type letter, demangled name, object) of each symbol."""
    found, member = [], ""
    for line in common.output([nm, "-C", *options, archive]).splitlines():
        if line.endswith((".o:", ".obj:")):
            member = line[:-1]
            continue
        match = re.match(r"^[0-9a-f ]*\s([A-Za-z])\s(.*)$", line)
        if match:
            found.append((match.group(1), match.group(2), member))
    return found


def base_name(name):
    """A demangled name without its arguments, as symbols.txt writes it."""
    return name.split("(")[0]


def allowed_on(machine, path):
    """Names of symbols.txt for every machine and, behind its name, for this one."""
    words = (line.split() for line in common.list_file(path))
    return {name for name, *machines in words if not machines or machine in machines}


def machine_of(readelf, archive):
    return re.search(r"Machine:\s+(.*)", common.output([readelf, "-h", archive])).group(1).split()[-1]


def check_archives(folder, nm="nm", readelf="readelf"):
    archives = {module: folder / f"librelnav_{module}.a" for module in USES}
    archives = {module: archive for module, archive in archives.items() if archive.is_file()}
    if not archives:
        return [f"{folder}: no archive of the flight core there; build first"]
    machine = machine_of(readelf, next(iter(archives.values())))
    allowed = allowed_on(machine, pathlib.Path(__file__).parent / "symbols.txt")
    defined = {module: {name for kind, name, _ in symbols(nm, archive, "--defined-only") if kind not in "tdrb"}
               for module, archive in archives.items()}
    problems = []
    for module, archive in archives.items():
        within = set().union(*(defined.get(name, set()) for name in [module, *USES[module]]))
        for kind, name, member in symbols(nm, archive, "-u"):
            if name in within or base_name(name) in allowed or kind in "wv":
                continue
            where = f"{archive.name}({member}): "
            owners = [other for other in defined if name in defined[other]]
            if owners:
                problems.append(where + f"uses {name} of {owners[0]}, which {module} must not see")
            elif name.startswith("relnav::"):
                problems.append(where + f"{name} is defined nowhere")
            else:
                problems.append(where + f"undefined {name} is not in tests/arch/symbols.txt")
        writable = []
        member = ""
        for line in common.output([readelf, "-SW", archive]).splitlines():
            if line.startswith("File: "):
                member = line.split("(")[-1].rstrip(")")
            match = SECTION.match(line)
            if not match:
                continue
            section, size, flags = match.group(1), int(match.group(2), 16), match.group(3)
            if size == 0 or "W" not in flags or "A" not in flags or section.startswith(".data.rel.ro"):
                continue
            if re.match(r"\.(init_array|fini_array|ctors|dtors|preinit_array)", section):
                problems.append(f"{archive.name}({member}): static construction ({section}, {size} bytes)")
            else:
                writable.append((member, section, size))
        if writable:
            data = {}
            for kind, name, owner in symbols(nm, archive, "--defined-only"):
                if kind in "bBdDCugGsS" and not name.startswith("vtable for"):
                    data.setdefault(owner, []).append(name)
            for member, section, size in writable:
                names = ", ".join(data.get(member, [])) or "?"
                problems.append(f"{archive.name}({member}): writable data ({section}, {size} bytes): {names}")
    return problems


def check_sources(root):
    """Seeds: each <module>.cpp below root becomes librelnav_<module>.a."""
    flags = ["-std=c++20", "-O2", "-ffp-contract=off", "-fno-math-errno", "-fno-threadsafe-statics"]
    for source in sorted(root.glob("*.cpp")):
        exceptions = [] if "throw" in source.read_text() else ["-fno-exceptions", "-fno-rtti"]
        result = common.run([common.compiler(), *flags, *exceptions, "-c", source, "-o", source.with_suffix(".o")])
        if result.returncode != 0:
            return ["seed does not compile: " + result.stdout]
        common.output(["ar", "rcs", root / f"librelnav_{source.stem}.a", source.with_suffix(".o")])
    return check_archives(root)


SEEDS = [
    common.Seed("what is allowed", {
        "base.cpp": "namespace relnav { [[noreturn]] void panic(const char*, int, const char*); extern const int table[3];\n"
                    "const int table[3] = {1, 2, 3}; int one(int i) { if (i > 2) panic(\"\", 1, \"\"); return table[i]; } }",
        "math.cpp": "#include <cmath>\n#include <cstring>\nnamespace relnav { int one(int); struct I { virtual int f() = 0; };\n"
                    "struct A final : I { int f() override { return one(1); } }; int g(I& i) { return i.f(); }\n"
                    "double s(double x) { return std::sqrt(x); } void c(char* a, const char* b, unsigned long n) {\n"
                    "std::memcpy(a, b, n); } }"}, None),
    common.Seed("malloc", {"base.cpp": "#include <cstdlib>\nvoid* f(unsigned n) { return std::malloc(n); }"},
                "undefined malloc is not in"),
    common.Seed("operator new", {"base.cpp": "int* f() { return new int[3]; }"}, "undefined operator new[]"),
    common.Seed("operator delete through a virtual destructor",
                {"base.cpp": "struct A { virtual ~A(); }; A::~A() {}"}, "undefined operator delete"),
    common.Seed("libm", {"math.cpp": "#include <cmath>\ndouble f(double x) { return std::sin(x); }"}, "undefined sin is not in"),
    common.Seed("exception", {"base.cpp": "void f() { throw 1; }"}, "undefined __cxa_throw"),
    common.Seed("mutable global", {"base.cpp": "int counter = 3; int next() { return counter++; }"}, "writable data (.data"),
    common.Seed("mutable zero global", {"base.cpp": "static long sum; long add(long x) { return sum += x; }"},
                "writable data (.bss"),
    common.Seed("function-local static",
                {"base.cpp": "int seed(); int f() { static int value = seed(); return value; } int seed() { return 1; }"},
                "writable data"),
    common.Seed("static construction",
                {"base.cpp": "int seed(); struct A { A() : value(seed()) {} int value; }; A object;"}, "static construction"),
    common.Seed("upwards", {"base.cpp": "namespace relnav { int high(); int low() { return high(); } }",
                            "app.cpp": "namespace relnav { int high() { return 1; } }"}, "which base must not see"),
    common.Seed("sideways", {"vision.cpp": "namespace relnav { int ekf(); int f() { return ekf(); } }",
                             "estimation.cpp": "namespace relnav { int ekf() { return 1; } }"}, "which vision must not see"),
    common.Seed("nowhere", {"base.cpp": "namespace relnav { int gone(); int f() { return gone(); } }"}, "is defined nowhere"),
    common.Seed("operating system", {"app.cpp": "#include <unistd.h>\nint f() { return getpid(); }"}, "undefined getpid"),
]


def on_tree(arguments):
    missing = [f"{arguments.archives}: librelnav_{module}.a is not there; build first" for module in USES
               if any((common.ROOT / "fsw" / module).glob("*.cpp"))
               and not (arguments.archives / f"librelnav_{module}.a").is_file()]
    return missing + check_archives(arguments.archives, arguments.nm, arguments.readelf)


if __name__ == "__main__":
    common.main(__doc__, check_sources, SEEDS, common.add_archive_arguments, on_tree)
