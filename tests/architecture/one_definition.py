"""Fails when two files define a type of the same name in the same namespace (unnamed ones aside). The language allows one
definition: a vector of the one may be grown by the code made for the other, and neither compiler nor linker says a word."""
import collections
import pathlib
import re
import sys

from tracked_files import tracked_files

ROOT = pathlib.Path(sys.argv[1])
TYPE = re.compile(r"^(?:template <[^>]*>\n)?(?:struct|class|enum class|enum) (?:\[\[\w+\]\] )?(\w+)\b(?!::)(?=[^;()]*[{:])", re.M)
UNNAMED = re.compile(r"^namespace \{$.*?^\}  // namespace$", re.M | re.S)
NAMED = re.compile(r"^namespace ([\w:]+) \{\n(.*?)^\}  // namespace \1", re.M | re.S)

owners = collections.defaultdict(set)
for name in tracked_files(ROOT, "core", "storage", "api", "server"):
    if name.endswith((".h", ".cc")):
        for namespace, body in NAMED.findall(UNNAMED.sub("", (ROOT / name).read_text())):
            for type_name in TYPE.findall(body):
                owners[f"{namespace}::{type_name}"].add(name)
twice = {name: paths for name, paths in owners.items() if len(paths) > 1}
for name, paths in sorted(twice.items()):
    print(f"{name} is defined in {' and '.join(sorted(paths))}")
print(f"{len(owners)} types, {len(twice)} of them defined twice")
sys.exit(1 if twice or len(owners) < 100 else 0)
