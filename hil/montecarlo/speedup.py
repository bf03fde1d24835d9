#!/usr/bin/env python3
"""How much faster a campaign is with 2 jobs than with 1, and what it costs beside its runs.

    hil/montecarlo/speedup.py RELNAV SCENARIO [--runs N] [--rounds R] [--program PROGRAM]

The same campaign with 1 job and with 2 (and, to see what the machine gives, the runs alone with xargs -P 1 and -P 2), in turns;
medians of the rounds. A figure to quote needs a machine with nothing else to do: the load is printed.
"""
import argparse
import os
import pathlib
import resource
import statistics
import subprocess
import tempfile
import time


def timed(command, **options):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    start = time.monotonic()
    subprocess.run([str(c) for c in command], check=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, **options)
    wall = time.monotonic() - start
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("relnav")
    parser.add_argument("scenario")
    parser.add_argument("--runs", type=int, default=40)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--program", help="stands in for relnav sim")
    o = parser.parse_args()
    program = o.program or o.relnav
    figures = {}
    with tempfile.TemporaryDirectory(prefix="relnav_speedup_") as folder:
        for turn in range(o.rounds):
            for jobs in (1, 2):
                out = pathlib.Path(folder) / f"{turn}-{jobs}"
                extra = ["--program", o.program] if o.program else []
                figures.setdefault(("campaign", jobs), []).append(timed(
                    [o.relnav, "montecarlo", "--scenario", o.scenario, "--runs", o.runs, "--jobs", jobs, "--out", out, *extra]))
                numbers = "\n".join(str(k) for k in range(o.runs)) + "\n"
                figures.setdefault(("alone", jobs), []).append(timed(
                    ["xargs", "-P", jobs, "-I{}", program, "sim", "--scenario", o.scenario, "--run", "{}", "--result",
                     f"{folder}/{turn}-{jobs}-{{}}"], input=numbers, text=True))
    for (what, jobs), values in figures.items():
        print(f"{what:9} {jobs} job{'s' if jobs > 1 else ' '}: {statistics.median(v[0] for v in values):7.2f} s, "
              f"CPU {statistics.median(v[1] for v in values):7.2f} s")
    for what in ("campaign", "alone"):
        ratios = [a[0] / b[0] for a, b in zip(figures[what, 1], figures[what, 2])]
        print(f"{what:9} speed-up {statistics.median(ratios):.3f} ({min(ratios):.3f} to {max(ratios):.3f})")
    extra = statistics.median((a[1] - b[1]) / o.runs for a, b in zip(figures["campaign", 1], figures["alone", 1]))
    print(f"CPU of the campaign beside its runs, more than xargs: {extra * 1000:.2f} ms a run; load now {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
