"""Fails on a circle of includes between the rooms of one folder: rooms that need each other are one room, and nobody can read
the one before the other. What two of them need lies in a room below both."""
import collections
import pathlib
import re
import sys

from tracked_files import tracked_files

ROOT = pathlib.Path(sys.argv[1])
INCLUDE = re.compile(r'^#include "([^"]+)"', re.M)


def arrows_by_folder():
    """For each folder, the files by which one of its rooms includes another."""
    found = collections.defaultdict(lambda: collections.defaultdict(list))
    for name in tracked_files(ROOT, "core", "storage", "api", "server"):
        if not name.endswith((".h", ".cc")):
            continue
        source = name.split("/")[:-1]
        for target_name in INCLUDE.findall((ROOT / name).read_text()):
            target = target_name.split("/")[:-1]
            shared = 0
            while shared < min(len(source), len(target)) and source[shared] == target[shared]:
                shared += 1
            if 0 < shared < min(len(source), len(target)):
                found["/".join(source[:shared])][source[shared], target[shared]].append(f"{name} -> {target_name}")
    return found


def way_between(arrows, start, end):
    """The rooms on a way from one to the other; nothing where there is none."""
    ways = [[start]]
    seen = {start}
    for way in ways:
        if way[-1] == end:
            return way
        for source, target in sorted(arrows):
            if source == way[-1] and target not in seen:
                seen.add(target)
                ways.append([*way, target])
    return None


def main():
    folders = arrows_by_folder()
    problems = []
    for folder, files in sorted(folders.items()):
        for source, target in sorted(files):
            way = way_between(files, target, source)
            if way:
                problems.append(f"{folder}: {source} -> {' -> '.join(way)}: {'; '.join(files[source, target][:3])}")
    arrows = sum(map(len, folders.values()))
    print("\n".join(problems) or f"{arrows} arrows between rooms close no circle")
    return 1 if problems or arrows < 100 else 0


if __name__ == "__main__":
    sys.exit(main())
