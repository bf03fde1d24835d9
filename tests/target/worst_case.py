"""Constructed captures that ask for the most work, of every mode: what is measured of them bounds what a step takes.

noncoop      a capture whose target comes apart once all feature slots are full: every second block of the picture moves on its own,
             so that features are found where they do not fit, every hypothesis is tried, and windows grow
coop-*       more lights than there is room for, none of them the target's: every picture is looked at, every search uses its
             budget, with as many markers as a target can have"""
import pathlib
import random
import shutil
import struct
import zlib

CAPTURES = pathlib.Path(__file__).resolve().parents[2] / "hil" / "captures"
WIDTH, HEIGHT = 640, 480
WHOLE_FRAMES, BROKEN_FRAMES, LIGHT_FRAMES = 70, 10, 8
SIGNATURE = b"\x89PNG\r\n\x1a\n"


def write_png(path, rows):
    """8-bit grey, rows of bytes."""
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    header = struct.pack(">IIBBBBB", WIDTH, HEIGHT, 8, 0, 0, 0, 0)
    data = zlib.compress(b"".join(b"\0" + bytes(row) for row in rows), 1)
    path.write_bytes(SIGNATURE + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b""))


def read_png(path):
    """Rows of an 8-bit grey picture of the size above, not interlaced."""
    data, at, packed = path.read_bytes(), len(SIGNATURE), b""
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        if kind == b"IHDR" and struct.unpack_from(">IIBBBBB", data, at + 8) != (WIDTH, HEIGHT, 8, 0, 0, 0, 0):
            raise SystemExit(f"{path}: not {WIDTH} x {HEIGHT} in 8 bits of grey")
        packed += data[at + 8:at + 8 + size] if kind == b"IDAT" else b""
        at += 12 + size
    raw, above, rows = zlib.decompress(packed), bytearray(WIDTH), []
    for v in range(HEIGHT):
        filtering, line = raw[v * (WIDTH + 1)], bytearray(raw[v * (WIDTH + 1) + 1:(v + 1) * (WIDTH + 1)])
        left = corner = 0
        for u in range(WIDTH):
            up = above[u]
            if filtering == 1:
                guess = left
            elif filtering == 2:
                guess = up
            elif filtering == 3:
                guess = (left + up) // 2
            elif filtering == 4:
                distances = [(abs(up - corner), 0, left), (abs(left - corner), 1, up), (abs(left + up - 2 * corner), 2, corner)]
                guess = min(distances)[2]
            else:
                guess = 0
            left, corner = (line[u] + guess) & 255, up
            line[u] = left
        rows.append(line)
        above = line
    return rows


def shuffled(rows, generator, block=24, reach=10):
    """Every second block of the picture moved on its own: what is left still gives an update."""
    out = [bytearray(row) for row in rows]
    for v0 in range(0, HEIGHT - block + 1, block):
        for u0 in range(v0 // block % 2 * block, WIDTH - block + 1, 2 * block):
            u = min(max(u0 + generator.randint(-reach, reach), 0), WIDTH - block)
            v = min(max(v0 + generator.randint(-reach, reach), 0), HEIGHT - block)
            for k in range(block):
                out[v0 + k][u0:u0 + block] = rows[v + k][u:u + block]
    return out


def lights(generator, count):
    """Round spots of a few pixels, apart from each other."""
    rows = [bytearray(b"\x0a") * WIDTH for _ in range(HEIGHT)]
    profile = [bytes((40, 90, 110, 90, 40)), bytes((90, 170, 210, 170, 90)), bytes((110, 210, 240, 210, 110))]
    places = generator.sample([(u, v) for u in range(20, WIDTH - 20, 24) for v in range(20, HEIGHT - 20, 24)], count)
    for u, v in places:
        u, v = u + generator.randint(-6, 6), v + generator.randint(-6, 6)
        for k in range(5):
            rows[v - 2 + k][u - 2:u + 3] = profile[min(k, 4 - k)]
    return rows


def write_list(folder, stamps):
    lines = "".join(f"{stamp},{stamp}.png\n" for stamp in stamps)
    (folder / "data.csv").write_text("#timestamp [ns],filename\n" + lines)


def come_apart(folder):
    generator = random.Random(1)
    source, camera = CAPTURES / "spin_near" / "mav0" / "cam0", folder / "mav0" / "cam0"
    (camera / "data").mkdir(parents=True)
    shutil.copy(source / "sensor.yaml", camera)
    names = [line.split(",") for line in (source / "data.csv").read_text().split()[-150:]]
    names = names[:WHOLE_FRAMES + BROKEN_FRAMES]
    for k, (stamp, name) in enumerate(names):
        copy = camera / "data" / f"{stamp}.png"
        if k < WHOLE_FRAMES:
            copy.symlink_to(source / "data" / name)
        else:
            write_png(copy, shuffled(read_png(source / "data" / name), generator))
    write_list(camera, [stamp for stamp, _ in names])


def drown_in_lights(folder, capture):
    generator = random.Random(2)
    stamps = [100_000_000_000 + k * 100_000_000 for k in range(LIGHT_FRAMES)]
    for source in sorted((CAPTURES / capture / "mav0").iterdir()):
        camera = folder / "mav0" / source.name
        (camera / "data").mkdir(parents=True)
        shutil.copy(source / "sensor.yaml", camera)
        for stamp in stamps:
            write_png(camera / "data" / f"{stamp}.png", lights(generator, 90))
        write_list(camera, stamps)
    markers = [[generator.uniform(-1.0, 1.0) for _ in range(3)] for _ in range(16)]
    (folder / "target.yaml").write_text("frame: target_body\nunit: m\nfeatures:\n" + "".join(
        f"  - {{id: {k + 1}, xyz: [{x:.6f}, {y:.6f}, {z:.6f}]}}\n" for k, (x, y, z) in enumerate(markers)))


def write(folder, mode):
    """A data set for `relnav replay --mode MODE`; the options that go with it."""
    shutil.rmtree(folder, ignore_errors=True)
    if mode == "noncoop":
        come_apart(folder)
        return ["--range", "3.4"]
    drown_in_lights(folder, {"coop-mono": "lights_mono", "coop-stereo": "lights_stereo"}[mode])
    return []
