"""The container files without a container engine: the Dockerfile's steps are replayed as far as a plain Debian can,
against the binary that was built here; the compose file and nginx' configuration are linted."""
import json
import os
import pathlib
import re
import shutil
import socket
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BINARY = pathlib.Path(os.environ.get("SKYQUILT_BINARY", ROOT / "build/release/bin/skyquilt")).resolve()


def instructions():
    """(word, rest) of the Dockerfile, lines joined, comments dropped."""
    text = (ROOT / "docker/Dockerfile").read_text()
    text = re.sub(r"^\s*#.*\n", "", text, flags=re.M)
    joined = re.sub(r"\\\n", " ", text)
    return [tuple(line.split(None, 1)) for line in joined.splitlines() if line.strip()]


class Image(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.addCleanup(self.scratch.cleanup)

    def test_every_package_that_is_installed_exists(self):
        if not shutil.which("apt-cache"):
            self.skipTest("not a Debian")
        wanted = set()
        for word, rest in instructions():
            for packages in re.findall(r"apt-get install -y --no-install-recommends ([a-z0-9.+ -]+)", rest) if word == "RUN" else []:
                wanted |= {name for name in packages.split() if not name.startswith("-")}
        self.assertGreater(len(wanted), 20)
        shown = subprocess.run(["apt-cache", "show", "--no-all-versions", *sorted(wanted)], capture_output=True, text=True).stdout
        known = set(re.findall(r"^Package: (\S+)", shown, re.M))
        if not known:
            self.skipTest("apt has no package lists")
        self.assertEqual(wanted - known, set())

    def test_every_file_that_is_copied_exists(self):
        for word, rest in instructions():
            if word != "COPY" or rest.startswith("--from"):
                continue
            for source in rest.split()[:-1]:
                self.assertTrue((ROOT / source).exists(), source)
        named = re.search(r"cp -r (web/.*) /out/share", (ROOT / "docker/Dockerfile").read_text()).group(1)
        for source in named.split():
            if source != "web/vendor":  # made by the step before
                self.assertTrue((ROOT / source).exists(), source)

    def test_what_the_binary_links_to_has_packages(self):
        if not shutil.which("readelf") or not shutil.which("dpkg"):
            self.skipTest("readelf and dpkg are not here")
        listed = next(rest for word, rest in instructions() if word == "RUN" and "readelf" in rest)
        pipeline = listed[listed.index("readelf"):].replace("/out/bin/skyquilt", str(BINARY))
        out = pathlib.Path(self.scratch.name, "packages.txt")
        subprocess.run(["sh", "-c", pipeline.replace("/out/packages.txt", str(out))], check=True, capture_output=True)
        packages = out.read_text().split()
        self.assertIn("libc6", packages)
        self.assertLessEqual({"libsqlite3-0", "libarchive13"}, set(packages))

    def test_the_command_serves_and_the_health_check_sees_it(self):
        command = json.loads(next(rest for word, rest in instructions() if word == "CMD"))
        check = json.loads(re.search(r"CMD (\[.*\])", next(rest for word, rest in instructions() if word == "HEALTHCHECK")).group(1))
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        replayed = [word.replace("/data", self.scratch.name).replace("0.0.0.0:8080", f"127.0.0.1:{port}") for word in command]
        self.assertEqual(replayed[0], "skyquilt")
        self.assertNotEqual(self.run_check(check, port), 0)
        server = subprocess.Popen([str(BINARY), *replayed[1:]], stdout=subprocess.PIPE, text=True)
        try:
            self.assertIn("serving at", server.stdout.readline())
            self.assertEqual(self.run_check(check, port), 0)
        finally:
            server.terminate()
            self.assertEqual(server.wait(timeout=60), 0)
            server.stdout.close()

    def run_check(self, check, port):
        return subprocess.run([word.replace("/8080", f"/{port}") for word in check], capture_output=True).returncode

    def test_the_image_runs_as_nobody_special(self):
        users = [rest.strip() for word, rest in instructions() if word == "USER"]
        self.assertEqual(users, ["skyquilt"])
        last_stage = max(i for i, (word, _) in enumerate(instructions()) if word == "FROM")
        self.assertTrue(any(word == "USER" for word, _ in instructions()[last_stage:]))

    def test_the_compose_file_is_sound(self):
        try:
            import yaml
        except ImportError:
            self.skipTest("python3-yaml is not here")
        compose = yaml.safe_load((ROOT / "docker/compose.yaml").read_text())
        self.assertLessEqual(set(compose), {"services", "volumes", "name", "networks"})
        known = {"build", "image", "restart", "volumes", "read_only", "tmpfs", "cap_drop", "security_opt", "mem_limit",
                 "stop_grace_period", "expose", "depends_on", "ports", "environment", "command"}
        for name, service in compose["services"].items():
            self.assertLessEqual(set(service), known, name)
            for volume in service.get("volumes", []):
                source = volume.split(":")[0]
                if source.startswith("./") and source != "./certs":  # the operator's own
                    self.assertTrue((ROOT / "docker" / source).exists(), source)
                elif not source.startswith("."):
                    self.assertIn(source, compose["volumes"])
            for needed in service.get("depends_on", {}):
                self.assertIn(needed, compose["services"])
        built = compose["services"]["skyquilt"]["build"]
        self.assertTrue((ROOT / "docker" / built["context"] / built["dockerfile"]).exists())
        self.assertNotIn("ports", compose["services"]["skyquilt"])  # only nginx is reached from outside

    def test_nginx_understands_its_configuration(self):
        if not shutil.which("nginx") or not shutil.which("openssl"):
            self.skipTest("nginx and openssl are not here")
        folder = pathlib.Path(self.scratch.name)
        subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "1", "-subj", "/CN=localhost",
                        "-keyout", folder / "privkey.pem", "-out", folder / "fullchain.pem"], check=True, capture_output=True)
        text = (ROOT / "docker/nginx.conf").read_text().replace("/etc/nginx/certs", str(folder)).replace("skyquilt:8080", "127.0.0.1:8080")
        # Debian's nginx is older than the image's and says HTTP/2 another way.
        text = text.replace("  http2 on;\n", "")
        config = folder / "nginx.conf"
        config.write_text(f"pid {folder}/pid; error_log stderr; events {{}} http {{ access_log off; {text} }}")
        said = subprocess.run(["nginx", "-t", "-c", config], capture_output=True, text=True)
        self.assertEqual(said.returncode, 0, said.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
