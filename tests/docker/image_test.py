"""The container files without a container engine: the Dockerfile's steps are replayed as far as a plain Debian can,
against the binary that was built here; the compose file and nginx' configuration are linted."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

from nginx import NGINX, OPENSSL, free_port, http_of, start_nginx

ROOT = pathlib.Path(__file__).resolve().parents[2]
BINARY = pathlib.Path(os.environ.get("SKYQUILT_BINARY", ROOT / "build/release/bin/skyquilt")).resolve()


def instructions():
    """(word, rest) of the Dockerfile, lines joined, comments dropped."""
    text = (ROOT / "docker/Dockerfile").read_text()
    text = re.sub(r"^\s*#.*\n", "", text, flags=re.M)
    joined = re.sub(r"\\\n", " ", text)
    return [tuple(line.split(None, 1)) for line in joined.splitlines() if line.strip()]


def packages_of(sections):
    return subprocess.run([ROOT / "cmake/list_packages.sh", *sections], capture_output=True, text=True,
                          check=True).stdout.split()


class Image(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.addCleanup(self.scratch.cleanup)

    def test_every_package_that_is_installed_exists(self):
        if not shutil.which("apt-cache"):
            self.skipTest("not a Debian")
        wanted = set()
        for word, rest in instructions():
            for sections in re.findall(r"/packages/list_packages.sh ([a-z ]+)", rest) if word == "RUN" else []:
                wanted |= set(packages_of(sections.split()))
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

    def test_the_operators_key_goes_into_no_layer_and_no_commit(self):
        self.assertIn("docker/certs", (ROOT / "docker/Dockerfile.dockerignore").read_text().splitlines())
        self.assertIn("/docker/certs/", (ROOT / ".gitignore").read_text().splitlines())

    def test_what_the_binary_links_to_has_packages(self):
        if not shutil.which("readelf") or not shutil.which("dpkg"):
            self.skipTest("readelf and dpkg are not here")
        listed = next(rest for word, rest in instructions() if word == "RUN" and "readelf" in rest)
        pipeline = listed[listed.index("readelf"):].replace("/out/bin/skyquilt", str(BINARY))
        pipeline = pipeline.replace("/packages/", f"{ROOT}/cmake/")
        out = pathlib.Path(self.scratch.name, "packages.txt")
        subprocess.run(["sh", "-c", pipeline.replace("/out/packages.txt", str(out))], check=True, capture_output=True)
        packages = out.read_text().split()
        self.assertIn("libc6", packages)
        self.assertLessEqual({"libsqlite3-0", "libarchive13", "libgdal32", *packages_of(["run"])}, set(packages))
        # No library depends on it: without it every certificate of a store, a webhook's receiver or a server is refused.
        self.assertIn("ca-certificates", packages)

    def test_the_command_serves_with_a_token_and_the_health_check_sees_it(self):
        self.serve_as_the_image(None)

    def test_the_command_serves_everybody_where_a_variable_says_so(self):
        self.serve_as_the_image({"SKYQUILT_SERVE_OPEN": "true"})

    def serve_as_the_image(self, variables):
        command = json.loads(next(rest for word, rest in instructions() if word == "CMD"))
        check = json.loads(re.search(r"CMD (\[.*\])", next(rest for word, rest in instructions() if word == "HEALTHCHECK")).group(1))
        port = free_port()
        self.assertIn("0.0.0.0:8080", command)
        replayed = [word.replace("/data", self.scratch.name).replace(":8080", f":{port}") for word in command]
        self.assertEqual(replayed[0], "skyquilt")
        self.assertNotEqual(self.run_check(check, port), 0)
        # Nobody is let in who did not say so: with a token, or by the variable.
        refused = subprocess.run([str(BINARY), *replayed[1:]], capture_output=True, text=True, timeout=60)
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("token add", refused.stderr)
        if variables is None:
            subprocess.run([str(BINARY), "token", "add", "one", "--data", self.scratch.name], check=True, capture_output=True)
        server = subprocess.Popen([str(BINARY), *replayed[1:]], stdout=subprocess.PIPE, text=True, env={**os.environ, **(variables or {})})
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

    @unittest.skipUnless(NGINX and OPENSSL, "nginx and openssl are not here")
    def test_nginx_writes_no_token_down(self):
        ports = {80: free_port(), 443: free_port()}
        http = http_of("nginx.conf", self.scratch.name, ports, {"skyquilt": free_port()})
        nginx = start_nginx(self, self.scratch.name, ports[443], http)
        for scheme, inside in (("http", 80), ("https", 443)):
            subprocess.run(["curl", "-sk", "-o", "/dev/null", "-e", "https://localhost/?token=sq_secret",
                            f"{scheme}://127.0.0.1:{ports[inside]}/tiles/x/1/2/3?token=sq_secret"], check=True)
        nginx.terminate()
        nginx.wait(timeout=60)
        folder = pathlib.Path(self.scratch.name)
        # There is nothing behind it: what nginx says of that must not hold the token either.
        written = (folder / "access.log").read_text() + (folder / "error.log").read_text()
        self.assertEqual(written.count("/tiles/x/1/2/3"), 2, written)
        self.assertNotIn("sq_secret", written)
