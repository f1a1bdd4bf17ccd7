#!/usr/bin/env python3
"""Counts the messages of binary flight logs, independently of the C++ parsers.

Used to check them: the numbers in samples_test.cc come from here. It shares no method with them where it can:
DataFlash messages are found through the lengths of FMT, ULog topics by their subscriptions, MAVLink packets by
frames alone (no checksums). Usage: count_messages.py FILE...
"""
import collections
import struct
import sys


def dataflash(data):
    lengths, names, counts, at = {128: 89}, {128: "FMT"}, collections.Counter(), 0
    while at + 3 <= len(data):
        assert data[at:at + 2] == b"\xa3\x95", f"no message head at {at}"
        kind = data[at + 2]
        if at + lengths[kind] > len(data):
            break
        if kind == 128:
            defined, length, name = struct.unpack_from("<BB4s", data, at + 3)
            lengths[defined], names[defined] = length, name.rstrip(b"\0").decode()
        counts[names[kind]] += 1
        at += lengths[kind]
    return counts


def ulog(data):
    topics, counts, at = {}, collections.Counter(), 16
    while at + 3 <= len(data):
        size, kind = struct.unpack_from("<HB", data, at)
        body = data[at + 3:at + 3 + size]
        if len(body) < size:
            break
        if kind == ord("A"):
            name = body[3:].decode()
            topics[struct.unpack_from("<H", body, 1)[0]] = name + (f"[{body[0]}]" if body[0] else "")
        elif kind == ord("D"):
            counts[topics[struct.unpack_from("<H", body)[0]]] += 1
        at += 3 + size
    return counts


def tlog(data):
    counts, at = collections.Counter(), 0
    while at + 9 < len(data):
        magic, length = data[at + 8], data[at + 9]
        if magic == 0xFE:
            kind, size = data[at + 8 + 5], 8 + 6 + length + 2
        else:
            assert magic == 0xFD, f"no packet at {at}"
            kind = int.from_bytes(data[at + 15:at + 18], "little")
            size = 8 + 10 + length + 2 + (13 if data[at + 10] & 1 else 0)
        if at + size > len(data):
            break
        counts[f"MSG_{kind}"] += 1
        at += size
    return counts


if __name__ == "__main__":
    for path in sys.argv[1:]:
        with open(path, "rb") as file:
            content = file.read()
        reader = dataflash if content[:2] == b"\xa3\x95" else ulog if content[:4] == b"ULog" else tlog
        result = reader(content)
        print(path, sum(result.values()), dict(sorted(result.items())))
