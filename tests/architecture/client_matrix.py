"""Fails when a row of docs/developers/clients.md names a test that is not there or not run, or an npm package in another version than the
tests install."""
import json
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1])
E2E = ROOT / "tests" / "e2e"
COLUMNS = ["client", "version", "how", "without", "token", "tests"]
FEWEST_ROWS = 25  # a matrix that shrank below what it held is no matrix

packages = json.loads((E2E / "clients" / "package.json").read_text())["dependencies"]
registered = (E2E / "CMakeLists.txt").read_text()
problems, rows = [], 0
for number, line in enumerate((ROOT / "docs" / "developers" / "clients.md").read_text().splitlines(), 1):
    if not line.startswith("|") or set(line) <= set("|-"):
        continue
    cells = [cell.strip() for cell in line.strip("|").split("|")]
    where = f"docs/developers/clients.md:{number}"
    if cells == COLUMNS:
        continue
    if len(cells) != len(COLUMNS) or not all(cells):
        problems.append(f"{where}: a row has the columns {', '.join(COLUMNS)}, each with something in it")
        continue
    rows += 1
    package = re.fullmatch(r"`([^`]+)`", cells[0])
    if package and packages.get(package.group(1)) != cells[1]:
        problems.append(f"{where}: tests install {package.group(1)} {packages.get(package.group(1))}")
    named = re.findall(r"`([\w/]+)\.py` `(\w+)`", cells[5])
    if not named:
        problems.append(f"{where}: no test is named as `file.py` `test_name`")
    for file, test in named:
        path = E2E / f"{file}.py"
        if not path.exists() or not re.search(rf"def {test}\(", path.read_text()):
            problems.append(f"{where}: there is no {test} in tests/e2e/{file}.py")
        elif not re.search(rf"[ (]{file}[ )\n]", registered):
            problems.append(f"{where}: tests/e2e/CMakeLists.txt does not run {file}")
if rows < FEWEST_ROWS:
    problems.append(f"docs/developers/clients.md: {rows} rows, fewer than {FEWEST_ROWS}")
print("\n".join(problems) or f"every test of the {rows} rows is there")
sys.exit(1 if problems else 0)
