#!/usr/bin/env python3
"""What a command prints is what a file says.

    same_output.py FILE COMMAND..."""
import difflib
import pathlib
import subprocess
import sys

expected = pathlib.Path(sys.argv[1]).read_text().splitlines()
result = subprocess.run(sys.argv[2:], capture_output=True, text=True, check=False)
printed = (result.stdout + result.stderr).splitlines()
print("\n".join(printed))
problems = list(difflib.unified_diff(expected, printed, sys.argv[1], sys.argv[2], lineterm=""))
if problems or result.returncode != 0:
    sys.exit("\n".join([*problems, f"exit status {result.returncode}"]))
