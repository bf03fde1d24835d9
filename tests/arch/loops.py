#!/usr/bin/env python3
"""Every loop of fsw/ and hal/ says how often it runs at most.

A range for runs once for each element of a bounded container; a counted for (one variable, stepped in its head alone) as often
as its condition says. Any other loop, while and do first of all, has `// bound: ...` on its line or the line above. docs/work.md lists
these."""
import re

import common

BOUND = re.compile(r"//\s*bound:\s*(\S.*)")
BEGIN, END = "<!-- loops: made by tests/arch/loops.py --update, begin -->\n", "<!-- loops: end -->\n"
HEAD = re.compile(r"\b(for|while|do)\b\s*([({])")


def closing(text, at, pair):
    """Position behind the bracket that closes the one at `at`."""
    depth = 0
    for i in range(at, len(text)):
        depth += (text[i] == pair[0]) - (text[i] == pair[1])
        if depth == 0:
            return i + 1
    return len(text)


def body_at(text, at):
    """The statement that begins behind `at`: a block, or up to the semicolon outside of brackets."""
    while at < len(text) and text[at].isspace():
        at += 1
    if at < len(text) and text[at] == "{":
        return text[at:closing(text, at, "{}")]
    depth = 0
    for i in range(at, len(text)):
        depth += (text[i] in "({[") - (text[i] in ")}]")
        if text[i] == ";" and depth == 0:
            return text[at:i + 1]
    return text[at:]


def changes(text, name):
    n = re.escape(name)
    return re.search(rf"(?<![\w.>])(?:(?:\+\+|--){n}\b(?!\s*[\[.])|{n}\s*(?:\+\+|--|[-+*/%&|^]=|<<=|>>=|=(?!=)))", text) is not None


def is_counted(head, body):
    parts = head.split(";")
    if len(parts) != 3 or "||" in parts[1]:
        return False
    _, condition, step = (part.strip() for part in parts)
    for limit in condition.split("&&"):
        down = re.fullmatch(r"\s*(\w+)--\s*>=?\s*[^<>]+", limit)
        if down and not step and not changes(body, down.group(1)):
            return True
        match = re.fullmatch(r"\s*(?:[\w:<>.()]+\s*[*]\s*)?(\w+)(?:\s*\+\s*[^<>]*(?:<\w+>)?)?\s*(<=?|>=?|!=)\s*(.+)", limit)
        if not match:
            continue
        name, relation = match.group(1), match.group(2)
        n = re.escape(name)
        up = re.fullmatch(rf"\+\+{n}|{n}\+\+|{n} \+= [\w:<>.* ]+", step)
        fall = re.fullmatch(rf"--{n}|{n}--|{n} -= \w+", step)
        right_way = up if relation in ("<", "<=", "!=") else fall
        if right_way and not changes(body, name) and not changes(match.group(3), name):
            return True
    return False


def loops(text):
    """(line, words of the head, whether its bound is plain, written bound) of each loop."""
    clean = common.without_comments(text)
    lines = text.splitlines()
    ends_of_do = set()
    for match in HEAD.finditer(clean):
        kind, opened = match.group(1), match.start(2)
        if clean[clean.rfind("\n", 0, match.start()) + 1:match.start()].lstrip().startswith("#"):
            continue
        if kind == "do":
            behind = closing(clean, opened, "{}")
            last = re.compile(r"\s*while").match(clean, behind)
            if last:
                ends_of_do.add(last.end())
            head, plain = "do", False
        elif clean[opened] != "(" or match.end(1) in ends_of_do:
            continue
        else:
            behind = closing(clean, opened, "()")
            head = " ".join(clean[opened + 1:behind - 1].split())
            body = body_at(clean, behind)
            plain = kind == "for" and (";" not in head or is_counted(head, body))
        number = clean.count("\n", 0, match.start()) + 1
        near = lines[number - 1:number] + (lines[number - 2:number - 1] if lines[number - 2].lstrip().startswith("//") else [])
        written = next((found.group(1) for found in map(BOUND.search, near) if found), None)
        yield number, f"{kind} ({head})", plain, written


def check(root):
    problems = []
    for path in common.sources(root, ["fsw", "hal"]):
        for number, head, plain, written in loops((root / path).read_text()):
            if not plain and not written:
                problems.append(f"{path}:{number}: how often at most? Say `// bound: ...`: {head}")
    return problems


def seed(code, caught=True):
    return common.Seed(code, {"fsw/base/a.cpp": f"void f(int n, int* p) {{\n{code}\n}}\n"}, "fsw/base/a.cpp:2: how often" if caught else None)


SEEDS = [
    seed("for (int i = 0; i < n; ++i) p[i] = i;", False),
    seed("for (int i = 0; i + 8 <= n; i += 8) { p[i] = 1; }", False),
    seed("for (std::size_t i = n; i-- > 0;) p[i] = 1;", False),
    seed("for (int k = n; k > 0 && p[k] < p[k - 1]; --k) swap(p[k], p[k - 1]);", False),
    seed("for (const int x : list) use(x);", False),
    seed("while (n != 0) n &= n - 1;  // bound: the 32 bits of n", False),
    seed("do { --n; } while (n > 0);  // bound: n", False),
    seed("while (n != 0) n &= n - 1;"),
    seed("for (;;) { if (p[n]) break; }"),
    seed("for (int i = 0; p[i] != 0; ++i) {}"),
    seed("for (int i = 0; i < n; ++i) { if (p[i] == 3) i = 0; }"),
    seed("for (int i = 0; i < n; ++i) { --i; }"),
    seed("for (int i = 0; i < n; --i) {}"),
    seed("for (int i = 0; i < n || p[i]; ++i) {}"),
    seed("for (int i = 0; i < n;) { ++i; }"),
    seed("for (const Node* x = head; x != nullptr; x = x->next) {}"),
    seed("do { --n; } while (n > 0);"),
    seed("while (true) {}  // bound:"),
]


def table(root):
    text = "| file | loop | runs at most |\n|---|---|---|\n"
    for path in common.sources(root, ["fsw", "hal"]):
        for _, head, plain, written in loops((root / path).read_text()):
            if not plain and written:
                text += f"| `{path}` | `{head.replace('|', '&#124;')}` | {written} |\n"
    return text


def on_tree(arguments):
    path = arguments.root / "docs/work.md"
    document = path.read_text()
    begin, end = document.index(BEGIN) + len(BEGIN), document.index(END)
    if arguments.update:
        path.write_text(document[:begin] + table(arguments.root) + document[end:])
    elif document[begin:end] != table(arguments.root):
        return check(arguments.root) + ["docs/work.md: the table of loops is not that of the sources; see --update"]
    return check(arguments.root)


def add_arguments(parser):
    parser.add_argument("--update", action="store_true", help="write the table of docs/work.md anew")


if __name__ == "__main__":
    common.main(__doc__, check, SEEDS, add_arguments, on_tree)
