#!/usr/bin/env python3
"""What each object of the flight core was compiled with, as the compiler wrote it into the object (-frecord-gcc-switches),
and that it holds no tables of exceptions and no run-time type information. On any target: --readelf, --nm of its tools."""
import pathlib
import re

import common

REQUIRED = ["-std=c++20", "-ffp-contract=off", "-fno-math-errno", "-fno-exceptions", "-fno-rtti", "-fno-threadsafe-statics"]
# Options that change bits or bring back what is off, whatever stands before them.
FORBIDDEN = re.compile(
    r"^-(ffast-math|Ofast|funsafe-math-optimizations|fassociative-math|freciprocal-math|ffinite-math-only|fno-signed-zeros|"
    r"fno-trapping-math|frounding-math|fsingle-precision-constant|fexcess-precision=fast|ffp-contract=(fast|on)|mfpmath=387|"
    r"mfma4?|march=native|mtune=native|flto.*|fopenmp.*|fexceptions|frtti|fthreadsafe-statics|fmath-errno|fprofile-.*)$")
RECORD = re.compile(r"^\s*\[\s*[0-9a-f]+\]\s+(.*)$")
# .ARM.exidx alone only says that nothing is unwound here.
SECTION = re.compile(r"^\s*\[\s*\d+\]\s+(\.gcc_except_table\S*|\.ARM\.extab\S*)\s")


def by_member(text):
    """Lines of each object of an archive, as readelf and nm print them."""
    members, lines = {}, []
    for line in text.splitlines():
        file = re.match(r"^File: \S*\((\S+)\)$", line) or re.match(r"^(\S+\.o(?:bj)?):$", line)
        if file:
            lines = members.setdefault(file.group(1), [])
        lines.append(line)
    return members


def check_archives(archives, readelf, nm):
    problems = []
    for archive in archives:
        sections, records = by_member(common.output([readelf, "-SW", archive])), by_member(common.output([readelf, "-p", ".GCC.command.line", archive]))
        names = by_member(common.output([nm, archive]))
        for member, lines in sections.items():
            where = f"{archive.name}({member})"
            found = [match.group(1) for match in map(RECORD.match, records.get(member, [])) if match]
            if not found:
                problems.append(f"{where}: does not say what it was compiled with")
            for record in found:
                flags = record.split()
                problems += [f"{where}: compiled without {flag}" for flag in REQUIRED if flag not in flags]
                problems += [f"{where}: compiled with {flag}" for flag in flags if FORBIDDEN.match(flag)]
            problems += [f"{where}: table of exceptions ({match.group(1)})" for match in map(SECTION.match, lines) if match]
            types = [line.split()[-1] for line in names.get(member, []) if re.search(r" _ZT[IS]", line)]
            problems += [f"{where}: run-time type information ({name})" for name in types]
    return problems


def check_sources(root):
    """Seeds: the first line of each source names its flags."""
    archives = []
    for source in sorted(root.glob("*.cpp")):
        flags = source.read_text().splitlines()[0].removeprefix("//").split()
        result = common.run([common.compiler(), "-O2", *flags, "-c", source, "-o", source.with_suffix(".o")])
        if result.returncode != 0:
            return ["seed does not compile: " + result.stdout]
        archives.append(source.with_suffix(".a"))
        common.output(["ar", "rcs", archives[-1], source.with_suffix(".o")])
    return check_archives(archives, "readelf", "nm")


GOOD = " ".join(REQUIRED) + " -frecord-gcc-switches"


def seed(name, flags, code, message):
    return common.Seed(name, {"a.cpp": f"//{flags}\n{code}\n"}, message)


PLAIN = "struct I { virtual int f() = 0; }; int g(I& i) { return i.f(); }"
DYING = "int outside(); struct D { ~D(); }; int f() { D d; return outside(); }"
SEEDS = [
    seed("what is allowed", GOOD, PLAIN, None),
    seed("no record", " ".join(REQUIRED), PLAIN, "does not say what it was compiled with"),
    *(seed(f"without {flag}", GOOD.replace(flag + " ", "-std=c++17 " if "std" in flag else ""), PLAIN, f"compiled without {flag}")
      for flag in REQUIRED),
    *(seed(f"with {flag}", f"{GOOD} {flag}", PLAIN, f"compiled with {flag}")
      for flag in ("-ffast-math", "-Ofast", "-mfma", "-fexceptions", "-frtti", "-funsafe-math-optimizations", "-ffp-contract=fast")),
    seed("exceptions", GOOD.replace("-fno-exceptions ", ""), DYING, "table of exceptions"),
    seed("type information", GOOD.replace("-fno-rtti ", ""), "struct A { virtual int f(); }; int A::f() { return 1; }",
         "run-time type information (_ZTI1A)"),
]


def on_tree(arguments):
    modules = sorted({path.parts[1] for path in common.sources(common.ROOT, ["fsw"], {".cpp"})})
    archives = [arguments.archives / f"librelnav_{module}.a" for module in modules]
    missing = [f"{archive} is not there; build first" for archive in archives if not archive.is_file()]
    return missing or check_archives(archives, arguments.readelf, arguments.nm)


if __name__ == "__main__":
    common.main(__doc__, check_sources, SEEDS, common.add_archive_arguments, on_tree)
