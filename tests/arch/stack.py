#!/usr/bin/env python3
"""Worst-case stack of the flight core, from the compiler's own call graph (-fstack-usage -fcallgraph-info=su,da).

The release build writes them beside its objects. No recursion, no dynamic frame (alloca, variable arrays), no call to an
outside function and no indirect call that stack.txt does not name, and the bounds of stack.txt hold."""
import pathlib
import re
import sys

import common

NODE = re.compile(r'^node: \{ title: "([^"]*)" label: "([^"]*)"')
EDGE = re.compile(r'^edge: \{ sourcename: "([^"]*)" targetname: "([^"]*)"(?: label: "([^"]*)")?')
INDIRECT = "__indirect_call"


class Function:
    def __init__(self, title):
        self.title = title
        self.name = title       # as a person reads it
        self.frame = None       # bytes; None: not ours
        self.dynamic = False
        self.calls = set()


def read_graph(files):
    """Functions by title, of all call graph files together. File-local titles carry their path, so they do not collide."""
    functions = {}

    def at(title):
        return functions.setdefault(title, Function(title))

    for path in files:
        for line in path.read_text(errors="replace").splitlines():
            node = NODE.match(line)
            if node:
                function = at(node.group(1))
                parts = node.group(2).split("\\n")
                frame = next((part for part in parts if re.match(r"\d+ bytes \(", part)), None)
                if frame:
                    function.name = parts[0]
                    function.frame = max(function.frame or 0, int(frame.split()[0]))
                    function.dynamic |= "dynamic" in frame and "bounded" not in frame
                elif function.frame is None:
                    function.name = parts[0]
                continue
            edge = EDGE.match(line)
            if edge:
                at(edge.group(1)).calls.add(edge.group(2))
                at(edge.group(2))
    return functions


def read_rules(path):
    rules = {"bound": [], "indirect": [], "external": {}}
    for line in common.list_file(path):
        kind, _, rest = line.partition(" ")
        if kind == "bound":
            pattern, _, size = rest.rpartition(" ")
            rules["bound"].append((re.compile(pattern.strip()), int(size)))
        elif kind == "indirect":
            caller, _, callee = rest.partition(" -> ")
            callee = callee.strip()
            rules["indirect"].append((re.compile(caller.strip()), None if callee == "hal" else re.compile(callee)))
        elif kind == "external":
            name, _, size = rest.rpartition(" ")
            rules["external"][name.strip()] = int(size)
        else:
            raise SystemExit(f"{path}: what is '{line}'?")
    return rules


def define_aliases(functions):
    """A constructor of a complete object (C1) is an alias of the one of a base object (C2), the same for destructors; only
    the latter has a node with a frame. Calls of the former go to it."""
    defined = {title.rsplit(":", 1)[-1]: title for title, function in functions.items() if function.frame is not None}
    alias = {}
    for title, function in functions.items():
        if function.frame is None:
            mangled = title.rsplit(":", 1)[-1]
            for match in re.finditer("([CD])1E", mangled):
                twin = f"{mangled[:match.start()]}{match.group(1)}2E{mangled[match.end():]}"
                if twin in defined:
                    alias[title] = defined[twin]
    for function in functions.values():
        function.calls = {alias.get(title, title) for title in function.calls}


def plain(name):
    """relnav::panic of '[[noreturn]] void relnav::panic(const char*, ...)'."""
    return name.split("(")[0].split(" ")[-1]


def examine(functions, rules, report=None):
    """Problems found. Fills report with (bytes, name, path of names) of the roots and (caller) of HAL calls."""
    problems = []
    define_aliases(functions)
    ours = {title: function for title, function in functions.items() if function.frame is not None}
    callees = {}
    hal_callers = []
    for function in ours.values():
        targets = set()
        for title in function.calls:
            target = functions[title]
            if title == INDIRECT:
                rule = next((callee for caller, callee in rules["indirect"] if caller.search(function.name)), False)
                if rule is False:
                    problems.append(f"indirect call in {function.name}: not in tests/arch/stack.txt")
                elif rule is None:
                    hal_callers.append(function.name)
                else:
                    callees_here = {other.title for other in ours.values() if rule.search(other.name)}
                    if not callees_here:
                        problems.append(f"indirect call in {function.name}: no function is called {rule.pattern}")
                    targets |= callees_here
            elif target.frame is None and plain(target.name) not in rules["external"] and title not in rules["external"]:
                problems.append(f"{function.name} calls {target.name}, which is not in tests/arch/stack.txt")
            else:
                targets.add(title)
        callees[function.title] = sorted(targets)
        if function.dynamic:
            problems.append(f"dynamic frame: {function.name}: its size is not known before it runs")

    def leaf(title):
        target = functions[title]
        return rules["external"].get(plain(target.name), rules["external"].get(title, 0))

    depth, deepest, state = {}, {}, {}

    def visit(title, path):
        if title in depth:
            return depth[title]
        if functions[title].frame is None:
            depth[title] = leaf(title)
            return depth[title]
        if state.get(title) == "open":
            names = [functions[step].name for step in path[path.index(title):]] + [functions[title].name]
            problems.append("recursion: " + " -> ".join(names))
            return 0
        state[title] = "open"
        worst, via = 0, None
        for target in callees[title]:
            below = visit(target, path + [title])
            if below > worst:
                worst, via = below, target
        state[title] = "done"
        depth[title], deepest[title] = functions[title].frame + worst, via
        return depth[title]

    sys.setrecursionlimit(10000)
    for title in sorted(ours):
        visit(title, [])
    for pattern, size in rules["bound"]:
        for function in ours.values():
            if pattern.search(function.name) and depth[function.title] > size:
                problems.append(f"stack of {function.name}: {depth[function.title]} bytes, bound {size}")
    if report is not None:
        report["hal"] = sorted(set(hal_callers))
        report["worst"] = sorted(((depth[title], title) for title in ours), reverse=True)

        def chain(title):
            lines = []
            while title is not None:
                function = functions[title]
                lines.append(f"{function.frame if function.frame is not None else leaf(title):8d}  {function.name}")
                title = deepest.get(title)
            return lines
        report["path"] = chain
    return problems


def call_graphs(folder):
    """What the release build has written beside its object files, of sources that still exist."""
    objects = folder / "fsw" / "CMakeFiles"
    found = []
    for path in sorted(objects.rglob("*.ci")):
        source = path.relative_to(objects).parts[1:]
        if (common.ROOT / "fsw" / pathlib.Path(*source).with_suffix(".cpp")).exists() or \
           (common.ROOT / "fsw" / str(pathlib.Path(*source)).removesuffix(".ci")).exists():
            found.append(path)
    return found


def on_tree(arguments):
    files = call_graphs(arguments.build.resolve())
    missing = len(common.sources(common.ROOT, ["fsw"], {".cpp"})) - len(files)
    if missing:
        return [f"{arguments.build}: {missing} sources of fsw/ without their call graph; build the preset `host` first"]
    functions = read_graph(files)
    report = {}
    problems = examine(functions, read_rules(arguments.rules), report)
    print(f"{len(files)} call graphs, {sum(f.frame is not None for f in functions.values())} functions")
    step = next((title for _, title in report["worst"] if "relnav::app::FlightLoop::step(" in functions[title].name), None)
    if step is None:
        print("FlightLoop::step() has no call graph yet; deepest function instead:")
        step = report["worst"][0][1]
    print(f"worst stack: {next(size for size, title in report['worst'] if title == step)} bytes")
    for line in report["path"](step):
        print(line)
    for name in report["hal"]:
        print("calls through a HAL interface (the platform's stack comes on top):", name)
    return problems


def check_sources(root):
    for source in sorted(root.glob("*.cpp")):
        result = common.run([common.compiler(), "-std=c++20", "-O2", "-fno-exceptions", "-fstack-usage", "-fcallgraph-info=su,da",
                             "-c", source, "-o", source.with_suffix(".o")], cwd=root)
        if result.returncode != 0:
            return ["seed does not compile: " + result.stdout]
    return examine(read_graph(sorted(root.glob("*.ci"))), read_rules(root / "rules.txt"))


RULES = ("bound relnav::step 600\nindirect relnav::step -> hal\nindirect relnav::core -> relnav::.*::inner\\(\n"
         "external memset 128\nexternal relnav::panic 64\n")
CORE = "namespace relnav { struct I { virtual int inner(int) = 0; }; int outside(int); void sink(char*);\n%s\n}\n"

B = "namespace relnav { struct B { explicit B(int n); volatile int v[200]; };\n%s\n}\n"
CONSTRUCTOR = {"a.cpp": B % "int step(int n) { B b(n); return b.v[n]; }",
               "b.cpp": B % "B::B(int n) { volatile int a[200]; a[n] = 1; v[n] = a[n / 2]; }"}


def seed(name, code, message, rules=RULES):
    return common.Seed(name, {"a.cpp": CORE % code, "rules.txt": rules}, message)


SEEDS = [
    seed("what is allowed", "void panic(const char*); int step(I& i) { if (i.inner(1) == 2) panic(\"\"); return 1; }", None),
    seed("recursion", "int f(int n); __attribute__((noinline)) int g(int n) { return f(n - 1) + 1; }\n"
         "int f(int n) { return n < 2 ? n : g(n) * g(n - 2); }", "recursion: "),
    seed("recursion through an interface", "__attribute__((noinline)) int core(I& i) { return i.inner(3) + 1; }\n"
         "struct A : I { int inner(int n) override; };\nint A::inner(int n) { return n ? core(*this) * 2 : 1; }", "recursion: "),
    seed("alloca", "int f(int n) { volatile char* p = static_cast<char*>(__builtin_alloca(n)); p[n - 1] = 1; return p[0]; }",
         "dynamic frame: "),
    seed("unknown external", "int f(int n) { return outside(n) + 1; }", "which is not in tests/arch/stack.txt"),
    seed("unknown indirect call", "int f(I& i) { return i.inner(3) + 1; }", "indirect call in "),
    seed("indirect call of nobody", "int core(I& i) { return i.inner(3) + 1; }", "no function is called "),
    common.Seed("constructor under two names", {**CONSTRUCTOR, "rules.txt": RULES.replace(" 600", " 2000")}, None),
    common.Seed("over the bound through a constructor", {**CONSTRUCTOR, "rules.txt": RULES.replace(" 600", " 1200")},
                "bound 1200"),
    seed("over the bound", "__attribute__((noinline)) int low(int n) { volatile int a[100]; a[n] = 1; return a[n / 2]; }\n"
         "int step(int n) { volatile int a[100]; a[n] = low(n); return a[n / 2]; }", "bound 600"),
    seed("over the bound through an interface",
         "struct A : I { int inner(int n) override; }; int A::inner(int n) { volatile int a[200]; a[n] = 1; return a[n / 2]; }\n"
         "int core(I& i) { return i.inner(3) + 1; }", "bound 600", RULES.replace("bound relnav::step", "bound relnav::core")),
]


def add_arguments(parser):
    parser.add_argument("--build", type=pathlib.Path, default=common.ROOT / "build/host",
                        help="build folder of the preset host")
    parser.add_argument("--rules", type=pathlib.Path, default=pathlib.Path(__file__).parent / "stack.txt")


if __name__ == "__main__":
    common.main(__doc__, check_sources, SEEDS, add_arguments, on_tree)
