"""Fails on what clang-tidy finds in the product (core, storage, api, server); .clang-tidy has the checks and says why others
are off. Exit code 77, which ctest shows as skipped, where there is no clang-tidy.

usage: tidy.py ROOT BUILD [PART]   PART: only units one of whose sources has this in its name

BUILD is a configured and built tree: the units are taken as its compile_commands.json has them, which in the release
configuration are whole libraries, whose headers are then read once. As many run at once as there are cores. What a header
shows to several units counts once.

A unit found clean is remembered in BUILD/tidy under everything that its verdict hangs on: this program, the version of
clang-tidy, the checks, the command, and the contents of all files that the unit includes. Ninja knows these from the last
compilation; a verdict is kept only where none of them has changed since, so that the list is true."""
import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import resource
import shlex
import shutil
import subprocess
import sys

from tracked_files import tracked_files

ROOT = pathlib.Path(os.path.abspath(sys.argv[1]))
BUILD = pathlib.Path(os.path.abspath(sys.argv[2]))
PART = sys.argv[3] if len(sys.argv) > 3 else ""
PRODUCT = ("core", "storage", "api", "server")
CHECKS = ROOT / ".clang-tidy"
# The compiler has its own warnings; some of its options clang does not know.
# Boost.Asio and libstdc++ believe that clang has no coroutines of the standard.
COROUTINES = ["__cpp_impl_coroutine=201902L", "BOOST_ASIO_HAS_CO_AWAIT=1", "BOOST_ASIO_HAS_STD_COROUTINE=1"]
OPTIONS = ["--quiet", "--extra-arg=-Wno-everything", f"-p={BUILD / 'tidy'}", *(f"--extra-arg=-D{name}" for name in COROUTINES),
           f"--header-filter=^{re.escape(str(ROOT))}/({'|'.join(PRODUCT)})/"]
PRECOMPILED = re.compile(r" -Winvalid-pch -include \S+")  # GCC's, which clang cannot read
# Template bodies that a unit does not need are not looked at, which spares most of the standard library's. Clang 14 cannot
# delay those of coroutines.
DELAYED = "--extra-arg=-fdelayed-template-parsing"
FINDING = re.compile(r"^(?P<file>/[^:\n]+|[^:\s]+):(?P<line>\d+):(?P<column>\d+): (?:warning|error|fatal error): "
                     r"(?P<text>.*) \[(?P<check>[\w.,-]+)\]$", re.M)


class Unit:
    """What is compiled as one: `sources` are the product's files among what the command names or the unity file includes."""

    def __init__(self, entry):
        self.path = pathlib.Path(entry["directory"], entry["file"])
        self.words = shlex.split(entry["command"])
        output = self.words[self.words.index("-o") + 1] if "-o" in self.words else ""
        self.object = pathlib.Path(entry["directory"], output)
        self.sources = [self.path]
        if self.path.parent.name == "Unity" and self.path.is_relative_to(BUILD):
            if not self.path.is_file():
                fail(f"{self.path} does not exist: configure and build first.")
            self.sources = [pathlib.Path(name) for name in re.findall(r'^#include "(.+)"', self.path.read_text(), re.M)]
        self.sources = [name for name in map(product_name, self.sources) if name]
        self.includes = []

    def size(self):
        """Bytes to read, a guess at the time it takes."""
        return sum(path.stat().st_size for path in self.includes if path.is_file())


def fail(message):
    print(message)
    sys.exit(1)


def product_name(path):
    """The path below ROOT of one of the product's files, and None for any other."""
    name = path.relative_to(ROOT).as_posix() if path.is_relative_to(ROOT) else ""
    return name if name.startswith(tuple(folder + "/" for folder in PRODUCT)) else None


def find_units():
    commands = BUILD / "compile_commands.json"
    if not commands.is_file():
        fail(f"{commands} does not exist: configure and build first, with Ninja or Makefiles.")
    entries = json.loads(commands.read_text())
    for entry in entries:
        entry["command"] = PRECOMPILED.sub("", entry["command"])
    (BUILD / "tidy").mkdir(exist_ok=True)
    (BUILD / "tidy" / "compile_commands.json").write_text(json.dumps(entries))
    units = [unit for unit in map(Unit, entries) if unit.sources]
    compiled = {name for unit in units for name in unit.sources}
    left_out = [name for name in tracked_files(ROOT, *PRODUCT) if name.endswith(".cc") and name not in compiled]
    if left_out:
        fail(f"{BUILD} compiles no {', '.join(left_out)}: configure and build first.")
    return [unit for unit in units if any(PART in name for name in unit.sources)]


def read_includes(units):
    """What each unit includes, itself too, as of its last compilation; nothing where Ninja cannot tell."""
    ninja = shutil.which("ninja")
    if ninja is None or not (BUILD / ".ninja_deps").is_file():
        return
    told = subprocess.run([ninja, "-C", str(BUILD), "-t", "deps"], capture_output=True, text=True)
    by_object = {}
    for entry in told.stdout.split("\n\n") if told.returncode == 0 else []:
        head, *names = entry.strip().splitlines() or [""]
        if "(VALID)" in head:
            by_object[BUILD / head.split(": #deps")[0]] = [BUILD / name.strip() for name in names]
    for unit in units:
        unit.includes = by_object.get(unit.object, [])


class Verdicts:
    """Which units are known to be clean: a file for each in BUILD/tidy, with its key."""

    def __init__(self, clang_tidy):
        version = subprocess.run([clang_tidy, "--version"], capture_output=True, text=True, check=True).stdout
        # Not the line that names the processor at hand.
        version = "\n".join(line for line in version.splitlines() if "version" in line)
        self.common = [version, " ".join(OPTIONS), self.digest(CHECKS), self.digest(pathlib.Path(__file__))]
        self.folder = BUILD / "tidy"
        self.digests = {}

    @staticmethod
    def digest(path):
        return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else "absent"

    def key(self, unit):
        for path in unit.includes:
            if path not in self.digests:
                self.digests[path] = self.digest(path)
        facts = [*self.common, *unit.words, str(unit.path), self.digest(unit.path)]
        facts += [f"{path} {self.digests[path]}" for path in unit.includes]
        return hashlib.sha256("\0".join(facts).encode()).hexdigest()

    def file(self, unit):
        return self.folder / hashlib.sha256(str(unit.path).encode()).hexdigest()

    def is_clean(self, unit):
        file = self.file(unit)
        return bool(unit.includes) and file.is_file() and file.read_text() == self.key(unit)

    def remember(self, unit):
        """Under the contents from before the look: what was changed meanwhile is younger than the object."""
        if not unit.includes or not unit.object.is_file():
            return
        compiled = unit.object.stat().st_mtime
        if all(path.is_file() and path.stat().st_mtime <= compiled for path in [unit.path, *unit.includes]):
            self.file(unit).write_text(self.key(unit))


def look_at(clang_tidy, unit):
    has_coroutines = any("co_await" in (ROOT / name).read_text() for name in unit.sources)
    options = OPTIONS if has_coroutines else [*OPTIONS, DELAYED]
    return subprocess.run([clang_tidy, *options, str(unit.path)], capture_output=True, text=True, cwd=BUILD)


def findings_in(unit, said):
    found = {(product_name(pathlib.Path(one["file"])) or one["file"], int(one["line"]), int(one["column"]), one["text"], one["check"])
             for one in FINDING.finditer(said.stdout)}
    if said.returncode != 0 and not found:
        words = (said.stderr or said.stdout).strip()[-2000:]
        found.add((str(unit.path), 0, 0, f"clang-tidy ended with {said.returncode}: {words}", "clang-tidy"))
    return found


def main():
    clang_tidy = shutil.which("clang-tidy") or shutil.which("clang-tidy-14")
    if clang_tidy is None:
        print("skipped: clang-tidy is not installed")
        sys.exit(77)
    units = find_units()
    if not units:
        fail(f"no source's name has {PART} in it.")
    read_includes(units)
    verdicts = Verdicts(clang_tidy)
    unknown = sorted((unit for unit in units if not verdicts.is_clean(unit)), key=Unit.size, reverse=True)
    findings = set()
    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        running = {pool.submit(look_at, clang_tidy, unit): unit for unit in unknown}
        for done in concurrent.futures.as_completed(running):
            found = findings_in(running[done], done.result())
            findings |= found
            if not found:
                verdicts.remember(running[done])
    place = None
    for name, line, _, text, check in sorted(findings):
        if place != (name, line):
            place = (name, line)
            print(f"{name}:{line}:")
        print(f"    {text} [{check}]")
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"{len(units)} units, {len(units) - len(unknown)} of them clean as before; {len(findings)} findings; "
          f"{used.ru_utime + used.ru_stime:.0f} s of processor time")
    sys.exit(1 if findings else 0)


main()
