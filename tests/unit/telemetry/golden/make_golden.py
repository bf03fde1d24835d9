#!/usr/bin/env python3
"""Makes the golden packets from the ICD alone (docs/telemetry-icd.md), with Python's struct and binascii: nothing of ours.

    python3 tests/unit/telemetry/golden/make_golden.py [--check]

--check compares with the stored files instead of writing them.
"""
import binascii
import pathlib
import struct
import sys

HERE = pathlib.Path(__file__).parent
BASE = 0x123
DESTINATION = 0x0B0C
TIME_REFERENCE = 5
SEQUENCE = 3
EPOCH_OFFSET_NS = 378691237 * 10**9  # Unix epoch since 1958, and TAI - UTC = 37 s
TIME_NS = 1_700_000_000_123_456_789

FORMAT = {"u8": "B", "u16": "H", "u32": "I", "u64": "Q", "i16": "h", "i32": "i", "i64": "q", "f32": "f", "f64": "d"}


def frange(n, start, step):
    return [start + i * step for i in range(n)]


PACKETS = {
    "rel_state": dict(
        offset=0, service=3, subtype=25, structure=1,
        fields=[
            ("time_ns", "u64", [TIME_NS]), ("frame_sequence", "u32", [0x01020304]), ("camera", "u8", [1]),
            ("mode", "u8", [2]), ("valid_flags", "u8", [0x5F]), ("quality", "u8", [87]), ("reset_counter", "u16", [513]),
            ("estimator", "u8", [4]), ("parent_frame", "u8", [1]), ("child_frame", "u8", [2]),
            ("t_CT", "f64", [1.0, -2.0, 30.5]), ("q_CT", "f64", [0.1, -0.5, 0.5, 0.7]),
            ("v_C", "f64", [0.001, 1e-300, -0.25]), ("omega_C", "f64", [3.0e-3, -4.0e-3, 0.0]),
            ("pose_covariance", "f32", frange(21, 0.25, 0.5)), ("rate_covariance", "f32", frange(21, -1.0, 0.125)),
        ]),
    "features": dict(
        offset=1, service=3, subtype=26, structure=2,
        fields=[("time_ns", "u64", [TIME_NS]), ("frame_sequence", "u32", [77]), ("part", "u8", [1]), ("parts", "u8", [2]),
                ("features_total", "u16", [66])],
        entries=[
            [("slot", "u16", [64]), ("generation", "u16", [0xFFFF]), ("u_px_256", "i32", [-128]),
             ("v_px_256", "i32", [524287]), ("residual_px", "f32", [0.75]), ("use", "u8", [3])],
            [("slot", "u16", [65]), ("generation", "u16", [1]), ("u_px_256", "i32", [81920]),
             ("v_px_256", "i32", [-2147483648]), ("residual_px", "f32", [0.0]), ("use", "u8", [5])],
        ]),
    "health": dict(
        offset=2, service=3, subtype=25, structure=3,
        fields=[
            ("time_ns", "u64", [TIME_NS]), ("frame_sequence", "u32", [4000000000]), ("mode", "u8", [3]), ("flags", "u8", [11]),
            ("last_status", "u8", [9]), ("frames_processed", "u32", [100001]), ("frames_refused", "u32", [12]),
            ("frames_incomplete", "u32", [13]), ("frames_lost", "u32", [14]), ("camera_losses", "u16", [15]),
            ("features", "u16", [40]), ("matched", "u16", [33]), ("inliers", "u16", [31]), ("refused_updates", "u32", [16]),
            ("covariance_repairs", "u32", [17]), ("reset_counter", "u16", [18]), ("test_ratio", "f32", [0.5]),
            ("telemetry_dropped", "u32", [19]), ("event_count", "u32", [20]), ("events_suppressed", "u32", [21]),
            ("latency_us", "u32", [22]), ("latency_max_us", "u32", [4294967295]), ("arrival_latency_us", "u32", [24]),
            ("arrival_latency_max_us", "u32", [25]),
        ]),
    "event": dict(
        offset=3, service=5, subtype=2, structure=None,
        fields=[("event_id", "u16", [4]), ("occurrence", "u32", [70000]), ("suppressed", "u32", [2]), ("status", "u8", [10]),
                ("time_ns", "u64", [TIME_NS]), ("frame_sequence", "u32", [99]),
                ("args", "i64", [98, TIME_NS, -1, -9223372036854775808])]),
    "time": dict(
        offset=4, service=3, subtype=25, structure=5,
        fields=[("time_ns", "u64", [TIME_NS]), ("tai_ns", "u64", [2078691237 * 10**9]), ("drift_ppb", "i32", [-20000]),
                ("residual_ns", "i32", [-2147483648]), ("pulse_age_ms", "u32", [70000]), ("pulses_used", "u32", [30]),
                ("pulses_missed", "u32", [31]), ("pulses_refused", "u32", [32]), ("sync", "u8", [2]),
                ("seconds_source", "u8", [1]), ("exposure_offset_ns", "i32", [-33])]),
    "command_ack": dict(
        offset=5, service=1, subtype=8, structure=None,
        fields=[("request_packet_id", "u16", [0x1800 | BASE]), ("request_sequence", "u16", [0xC000 | 4711]),
                ("stage", "u8", [8]), ("code", "u8", [6]), ("service", "u8", [9]), ("subtype", "u8", [128]),
                ("time_ns", "u64", [TIME_NS])]),
    "pong": dict(offset=6, service=17, subtype=2, structure=None, fields=[("time_ns", "u64", [TIME_NS])]),
}


def pack(fields):
    return b"".join(struct.pack(">" + FORMAT[kind] * len(values), *values) for _, kind, values in fields)


def lines(fields, prefix=""):
    for name, kind, values in fields:
        for i, value in enumerate(values):
            if kind == "f32":
                value = struct.unpack(">f", struct.pack(">f", value))[0]
            text = value.hex() if kind[0] == "f" else str(value)
            yield f"{prefix}{name}{f'[{i}]' if len(values) > 1 else ''} {text}"


def golden(name, p):
    tai = TIME_NS + EPOCH_OFFSET_NS
    cuc = struct.pack(">IH", tai // 10**9, (tai % 10**9) * 65536 // 10**9)
    secondary = bytes([0x20 | TIME_REFERENCE, p["service"], p["subtype"]]) + struct.pack(">HH", SEQUENCE, DESTINATION) + cuc
    body = b"" if p["structure"] is None else struct.pack(">H", p["structure"])
    body += pack(p["fields"])
    if "entries" in p:
        body += struct.pack(">H", len(p["entries"])) + b"".join(pack(e) for e in p["entries"])
    data = secondary + body
    packet = struct.pack(">HHH", 0x0800 | (BASE + p["offset"]), 0xC000 | SEQUENCE, len(data) + 2 - 1) + data
    packet += struct.pack(">H", binascii.crc_hqx(packet, 0xFFFF))
    out = [f"# {name.upper()}: made by make_golden.py, do not edit", f"hex {packet.hex()}"]
    out += lines(p["fields"])
    for i, entry in enumerate(p.get("entries", [])):
        out += lines(entry, f"entry{i}.")
    return "\n".join(out) + "\n"


def main():
    check = "--check" in sys.argv[1:]
    bad = 0
    for name, packet in PACKETS.items():
        path = HERE / f"{name}.txt"
        text = golden(name, packet)
        if not check:
            path.write_text(text)
        elif path.read_text() != text:
            print(f"{path}: differs from what make_golden.py makes", file=sys.stderr)
            bad = 1
    return bad


if __name__ == "__main__":
    sys.exit(main())
