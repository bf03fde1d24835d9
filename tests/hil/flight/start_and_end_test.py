"""How relnav-flight begins and ends: with and without a camera, told by signals and by telecommand, and what it refuses to fly
with."""
import socket
import time
import unittest

import rig

ONE_CAMERA = rig.camera_section("aravis:127.0.0.1", rig.CAPTURES / "lights_mono/mav0/cam0/sensor.yaml", trigger="software",
                                stamps="original")
TARGET = rig.CAPTURES / "lights_mono/target.yaml"
CAPTURE = rig.CAPTURES / "lights_mono"


class StartAndEnd(unittest.TestCase):
    def setUp(self):
        self.folder = rig.folder_for(self)
        self.config = self.folder / "flight.yaml"

    def test_waits_for_its_camera_then_flies_and_ends_when_told(self):
        telemetry, manager = rig.Telemetry(), rig.Manager(self.folder)
        self.addCleanup(telemetry.close)
        self.addCleanup(manager.close)
        rig.write_config(self.config, TARGET, ONE_CAMERA, rig.UDP)
        with rig.fly(self.config, manager=manager, watchdog_s=2.0) as flight:
            waits = "waits for a camera: camera 127.0.0.1: nothing answers there"
            self.assertIsNotNone(flight.wait_for_line(waits), flight.output)
            self.assertTrue(manager.wait_for(lambda: manager.has("STATUS=" + waits), 5.0), manager.messages)
            self.assertTrue(manager.has("READY=1"), manager.messages)  # all is set up; a missing camera is no reason to fail
            time.sleep(1.5)
            self.assertGreaterEqual(len(manager.times_of("WATCHDOG=1")), 3)  # kept fed while it waits
            self.assertEqual(telemetry.states, [])
            with rig.serve(CAPTURE, "--loop", rate="lockstep") as server:
                self.assertTrue(telemetry.wait_for(lambda: telemetry.first_valid(), 20.0), flight.output)
                self.assertTrue(manager.wait_for(lambda: manager.has("STATUS=TRACK"), 10.0), manager.messages)
                told = time.monotonic()
                self.assertEqual(flight.end(), 0, flight.output)
                self.assertLess(time.monotonic() - told, 5.0)
                self.assertEqual(server.end(), 0)
            self.assertTrue(manager.wait_for(lambda: manager.has("STOPPING=1"), 5.0), manager.messages)
            stopped = telemetry.wait_for(
                lambda: [e for e in telemetry.events if e.event == "mode_changed" and e.args[1] == rig.STANDBY], 5.0)
            self.assertTrue(stopped, "the last event did not come out")
            self.assertIs(telemetry.packets[-1], stopped[-1])

    def test_ends_with_its_frames(self):
        out = self.folder / "out.bin"
        rig.write_config(self.config, TARGET, ONE_CAMERA, f"file:{out}")
        with rig.serve(CAPTURE, rate="lockstep"), rig.fly(self.config, "--frames", "7") as flight:
            self.assertEqual(flight.wait(), 0, flight.output)
        self.assertEqual(sum(p.kind == rig.REL_STATE for p in rig.split(out.read_bytes())), 7)

    def test_telecommands_while_it_waits(self):
        telemetry = rig.Telemetry()
        self.addCleanup(telemetry.close)
        rig.write_config(self.config, TARGET, ONE_CAMERA, rig.UDP,
                         telecommands=f"udp://127.0.0.1:{rig.TELECOMMAND_PORT}")
        with rig.fly(self.config) as flight, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ground:
            self.assertIsNotNone(flight.wait_for_line("waits for a camera"), flight.output)
            there = ("127.0.0.1", rig.TELECOMMAND_PORT)
            ping = rig.telecommand(17, 1, sequence=41)
            ground.sendto(ping, there)
            self.assertTrue(telemetry.wait_for(lambda: [p for p in telemetry.packets if p.kind == rig.PONG], 5.0))
            ground.sendto(ping[:-1] + bytes([ping[-1] ^ 1]), there)  # damaged
            ground.sendto(rig.telecommand(8, 1, b"\x63", sequence=42), there)  # no such function
            self.assertTrue(telemetry.wait_for(lambda: len([p for p in telemetry.packets if p.kind == rig.TC_ACK]) == 4, 5.0))
            acks = [(p.request_sequence & 0x3FFF, p.stage, p.code) for p in telemetry.of(rig.TC_ACK)]
            crc_mismatch, unsupported = 18, 19
            self.assertEqual(acks, [(41, 1, 0), (41, 7, 0), (41, 2, crc_mismatch), (42, 2, unsupported)])
            self.assertEqual(len(telemetry.of(rig.PONG)), 1)
            self.assertEqual(flight.end(), 0)

    def refused(self, *parts, arguments=None):
        """It ends with status 2 and one line that has all `parts`."""
        with rig.Process([rig.FLIGHT, *([self.config] if arguments is None else arguments)]) as flight:
            self.assertEqual(flight.wait(20.0), 2, flight.output)
            self.assertEqual(len(flight.lines), 1, flight.output)
            for part in parts:
                self.assertIn(part, flight.output)

    def test_refuses_with_one_line(self):
        def config(telemetry=rig.UDP, **options):
            rig.write_config(self.config, TARGET, ONE_CAMERA, telemetry, **options)

        self.refused("nowhere.yaml", arguments=[self.folder / "nowhere.yaml"])
        self.config.write_text("mode: [coop-mono\n")
        self.refused("flight.yaml")
        config(more="moder: coop-mono\n")
        self.refused("flight.yaml", "moder", "expected")
        config(more="lines: {chip: no-such-chip}\n")
        self.refused("no-such-chip")
        config(f"file:{self.folder}/nowhere/out.bin")
        self.refused("nowhere/out.bin")
        config("file:" + str(self.folder))
        self.refused(str(self.folder))
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
            taken.bind(("127.0.0.1", rig.TELECOMMAND_PORT))
            config(telecommands=f"udp://127.0.0.1:{rig.TELECOMMAND_PORT}")
            self.refused(str(rig.TELECOMMAND_PORT), "in use")
        config()
        for frames in (["nonsense"], ["-3"], ["7", "--frames", "nonsense"]):
            self.refused("--frames", arguments=[self.config, "--frames", *frames])
        self.refused("CONFIG", arguments=[])
        self.refused("--fast", arguments=[self.config, "--fast"])

    def test_the_second_camera_that_is_missing_is_named(self):
        stereo = rig.CAPTURES / "lights_stereo"
        one, two = (rig.camera_section(f"aravis:127.0.0.{k + 1}", stereo / f"mav0/cam{k}/sensor.yaml", trigger="software")
                    for k in (0, 1))
        rig.write_config(self.config, stereo / "target.yaml", one, rig.UDP, second=two, mode="coop-stereo")
        with rig.fly(self.config) as flight:
            self.assertIsNotNone(flight.wait_for_line("camera 127.0.0.1: nothing answers"), flight.output)
            with rig.serve(stereo, rate="lockstep"):
                self.assertIsNotNone(flight.wait_for_line("camera 127.0.0.2: nothing answers"), flight.output)
            self.assertEqual(flight.end(), 0)

    def test_a_manager_that_is_not_there_is_said(self):
        rig.write_config(self.config, TARGET, ONE_CAMERA, rig.UDP)
        for name in ("relative/path", "/" + 200 * "x"):
            with rig.Process([rig.FLIGHT, self.config], {"NOTIFY_SOCKET": name}) as flight:
                self.assertEqual(flight.wait(20.0), 2, flight.output)
                self.assertIn("NOTIFY_SOCKET", flight.output)
                self.assertEqual(len(flight.lines), 1, flight.output)


if __name__ == "__main__":
    rig.enter_own_network()
    unittest.main(verbosity=2)
