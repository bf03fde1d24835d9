"""What goes over the wire, read by others: tshark's CCSDS dissector, Python's CRC."""
import binascii
import collections
import subprocess
import time
import unittest

import rig

FRAMES = 60


def capture_wire(path):
    """tshark, once it listens."""
    tshark = rig.Process(["tshark", "-i", "lo", "-f", f"udp dst port {rig.TELEMETRY_PORT}", "-w", path, "-q"])
    tshark.wait_for_line("Capturing on", 30.0)
    time.sleep(1.5)  # it says so a little before it does
    return tshark


def dissect(path):
    """For each packet: version, type, APID, sequence flags and count, length field, and the bytes."""
    fields = ["ccsds.version", "ccsds.type", "ccsds.secheader", "ccsds.apid", "ccsds.seqflag", "ccsds.seqnum", "ccsds.length",
              "udp.payload"]
    command = ["tshark", "-r", path, "-d", f"udp.port=={rig.TELEMETRY_PORT},ccsds", "-T", "fields", "-E", "separator=;"]
    for field in fields:
        command += ["-e", field]
    lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
    return [(*(int(x, 0) for x in cells[:7]), bytes.fromhex(cells[7])) for cells in (line.split(";") for line in lines)]


class Wire(unittest.TestCase):
    def test_others_read_every_packet(self):
        folder = rig.folder_for(self)
        capture = rig.CAPTURES / "lights_mono"
        telemetry = rig.Telemetry()
        self.addCleanup(telemetry.close)
        camera = rig.camera_section("aravis:127.0.0.1", capture / "mav0/cam0/sensor.yaml", trigger="software",
                                    stamps="original")
        config = rig.write_config(folder / "flight.yaml", capture / "target.yaml", camera, rig.UDP,
                                  telecommands=f"udp://127.0.0.1:{rig.TELECOMMAND_PORT}",
                                  more="loop: {features_every_frames: 1, health_every_frames: 1}\n")
        wire = folder / "wire.pcapng"
        with capture_wire(wire) as tshark, rig.serve(capture, "--loop", rate="lockstep"), \
                rig.fly(config, "--frames", str(FRAMES)) as flight:
            ground = rig.socket.socket(rig.socket.AF_INET, rig.socket.SOCK_DGRAM)
            with ground:
                self.assertTrue(telemetry.wait_for(lambda: telemetry.states, 20.0), flight.output)
                ground.sendto(rig.telecommand(17, 1), ("127.0.0.1", rig.TELECOMMAND_PORT))
            self.assertEqual(flight.wait(), 0, flight.output)
            time.sleep(1.0)
            tshark.end()
        packets = dissect(wire)
        kinds = collections.defaultdict(list)
        for version, kind, secondary, apid, flags, count, length, raw in packets:
            self.assertEqual((version, kind, secondary, flags), (0, 0, 1, 3))
            self.assertEqual(length, len(raw) - 7)
            self.assertEqual(apid, int.from_bytes(raw[:2], "big") & 0x7FF)
            self.assertEqual(binascii.crc_hqx(raw, 0xFFFF), 0)
            kinds[apid - rig.APID_BASE].append(count)
        for kind, counts in kinds.items():
            self.assertEqual(counts, list(range(len(counts))), rig.NAMES[kind])
        # What was seen is what was sent, and of each kind something was.
        self.assertEqual([p[-1] for p in packets], [p.raw for p in telemetry.packets])
        self.assertEqual(len(kinds[rig.REL_STATE]), FRAMES)
        self.assertEqual(set(kinds), {rig.REL_STATE, rig.FEATURES, rig.HEALTH, rig.EVENT, rig.TC_ACK, rig.PONG})
        rig.print_table(["on the wire", "packets", "gaps", "CRC wrong"],
                        [[rig.NAMES[kind], len(counts), 0, 0] for kind, counts in sorted(kinds.items())])


if __name__ == "__main__":
    rig.enter_own_network()
    unittest.main(verbosity=2)
