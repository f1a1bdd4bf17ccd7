"""Writes docs/developers/hardening.md: what was tried against the program, what it did, what it does now, and the test that holds it.

    python3 tests/hardening/hardening_table.py            writes the table; fails on a test that does not exist
    python3 tests/hardening/hardening_table.py --check    fails when docs/developers/hardening.md is not what this would write
"""
import pathlib
import re
import sys

from rows import ROWS

ROOT = pathlib.Path(__file__).resolve().parents[2]
TABLE = ROOT / "docs" / "developers" / "hardening.md"
HEAD = """# Hardening

What was tried against the program on purpose, what it did before, what it does now, and the test that holds it there.
Made by `python3 tests/hardening/hardening_table.py`, which fails when one of the named tests does not exist; a test runs it.
`Suite.Name` is a case of a unit program (`build/release/bin/PROGRAM --gtest_filter=Suite.Name`), `file.py name` an end-to-end test
(`SKYQUILT_BINARY=... python3 tests/support/cases.py tests/e2e/file.py`), `file.js name` a test of the page.

"""


def sources():
    return [path for folder in ("tests",) for path in (ROOT / folder).rglob("*") if path.suffix in (".cc", ".py", ".js")]


def known_tests():
    """Names as the table has them."""
    known = set()
    for path in sources():
        text = path.read_text(errors="replace")
        if path.suffix == ".cc":
            for suite, name in re.findall(r"^TEST(?:_F|_P)?\((\w+), (\w+)\)", text, re.M):
                known.add(f"{suite}.{name}")
            if path.name.endswith("_fuzz.cc"):
                known.add(path.stem)
        elif path.suffix == ".py":
            for name in re.findall(r"^ +def (test_\w+)", text, re.M):
                known.add(f"{path.name} {name}")
        else:
            for name in re.findall(r"^test\((['\"`])(.*?)\1", text, re.M):
                known.add(f"{path.name} {name[1]}")
    return known


def table():
    known = known_tests()
    text = HEAD
    missing = []
    for title, rows in ROWS:
        text += f"## {title}\n\n| tried | before | now | held by |\n|---|---|---|---|\n"
        for tried, before, now, tests in rows:
            missing += [name for name in tests if name not in known]
            text += f"| {tried} | {before} | {now} | {', '.join(f'`{name}`' for name in tests)} |\n"
        text += "\n"
    return text.rstrip("\n") + "\n", missing


def main():
    text, missing = table()
    for name in missing:
        print(f"no such test: {name}")
    if missing:
        return 1
    if "--check" in sys.argv[1:]:
        if not TABLE.exists() or TABLE.read_text() != text:
            print("docs/developers/hardening.md is out of date: run python3 tests/hardening/hardening_table.py")
            return 1
        print("docs/developers/hardening.md is current")
        return 0
    TABLE.write_text(text)
    print(f"{sum(len(rows) for _, rows in ROWS)} rows in docs/developers/hardening.md")
    return 0


if __name__ == "__main__":
    sys.exit(main())
