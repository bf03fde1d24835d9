#!/usr/bin/env python3
"""Counts test cases from the JUnit files that ctest writes.

    count.py FILE.xml...             cases: those CppUTest reports in each executable's output, else one a ctest entry
    count.py --entries FILE.xml...   one a ctest entry

Prints `PASSED FAILED` and, on stderr, the entries that failed. An executable that ends without CppUTest's last line
(crash, time-out) counts as one failed case."""
import re
import sys
import xml.etree.ElementTree

# OK (12 tests, 12 ran, 30 checks, 0 ignored, 0 filtered out, 3 ms)
# Errors (1 failures, 12 tests, 12 ran, 30 checks, ...)
SUMMARY = re.compile(r"^(?:\x1b\[[0-9;]*m)?(OK|Errors) \((?:(\d+) failures?, )?(?:ran nothing, )?(\d+) tests?, (\d+) ran", re.M)


def read(path):
    """The file's root element, whatever bytes the tests printed."""
    with open(path, encoding="utf-8", errors="replace") as file:
        return xml.etree.ElementTree.fromstring(re.sub("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]", "?", file.read()))


def count_entry(name, good, output):
    """(passed, failed) of one ctest entry."""
    summaries = SUMMARY.findall(output)
    is_cpputest = name.startswith("unit_") or re.search(r"^TEST\(", output, re.M) or summaries
    if not is_cpputest:
        return (1, 0) if good else (0, 1)
    ran = sum(int(summary[3]) for summary in summaries)
    failed = min(sum(int(summary[1] or 0) for summary in summaries), ran)
    if not good and failed == 0:
        failed = 1  # it crashed, ran out of time, or ran nothing
        ran = max(ran, 1)
    return ran - failed, failed


def main():
    arguments = sys.argv[1:]
    by_entry = "--entries" in arguments
    passed = failed = 0
    for path in (argument for argument in arguments if argument != "--entries"):
        for case in read(path).iter("testcase"):
            name, status = case.get("name"), case.get("status")
            if status == "disabled" or case.find("skipped") is not None and status != "fail":
                print(f"did not run: {name}", file=sys.stderr)
                failed += 1
                continue
            good = status == "run"
            output = case.findtext("system-out") or ""
            one = (int(good), int(not good)) if by_entry else count_entry(name, good, output)
            if one[1]:
                print(f"FAILED: {name} ({one[1]} of {sum(one)})", file=sys.stderr)
            passed, failed = passed + one[0], failed + one[1]
    print(passed, failed)


if __name__ == "__main__":
    main()
