"""Fails on flags in a vector<char> in core/alignment (of photos they are a PhotoSet, of others a field or a vector<bool>), and
on more than 20 casts to std::size_t there: an index of the right type needs none."""
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1])
LIMIT = 20
FLAGS = re.compile(r"\bvector<\s*char\s*>")
CAST = re.compile(r"\bstatic_cast<(?:std::)?size_t>")

problems, casts = [], []
for path in sorted((ROOT / "core" / "alignment").rglob("*.*")):
    if path.suffix in (".h", ".cc"):
        for number, line in enumerate(path.read_text().splitlines(), 1):
            place = f"{path.relative_to(ROOT)}:{number}"
            problems += [f"{place}: flags in a vector<char>" for _ in FLAGS.findall(line)]
            casts += [place for _ in CAST.findall(line)]
if len(casts) > LIMIT:
    problems.append(f"core/alignment: {len(casts)} casts to std::size_t, the limit is {LIMIT}: {', '.join(casts)}")
print("\n".join(problems) or f"no flags in a vector<char>, {len(casts)} casts to std::size_t")
sys.exit(1 if problems else 0)
