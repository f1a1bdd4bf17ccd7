"""Fails on a source file that no CMakeLists.txt lists (dead code), on globbing, and on unfinished work."""
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1])
FOLDERS = ("core", "storage", "api", "server", "tests")
problems = []
for folder in FOLDERS:
    for lists in sorted((ROOT / folder).rglob("CMakeLists.txt")):
        if re.search(r"file\s*\(\s*GLOB", lists.read_text(), re.I):
            problems.append(f"{lists.relative_to(ROOT)}: sources are listed, not globbed")
    for path in sorted((ROOT / folder).rglob("*.cc")):
        listed = False
        for parent in path.parents:
            lists = parent / "CMakeLists.txt"
            if lists.exists() and re.search(r"(^|[\s/(])" + re.escape(path.relative_to(parent).as_posix()) + r"([\s)]|$)",
                                            lists.read_text()):
                listed = True
                break
            if parent == ROOT:
                break
        if not listed:
            problems.append(f"{path.relative_to(ROOT)}: no CMakeLists.txt lists it")
    for path in sorted((ROOT / folder).rglob("*")):
        if path.suffix in (".h", ".cc", ".js") and re.search(r"\b(TODO|FIXME|XXX)\b", path.read_text(errors="replace")):
            problems.append(f"{path.relative_to(ROOT)}: unfinished work is marked in it")
print("\n".join(problems) or "every source is built")
sys.exit(1 if problems else 0)
