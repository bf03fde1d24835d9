"""Latency from the arrival of a frame to its first packet, by HEALTH: 640 x 480 pixels, free running, stamps of the machine's
clock. Printed is what the issue wants to be shown (99.9 % at most 3 times the median); asserted only what a busy machine keeps
as well. A virtual machine stands still now and then: as root, a thread on each core that nothing in the machine can hold up
(stalls.py) tells when, and the frames of such moments are left out of a second set of columns.
--frames N [2000], --rate HZ [150]."""
import argparse
import os
import statistics
import sys
import unittest

import rig
import stalls

FRAMES = 2000
RATE_HZ = 150.0
MOST_MEDIAN_US = 50_000
HEAD = ["flight", "frames", "median us", "99 % us", "99.9 % us", "largest us", "99.9 % / median", "clear of stalls",
        "99.9 % of these us", "/ median"]


def percentile(values, share):
    return sorted(values)[int(share * len(values))]


class Latency(unittest.TestCase):
    rows = []

    def measure(self, name, more="", camera_first=False):
        folder = rig.folder_for(self)
        capture = rig.Capture(folder, rate_hz=RATE_HZ)
        telemetry = rig.Telemetry()
        self.addCleanup(telemetry.close)
        camera = rig.camera_section("aravis:127.0.0.1", capture.calibration)
        config = rig.write_config(folder / "flight.yaml", capture.target, camera, rig.UDP,
                                  more="cooperative: {acceleration_psd: 1000, angular_psd: 100}\n"
                                       "loop: {health_every_frames: 1}\n" + more)
        # A real camera does not wait for this machine's processor; the one played here does, unless it goes first.
        before = ["chrt", "--fifo", "60"] if camera_first else []
        with (rig.serve(capture.path, "--loop", before=before), stalls.Witnesses() as witnesses,
              rig.fly(config, "--frames", str(FRAMES)) as flight):
            self.assertEqual(flight.wait(10.0 + 3.0 * FRAMES / RATE_HZ), 0, flight.output)
        # Without a new frame HEALTH tells of the former one again.
        health = {h.frame_sequence: h for h in reversed(telemetry.of(rig.HEALTH)) if h.arrival_latency_us > 0}
        self.assertGreater(len(health), 0.95 * FRAMES)
        latencies = [h.arrival_latency_us for h in health.values()]
        self.assertLessEqual(max(latencies), max(h.arrival_latency_max_us for h in health.values()))
        median, high = statistics.median(latencies), percentile(latencies, 0.999)
        row = [name, len(latencies), f"{median:.0f}", percentile(latencies, 0.99), high, max(latencies), f"{high / median:.1f}"]
        if witnesses.running:
            # The stamp is of the machine's clock, and so is what the witnesses saw.
            stamps = {s.frame_sequence: s.time_ns for s in telemetry.states}
            clear = [h.arrival_latency_us for sequence, h in health.items() if sequence in stamps and
                     not witnesses.any_between(stamps[sequence], stamps[sequence] + 1000 * h.latency_us)]
            high = percentile(clear, 0.999)
            row += [len(clear), high, f"{high / statistics.median(clear):.1f}"]
        Latency.rows.append(row)
        self.assertLess(median, MOST_MEDIAN_US)
        for state in telemetry.states[-10:]:
            self.assertTrue(state.pose_valid)
        return flight.output

    def test_as_a_usual_process(self):
        self.measure("usual")

    @unittest.skipIf(os.geteuid() != 0, "needs root")
    def test_with_real_time_priority(self):
        output = self.measure("SCHED_FIFO 50, camera 60", "realtime: {priority: 50}\n", camera_first=True)
        if "priority" in output:
            print(output)

    @classmethod
    def tearDownClass(cls):
        rig.print_table(HEAD, cls.rows)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=FRAMES)
    parser.add_argument("--rate", type=float, default=RATE_HZ)
    rig.enter_own_network()
    arguments, rest = parser.parse_known_args()
    FRAMES, RATE_HZ = arguments.frames, arguments.rate
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
