"""Fails where two places share six identical lines or more: what is done twice belongs in one function.

What counts is code in C++, JavaScript, CSS, Python, shell and CMake, line by line with white space folded. Passed over,
as if they were not there: blank lines, comments, includes and imports, lines without a letter or digit, and the lines
that open and close a namespace or bring a name in from another. Not read: SQL (a migration is history and says all it
does), HTML and data. Lines that differ in a name or a number differ: similar code is not this test's matter."""
import collections
import pathlib
import re
import sys

from tracked_files import tracked_files

ROOT = pathlib.Path(sys.argv[1])
RUN = 6
SUFFIXES = {".h", ".cc", ".js", ".css", ".py", ".sh", ".cmake"}
COMMENT = {".py": "#", ".sh": "#", ".cmake": "#", ".txt": "#"}
C_COMMENT = r"//|/\*|\* |\*/|#\s*(include|pragma)"
PASSED_OVER = (r"|(import|from) [\w.{'\"]|export \{|const \{[\w, ]+\} = require\("
               r"|using [\w:]+( = [\w:]+)?;|namespace [\w:]* ?(= [\w:]+;|\{)|\}  // namespace")


def lines_of(path):
    """(line number, text) of what counts."""
    passed_over = re.compile(COMMENT.get(path.suffix, C_COMMENT) + PASSED_OVER)
    kept = []
    for number, line in enumerate(path.read_text(errors="replace").splitlines(), 1):
        text = " ".join(line.split())
        if re.search(r"\w", text) and not passed_over.match(text):
            kept.append((number, text))
    return kept


def main():
    files = {}
    for name in tracked_files(ROOT):
        path = ROOT / name
        if (path.suffix in SUFFIXES or path.name == "CMakeLists.txt"):
            files[name] = lines_of(path)
    places = collections.defaultdict(list)
    for name, lines in files.items():
        for start in range(len(lines) - RUN + 1):
            places[tuple(text for _, text in lines[start:start + RUN])].append((name, start))
    problems, covered = [], set()
    for found in places.values():
        first, *others = found
        for other in others:
            if (first, other) in covered:
                continue
            a, b = files[first[0]], files[other[0]]
            length = RUN
            while (first[1] + length < len(a) and other[1] + length < len(b)
                   and a[first[1] + length][1] == b[other[1] + length][1]):
                length += 1
            for k in range(length - RUN + 1):
                covered.add(((first[0], first[1] + k), (other[0], other[1] + k)))
            problems.append((length, f"{first[0]}:{a[first[1]][0]}-{a[first[1] + length - 1][0]} and "
                                     f"{other[0]}:{b[other[1]][0]}-{b[other[1] + length - 1][0]}: {length} lines are the same"))
    problems.sort(reverse=True)
    print("\n".join(text for _, text in problems) or f"no two places of {len(files)} files share {RUN} lines")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
