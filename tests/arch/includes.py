#!/usr/bin/env python3
"""Direction of includes (design: "Folders: who lives where, and who may include whom")."""
import pathlib
import re

import common

# Rooms a room may include from, besides itself. Everybody in fsw, hal and platform sees fsw/config.hpp.
BELOW = {
    "fsw/config": set(),
    "fsw/base": set(),
    "fsw/math": {"fsw/base"},
    "fsw/attitude": {"fsw/base", "fsw/math"},
    "fsw/geometry": {"fsw/base", "fsw/math", "fsw/attitude"},
    "fsw/vision": {"fsw/base", "fsw/math", "fsw/attitude", "fsw/geometry"},
    "fsw/estimation": {"fsw/base", "fsw/math", "fsw/attitude", "fsw/geometry"},
    "fsw/telemetry": {"fsw/base"},
    "fsw/app": {"fsw/base", "fsw/math", "fsw/attitude", "fsw/geometry", "fsw/vision", "fsw/estimation", "fsw/telemetry",
                "hal"},
    "hal": {"fsw/base"},
}
WITH_EIGEN = {"fsw/math", "fsw/attitude", "fsw/geometry", "fsw/vision", "fsw/estimation", "fsw/app"}
INCLUDE = re.compile(r'^\s*#\s*include\s*(?:"([^"]*)"|<([^>]*)>|(\S+))')


def room_of(path):
    parts = pathlib.PurePosixPath(path).parts
    if parts[0] == "fsw":
        return "fsw/config" if parts[1:] == ("config.hpp",) else "/".join(parts[:2])
    if parts[0] == "platform":
        return "/".join(parts[:2])
    return parts[0]


def sees(path, room, other):
    """Whether a file of `room` may include from room `other`."""
    if room == other or (other == "fsw/config" and not room.startswith("hil")):
        return True
    if room.startswith("platform/"):
        if pathlib.PurePosixPath(path).name == "main.cpp":  # the one place that wires things up
            return other in {"hal", "platform/files", "platform/posix"} or other.startswith("fsw/")
        if room == "platform/files":  # fills the flight code's configuration
            return other.startswith("fsw/")
        return other in {"hal", "fsw/base"}
    return other in BELOW.get(room, set())


def check(root):
    standard = set(common.list_file(pathlib.Path(__file__).parent / "standard_headers.txt"))
    problems = []
    for path in common.sources(root, ["fsw", "hal", "platform"]):
        name = path.as_posix()
        room = room_of(name)
        if room not in BELOW and not room.startswith("platform/"):
            problems.append(f"{name}: {room} is no room of the design (see BELOW in tests/arch/includes.py)")
            continue
        text = common.without_comments((root / path).read_text(), keep_strings=True)
        for number, line in enumerate(text.splitlines(), 1):
            match = INCLUDE.match(line)
            if not match:
                continue
            quoted, angled, other = match.groups()
            where = f"{name}:{number}: "
            if other:
                problems.append(where + f"computed include {other}")
            elif quoted is not None:
                if ".." in quoted or not (root / quoted).is_file():
                    problems.append(where + f'"{quoted}" is not a file; includes are written from the repository\'s root')
                elif not sees(name, room, room_of(quoted)):
                    problems.append(where + f'{room} must not include "{quoted}"')
            elif room.startswith("platform/"):
                first = angled.split("/")[0]
                if first in {"fsw", "hal", "platform", "hil", "tests"}:
                    problems.append(where + f"write <{angled}> with quotes")
            elif angled.startswith("Eigen/"):
                if room not in WITH_EIGEN:
                    problems.append(where + f"{room} must do without <{angled}>")
            elif angled not in standard:
                problems.append(where + f"<{angled}> is not in tests/arch/standard_headers.txt")
    return problems


def tree(files):
    """A seed's files, with every header that rooms are expected to see."""
    base = {name: "" for name in ("fsw/config.hpp", "fsw/base/status.hpp", "fsw/math/types.hpp", "fsw/attitude/dcm.hpp",
                                  "fsw/geometry/pose.hpp", "fsw/vision/fast.hpp", "fsw/estimation/ekf.hpp",
                                  "fsw/telemetry/packet.hpp", "fsw/app/loop.hpp", "hal/camera.hpp",
                                  "platform/host/stub.hpp", "platform/linux/gpio.hpp", "platform/posix/udp.hpp",
                                  "hil/tool.hpp", "tests/support/x.hpp")}
    return {**base, **files}


def seed(name, path, include, message):
    return common.Seed(name, tree({path: f"#pragma once\n#include {include}\n"}), message)


SEEDS = [
    common.Seed("every allowed direction", tree({
        "fsw/math/a.hpp": '#include <Eigen/Core>\n#include "fsw/base/status.hpp"\n#include "fsw/config.hpp"\n',
        "fsw/vision/a.cpp": '#include <cstdint>\n#include "fsw/geometry/pose.hpp"\n',
        "fsw/app/a.cpp": '#include "fsw/vision/fast.hpp"\n#include "fsw/estimation/ekf.hpp"\n#include "hal/camera.hpp"\n',
        "platform/host/a.cpp": '#include <chrono>\n#include "hal/camera.hpp"\n#include "fsw/base/status.hpp"\n',
        "platform/linux/main.cpp": '#include "fsw/app/loop.hpp"\n#include "platform/posix/udp.hpp"\n',
        "fsw/base/c.hpp": '// #include <vector>\n/* #include "hal/camera.hpp" */\n'}), None),
    seed("base upwards", "fsw/base/a.hpp", '"fsw/math/types.hpp"', "fsw/base must not include"),
    seed("vision to estimation", "fsw/vision/a.cpp", '"fsw/estimation/ekf.hpp"', "fsw/vision must not include"),
    seed("estimation to vision", "fsw/estimation/a.cpp", '"fsw/vision/fast.hpp"', "fsw/estimation must not include"),
    seed("telemetry to math", "fsw/telemetry/a.cpp", '"fsw/math/types.hpp"', "fsw/telemetry must not include"),
    seed("estimation to the HAL", "fsw/estimation/a.cpp", '"hal/camera.hpp"', "fsw/estimation must not include"),
    seed("HAL to the loop", "hal/a.hpp", '"fsw/app/loop.hpp"', "hal must not include"),
    seed("platform to platform", "platform/host/a.cpp", '"platform/linux/gpio.hpp"', "platform/host must not include"),
    seed("platform to the core", "platform/linux/a.cpp", '"fsw/estimation/ekf.hpp"', "platform/linux must not include"),
    seed("platform to what POSIX systems share", "platform/linux/a.cpp", '"platform/posix/udp.hpp"',
         "platform/linux must not include"),
    seed("main.cpp to another platform", "platform/linux/main.cpp", '"platform/host/stub.hpp"', "must not include"),
    seed("flight code to hil", "fsw/app/a.cpp", '"hil/tool.hpp"', "fsw/app must not include"),
    seed("platform to tests", "platform/host/a.cpp", '"tests/support/x.hpp"', "platform/host must not include"),
    seed("operating system in flight code", "fsw/app/a.cpp", "<unistd.h>", "<unistd.h> is not in"),
    seed("heap container in flight code", "fsw/base/a.hpp", "<vector>", "<vector> is not in"),
    seed("operating system in the HAL", "hal/a.hpp", "<thread>", "<thread> is not in"),
    seed("Eigen in telemetry", "fsw/telemetry/a.cpp", "<Eigen/Core>", "must do without"),
    seed("relative include", "fsw/base/a.hpp", '"status.hpp"', "is not a file"),
    seed("a room nobody planned", "fsw/utils/a.hpp", "<cstdint>", "is no room of the design"),
]

if __name__ == "__main__":
    common.main(__doc__, check, SEEDS)
