"""A capture served by GigE Vision cameras in lock step and flown by relnav-flight gives the telemetry that its replay gives, to
the byte. The last event is the flight's own: the mode after the last frame."""
import collections
import subprocess
import unittest

import rig


def flown(folder, name, mode, addresses, frames):
    """All packets of a flight over a capture, one server for each address."""
    capture = rig.CAPTURES / name
    sections = [rig.camera_section(f"aravis:{address}", capture / f"mav0/cam{k}/sensor.yaml", trigger="software",
                                   stamps="original") for k, address in enumerate(addresses)]
    out = folder / "flown.bin"
    config = rig.write_config(folder / "flight.yaml", capture / "target.yaml", sections[0], f"file:{out}", mode=mode,
                              second=sections[1] if len(sections) > 1 else None,
                              more="loop: {acquire_wait_ns: 4000000000}\n")  # the machine may be busy
    servers = [rig.serve(capture, "--camera", str(k), address=f"{address},RN0{k}", rate="lockstep")
               for k, address in enumerate(addresses)]
    with servers[0], servers[-1], rig.fly(config, "--frames", str(frames)) as flight:
        status = flight.wait()
        if status != 0:
            raise AssertionError(f"relnav-flight ended with {status}: {flight.output}")
    return rig.split(out.read_bytes())


def replayed(folder, name, mode):
    subprocess.run([rig.RELNAV, "replay", "--dataset", rig.CAPTURES / name, "--mode", mode, "--out", folder / "replay"],
                   check=True, stdout=subprocess.DEVNULL)
    return rig.split((folder / "replay/telemetry.bin").read_bytes())


class SameTelemetry(unittest.TestCase):
    def compare(self, name, mode, addresses):
        folder = rig.folder_for(self)
        replay = replayed(folder, name, mode)
        frames = sum(p.kind == rig.REL_STATE for p in replay)
        flight = flown(folder, name, mode, addresses, frames)
        self.assertEqual(flight[-1].kind, rig.EVENT)
        self.assertEqual((flight[-1].event, flight[-1].args[1]), ("mode_changed", rig.STANDBY))
        for p, q in zip(flight[:-1], replay):
            if p.raw != q.raw:
                byte = next((i for i, (a, b) in enumerate(zip(p.raw, q.raw)) if a != b), len(p.raw))
                self.fail(f"{rig.NAMES[p.kind]} {p.count} of the flight differs from {rig.NAMES[q.kind]} {q.count} of the "
                          f"replay at byte {byte}")
        self.assertEqual(len(flight) - 1, len(replay))
        kinds = collections.Counter(rig.NAMES[p.kind] for p in flight)
        rig.print_table([f"{name}, {mode}", "packets", "equal to the replay"],
                        [[kind, n, n - (kind == "EVENT")] for kind, n in sorted(kinds.items())])

    def test_one_camera(self):
        self.compare("lights_mono", "coop-mono", ["127.0.0.1"])

    def test_two_cameras(self):
        self.compare("lights_stereo", "coop-stereo", ["127.0.0.1", "127.0.0.2"])


if __name__ == "__main__":
    rig.enter_own_network()
    unittest.main(verbosity=2)
