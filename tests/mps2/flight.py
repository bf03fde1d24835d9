#!/usr/bin/env python3
"""The flight loop on an emulated Cortex-M7 against the host's: the same capture, byte for byte the same packets and poses.

    flight.py CASE --relnav TOOL --work DIR --emulator PROGRAM MACHINE IMAGE

CASE is one of CASES: a mode, or what goes wrong with its input."""
import argparse
import csv
import hashlib
import json
import os
import pathlib
import shutil
import statistics
import struct
import subprocess
import sys
import zlib

TESTS = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(TESTS / "target"), str(TESTS / "arch")]
import bit_identity  # noqa: E402  the same runs as on every other target
import work  # noqa: E402  and the same limits of their work
import worst_case  # noqa: E402

FRAME_HEADER = struct.Struct("<4sIqqqqdIIBBHIII")


def require(condition, what):
    if not condition:
        sys.exit(f"FAILED: {what}")


class Bench:
    """A capture replayed on the host and packed for the target."""

    def __init__(self, arguments, mode, frames=None, constructed=False):
        self.relnav, self.emulator, self.image = arguments.relnav, arguments.emulator[:2], arguments.emulator[2]
        self.work = arguments.work
        shutil.rmtree(self.work, ignore_errors=True)
        self.work.mkdir(parents=True)
        capture, most, options = bit_identity.RUNS[mode]
        if constructed:
            data, options = self.work / "data", worst_case.write(self.work / "data", mode)
        else:
            data = bit_identity.beginning(bit_identity.CAPTURES / capture, frames or most, self.work / "data")
        common = ["--dataset", data, "--mode", mode, *options]
        self.host = self.work / "host"
        self.packed = self.work / "in"
        self.out = self.work / "out"
        self.out.mkdir()
        self.host_status = self.command(self.relnav, "replay", *common, "--out", self.host).returncode
        packing = self.command(self.relnav, "pack", *common, "--out", self.packed)
        require(packing.returncode == 0, f"relnav pack: {packing.stderr}")

    @staticmethod
    def command(*words, **options):
        return subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False, **options)

    def fly(self, options="", machine=None):
        """Exit status and console of the image."""
        program = [self.emulator[0], machine or self.emulator[1]]
        result = self.command(*program, self.image, self.packed, self.out,
                              env={**os.environ, "RELNAV_QEMU_OPTIONS": options}, timeout=900)
        console = result.stdout + result.stderr
        print(console, end="")
        return result.returncode, console

    def events(self):
        """Names of the events sent, and their arguments."""
        decoded = self.command(self.relnav, "tlm", "decode", self.out / "telemetry.bin", "--json")
        require(decoded.returncode == 0, f"the target's telemetry does not decode: {decoded.stderr}")
        packets = [json.loads(line) for line in decoded.stdout.splitlines()]
        return [packet for packet in packets if packet.get("packet", packet.get("name", "")).lower() == "event"]

    def require_event(self, name):
        events = self.events()
        require(any(name in json.dumps(event) for event in events), f"no event {name}, but {events}")


def compare(arguments, mode, constructed=False):
    """Exit status, packets and poses as on the host; of a run that other targets make as well, also their hashes. And the work of
    each step."""
    bench = Bench(arguments, mode, constructed=constructed)
    golden = {} if constructed else bit_identity.golden()
    status, console = bench.fly("-icount shift=0")
    require(status == bench.host_status, f"exit status {status}, on the host {bench.host_status}")
    for name in ("telemetry.bin", "trajectory.tum"):
        here, there = (bench.out / name).read_bytes(), (bench.host / name).read_bytes()
        require(constructed or len(there) > 1000, f"the host's {name} is all but empty")
        require(here == there, f"{name}: {len(here)} bytes differ from the host's {len(there)}")
        key = f"{mode}/{name}"
        require(constructed or hashlib.sha256(here).hexdigest() == golden[key], f"{key}: not as on other targets")
    figures = dict(line.split() for line in console.splitlines() if len(line.split()) == 2)
    own = [(int(row["work"]), int(row["transfer"])) for row in csv.DictReader((bench.out / "effort.csv").open())]
    steps = [(step + transfer, transfer) for step, transfer in own]
    print(work.HEADER + work.row(f"{arguments.case}, {figures['stack_used']} bytes of stack", steps))
    problems = work.problems_with(arguments.case, steps, work.limits(2)[mode] if constructed else None)
    require(not problems, "; ".join(problems))
    require(int(figures["watchdog_kicks"]) >= int(figures["steps"]), "a step without its kick")
    require(int(figures["stack_used"]) < 48 * 1024, "the stack's reserve is gone")


def one_ulp(arguments):
    """The image is wrong by one unit in the last place, once: it must show."""
    bench = Bench(arguments, "coop-mono")
    bench.fly()
    for name in ("telemetry.bin", "trajectory.tum"):
        require((bench.out / name).read_bytes() != (bench.host / name).read_bytes(), f"{name} does not show it")


# ---- what goes wrong ----

def change_frame(path, number, change):
    """Applies `change` to header fields and pixels of a frame; the header's checksum is made good."""
    data = bytearray(path.read_bytes())
    index_offset = struct.unpack_from("<Q", data, 8)[0]
    offset = struct.unpack_from("<Q", data, index_offset + 8 * number)[0]
    fields = list(FRAME_HEADER.unpack_from(data, offset))
    begin = offset + FRAME_HEADER.size
    pixels = bytes(data[begin:begin + fields[12]])
    changed = change(fields, pixels)
    fields[14] = zlib.crc32(FRAME_HEADER.pack(*fields)[:-4])
    FRAME_HEADER.pack_into(data, offset, *fields)
    data[begin:begin + len(changed)] = changed
    path.write_bytes(data)


def wrong_size(arguments):
    """Half as high: refused with an event, the frames around it are used."""
    bench = Bench(arguments, "coop-mono")

    def halve(fields, pixels):
        fields[8] //= 2
        fields[12] //= 2
        fields[13] = zlib.crc32(pixels[:fields[12]])
        return pixels
    change_frame(bench.packed / "frames0.rnc", 5, halve)
    status, _ = bench.fly()
    require(status == 0, f"exit status {status}")
    bench.require_event("frame_refused_size")


def torn_frame(arguments):
    """One flipped bit among the pixels, then a header that is none."""
    bench = Bench(arguments, "coop-mono")
    path = bench.packed / "frames0.rnc"
    change_frame(path, 5, lambda fields, pixels: pixels[:1000] + bytes([pixels[1000] ^ 1]) + pixels[1001:])

    def no_magic(fields, pixels):
        fields[0] = b"????"
        return pixels
    change_frame(path, 8, no_magic)
    status, _ = bench.fly()
    require(status == 0, f"exit status {status}")
    bench.require_event("frame_incomplete")


def without(name, event):
    def case(arguments):
        bench = Bench(arguments, "coop-stereo", 4)
        (bench.packed / name).unlink()
        status, console = bench.fly()
        require(status == 2, f"exit status {status}")
        require("relnav-mps2: " in console, "not a word on the console")
        bench.require_event(event)
        require((bench.out / "trajectory.tum").read_text().count("\n") == 1, "poses out of nothing")
    case.__doc__ = f"{name} is not there: {event}, and no flight."
    return case


def cut_container(arguments):
    """A container whose end is missing is none."""
    bench = Bench(arguments, "coop-mono", 4)
    path = bench.packed / "frames0.rnc"
    path.write_bytes(path.read_bytes()[:-40])
    status, _ = bench.fly()
    require(status == 1, f"exit status {status}")
    bench.require_event("frame_incomplete")


def damaged_setup(arguments):
    """One flipped bit in the configuration."""
    bench = Bench(arguments, "coop-mono", 4)
    path = bench.packed / "setup.bin"
    data = bytearray(path.read_bytes())
    data[100] ^= 1
    path.write_bytes(data)
    status, console = bench.fly()
    require(status == 2 and "crc_mismatch" in console, f"exit status {status}")
    bench.require_event("configuration_refused")


def no_output(arguments):
    """Nowhere to write to."""
    bench = Bench(arguments, "coop-mono", 4)
    bench.out = bench.work / "absent"
    status, console = bench.fly()
    require(status == 2 and "absent" in console, f"exit status {status}")


def no_fpu(arguments):
    """A processor without FPU (AN385), and one with single precision only (AN386): the safe state before the first use."""
    bench = Bench(arguments, "coop-mono", 4)
    for machine in ("mps2-an385", "mps2-an386"):
        status, console = bench.fly(machine=machine)
        require(status == 101 and "FPU" in console, f"{machine}: exit status {status}")


CASES = {
    **{mode: (lambda arguments, mode=mode: compare(arguments, mode)) for mode in bit_identity.RUNS},
    **{f"worst_{mode}": (lambda arguments, mode=mode: compare(arguments, mode, constructed=True)) for mode in bit_identity.RUNS},
    "one_ulp": one_ulp,
    "wrong_size": wrong_size,
    "torn_frame": torn_frame,
    "missing_setup": without("setup.bin", "configuration_refused"),
    "missing_frames": without("frames1.rnc", "camera_lost"),
    "cut_container": cut_container,
    "damaged_setup": damaged_setup,
    "no_output": no_output,
    "no_fpu": no_fpu,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("case", choices=[*CASES])
    parser.add_argument("--relnav", required=True, type=pathlib.Path)
    parser.add_argument("--work", required=True, type=pathlib.Path)
    parser.add_argument("--emulator", required=True, nargs=3)
    arguments = parser.parse_args()
    require(arguments.relnav.is_file(), f"{arguments.relnav} is not there: build the preset host first")
    CASES[arguments.case](arguments)


if __name__ == "__main__":
    main()
