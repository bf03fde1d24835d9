#!/usr/bin/env python3
"""Every header of fsw/, hal/, platform/host and platform/posix compiles on its own, and twice in a row, with the build's warnings.
Those that stand first in the source of their name are compiled on their own by the build; of these only the guard is looked at."""
import concurrent.futures
import re

import common


def compile_alone(root, header, flags):
    """Empty when fine, else what the compiler says first."""
    unit = f'#include "{header}"\n#include "{header}"\n'
    command = [common.compiler(), *flags, "-fsyntax-only", f"-I{root}", "-x", "c++", "-"]
    result = common.subprocess.run(command, input=unit, capture_output=True, text=True, check=False)
    if result.returncode == 0:
        return ""
    lines = [line for line in result.stderr.splitlines() if "error" in line] or result.stderr.splitlines() or ["?"]
    return f"{header}: does not compile on its own: {lines[0].replace(str(root) + '/', '')}"


def is_first_in_its_source(root, header):
    source = (root / header).with_suffix(".cpp")
    first = re.search(r'^#include [<"](.+)[>"]', source.read_text(), re.M) if source.exists() else None
    return first is not None and first.group(1) == header.as_posix()


def has_guard(root, header):
    code = common.without_comments((root / header).read_text()).split("\n")
    return next((line.strip() for line in code if line.strip()), "") == "#pragma once"


def check(root):
    flags = common.strict_flags() + common.eigen_flags()
    headers = common.sources(root, ["fsw", "hal", "platform/host", "platform/posix"], {".hpp", ".h"})
    if not headers:
        return ["no headers found"]
    built = [header for header in headers if is_first_in_its_source(root, header)]
    problems = [f"{header}: does not begin with #pragma once" for header in built if not has_guard(root, header)]
    headers = [header for header in headers if header not in built]
    with concurrent.futures.ThreadPoolExecutor(max_workers=2) as pool:
        results = pool.map(lambda header: compile_alone(root, header, flags), headers)
        return problems + [problem for problem in results if problem]


SEEDS = [
    common.Seed("a sound header", {"fsw/base/a.hpp": "#pragma once\n#include <cstdint>\ninline std::uint8_t one() { return 1; }\n"},
                None),
    common.Seed("lacks an include", {"fsw/base/a.hpp": "#pragma once\ninline std::uint8_t one() { return 1; }\n"},
                "fsw/base/a.hpp: does not compile on its own"),
    common.Seed("lacks its guard", {"hal/a.hpp": "struct A {};\n"}, "hal/a.hpp: does not compile on its own"),
    common.Seed("stands first in its source",
                {"fsw/base/a.hpp": "#pragma once\ninline std::uint8_t one() { return 1; }\n",
                 "fsw/base/a.cpp": "#include \"fsw/base/a.hpp\"\n"}, None),
    common.Seed("stands second in its source",
                {"fsw/base/a.hpp": "#pragma once\ninline std::uint8_t one() { return 1; }\n",
                 "fsw/base/a.cpp": "#include <cstdint>\n#include \"fsw/base/a.hpp\"\n"}, "fsw/base/a.hpp: does not compile on its own"),
    common.Seed("lacks its guard, first in its source",
                {"fsw/base/a.hpp": "struct A {};\n", "fsw/base/a.cpp": "#include \"fsw/base/a.hpp\"\n"}, "does not begin with #pragma once"),
    common.Seed("warns", {"fsw/math/a.hpp": "#pragma once\ninline int f(long x) { return x; }\n"},
                "fsw/math/a.hpp: does not compile on its own"),
]

if __name__ == "__main__":
    common.main(__doc__, check, SEEDS)
