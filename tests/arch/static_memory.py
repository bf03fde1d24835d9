#!/usr/bin/env python3
"""Static memory of the flight loop, frames aside: sizeof(FlightLoop) within its budget at each number of feature slots."""
import common

BUDGETS = {40: 1 << 20, 60: 2 << 20}  # feature slots: bytes


def size_of_loop(root, slots, compiler=None):
    """Bytes, or what the compiler says. It is asked by an error that names the size: nothing has to run."""
    unit = ('#include "fsw/app/flight_loop.hpp"\ntemplate <unsigned long bytes> struct Size;\n'
            "Size<sizeof(relnav::app::FlightLoop)> size;\n")
    command = [*(compiler or [common.compiler()]), "-std=c++20", *common.eigen_flags(), f"-DRELNAV_MAX_FEATURES={slots}", "-fsyntax-only",
               f"-I{root}", "-x", "c++", "-"]
    errors = common.subprocess.run(command, input=unit, capture_output=True, text=True, check=False,
                                   cwd=root).stderr
    size = common.re.search(r"Size<(\d+)", errors)
    return int(size.group(1)) if size else errors.splitlines()[0] if errors else "no answer"


def problem_with(root, slots, budget):
    size = size_of_loop(root, slots)
    if isinstance(size, str):
        return f"{slots} slots: does not compile: {size}"
    print(f"{slots} slots: {size} of {budget} bytes")
    return f"{slots} slots: the flight loop takes {size} bytes of static memory, {budget} at most" if size > budget else ""


def check(root):
    problems = [problem_with(root, slots, budget) for slots, budget in BUDGETS.items()]
    return [problem for problem in problems if problem]


def loop_of(size_40, size_60):
    return ("#pragma once\nnamespace relnav::app {\n"
            f"struct FlightLoop {{ char memory[RELNAV_MAX_FEATURES == 40 ? {size_40} : {size_60}]; }};\n}}\n")


SEEDS = [
    common.Seed("within the budget", {"fsw/app/flight_loop.hpp": loop_of(1 << 20, 2 << 20)}, None),
    common.Seed("one byte too many at 40 slots", {"fsw/app/flight_loop.hpp": loop_of((1 << 20) + 1, 1)},
                "40 slots: the flight loop takes 1048577 bytes"),
    common.Seed("too large at 60 slots", {"fsw/app/flight_loop.hpp": loop_of(1, 3 << 20)},
                "60 slots: the flight loop takes 3145728 bytes"),
]

if __name__ == "__main__":
    common.main(__doc__, check, SEEDS)
