#!/usr/bin/env python3
"""clang-tidy over the flight code with .clang-tidy: names (the frame rule included) and a small set of likely mistakes."""
import collections
import concurrent.futures
import re
import shutil
import tempfile

import common

TOOL = shutil.which("clang-tidy-14") or shutil.which("clang-tidy") or "clang-tidy"
CONFIG = common.ROOT / ".clang-tidy"
MOST_FILES = 14  # of a unit


def problems_of(command):
    result = common.run(command)
    lines = [line for line in result.stdout.splitlines() if re.search(r": (error|warning): ", line)]
    if result.returncode != 0 and not lines:
        lines = [result.stdout.strip() or f"{TOOL} failed"]
    return lines


def tidy(units, flags):
    """units: lists of files. What a list has in common is read once: nearly all of the time goes into Eigen's headers."""
    def one(files):
        with tempfile.NamedTemporaryFile("w", suffix=".cpp") as unit:
            unit.writelines(f'#include "{path}"\n' for path in files)
            unit.flush()
            lines = problems_of([TOOL, "--quiet", f"--config-file={CONFIG}", unit.name, "--", *flags])
        if len(files) > 1 and any("[clang-diagnostic-error]" in line for line in lines):
            half = len(files) // 2  # names of anonymous namespaces may have met
            return one(files[:half]) + one(files[half:])
        return lines
    with concurrent.futures.ThreadPoolExecutor(max_workers=2) as pool:
        return sorted({line for lines in pool.map(one, units) for line in lines})


def flags(root):
    # Naming needs no optimiser, and gcc's own flags mean nothing here.
    return ["-std=c++20", "-fno-exceptions", "-fno-rtti", f"-I{root}", *common.eigen_flags()]


def check(root):
    sources = common.sources(root, ["fsw"], {".cpp"})
    included = set()
    for path in common.sources(root, ["fsw", "hal"]):
        included |= set(re.findall(r'#include "([^"]+)"', (root / path).read_text()))
    # Headers come with the sources that include them, and those that nobody includes stand beside them.
    lone = [path for path in common.sources(root, ["fsw", "hal"], {".hpp"}) if path.as_posix() not in included]
    rooms = collections.defaultdict(list)
    for path in sources + lone:
        rooms[path.parent].append(root / path)
    units = [files[i:i + MOST_FILES] for files in rooms.values() for i in range(0, len(files), MOST_FILES)]
    return [problem.replace(str(root) + "/", "") for problem in tidy(units, flags(root))]


GOOD = """#pragma once
namespace relnav {
struct Pose { double t_CT = 0; double R_CT = 1; double omega_C = 0; };
enum class Mode { standby, acquire };
inline constexpr int max_features = 3;
class Filter {
 public:
  double update(const Pose& pose_CT, double S_px2, double q_CT_prev) {
    const double K = S_px2, PHt = K, J_uv_p = PHt, H_pose = J_uv_p, r_TC = H_pose, dR_CT = r_TC, P = dR_CT;
    return t_TC_ + P + pose_CT.t_CT + q_CT_prev + count_;
  }
 private:
  double t_TC_ = 0;
  double count_ = 0;
};
}  // namespace relnav
"""


def seed(name, old, new, message):
    return common.Seed(name, {"fsw/base/a.hpp": GOOD.replace(old, new), "fsw/base/a.cpp": '#include "fsw/base/a.hpp"\n'}, message)


SEEDS = [
    seed("names with frames", "Pose {", "Pose {", None),
    seed("camelCase variable", "double K = S_px2", "double gainMatrix = 1, K = S_px2", "invalid case style for"),
    seed("type in lower case", "struct Pose {", "struct other_pose {}; struct Pose {", "'other_pose'"),
    seed("member without its underscore", "double count_ = 0;", "double count_ = 0; double sum = 0;", "'sum'"),
    seed("function in CamelCase", " private:", "  void DoIt() {}\n private:", "'DoIt'"),
    seed("constant with a k", "max_features", "kMaxFeatures", "'kMaxFeatures'"),
    seed("enumerator in capitals", "standby,", "STANDBY,", "'STANDBY'"),
    seed("macro without prefix", "namespace relnav {\nstruct", "#define HELPER 1\nnamespace relnav {\nstruct", "'HELPER'"),
    common.Seed("in a source, among names that meet",
                {"fsw/base/a.cpp": "namespace { constexpr int one = 1; }\nint two() { return 2 * one; }\n",
                 "fsw/base/b.cpp": "namespace { constexpr int one = 1; }\nint aB() { return one; }\n"}, "'aB'"),
    common.Seed("a header that nobody includes", {"hal/a.hpp": "#pragma once\nstruct wrong_name {};\n"}, "'wrong_name'"),
]

if __name__ == "__main__":
    common.main(__doc__, check, SEEDS)
