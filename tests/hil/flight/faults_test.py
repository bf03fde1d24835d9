"""Each fault that `relnav serve` can inject, into a free-running flight: the event that says so, no wrong pose called valid, and
how long until the next measured pose."""
import unittest

import rig

RATE_HZ = 20.0
FIRST = 25  # frame of the fault: the target is tracked long since
MOST_RAD = 0.02  # that a pose called valid may be off in attitude however small its sigma
AFTER = 10  # packets of the state that are looked at after the first measured one
# A pendulum's acceleration is more than the loop expects unless told.
MORE = "cooperative: {acceleration_psd: 50, angular_psd: 10}\nloop: {event_spacing_frames: 1, health_every_frames: 1}\n"


class Case:
    """What is injected, the event that is due, how long the fault itself takes (frames), and the most that a pose may be late
    after it (s)."""

    def __init__(self, fault, event, frames, within_s=4.0, jump_s=0.0):
        self.fault, self.event, self.frames, self.within_s = fault, event, frames, within_s
        self.jump_ns = round(jump_s * 1e9)


CASES = [
    Case(f"lost@{FIRST}", "frame_gap", 1),
    Case(f"lost@{FIRST}:15", "frame_gap", 15),
    Case(f"frozen@{FIRST}:5", "image_frozen", 5),
    Case(f"torn@{FIRST}:5", "image_torn", 5),
    Case(f"black@{FIRST}:5", "image_without_contrast", 5),
    Case(f"white@{FIRST}:5", "image_without_contrast", 5),
    Case(f"black@{FIRST}:20", "track_lost", 20),
    Case(f"time_jump@{FIRST}:5", "frame_gap", 0, jump_s=5.0),
    Case(f"time_jump@{FIRST}:100", "track_lost", 0, jump_s=100.0),
    Case(f"time_jump@{FIRST}:-5", "frame_refused_out_of_order", 0, jump_s=-5.0),
    Case(f"packets@{FIRST}:5:50", "frame_incomplete", 5),
    Case(f"unplug@{FIRST}:700", "camera_lost", 14),
]


def judge(state, truth):
    """What is wrong with a pose that is called valid; None: nothing. Five sigma of the packet's own covariance, or what is no
    worse than 2 % of the range and MOST_RAD."""
    if truth is None:
        return "no frame has this stamp"
    distance, angle, sigma_t, sigma_phi = rig.pose_error(state, truth)
    range_m = sum(x * x for x in truth[0]) ** 0.5
    if distance > max(5.0 * sigma_t, 0.02 * range_m) or angle > max(5.0 * sigma_phi, MOST_RAD):
        return f"off by {distance:.3f} m (sigma {sigma_t:.3f}), {angle:.4f} rad (sigma {sigma_phi:.4f})"
    return None


class Faults(unittest.TestCase):
    rows = []

    def fly(self, case, folder, capture):
        telemetry = rig.Telemetry()
        try:
            camera = rig.camera_section("aravis:127.0.0.1", capture.calibration, stamps="original")
            config = rig.write_config(folder / "flight.yaml", capture.target, camera, rig.UDP, more=MORE)
            with rig.serve(capture.path, "--loop", "--fault", case.fault) as server, rig.fly(config) as flight:
                done = telemetry.wait_for(lambda: len(self.measured_after(case, capture, telemetry.states)) > AFTER, 10.0)
                self.assertTrue(done, f"{case.fault}: {flight.output}\n{server.output}")
                self.assertEqual(flight.end(), 0, flight.output)
            return telemetry.packets
        finally:
            telemetry.close()

    @staticmethod
    def jumped(packet, case):
        """Its stamp is of after the jump."""
        return case.jump_ns != 0 and packet.frame_sequence >= FIRST

    def original_ns(self, packet, case):
        return packet.time_ns - (case.jump_ns if self.jumped(packet, case) else 0)

    def measured_after(self, case, capture, states):
        """Those with a measured pose of a frame after the fault's end."""
        end_ns = self.served_ns(capture, FIRST + case.frames)
        return [s for s in states if s.pose_valid and not s.flags & rig.PREDICTED and self.original_ns(s, case) >= end_ns]

    def check(self, case, folder, capture):
        packets = self.fly(case, folder, capture)
        states = [p for p in packets if p.kind == rig.REL_STATE]
        wrong = [f"frame {s.frame_sequence}: {problem}" for s in states if s.pose_valid
                 for problem in [judge(s, capture.pose_at(self.original_ns(s, case)))] if problem]
        self.assertEqual(wrong, [], case.fault)
        begin_ns = self.served_ns(capture, FIRST)
        end_ns = self.served_ns(capture, FIRST + case.frames)
        before = [s for s in states if self.original_ns(s, case) < begin_ns]
        self.assertTrue(before and before[-1].mode == rig.TRACK, f"{case.fault}: not tracked before it")
        begin = before[-1].at
        events = [p.event for p in packets if p.kind == rig.EVENT and p.at > begin]
        if case.event:
            self.assertIn(case.event, events, case.fault)
        measured = self.measured_after(case, capture, states)
        late_s = (self.original_ns(measured[0], case) - end_ns) / 1e9
        silent_s = measured[0].at - begin
        during = [s for s in states if begin_ns <= self.original_ns(s, case) < end_ns]
        kept = sum(s.pose_valid and not s.flags & rig.PREDICTED for s in during)
        predicted = sum(s.pose_valid and bool(s.flags & rig.PREDICTED) for s in during)
        kinds = [e for k, e in enumerate(events) if e not in events[:k] and e != "mode_changed"]
        Faults.rows.append([f"`{case.fault}`", ", ".join(kinds), f"{kept} + {predicted}", f"{late_s:.2f}", f"{silent_s:.2f}"])
        self.assertLessEqual(late_s, case.within_s, case.fault)

    @staticmethod
    def served_ns(capture, number):
        return capture.stamps[number % len(capture.stamps)] + number // len(capture.stamps) * capture.loop_ns

    def test_each_fault(self):
        folder = rig.folder_for(self)
        capture = rig.Capture(folder, rate_hz=RATE_HZ)
        for case in CASES:
            with self.subTest(fault=case.fault):
                self.check(case, folder, capture)

    @classmethod
    def tearDownClass(cls):
        rig.print_table(["fault", "events", "poses during it: measured + predicted", "measured pose after its end, s",
                         "without measured pose, s"], cls.rows)


if __name__ == "__main__":
    rig.enter_own_network()
    unittest.main(verbosity=2)
