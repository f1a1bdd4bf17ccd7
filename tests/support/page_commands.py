"""What a page of docs/ has its reader type."""
import pathlib
import re
import shlex

DOCS = pathlib.Path(__file__).resolve().parents[2] / "docs"
BLOCK = re.compile(r"```sh\n(.*?)```", re.S)


def shell_blocks(page):
    """The shell blocks: of each its commands, as words, without comments."""
    for block in BLOCK.findall((DOCS / page).read_text()):
        lines = [shlex.split(line, comments=True) for line in block.replace("\\\n", " ").splitlines()]
        yield [words for words in lines if words]


def code_spans(page):
    """What stands between back-quotes outside of blocks, each once."""
    text = BLOCK.sub("", (DOCS / page).read_text())
    return list(dict.fromkeys(" ".join(span.split()) for span in re.findall(r"`([^`]+)`", text)))


def table(page, heading):
    """The rows of the table whose first column has this heading: their cells."""
    found = re.search(rf"^\| {re.escape(heading)} \|.*\n\|[-|]+\n((?:\|.*\n)+)", (DOCS / page).read_text(), re.M)
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in found[1].splitlines()]
