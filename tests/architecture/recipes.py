"""Fails when a patch of docs/developers/recipes does not fit the sources, touches more files than docs/developers/recipes.md says, or, with
--compile, what it makes of a source does not compile."""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(sys.argv[1]).resolve()
ROW = re.compile(r"^\| [^|]+ \| (\d+) \| \[(\w+)\]\(recipes/\2\.patch\) \|$", re.MULTILINE)
GENERATED = "api/clients/python/skyquilt/contract/"
INCLUDES = ["-isystem", "/usr/include/eigen3", "-isystem", "/usr/include/opencv4"]


def problems_of(name, most):
    patch = ROOT / "docs" / "developers" / "recipes" / f"{name}.patch"
    if not patch.is_file():
        return [f"docs/developers/recipes.md: there is no recipes/{name}.patch"]
    touched = sorted(set(re.findall(r"^(?:---|\+\+\+) [ab]/(\S+)$", patch.read_text(), re.MULTILINE)))
    written = [path for path in touched if not path.startswith(GENERATED)]
    if len(written) > most:
        return [f"{patch.name}: touches {len(written)} files, at most {most} are said: {', '.join(written)}"]
    with tempfile.TemporaryDirectory() as scratch:
        for path in touched:
            if (ROOT / path).is_file():
                (pathlib.Path(scratch) / path).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(ROOT / path, pathlib.Path(scratch) / path)
        # From outside any repository, where paths are those of the patch.
        applied = subprocess.run(["git", "apply", patch], cwd=scratch, capture_output=True, text=True,
                                 env={"PATH": "/usr/bin:/bin", "GIT_CEILING_DIRECTORIES": str(pathlib.Path(scratch).parent)})
        if applied.returncode:
            return [f"{patch.name}: does not fit: {applied.stderr.strip()}"]
        found = []
        for path in touched:
            if not path.endswith(".cc") or "--compile" not in sys.argv:
                continue
            compiled = subprocess.run(["g++", "-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-I", scratch, "-I", ROOT,
                                       *INCLUDES, pathlib.Path(scratch) / path], capture_output=True, text=True)
            if compiled.returncode:
                found.append(f"{patch.name}: {path} does not compile: {compiled.stderr.strip()[:2000]}")
        return found


rows = ROW.findall((ROOT / "docs" / "developers" / "recipes.md").read_text())
problems = [] if rows else ["docs/developers/recipes.md: no recipe in its table"]
for most, name in rows:
    problems += problems_of(name, int(most))
told = {name for _, name in rows}
problems += [f"docs/developers/recipes.md does not name {path.name}" for path in sorted((ROOT / "docs" / "developers" / "recipes").iterdir())
             if path.stem not in told]
print("\n".join(problems) or f"{len(rows)} recipes fit")
sys.exit(1 if problems else 0)
