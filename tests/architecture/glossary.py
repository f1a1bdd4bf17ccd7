"""Fails on words that docs/developers/glossary.md refuses, in names, comments and messages.

Names are split into their words first (kMinFollowers reads "k min followers"), so that one rule finds a word in
prose, in CamelCase and in snake_case."""
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1])
EVERYWHERE = ("core", "storage", "api", "server", "web/src", "docs")
SUFFIXES = {".h", ".cc", ".js", ".css", ".html", ".md", ".txt", ".sql"}
COUNTED = "photo|pair|flight|tile|block|row|line|file|lens|thread|job|request|client|owner|user|level|point|knot|cell"

# Refused (a pattern over words in lower case), where, what to say instead.
RULES = [
    (r"followers?", EVERYWHERE, "inliers"),
    (r"links? that holds?|links? holds?", EVERYWHERE, "verified pair"),
    (r"(first|second|next|middle|last|narrow) looks?", ("core", "docs"), "matching pass, rematch"),
    (r"pieces?", ("core",), "connected component; part, chunk or quarter of anything else"),
    (r"sights?", ("core",), "observation, track element"),
    (r"miss(es)?", ("core/alignment",), "reprojection error, residual"),
    (r"(lay|lays|laid|laying) (\w+ ){0,2}on the ground|lay on ground", EVERYWHERE, "project to ground"),
    (r"rescue[ds]?|rescuing", EVERYWHERE, "register by resection"),
    (r"passing things?", EVERYWHERE, "moving object"),
    (r"k (most|least)", EVERYWHERE, "kMax..., kMin..."),
    (rf"(one|twice|once|\d ([kmg]i? ?b|bytes|s|ms)) an? ({COUNTED})", EVERYWHERE, "per, as in one per photo"),
    (r"our bugs?", EVERYWHERE, "precondition, defect of this program"),
]
# Where the word is plainly another: the glossary itself, and names that files or clients keep.
ALLOWED = {
    ("docs/developers/glossary.md", None),
    ("core/pipeline/report/report_fields.h", "pieces"),  # a key of report.json
}


def words_of(line):
    line = re.sub(r"([a-z0-9])([A-Z])", r"\1 \2", line)
    line = re.sub(r"(\d)([A-Za-z])", r"\1 \2", line)
    line = re.sub(r"[.:;,|]+(\s|$)", " / ", line)  # what stands in two sentences is no phrase
    return re.sub(r"[^a-z0-9/]+", " ", line.lower())


def refused_in(name, text):
    rules = [(re.compile(rf"\b(?:{pattern})\b"), instead) for pattern, folders, instead in RULES
             if name.startswith(tuple(folder + "/" for folder in folders))]
    for number, line in enumerate(text.splitlines(), 1):
        words = words_of(line)
        for pattern, instead in rules:
            for found in pattern.finditer(words):
                # Errors of surveyed points keep their names in report.json: miss_east_m.
                if found[0] == "miss" and re.match(r" (east|north|up) m\b", words[found.end():]):
                    continue
                if (name, None) not in ALLOWED and (name, found[0]) not in ALLOWED:
                    yield f'{name}:{number}: "{found[0]}"; docs/developers/glossary.md says: {instead}'


# The rules find what they are there for.
for example in ("int kMinFollowers = 3;", "// 2 MiB a file", "double miss = 0.0;", "constexpr int kMost = 4;",
                "// thumbnails laid on the ground", "LayOnGround(view);", "const Look kLastLook;"):
    assert list(refused_in("core/alignment/example.cc", example)), example
for example in ("// one per photo", "told.miss_east_m = 0.1;", "// the camera looks down", "// 1/64 of a pixel"):
    assert not list(refused_in("core/alignment/example.cc", example)), example

found = []
for folder in EVERYWHERE:
    for path in sorted((ROOT / folder).rglob("*")):
        name = path.relative_to(ROOT).as_posix()
        if path.suffix in SUFFIXES and "/vendor/" not in name:
            found += refused_in(name, path.read_text(errors="replace") + "\n" + path.stem)
print("\n".join(found) or "no refused word is left")
sys.exit(1 if found else 0)
