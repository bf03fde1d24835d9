#!/usr/bin/env python3
"""The bits of a replay, in each mode, are those of golden.txt, whatever target, compiler and optimisation made the tool.

    bit_identity.py --work FOLDER [--disturbed] COMMAND...

COMMAND is the tool `relnav`, after its emulator where it needs one. --disturbed: the tool is one that is wrong by one unit in
the last place somewhere; passes if that shows in each mode. golden.txt is in the format of sha256sum."""
import argparse
import hashlib
import pathlib
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
CAPTURES = HERE.parents[1] / "hil" / "captures"
# Capture, frames used of it, how it is replayed. An emulator takes a second or so a frame.
RUNS = {
    "noncoop": ("spin_near", 40, ["--range", "3.4"]),
    "coop-mono": ("lights_mono", 20, []),
    "coop-stereo": ("lights_stereo", 12, []),
}
COMPARED = ("telemetry.bin", "trajectory.tum")


def beginning(capture, frames, folder):
    """A data set of the capture's first frames; the images are the capture's."""
    for camera in sorted((capture / "mav0").iterdir()):
        copy = folder / "mav0" / camera.name
        copy.mkdir(parents=True)
        rows = (camera / "data.csv").read_text().splitlines(keepends=True)
        (copy / "data.csv").write_text("".join(rows[:frames + 1]))
        shutil.copy(camera / "sensor.yaml", copy)
        (copy / "data").symlink_to(camera / "data")
    if (capture / "target.yaml").exists():
        shutil.copy(capture / "target.yaml", folder)
    return folder


def replay(command, mode, work):
    """Hash of each compared file of a run."""
    capture, frames, options = RUNS[mode]
    out = work / mode
    shutil.rmtree(out, ignore_errors=True)
    data = beginning(CAPTURES / capture, frames, out / "data")
    subprocess.run([*command, "replay", "--dataset", data, "--mode", mode, *options, "--out", out / "run"], check=True)
    return {f"{mode}/{name}": hashlib.sha256((out / "run" / name).read_bytes()).hexdigest() for name in COMPARED}


def golden():
    return dict(reversed(line.split()) for line in (HERE / "golden.txt").read_text().splitlines())


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--work", type=pathlib.Path, required=True)
    parser.add_argument("--disturbed", action="store_true")
    parser.add_argument("command", nargs="+")
    arguments = parser.parse_args()
    expected = golden()
    failed = False
    for mode in RUNS:
        hashes = replay(arguments.command, mode, arguments.work)
        for name, value in hashes.items():
            same = expected.get(name) == value
            print(f"{value}  {name}{'' if same else '  differs from golden.txt: ' + expected.get(name, 'nothing there')}")
        differs = any(expected.get(name) != value for name, value in hashes.items())
        failed |= differs != arguments.disturbed
    if failed:
        sys.exit("bit_identity: " + ("the disturbance does not show in each mode" if arguments.disturbed else "not the same bits"))


if __name__ == "__main__":
    main()
