"""Writes a bag in SQLite and files in MCAP with nothing but Python's own modules (and the tools zstd and lz4, where they
are installed): an independent writer for the tests of the readers. write_bags.py FOLDER"""

import shutil
import sqlite3
import struct
import subprocess
import sys
import zlib
from pathlib import Path

START = 1_700_000_000_000_000_000  # ns


def joint_state(stamp, names, position):
    out = bytearray()

    def align(n):
        out.extend(b"\0" * (-len(out) % n))

    def text(x):
        align(4)
        out.extend(struct.pack("<I", len(x) + 1) + x.encode() + b"\0")

    def doubles(values):
        align(4)
        out.extend(struct.pack("<I", len(values)))
        for value in values:
            align(8)
            out.extend(struct.pack("<d", value))

    out.extend(struct.pack("<iI", stamp // 10**9, stamp % 10**9))
    text("")
    align(4)
    out.extend(struct.pack("<I", len(names)))
    for name in names:
        text(name)
    doubles(position)
    doubles([])
    doubles([])
    return b"\0\1\0\0" + bytes(out)


MESSAGES = [(START + i * 10**7, joint_state(START + i * 10**7, ["shoulder", "elbow"], [0.25 * i, 1.0 / (i + 1)])) for i in range(50)]


def write_db3(path):
    path.unlink(missing_ok=True)
    db = sqlite3.connect(path)
    db.execute("CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL)")
    db.execute("CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL)")
    db.execute(
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
        "serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL)"
    )
    db.execute(
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL)"
    )
    db.execute("CREATE INDEX timestamp_idx ON messages (timestamp ASC)")
    db.execute("INSERT INTO topics VALUES (1, '/joint_states', 'sensor_msgs/msg/JointState', 'cdr', '')")
    db.executemany("INSERT INTO messages (topic_id, timestamp, data) VALUES (1, ?, ?)", MESSAGES)
    db.commit()
    db.close()


def record(opcode, content):
    return struct.pack("<BQ", opcode, len(content)) + content


def text(x):
    return struct.pack("<I", len(x)) + x.encode()


def write_mcap(path, packing):
    inner = record(0x03, struct.pack("<H", 7) + text("sensor_msgs/msg/JointState") + text("ros2msg") + struct.pack("<I", 0))
    inner += record(0x04, struct.pack("<HH", 3, 7) + text("/joint_states") + text("cdr") + struct.pack("<I", 0))
    for i, (time, data) in enumerate(MESSAGES):
        inner += record(0x05, struct.pack("<HIQQ", 3, i, time, time) + data)
    packed = inner
    if packing:
        packed = subprocess.run([packing, "-c", "-q", "-"], input=inner, capture_output=True, check=True).stdout
    chunk = struct.pack("<QQQI", MESSAGES[0][0], MESSAGES[-1][0], len(inner), zlib.crc32(inner))
    chunk += text(packing) + struct.pack("<Q", len(packed)) + packed
    front = b"\x89MCAP0\r\n" + record(0x01, text("ros2") + text("python"))
    section = record(0x06, chunk)
    # The checksum as the specification words it: of the data section alone.
    end = record(0x0F, struct.pack("<I", zlib.crc32(section)))
    path.write_bytes(front + section + end + record(0x02, struct.pack("<QQI", 0, 0, 0)) + b"\x89MCAP0\r\n")


folder = Path(sys.argv[1])
write_db3(folder / "python.db3")
for packing in ("", "zstd", "lz4"):
    if not packing or shutil.which(packing):
        write_mcap(folder / f"python_{packing or 'plain'}.mcap", packing)
