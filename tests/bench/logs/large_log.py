#!/usr/bin/env python3
"""Writes a long ArduPilot log and prints how much memory and time reading it takes: the size of a log must not matter.

Usage: large_log.py [GIBIBYTES [FOLDER]] with SKYQUILT_BINARY naming the program. The log is deleted afterwards.
"""
import array
import os
import pathlib
import resource
import struct
import subprocess
import sys
import tempfile
import time

BINARY = os.environ.get("SKYQUILT_BINARY", "build/release/bin/skyquilt")
HEAD = 0x95A3  # 0xA3 0x95 little-endian
FORMATS = {128: ("FMT", "BBnNZ", "Type,Length,Name,Format,Columns", 89),
           130: ("IMU", "Qffffff", "TimeUS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ", 35),
           131: ("GPS", "QBIHBcLLffffB", "TimeUS,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ,U", 46),
           132: ("BARO", "Qffcf", "TimeUS,Alt,Press,Temp,CRt", 25)}
BLOCK_S = 10  # of flight, made once and then stamped anew


def records(kind, rate_hz, body):
    """Records of one kind for one block, their time still zero."""
    name, _, _, length = FORMATS[kind]
    one = struct.pack("<HBQ", HEAD, kind, 0) + body
    assert len(one) == length, (name, len(one))
    return bytearray(one * (rate_hz * BLOCK_S)), length, rate_hz


IMU = records(130, 1000, struct.pack("<6f", 0.001, -0.002, 0.003, 0.05, -0.02, -9.81))
BARO = records(132, 10, struct.pack("<ffhf", 60.0, 95000.0, 2000, 0.0))
GPS = records(131, 5, struct.pack("<BIHBhiiffffB", 3, 0, 2300, 12, 80, 468000000, 71000000, 560.0, 8.0, 0.0, 0.0, 1))


def stamped(block, second):
    data, length, rate_hz = block
    step_us = 1000000 // rate_hz
    times = array.array("Q", range(second * 1000000, (second + BLOCK_S) * 1000000, step_us)).tobytes()
    for byte in range(8):
        data[3 + byte::length] = times[byte::8]
    return data


def write(path, size):
    with open(path, "wb") as file:
        for kind, (name, fields, columns, length) in FORMATS.items():
            file.write(struct.pack("<HBBB4s16s64s", HEAD, 128, kind, length, name.encode(), fields.encode(),
                                   columns.encode()))
        second = 1
        while file.tell() < size:
            for block in (IMU, GPS, BARO):
                file.write(stamped(block, second))
            second += BLOCK_S


def main():
    gibibytes = float(sys.argv[1]) if len(sys.argv) > 1 else 2.0
    folder = sys.argv[2] if len(sys.argv) > 2 else None
    with tempfile.TemporaryDirectory(dir=folder) as scratch:
        log = pathlib.Path(scratch) / "long.BIN"
        write(log, int(gibibytes * 2**30))
        began = time.monotonic()
        done = subprocess.run([BINARY, "inspect", log], capture_output=True, text=True)
        took = time.monotonic() - began
        peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
        print(done.stdout + done.stderr)
        size = log.stat().st_size / 2**20
        print(f"{size:.0f} MiB read in {took:.1f} s ({size / took:.0f} MiB/s), peak memory {peak:.0f} MiB")


if __name__ == "__main__":
    main()
