"""What cannot be used, walked through by machine: each is told in one clear line and ends with the documented status, and no
frame that was captured is lost. Keys are taken from what relnav-flight itself says it knows, so that a new one is tried as well."""
import pathlib
import re
import shutil
import socket
import subprocess
import unittest

import rig

CAPTURE = rig.CAPTURES / "lights_mono"
CALIBRATION = CAPTURE / "mav0/cam0/sensor.yaml"
TARGET = CAPTURE / "target.yaml"
DONE, FAULT, UNUSABLE = 0, 1, 2
SERVED = "aravis:127.0.0.1"
NOBODY = 65534


def as_nobody(*command):
    return ["setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups", *command]


class BadInput(unittest.TestCase):
    def setUp(self):
        self.folder = rig.folder_for(self)
        self.folder.chmod(0o755)  # what somebody else may not read is the file, not the way to it
        self.config = self.folder / "flight.yaml"

    def run_of(self, *command, seconds=30.0):
        """Status and lines of a program that ends by itself."""
        with rig.Process(command) as process:
            status = process.wait(seconds)
            return status, [text for _, text in process.lines]

    def refused(self, *command, parts=(), status=UNUSABLE):
        found, lines = self.run_of(*command)
        said = f"{[str(c) for c in command]}: status {found}\n" + "\n".join(lines)
        self.assertEqual(found, status, said)
        self.assertEqual(len(lines), 1, said)
        for part in parts:
            self.assertIn(str(part), lines[0], said)
        return lines[0]

    def write(self, camera, more="", telemetry=rig.UDP, **options):
        rig.write_config(self.config, TARGET, camera, telemetry, more=more, **options)

    # ---- configuration ----

    def check(self, text):
        """Status and lines of --check."""
        self.config.write_text(text)
        return self.run_of(rig.FLIGHT, self.config, "--check")

    def refused_config(self, text, line=None):
        status, lines = self.check(text)
        self.assertEqual((status, len(lines)), (UNUSABLE, 1), f"{text}\n{lines}")
        place = f"flight.yaml:{line}: " if line else "flight.yaml:"
        self.assertIn(place, lines[0], text)
        self.assertIn("(expected ", lines[0], text)
        return lines[0]

    def test_every_key_of_a_wrong_type_and_every_unknown_one(self):
        known = {"link": f'  telemetry: "{rig.UDP}"\n', "lines": "  chip: none\n",
                 "camera": f"  source: {SERVED}\n  calibration: {CALIBRATION}\n"}

        def names_in(line):
            return re.search(r"\(expected one of (.*)\)$", line)[1].split(", ")

        def with_sections(sections):
            return f"mode: coop-mono\ntarget: {TARGET}\n" + "".join(
                f"{name}:\n{body}" for name, body in {"camera": known["camera"], "link": known["link"], **sections}.items())

        self.assertEqual(self.check(with_sections({})), (DONE, []))
        text = with_sections({}) + "none: 1\n"
        roots = names_in(self.refused_config(text, line=text.count("\n")))
        self.assertIn("exposure", roots)
        scalars = {"mode", "target", "motion", "range_m", "range_sigma_m"}
        tried = 0
        for name in set(roots) - scalars - {"second_camera"}:
            body = known.get(name, "")
            text = with_sections({name: body + "  none: 1\n"})
            line = text.split("\n").index("  none: 1") + 1
            for key in names_in(self.refused_config(text, line)):
                bare = "".join(row + "\n" for row in body.splitlines() if not row.startswith(f"  {key}:"))
                for value in ("[1, 2]", "''", "1e999", "nonsense"):
                    row = f"  {key}: {value}"
                    text = with_sections({name: bare + row + "\n"})
                    tried += 1
                    status, lines = self.check(text)
                    if key == "calibration" and value not in ("[1, 2]", "''"):
                        self.assertEqual((status, len(lines)), (UNUSABLE, 1), f"{text}\n{lines}")  # names that file
                    elif value in ("[1, 2]", "''") or status != DONE:
                        self.refused_config(text, text.split("\n").index(row) + 1)
                    else:
                        self.assertEqual(lines, [], text)  # a name, or a number that may be negative
        for key in scalars:
            self.refused_config(re.sub(f"^{key}: .*\n", "", with_sections({}), flags=re.M) + f"{key}: [1]\n")
        self.assertGreater(tried, 400)

    def test_contradictions(self):
        camera = rig.camera_section(SERVED, CALIBRATION)
        cases = {
            "cooperative: {range_min_m: 10, range_max_m: 5}": "range_min_m under range_max_m",
            "exposure: {min_us: 2000}": "min_us not over start_us",
            "exposure: {max_us: 900}": "start_us not over max_us",
            "exposure: {gain_min: 20}": "gain_min not over gain_max",
            "exposure: {dark_level: 170}": "this under target_level",
            "exposure: {target_level: 230}": "under ceiling_level",
            "exposure: {dead_band: 5}": "max_step at least as large",
            "lines: {chip: none, strobe: 3, pulse: 3}": "a line for each use",
            "range_m: 5": "mode noncoop only",
            f"second_camera: {camera}": "second_camera with mode coop-stereo",
            "mode: noncoop": "a second time",
            "loop: {min_inliers: 5, min_inliers: 6}": "a second time",
            "loop: {}\nloop: {min_inliers: 6}": "a second time",
        }
        for more, expected in cases.items():
            self.write(camera, more + "\n")
            self.refused(rig.FLIGHT, self.config, "--check", parts=["flight.yaml", expected])
        for options, expected in (({"exposure_us": 1500}, "start_us"), ({"gain": 2}, "gain_min")):
            self.write(rig.camera_section(SERVED, CALIBRATION, **options), "exposure: {enabled: true}\n")
            self.refused(rig.FLIGHT, self.config, "--check", parts=["flight.yaml:3: ", expected])

    # ---- cameras that are none ----

    def not_cameras(self):
        """Device, and what is said about it."""
        file, folder = self.folder / "file", self.folder / "folder"
        file.write_text("no camera")
        folder.mkdir(exist_ok=True)
        return {"/dev/null": "not a", "/dev/zero": "not a", file: "not a", folder: "", self.folder / "nowhere": "not exist"}

    def test_devices_that_are_no_camera(self):
        for device, said in self.not_cameras().items():
            out = self.folder / "out.rnc"
            out.write_text("older")
            self.refused(rig.RELNAV, "capture", "--camera", f"v4l2:{device}", "--width", 640, "--height", 480,
                         "--out", out, "--force", parts=[device, said])
            self.assertEqual(out.read_text(), "older")  # replaced by a capture only
            # In flight a camera that is none yet is waited for, and says so once.
            section = f"{{source: 'v4l2:{device}', calibration: {CALIBRATION}}}"
            self.write(section)
            with rig.fly(self.config) as flight:
                self.assertIsNotNone(flight.wait_for_line(f"waits for a camera: {device}"), flight.output)
                self.assertIn(said, flight.output)
                self.assertEqual(flight.end(), DONE)
                waits = [text for _, text in flight.lines if "waits for" in text]
                self.assertEqual(len(waits), 1, flight.output)

    def test_without_permission(self):
        if subprocess.run(as_nobody("true"), stderr=subprocess.DEVNULL, check=False).returncode != 0:
            self.skipTest("nobody else can be here")
        secret = self.folder / "secret"
        secret.write_text("")
        secret.chmod(0)
        programs = self.folder / "bin"  # where somebody else may go
        programs.mkdir()
        for program in (rig.RELNAV, rig.FLIGHT):
            shutil.copy(program, programs)
        relnav, flight_program = programs / "relnav", programs / "relnav-flight"
        size = ("--width", 640, "--height", 480)
        self.refused(*as_nobody(relnav, "capture", "--camera", f"v4l2:{secret}", *size, "--out", "/tmp/nobody.rnc"),
                     parts=[secret, "ermission"])
        own = self.folder / "own"
        own.mkdir(mode=0o755)
        for name in ("cam.yaml", "target.yaml"):
            shutil.copy(CALIBRATION if name == "cam.yaml" else TARGET, own)
            (own / (CALIBRATION.name if name == "cam.yaml" else TARGET.name)).rename(own / name)
            (own / name).chmod(0o644)
        self.config = own / "flight.yaml"
        text = (f"mode: coop-mono\ntarget: target.yaml\ncamera: {{source: 'v4l2:{secret}', calibration: cam.yaml}}\n"
                f'link: {{telemetry: "{rig.UDP}"}}\n')
        self.config.write_text(text)
        self.config.chmod(0o644)
        with rig.Process(as_nobody(flight_program, self.config)) as flight:
            self.assertIsNotNone(flight.wait_for_line(f"waits for a camera: {secret}"), flight.output)
            self.assertIn("ermission", flight.output)
            self.assertEqual(flight.end(), DONE)
        self.config.write_text(text.replace(rig.UDP, f"file:{own}/out.bin"))
        self.refused(*as_nobody(flight_program, self.config), parts=[own / "out.bin"])
        for name in ("flight.yaml", "cam.yaml", "target.yaml"):
            self.config.write_text(text)
            (own / name).chmod(0)
            self.refused(*as_nobody(flight_program, self.config, "--check"), parts=[name])
            (own / name).chmod(0o644)

    # ---- places that are taken ----

    def test_ports_in_use(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
            taken.bind(("127.0.0.1", rig.TELECOMMAND_PORT))
            address = f"udp://127.0.0.1:{rig.TELECOMMAND_PORT}"
            self.write(rig.camera_section(SERVED, CALIBRATION), telecommands=address)
            self.refused(rig.FLIGHT, self.config, parts=[rig.TELECOMMAND_PORT, "in use"])
            self.refused(rig.RELNAV, "tlm", "decode", address, parts=[rig.TELECOMMAND_PORT, "in use"])
        self.write(rig.camera_section(SERVED, CALIBRATION), telecommands="udp://192.0.2.1:5000")
        self.refused(rig.FLIGHT, self.config, parts=["192.0.2.1"])
        with rig.serve(CAPTURE, "--loop") as server:
            self.assertIsNotNone(server.wait_for_line("127.0.0.1"), server.output)
            self.refused(rig.RELNAV, "serve", "--gige", "127.0.0.1", "--dataset", CAPTURE, parts=["127.0.0.1"])

    # ---- a full disk ----

    def small_disk(self, name, size):
        """A disk of `size`, gone with the namespace at the latest."""
        disk = self.folder / name
        disk.mkdir()
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", disk], check=False)
        if mounted.returncode != 0:
            self.skipTest("no file system can be mounted here")
        self.addCleanup(subprocess.run, ["umount", "--lazy", disk], check=False)
        return disk

    def test_a_disk_that_fills_up_keeps_what_was_captured(self):
        disk = self.small_disk("disk", "2m")
        out = disk / "frames.rnc"
        frame_bytes = 640 * 480 + 72
        with rig.serve(CAPTURE, "--loop"):
            status, lines = self.run_of(rig.RELNAV, "capture", "--camera", SERVED, "--calibration", CALIBRATION, "--format",
                                        "grey8", "--frames", 100, "--out", out, seconds=60.0)
        said = "\n".join(lines)
        self.assertEqual(status, FAULT, said)
        self.assertEqual(len([text for text in lines if "No space left" in text]), 1, said)
        size = out.stat().st_size
        whole = (2 * 1024 * 1024 - 32) // frame_bytes
        self.assertGreaterEqual(size, 32 + whole * frame_bytes)
        shutil.copy(out, self.folder / "frames.rnc")
        status, lines = self.run_of(rig.RELNAV, "export", self.folder / "frames.rnc", "--out", self.folder / "seq")
        said += "\n" + "\n".join(lines)
        self.assertEqual(status, DONE, said)
        images = sorted((self.folder / "seq/mav0/cam0/data").iterdir())
        self.assertEqual(len(images), whole, said)
        # Every frame in the order of the capture, none but those after the disk was full is missing.
        rows = (self.folder / "seq/mav0/cam0/frames.csv").read_text().splitlines()[1:]
        sequence = [int(row.split(",")[1]) for row in rows]
        self.assertEqual(sequence, list(range(sequence[0], sequence[0] + whole)), said)
        self.assertTrue(any(f"{whole} " in text for text in lines), said)

    def test_a_full_disk_does_not_end_the_flight(self):
        disk = self.small_disk("telemetry", "16k")
        out = disk / "out.bin"
        section = rig.camera_section(SERVED, CALIBRATION, trigger="software", stamps="original")
        self.write(section, telemetry=f"file:{out}", more="loop: {features_every_frames: 1, health_every_frames: 1}\n")
        with rig.serve(CAPTURE, "--loop", rate="lockstep"), rig.fly(self.config, "--frames", "80") as flight:
            self.assertEqual(flight.wait(), DONE, flight.output)
        stream = out.read_bytes()
        self.assertGreater(len(stream), 10_000)
        packets = rig.split(stream)
        self.assertEqual(sum(len(p.raw) for p in packets), len(stream))
        self.assertTrue(all(len(p.raw) == p.length + 7 for p in packets[:-1]))

    def test_places_that_cannot_be_written(self):
        for out in (self.folder, pathlib.Path("/dev/full"), self.folder / "nowhere/out.bin", pathlib.Path("/proc/out.bin")):
            self.write(rig.camera_section(SERVED, CALIBRATION), telemetry=f"file:{out}")
            if out != pathlib.Path("/dev/full"):  # opens, and then is as a disk that is full
                self.refused(rig.FLIGHT, self.config, parts=[out])
            with rig.serve(CAPTURE, "--loop"):
                status, lines = self.run_of(rig.RELNAV, "capture", "--camera", SERVED, "--calibration", CALIBRATION,
                                            "--format", "grey8", "--frames", 3, "--force", "--out", out)
            self.assertNotEqual(status, DONE, f"{out}\n{lines}")
            self.assertTrue(any(str(out) in text for text in lines), f"{out}\n{lines}")


if __name__ == "__main__":
    rig.enter_own_network()
    unittest.main(verbosity=2)
