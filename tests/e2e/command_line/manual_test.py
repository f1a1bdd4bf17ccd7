"""Manual pages and shell completions: all that --help lists is in them, and the shells and man take them as they are."""
import functools
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

from program import BINARY


def run(*command, text=None, **variables):
    done = subprocess.run(command, input=text, capture_output=True, text=True, timeout=120, env={**os.environ, **variables})
    assert done.returncode == 0, (command, done.stdout, done.stderr)
    return done.stdout


@functools.cache
def help_of(*path):
    return run(BINARY, *path, "--help")


def section(path, title):
    found = re.search(rf"^{title}:\n((?:  .*\n|\n(?=  ))*)", help_of(*path), re.M)
    return found[1] if found else ""


def commands_of(path=()):
    """All commands below one, as tuples of words."""
    names = re.findall(r"^  ([a-z][\w-]*)", section(path, "Subcommands"), re.M)
    below = [path + (name,) for name in names]
    return below + [deeper for one in below for deeper in commands_of(one)]


def options_of(path):
    """{name: words it takes, or None} of a command's options; flags have None."""
    options = {}
    for names, rest in re.findall(r"^  (-\S+)(.*)", section(path, "Options"), re.M):
        taken = re.match(r" (?:TEXT|ENUM):([a-z0-9_-]+(?:, [a-z0-9_-]+)* or [a-z0-9_-]+)\b", rest)
        words = re.split(r", | or ", taken[1]) if taken else None
        for name in re.sub(r"\{.*?\}", "", names).split(","):
            options[name] = words
    return options


ALL = [(), *commands_of()]
WITH_PAGE = [path for path in ALL if len(path) < 2]


def page_name(path):
    return "-".join(("skyquilt", *path))


class Completions(unittest.TestCase):
    def setUp(self):
        self.assertGreater(len(ALL), 20)
        self.assertIn(("token", "add"), ALL)
        self.assertEqual(options_of(("token", "add"))["--scope"], ["read", "upload", "admin"])
        self.assertGreater(sum(words is not None for path in ALL for words in options_of(path).values()), 10)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def script(self, shell):
        path = self.folder / "_skyquilt"
        path.write_text(run(BINARY, "completion", shell))
        return path

    def hold_against_help(self, answer):
        """`answer(words)`: what the shell proposes for the last of these words."""
        self.assertLessEqual({path[0] for path in ALL if len(path) == 1}, set(answer([""])))
        self.assertNotIn("stitch-sandboxed", answer([""]))
        self.assertEqual(set(answer(["token", ""])) - {"-h", "--help"}, {"add", "list", "revoke"})
        for path in ALL:
            options = options_of(path)
            proposed = set(answer([*path, "-"])) | set(answer([*path, "--"]))
            self.assertEqual({name for name in proposed if name.startswith("-")}, set(options), path)
            for name, words in options.items():
                if words is not None and name.startswith("--"):
                    self.assertEqual(answer([*path, name, ""]), words, (path, name))

    @unittest.skipUnless(shutil.which("bash"), "bash is not here")
    def test_bash_proposes_all_that_help_lists(self):
        script = self.script("bash")
        run("bash", "-n", str(script))
        loop = (f"source '{script}'; while IFS= read -r line; do read -ra COMP_WORDS <<<\"skyquilt $line\"; "
                "if [[ $line == '' || $line == *' ' ]]; then COMP_WORDS+=(''); fi; COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); "
                "COMPREPLY=(); _skyquilt; echo \"${COMPREPLY[*]}\"; done")

        def answer(words):
            return run("bash", "--norc", "-c", loop, text=" ".join(words) + "\n").split()

        self.hold_against_help(answer)
        self.assertEqual(answer(["token", "add", "--scope", "=", "ad"]), ["admin"])  # as bash splits --scope=ad
        self.assertEqual(answer(["completion", "z"]), ["zsh"])

    @unittest.skipUnless(shutil.which("fish"), "fish is not here")
    def test_fish_proposes_all_that_help_lists(self):
        script = self.script("fish")
        run("fish", "--no-config", "-n", str(script))

        def answer(words):
            said = run("fish", "--no-config", "-c", f"source {script}; complete -C 'skyquilt {' '.join(words)}'", HOME=str(self.folder))
            return [line.split("\t")[0] for line in said.splitlines()]

        everything = {path: set(answer([*path, "-"])) | set(answer([*path, "--"])) for path in ALL}
        for path in ALL:
            self.assertEqual({name for name in everything[path] if name.startswith("-")}, set(options_of(path)), path)
        self.assertLessEqual({path[0] for path in ALL if len(path) == 1}, set(answer([""])))
        self.assertEqual(sorted(answer(["token", "add", "--scope", ""])), ["admin", "read", "upload"])
        self.assertEqual(sorted(answer(["completion", ""])), ["bash", "fish", "zsh"])
        # A folder of the name of a command is not taken for it.
        self.assertIn("--listen", answer(["serve", "--data", "data", "--l"]))
        for path in ALL:
            for name, words in options_of(path).items():
                if words is not None and name.startswith("--"):
                    self.assertEqual(sorted(answer([*path, name, ""])), sorted(words), (path, name))

    @unittest.skipUnless(shutil.which("zsh"), "zsh is not here")
    def test_zsh_proposes_all_that_help_lists(self):
        script = self.script("zsh")
        run("zsh", "-f", "-n", str(script))
        # What each function tells _arguments, as zsh itself understands its quotes.
        told = "_arguments() { print -rl -- \"$@\" }; compdef() { }; "
        for path in ALL:
            function = "_".join(("_skyquilt", *path))
            specs = run("zsh", "-f", "-c", f"{told} source {script}; {function}").splitlines()
            options = {}
            for spec in specs:
                found = re.match(r"\*?(?:\([^)]*\))?(-[\w-]+)[=+]?\[.*?\](?::[^:]*:\((.*)\))?", spec)
                if found:
                    options[found[1]] = found[2].split() if found[2] else None
            options.pop("-C", None), options.pop("-s", None)
            self.assertEqual(options, options_of(path), path)

    @unittest.skipUnless(shutil.which("zsh"), "zsh is not here")
    def test_zsh_loads_it_as_a_completion(self):
        self.script("zsh")
        said = run("zsh", "-f", "-c", f"fpath=({self.folder} $fpath); autoload -U compinit; compinit -u -D; "
                                      "print $_comps[skyquilt]; autoload +X _skyquilt && print loaded")
        self.assertEqual(said.split(), ["_skyquilt", "loaded"])


class Pages(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        run(BINARY, "man", "--out", str(self.folder / "man1"), SOURCE_DATE_EPOCH="1700000000")
        self.pages = {path: self.folder / "man1" / f"{page_name(path)}.1" for path in WITH_PAGE}

    def test_there_is_a_page_for_each_command(self):
        self.assertEqual({path.name for path in (self.folder / "man1").iterdir()}, {page.name for page in self.pages.values()})
        for path, page in self.pages.items():
            self.assertEqual(run(BINARY, "man", *path, SOURCE_DATE_EPOCH="1700000000"), page.read_text())
            self.assertIn(" 1 2023-11-14 ", page.read_text())

    def test_all_that_help_lists_is_in_them(self):
        for path in ALL:
            text = self.pages[path[:1]].read_text().replace("\\-", "-")
            if len(path) == 2:
                part = re.search(rf"^\.SS skyquilt {' '.join(path)}\n(.*?)(?=^\.S[SH] )", text, re.M | re.S)
                self.assertIsNotNone(part, path)
                text = part[1]
            for name, words in options_of(path).items():
                paragraph = re.search(rf"^\.TP\n[^\n]*\\fB{name}\\fR.*?(?=^\.(?:TP|S[SH])|\Z)", text, re.M | re.S)
                self.assertIsNotNone(paragraph, (path, name))
                for word in words or []:
                    self.assertIn(f"\\fB{word}\\fR", paragraph[0], (path, name))
        serve = self.pages[("serve",)].read_text()
        for variable in re.findall(r"\(Env:(\w+)\)", help_of("serve")):
            self.assertIn(variable, serve)

    def test_what_help_says_below_the_options_is_in_them(self):
        place, data = (self.pages[(name,)].read_text().replace("\\-", "-") for name in ("place", "data"))
        self.assertRegex(place, r"(?ms)^\.SH EXAMPLES\n\.EX\n.*^skyquilt place map --gcp gcp_list\.txt$.*^\.EE$")
        self.assertIn("\nExit codes: 0 all is well, 1 it could not be checked, 2 there are differences.\n", data)

    def test_every_exit_code_is_in_them(self):
        for page in self.pages.values():
            codes = re.findall(r"^\.B (\d.*)$", page.read_text().split("\n.SH EXIT STATUS\n")[1], re.M)
            self.assertEqual(codes, ["0", "1", "2", "3", "64", "70", "104 to 114", "130"])

    @unittest.skipUnless(shutil.which("mandoc"), "mandoc is not here")
    def test_mandoc_has_nothing_to_say(self):
        for page in self.pages.values():
            self.assertEqual(run("mandoc", "-T", "lint", "-W", "warning", str(page)), "")

    @unittest.skipUnless(shutil.which("man") and shutil.which("groff"), "man and groff are not here")
    def test_man_shows_them_without_a_warning(self):
        for path, page in self.pages.items():
            done = subprocess.run(["man", "--warnings", "-E", "UTF-8", "-l", "-Tutf8", "-Z", str(page)], capture_output=True,
                                  text=True, env={**os.environ, "MANROFFSEQ": "", "MANWIDTH": "80", "LC_ALL": "C.UTF-8"})
            self.assertEqual((done.returncode, done.stderr), (0, ""), path)

    def test_a_command_that_does_not_exist_is_answered(self):
        done = subprocess.run([BINARY, "man", "stich"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 1)
        self.assertIn("Did you mean stitch?", done.stderr)

    def test_a_folder_that_cannot_be_written_is_said(self):
        (self.folder / "file").write_text("x")
        done = subprocess.run([BINARY, "man", "--out", str(self.folder / "file")], capture_output=True, text=True)
        self.assertEqual(done.returncode, 1)
        self.assertIn("cannot be written", done.stderr)
