"""Fails when a stop of docs/developers/architecture.md names a file or function that is not there, or a walk has more than 12 stops."""
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1])
STOP = re.compile(r"^(\d+)\. `([^`]+)` ((?:`[^`]+`(?:, )?)+):")

problems = []
for number, line in enumerate((ROOT / "docs" / "developers" / "architecture.md").read_text().splitlines(), 1):
    stop = STOP.match(line)
    if not stop:
        if re.match(r"^\d+\.", line):
            problems.append(f"docs/developers/architecture.md:{number}: a stop is \"N. `file` `Function`: what\"")
        continue
    if int(stop.group(1)) > 12:
        problems.append(f"docs/developers/architecture.md:{number}: a walk has at most 12 stops")
    path = ROOT / stop.group(2)
    if not path.exists():
        problems.append(f"docs/developers/architecture.md:{number}: there is no {stop.group(2)}")
        continue
    text = path.read_text()
    for name in re.findall(r"`([^`]+)`", stop.group(3)):
        if not re.search(r"\b" + re.escape(name.split("::")[-1]) + r"\(", text):
            problems.append(f"docs/developers/architecture.md:{number}: {stop.group(2)} has no {name}")
print("\n".join(problems) or "every stop of the walks is there")
sys.exit(1 if problems else 0)
