"""Fails on a circle of includes between the rooms of one folder: rooms that need each other are one room, and nobody can
read the one before the other. CIRCLES names the arrows that still close one, for each folder: the list only shrinks, so an
arrow of it that closes no circle any longer fails too."""
import collections
import pathlib
import re
import sys

from tracked_files import tracked_files

ROOT = pathlib.Path(sys.argv[1])
CIRCLES = {
    "api": {("flights", "auth"), ("indices", "ogc"), ("indices", "tiles"), ("nodeodm", "auth"), ("nodeodm", "uploads"), ("stac", "ogc"), ("surface", "flights"), ("tiles", "auth"), ("tiles", "ogc"), ("tiles", "surface"), ("webhooks", "auth"), ("wms", "maps")},
    "storage": {("catalogue", "jobs")},
}
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


def leads_to(arrows, start, end):
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
    problems = []
    for folder, files in sorted(arrows_by_folder().items()):
        excepted = CIRCLES.get(folder, set())
        allowed = set(files) - excepted
        for source, target in sorted(allowed):
            way = leads_to(allowed, target, source)
            if way:
                problems.append(f"{folder}: {source} -> {' -> '.join(way)}: {'; '.join(files[source, target][:3])}")
        for source, target in sorted(excepted):
            if (source, target) not in files or not leads_to(allowed, target, source):
                problems.append(f"{folder}: {source} -> {target} closes no circle any longer: take it out of CIRCLES")
    print("\n".join(problems) or f"no circles but {sum(map(len, CIRCLES.values()))} known arrows")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
