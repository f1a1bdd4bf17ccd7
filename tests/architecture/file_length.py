"""Fails on any source file above 500 lines: a file that long holds more than one concept."""
import pathlib
import sys

ROOT = pathlib.Path(sys.argv[1])
LIMIT = 500
SUFFIXES = {".h", ".cc", ".js", ".css", ".py", ".sh", ".cmake", ".html"}
SKIPPED = {"build", "node_modules", "vendor", ".git"}

too_long = []
for path in sorted(ROOT.rglob("*")):
    if path.suffix not in SUFFIXES or SKIPPED & set(path.relative_to(ROOT).parts):
        continue
    lines = len(path.read_text(errors="replace").splitlines())
    if lines > LIMIT:
        too_long.append(f"{path.relative_to(ROOT)}: {lines} lines, the limit is {LIMIT}")
print("\n".join(too_long) or "no file is too long")
sys.exit(1 if too_long else 0)
