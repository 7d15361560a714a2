"""Compresses the files of a wheel again, smaller: what pip unpacks stays the same.

    python tools/pack_wheel.py dist/feeler-*.whl

A wheel is an archive whose files are compressed by deflate; zopfli looks for the smallest of such streams, for a minute
where zlib takes a second. `make wheel` and the release workflow run this on what maturin built.
"""

from __future__ import annotations

import struct
import sys
import zipfile
import zlib
from pathlib import Path

ROUNDS = 5  # of zopfli: more take longer for little
LOCAL, CENTRAL, END = b"PK\3\4", b"PK\1\2", b"PK\5\6"
VERSION = 20  # of the archive's format: the first with folders and deflate
STORED, DEFLATED = 0, 8
UNIX = 3  # the system whose file modes are kept
UTF8 = 0x800


def smallest(data: bytes) -> tuple[int, bytes]:
    """The method, and the data by it."""
    from zopfli.zlib import compress  # only where wheels are made

    # Of the format of zlib without its head and its checksum.
    packed: bytes = compress(data, numiterations=ROUNDS)[2:-4] if data else data
    return (DEFLATED, packed) if len(packed) < len(data) else (STORED, data)


def pack(wheel: Path) -> None:
    """Replaces a wheel by one of the same files, in the same order, with the same times and modes."""
    places = []
    body = bytearray()
    with zipfile.ZipFile(wheel) as archive:
        for info in archive.infolist():
            data, name = archive.read(info), info.filename.encode()
            method, packed = smallest(data)
            year, month, day, hour, minute, second = info.date_time
            date = (year - 1980) << 9 | month << 5 | day
            time = hour << 11 | minute << 5 | second // 2
            common = (VERSION, UTF8, method, time, date, zlib.crc32(data), len(packed), len(data), len(name))
            places.append((common, info.external_attr, len(body), name))
            body += LOCAL + struct.pack("<5H3I2H", *common, 0) + name + packed
    start = len(body)
    for common, mode, at, name in places:
        body += CENTRAL + struct.pack("<BB5H3I5H2I", VERSION, UNIX, *common, 0, 0, 0, 0, mode, at) + name
    count = len(places)
    body += END + struct.pack("<4H2IH", 0, 0, count, count, len(body) - start, start, 0)
    new = wheel.with_suffix(".new")
    new.write_bytes(body)
    with zipfile.ZipFile(wheel) as before, zipfile.ZipFile(new) as after:
        if before.namelist() != after.namelist() or any(before.read(i) != after.read(i) for i in before.namelist()):
            sys.exit(f"pack_wheel: {wheel.name} would not be the same")
    new.replace(wheel)


def main() -> None:
    """The wheels that are named."""
    for wheel in map(Path, sys.argv[1:]):
        before = wheel.stat().st_size
        pack(wheel)
        print(f"pack_wheel: {wheel.name}: {before:,} bytes, now {wheel.stat().st_size:,}")


if __name__ == "__main__":
    main()
