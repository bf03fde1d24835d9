"""What the flight tests share: relnav-flight and `relnav serve` as processes in a network of their own, what they send, and the
truth of the captures. Times are of CLOCK_MONOTONIC in seconds unless they say otherwise. RELNAV_BIN names the folder with the
programs."""
import binascii
import bisect
import contextlib
import math
import os
import pathlib
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
CAPTURES = ROOT / "hil/captures"
BIN = pathlib.Path(os.environ.get("RELNAV_BIN", ROOT / "build/host/bin"))
RELNAV = str(BIN / "relnav")
FLIGHT = str(BIN / "relnav-flight")
TELEMETRY_PORT = 10015
TELECOMMAND_PORT = 10016


# ---- a network of its own ----

def enter_own_network():
    """The script again, in namespaces of its own: the ports are free, and all its processes end with it, however it ends."""
    if os.environ.pop("RELNAV_OWN_NETWORK", None) is None:
        unshare = ["unshare", "--net", "--pid", "--fork", "--kill-child", "--mount-proc"]
        if os.geteuid() != 0:
            unshare.insert(1, "--map-root-user")
        os.environ["RELNAV_OWN_NETWORK"] = "yes"
        os.execvp(unshare[0], [*unshare, sys.executable, *sys.argv])
    subprocess.run(["ip", "link", "set", "lo", "up"], check=True)
    subprocess.run(["ip", "address", "add", "127.0.0.2/8", "dev", "lo"], check=True)  # for a second camera


# ---- packets (docs/telemetry-icd.md) ----

APID_BASE = 0x100
REL_STATE, FEATURES, HEALTH, EVENT, TIME, TC_ACK, PONG = range(7)
NAMES = ["REL_STATE", "FEATURES", "HEALTH", "EVENT", "TIME", "TC_ACK", "PONG"]
EVENTS = {number: name for number, name in enumerate(
    """mode_changed configuration_accepted configuration_refused frame_refused_out_of_order frame_refused_size
    frame_refused_format frame_refused_age frame_incomplete frame_gap camera_lost camera_recovered image_without_contrast
    image_frozen too_few_features feature_capacity update_refused covariance_repaired filter_reset chart_switched
    track_acquired track_lost telemetry_dropped numerical_fault pose_ambiguous spots_dropped pair_incomplete
    safe_state_entered time_synchronised time_lost time_jumped command_refused line_failed image_torn""".split(), 1)}
STANDBY, ACQUIRE, TRACK, LOST = range(4)
POSE_VALID, COVARIANCE_VALID, PREDICTED = 0x01, 0x02, 0x40
HEALTH_FIELDS = ("time_ns frame_sequence mode flags last_status frames_processed frames_refused frames_incomplete frames_lost "
                 "camera_losses features matched inliers refused_updates covariance_repairs reset_counter test_ratio "
                 "telemetry_dropped event_count events_suppressed latency_us latency_max_us arrival_latency_us "
                 "arrival_latency_max_us").split()


class Packet:
    """One telemetry packet; `at` is when it was received, 0 from a file. Fields of its body are attributes."""

    def __init__(self, raw, at=0.0):
        self.raw = raw
        self.at = at
        first, second, self.length = struct.unpack(">HHH", raw[:6])
        self.apid = first & 0x7FF
        self.kind = self.apid - APID_BASE
        self.count = second & 0x3FFF
        if self.kind == REL_STATE:
            (self.time_ns, self.frame_sequence, self.camera, self.mode, self.flags, self.quality,
             self.reset_counter) = struct.unpack(">QIBBBBH", raw[21:39])
            self.t_CT = struct.unpack(">3d", raw[42:66])
            self.q_CT = struct.unpack(">4d", raw[66:98])
            self.covariance = struct.unpack(">21f", raw[146:230])
        elif self.kind == HEALTH:
            values = struct.unpack(">QIBBBIIIIHHHHIIHfIIIIIII", raw[21:102])
            self.__dict__.update(zip(HEALTH_FIELDS, values))
        elif self.kind == EVENT:
            (event, self.occurrence, self.suppressed, self.status, self.time_ns,
             self.frame_sequence) = struct.unpack(">HIIBQI", raw[19:42])
            self.args = struct.unpack(">4q", raw[42:74])
            self.event = EVENTS[event]
        elif self.kind == TC_ACK:
            (self.request_id, self.request_sequence, self.stage, self.code, self.service,
             self.subtype) = struct.unpack(">HHBBBB", raw[19:27])

    @property
    def pose_valid(self):
        return self.kind == REL_STATE and bool(self.flags & POSE_VALID)


def split(stream):
    """The packets of a file of packets."""
    packets = []
    while stream:
        length = 7 + int.from_bytes(stream[4:6], "big")
        packets.append(Packet(stream[:length]))
        stream = stream[length:]
    return packets


def telecommand(service, subtype, data=b"", sequence=0):
    """A telecommand for the loop, whole."""
    body = struct.pack(">BBBH", 0x20, service, subtype, 0) + data
    packet = struct.pack(">HHH", 0x1800 | APID_BASE, 0xC000 | sequence, len(body) + 1) + body
    return packet + binascii.crc_hqx(packet, 0xFFFF).to_bytes(2, "big")


class Datagrams:
    """Whatever arrives at a socket, with the time of arrival."""

    def __init__(self, sock):
        self.socket = sock
        with contextlib.suppress(OSError):
            sock.setsockopt(socket.SOL_SOCKET, 33, 1 << 24)  # SO_RCVBUFFORCE
        self.changed = threading.Condition()
        self.closed = False
        self.thread = threading.Thread(target=self.receive, daemon=True)
        self.thread.start()

    def receive(self):
        self.socket.settimeout(0.2)
        while not self.closed:
            try:
                data = self.socket.recv(65536)
            except TimeoutError:
                continue
            with self.changed:
                self.keep(data, time.monotonic())
                self.changed.notify_all()

    def wait_for(self, predicate, seconds):
        """What `predicate` gives as soon as that is true; else None at the end of the time."""
        with self.changed:
            return self.changed.wait_for(predicate, seconds) or None

    def close(self):
        self.closed = True
        self.thread.join()
        self.socket.close()


class Telemetry(Datagrams):
    """Every packet that comes to a UDP port."""

    def __init__(self, port=TELEMETRY_PORT):
        self.packets = []
        self.states = []  # and of these the REL_STATE
        self.events = []  # and the EVENT
        sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        sock.bind(("127.0.0.1", port))
        super().__init__(sock)

    def keep(self, data, at):
        packet = Packet(data, at)
        self.packets.append(packet)
        if packet.kind == REL_STATE:
            self.states.append(packet)
        elif packet.kind == EVENT:
            self.events.append(packet)

    def of(self, kind):
        with self.changed:
            return [p for p in self.packets if p.kind == kind]

    def first_event(self, name, after=0.0):
        return next((e for e in self.events if e.event == name and e.at >= after), None)

    def first_valid(self, after=0.0):
        """The first REL_STATE with a measured pose received after a moment."""
        return next((s for s in self.states if s.at >= after and s.pose_valid and not s.flags & PREDICTED), None)


class Manager(Datagrams):
    """A service manager: what it is told, as (time, text)."""

    def __init__(self, folder):
        self.messages = []
        self.path = str(folder / "notify")
        sock = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        sock.bind(self.path)
        super().__init__(sock)

    def keep(self, data, at):
        self.messages.append((at, data.decode()))

    def has(self, text):
        return any(text in message for _, message in self.messages)

    def times_of(self, text):
        return [at for at, message in self.messages if message == text]


# ---- captures ----

class Capture:
    """A folder that `relnav serve --loop` plays: a cooperative capture there and back, its stamps set so that the motion swings
    as a pendulum's does. Played once it would be over soon; played in a loop, or there and back at a steady rate, it would jump
    or bounce, which no filter has to believe. `rate_hz`: mean. Knows the pose at each stamp."""

    def __init__(self, folder, name="lights_mono", rate_hz=10.0):
        source = CAPTURES / name
        self.target = source / "target.yaml"
        self.path = folder / f"{name}_{rate_hz:g}"
        camera = source / "mav0/cam0"
        images = [line.split(",")[1].strip() for line in lines_of(camera / "data.csv")]
        poses = [[float(x) for x in line.split()][1:] for line in lines_of(source / "truth.tum")]
        half = len(images) - 1
        # Time of image k on the way there, in half swings; the way back mirrors it.
        there = [math.acos(1.0 - 2.0 * k / half) / math.pi for k in range(half + 1)]
        swing = [(time, k) for k, time in enumerate(there)] + [(2.0 - there[k], k) for k in range(half - 1, 0, -1)]
        # The server closes the loop by the mean period: it begins where the swing itself has that.
        first = min(range(len(swing) - 1), key=lambda i: abs(swing[i + 1][0] - swing[i][0] - 1.0 / half)) + 1
        order = swing[first:] + [(time + 2.0, k) for time, k in swing[:first]]
        half_ns = half / rate_hz * 1e9
        self.stamps = [100_000_000_000 + round((time - order[0][0]) * half_ns) for time, _ in order]
        self.poses = [poses[k] for _, k in order]
        span = self.stamps[-1] - self.stamps[0]
        self.loop_ns = span + span // (len(order) - 1)
        out = self.path / "mav0/cam0"
        (out / "data").mkdir(parents=True)
        shutil.copy(camera / "sensor.yaml", out)
        with (out / "data.csv").open("w") as table:
            table.write("#timestamp [ns],filename\n")
            for stamp, (_, k) in zip(self.stamps, order):
                (out / f"data/{stamp}.png").symlink_to(camera / "data" / images[k])
                table.write(f"{stamp},{stamp}.png\n")

    @property
    def calibration(self):
        return self.path / "mav0/cam0/sensor.yaml"

    def pose_at(self, time_ns):
        """t (m), q of the served frame with this original stamp; None: there is none."""
        time_in_loop = (time_ns - self.stamps[0]) % self.loop_ns + self.stamps[0]
        k = bisect.bisect_left(self.stamps, time_in_loop)
        if k == len(self.stamps) or self.stamps[k] != time_in_loop:
            return None
        return self.poses[k][:3], self.poses[k][3:]


def lines_of(path):
    """Of a table, without comments."""
    return [line for line in path.read_text().splitlines() if line and not line.startswith("#")]


def angle_between(p, q):
    """Of two unit quaternions, rad."""
    dot = abs(sum(a * b for a, b in zip(p, q)))
    if dot > 0.9:  # the arc cosine has no digits left near 1
        sign = 1.0 if sum(a * b for a, b in zip(p, q)) > 0.0 else -1.0
        return 4.0 * math.asin(min(1.0, math.dist(p, [sign * x for x in q]) / 2.0))
    return 2.0 * math.acos(min(1.0, dot))


def pose_error(state, truth):
    """Position error (m), attitude error (rad), and the sigma of each by the packet's covariance (0 without one)."""
    t, q = truth
    sigma_t = sigma_phi = 0.0
    if state.flags & COVARIANCE_VALID:
        diagonal = [state.covariance[i] for i in (0, 6, 11, 15, 18, 20)]
        sigma_t, sigma_phi = math.sqrt(sum(diagonal[:3])), math.sqrt(sum(diagonal[3:]))
    return math.dist(state.t_CT, t), angle_between(state.q_CT, q), sigma_t, sigma_phi


# ---- processes ----

class Process:
    """A program that runs until the end of the `with`. Lines of output and errors come as (time, text)."""

    def __init__(self, arguments, environment=None):
        self.lines = []
        self.changed = threading.Condition()
        self.process = subprocess.Popen([str(a) for a in arguments], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                        stderr=subprocess.STDOUT, text=True, errors="replace",
                                        env={**os.environ, **(environment or {})})
        self.reader = threading.Thread(target=self.read, daemon=True)
        self.reader.start()

    def read(self):
        for line in self.process.stdout:
            with self.changed:
                self.lines.append((time.monotonic(), line.rstrip("\n")))
                self.changed.notify_all()

    @property
    def pid(self):
        return self.process.pid

    @property
    def output(self):
        return "\n".join(text for _, text in self.lines)

    def wait_for_line(self, part, seconds=10.0):
        return self.wait_for_nth_line(part, 1, seconds)

    def wait_for_nth_line(self, part, n, seconds=10.0):
        """When the n-th line with `part` came, n from 1."""
        def times():
            return [at for at, text in self.lines if part in text]
        with self.changed:
            return times()[n - 1] if self.changed.wait_for(lambda: len(times()) >= n, seconds) else None

    def kill(self):
        """As a loss of power would."""
        self.process.send_signal(signal.SIGKILL)
        self.wait()

    def end(self, seconds=20.0):
        """Status after SIGTERM."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        return self.wait(seconds)

    def wait(self, seconds=60.0):
        """Its status; 'late' where it does not end in time."""
        try:
            status = self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            return "late"
        self.reader.join()
        self.process.stdout.close()
        return status

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.wait()

    # what it holds
    def descriptors(self):
        return len(os.listdir(f"/proc/{self.pid}/fd"))

    def threads(self):
        return len(os.listdir(f"/proc/{self.pid}/task"))

    def resident_kb(self):
        status = pathlib.Path(f"/proc/{self.pid}/status").read_text()
        return int(status.split("VmRSS:")[1].split()[0])


def serve(dataset, *options, address="127.0.0.1", rate="real", before=()):
    """`relnav serve` over GigE Vision. `before`: what the command begins with, such as chrt."""
    return Process([*before, RELNAV, "serve", "--gige", address, "--dataset", dataset, "--rate", rate, *options])


def camera_section(source, calibration, **options):
    section = {"source": source, "calibration": calibration, "format": "grey8", "packet_bytes": 1400, **options}
    return "{" + ", ".join(f"{key}: {value}" for key, value in section.items()) + "}"


def write_config(path, target, camera, telemetry, second=None, mode="coop-mono", telecommands=None, more=""):
    """A configuration of relnav-flight. `camera`, `second`: as camera_section() makes them; `more`: further sections."""
    text = f"mode: {mode}\ntarget: {target}\ncamera: {camera}\n"
    if second:
        text += f"second_camera: {second}\n"
    text += f'link: {{telemetry: "{telemetry}"' + (f', telecommands: "{telecommands}"' if telecommands else "") + "}\n"
    path.write_text(text + more)
    return path


def fly(config, *options, manager=None, watchdog_s=None):
    """relnav-flight."""
    environment = {}
    if manager:
        environment["NOTIFY_SOCKET"] = manager.path
    if watchdog_s:
        environment["WATCHDOG_USEC"] = str(round(watchdog_s * 1e6))
    return Process([FLIGHT, config, *options], environment)


UDP = f"udp://127.0.0.1:{TELEMETRY_PORT}"


def folder_for(test):
    """A folder that goes away with the test (unittest)."""
    path = pathlib.Path(tempfile.mkdtemp(prefix="relnav-flight-"))
    test.addCleanup(shutil.rmtree, path, ignore_errors=True)
    return path


def print_table(head, rows):
    """In Markdown, as docs/hil.md has it."""
    print("\n| " + " | ".join(head) + " |")
    print("|" + "---|" * len(head))
    for row in rows:
        print("| " + " | ".join(str(cell) for cell in row) + " |")
    sys.stdout.flush()
