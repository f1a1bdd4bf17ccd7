"""The Debian package as a file: what is in it, what it asks for, and what Debian's own tools say of it."""
import gzip
import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

from built_package import BUILD, ROOT, WHY_NOT, built_package, run

BINARY = os.environ.get("SKYQUILT_BINARY", str(ROOT / "build/release/bin/skyquilt"))


@unittest.skipIf(WHY_NOT, WHY_NOT)
@unittest.skipUnless(shutil.which("dpkg-deb") and shutil.which("cpack"), "dpkg and cpack are not here")
class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        scratch = tempfile.TemporaryDirectory()
        cls.addClassCleanup(scratch.cleanup)
        cls.package = built_package()
        cls.tree = pathlib.Path(scratch.name)
        run("dpkg-deb", "-R", cls.package, cls.tree)
        cls.files = {str(path.relative_to(cls.tree)) for path in cls.tree.rglob("*")
                     if not path.is_dir() and "DEBIAN" not in path.parts}

    def field(self, name):
        return run("dpkg-deb", "-f", self.package, name).strip()

    def test_all_parts_are_in_it(self):
        wanted = {"usr/bin/skyquilt", "lib/systemd/system/skyquilt.service", "etc/skyquilt.conf",
                  "usr/share/bash-completion/completions/skyquilt", "usr/share/zsh/vendor-completions/_skyquilt",
                  "usr/share/fish/vendor_completions.d/skyquilt.fish", "usr/share/man/man1/skyquilt.1.gz",
                  "usr/share/man/man1/skyquilt-serve.1.gz", "usr/share/doc/skyquilt/copyright",
                  "usr/share/doc/skyquilt/changelog.gz", "usr/share/doc/skyquilt/skyquilt.cdx.json"}
        self.assertEqual(wanted - self.files, set())
        for shell, path in (("bash", "bash-completion/completions/skyquilt"), ("zsh", "zsh/vendor-completions/_skyquilt")):
            self.assertEqual((self.tree / "usr/share" / path).read_text(), run(BINARY, "completion", shell))

    def test_the_page_is_whole(self):
        page = "usr/share/skyquilt/web/"
        shipped = {path.removeprefix(page) for path in self.files if path.startswith(page)}
        tracked = {str(path.relative_to(ROOT / "web")) for folder in ("src", "styles") for path in (ROOT / "web" / folder).rglob("*")
                   if path.suffix in (".js", ".css")}
        self.assertEqual(tracked - shipped, set())
        # The container's recipe names the same parts.
        named = re.search(r"cp -r (web/.*) /out/share", (ROOT / "docker/Dockerfile").read_text())[1].split()
        self.assertEqual({part.split("/")[1] for part in named}, {path.split("/")[0] for path in shipped})
        self.assertIn("vendor/maplibre-gl.mjs", shipped)
        self.assertEqual([path for path in shipped if path.endswith((".ts", ".mts"))], [])

    def test_it_asks_for_the_libraries_it_links_to(self):
        self.assertEqual(self.field("Package"), "skyquilt")
        depends = self.field("Depends")
        for package in ("libc6", "libgdal", "libopencv-core", "libsqlite3-0", "libpq5", "adduser", "proj-data"):
            self.assertRegex(depends, rf"\b{package}", package)
        self.assertNotIn("-dev", depends)
        project = re.search(r"project\(skyquilt VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text())[1]
        self.assertEqual(self.field("Version"), f"{project}-1")

    def test_the_program_is_stripped(self):
        if "__asan_init" in run("readelf", "-W", "--dyn-syms", BINARY):
            self.skipTest("a sanitizer's program")
        self.assertNotIn(".symtab", run("readelf", "-W", "-S", self.tree / "usr/bin/skyquilt"))
        self.assertLess(self.package.stat().st_size, 20e6)

    def test_the_configuration_has_only_options_of_serve(self):
        self.assertEqual((self.tree / "DEBIAN/conffiles").read_text(), "/etc/skyquilt.conf\n")
        text = (self.tree / "etc/skyquilt.conf").read_text()
        options = set(re.findall(r"--([a-z-]+)", run(BINARY, "serve", "--help")))
        named = re.findall(r"^(?:# )?([a-z-]+) = ", text, re.M)
        self.assertGreater(len(named), 8)
        self.assertEqual([name for name in named if name not in options], [])
        # As it is, the server starts with it and listens to its own machine alone.
        with tempfile.TemporaryDirectory() as data:
            config = pathlib.Path(data, "skyquilt.conf")
            config.write_text(text.replace("/var/lib/skyquilt\n", f"{data}/data\n", 1).replace("127.0.0.1:8080", "127.0.0.1:0"))
            server = subprocess.Popen([BINARY, "serve", "--config", config], stdout=subprocess.PIPE, text=True)
            self.assertIn("serving at http://127.0.0.1:", server.stdout.readline())
            server.terminate()
            self.assertEqual(server.wait(timeout=60), 0)
            server.stdout.close()

    def test_systemd_understands_the_unit(self):
        if not shutil.which("systemd-analyze"):
            self.skipTest("systemd-analyze is not here")
        unit = (self.tree / "lib/systemd/system/skyquilt.service").read_text()
        self.assertIn("ExecStart=/usr/bin/skyquilt serve --config /etc/skyquilt.conf\n", unit)
        place = self.tree / "checked/skyquilt.service"
        place.parent.mkdir(exist_ok=True)
        place.write_text(unit.replace("/usr/bin/skyquilt", BINARY))
        done = subprocess.run(["systemd-analyze", "verify", "--man=no", place], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))
        run("systemd-analyze", "security", "--offline=true", "--threshold=25", place)  # tenths of ten

    def test_it_says_what_it_is_made_of(self):
        told = json.loads((self.tree / "usr/share/doc/skyquilt/skyquilt.cdx.json").read_text())
        self.assertEqual((told["bomFormat"], told["specVersion"]), ("CycloneDX", "1.5"))
        components = {component["purl"]: component for component in told["components"] if "purl" in component}
        names = {component["name"] for component in components.values()}
        # What the package asks for is loaded or named by it, and what its page uses is what npm locked.
        asked = {entry.split()[0] for entry in re.split(r", ", self.field("Depends")) if "|" not in entry}
        self.assertEqual(asked - names - {"adduser", "init-system-helpers", "proj-data"}, set())
        locked = json.loads((ROOT / "web/package-lock.json").read_text())["packages"]
        for name in json.loads((ROOT / "web/package.json").read_text())["dependencies"]:
            component = components[f"pkg:npm/{name}@{locked['node_modules/' + name]['version']}"]
            self.assertEqual(len(component["hashes"][0]["content"]), 128)
        installed = run("dpkg-query", "-W", "-f", "${Version}", "libeigen3-dev")
        self.assertEqual(next(c["version"] for c in components.values() if c["name"] == "libeigen3-dev"), installed)
        references = {component["bom-ref"] for component in told["components"]} | {told["metadata"]["component"]["bom-ref"]}
        self.assertEqual(len(references), len(told["components"]) + 1)
        for entry in told["dependencies"]:
            self.assertLessEqual({entry["ref"], *entry["dependsOn"]}, references)

    def test_the_same_sources_make_the_same_lists(self):
        again = self.tree / "again.json"
        stamp = json.loads((self.tree / "usr/share/doc/skyquilt/skyquilt.cdx.json").read_text())["metadata"]["timestamp"]
        seconds = run("date", "-u", "-d", stamp, "+%s").strip()
        run("/usr/bin/python3", ROOT / "cmake/package/sbom.py", "--program", BINARY, "--version", self.field("Version").split("-")[0],
            "--lock", ROOT / "web/package-lock.json", "--out", again, env={**os.environ, "SOURCE_DATE_EPOCH": seconds})
        self.assertEqual(again.read_bytes(), (self.tree / "usr/share/doc/skyquilt/skyquilt.cdx.json").read_bytes())
        with gzip.open(self.tree / "usr/share/doc/skyquilt/changelog.gz") as changes:
            self.assertIn(b"Unreleased", changes.read())

    def test_lintian_has_nothing_to_say(self):
        if not shutil.which("lintian"):
            self.skipTest("lintian is not here")
        said = subprocess.run(["lintian", "--tag-display-limit", "0", "--fail-on", "error,warning", self.package],
                              capture_output=True, text=True)
        self.assertEqual((said.returncode, said.stdout), (0, ""), said.stderr)

    def test_an_install_from_source_keeps_a_configuration(self):
        with tempfile.TemporaryDirectory() as prefix:
            run("cmake", "--install", BUILD, "--prefix", prefix)
            config = pathlib.Path(prefix, "etc/skyquilt.conf")
            self.assertIn(f"ExecStart={prefix}/bin/skyquilt serve --config {config}\n",
                          pathlib.Path(prefix, "lib/systemd/system/skyquilt.service").read_text())
            config.write_text("listen = 127.0.0.1:1\n")
            run("cmake", "--install", BUILD, "--prefix", prefix)
            self.assertEqual(config.read_text(), "listen = 127.0.0.1:1\n")
            server = subprocess.Popen([f"{prefix}/bin/skyquilt", "serve", "--data", f"{prefix}/data", "--listen", "127.0.0.1:0"],
                                      stdout=subprocess.PIPE, text=True)
            port = re.search(r":(\d+)/", server.stdout.readline())[1]
            page = run("curl", "-sS", f"http://127.0.0.1:{port}/")
            server.terminate()
            server.wait(timeout=60)
            server.stdout.close()
            self.assertEqual(page, pathlib.Path(prefix, "share/skyquilt/web/index.html").read_text())
