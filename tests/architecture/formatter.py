"""Fails on C++ that clang-format would write in another way. Exit code 77, which ctest shows as skipped, where there is
no clang-format. `clang-format -i FILE` mends a file."""
import pathlib
import re
import shutil
import subprocess
import sys

from tracked_files import tracked_files

root = pathlib.Path(sys.argv[1])
formatter = shutil.which("clang-format") or shutil.which("clang-format-14")
if formatter is None:
    print("skipped: clang-format is not installed")
    sys.exit(77)
files = [name for name in tracked_files(root) if name.endswith((".h", ".cc"))]
said = subprocess.run([formatter, "--dry-run", "-Werror", "--ferror-limit=1", *files], cwd=root, capture_output=True, text=True)
print("\n".join(re.findall(r"^\S+:\d+:\d+: error: .*", said.stderr, re.M)) or said.stderr or f"{len(files)} files are formatted")
sys.exit(1 if said.returncode != 0 else 0)
