"""The package on a bare Debian 12 whose systemd runs: the service starts by itself, makes a map within all that its unit
takes from it, comes back after a kill, and stops before it is removed."""
import json
import os
import re
import shutil
import time
import unittest

import bare_debian
from built_package import WHY_NOT, built_package

REASON = WHY_NOT or bare_debian.why_not()
# Every kind of process that the server confines by itself: a job, previews, an export, a verdict, an archive.
WORK = r"""
set -e
api=http://127.0.0.1:8080/api/v1
cd /root
skyquilt simulate -o card --photos 5 --size 640x480 --no-world >/dev/null
for photo in card/photos/*; do photos+=(-F "photo=@$photo"); done
id=$(curl -fsS -F name=beach "${photos[@]}" $api/flights | cut -d'"' -f6)
await() { for _ in $(seq 1200); do if curl -fsS "$1" | grep -q "$2"; then return; fi; sleep 0.1; done; curl -fsS "$1"; exit 1; }
await $api/flights '"revision":1,'
curl -fsS -H 'Content-Type: application/json' -d '{"format":"geotiff","crs":"utm"}' $api/flights/$id/exports >/dev/null
await $api/flights/$id/exports '"state":"successful"'
curl -fsS $api/flights/$id/verdict | grep '"photos_readable": 5'
tar cf more.tar card/photos
curl -fsS -T more.tar $api/flights/$id/files/ | grep -o 'SIM_0005(2).JPG' | head -1
echo all went well
"""


@unittest.skipUnless(os.environ.get("SKYQUILT_BOOT_TESTS") == "1", "boots a system: asked for by SKYQUILT_BOOT_TESTS=1")
@unittest.skipIf(REASON, REASON)
@unittest.skipUnless(shutil.which("nsenter"), "nsenter is not here")
class Service(unittest.TestCase):
    def state(self):
        return self.booted.run("systemctl", "is-active", "skyquilt", check=False).strip()

    def wait_for(self, is_so, what):
        end = time.monotonic() + 60
        while not is_so():
            if time.monotonic() > end:
                self.fail(f"{what}: " + self.booted.run("journalctl", "-u", "skyquilt", "-n", "30", "--no-pager", check=False))
            time.sleep(0.2)

    def main_pid(self):
        return int(self.booted.run("systemctl", "show", "-P", "MainPID", "skyquilt"))

    def answers(self):
        return self.booted.run("curl", "-s", "-o", "/dev/null", "-w", "%{http_code}", "http://127.0.0.1:8080/healthz", check=False) == "200"

    def test_it_lives_by_its_unit(self):
        system = bare_debian.BareDebian()
        self.addCleanup(system.end)
        shutil.copy(built_package(), system.root / "root")
        package = f"/root/{built_package().name}"
        system.apt("update")
        system.apt("install", "curl", "dbus", "systemd", "systemd-sysv")
        system.apt("install", "--download-only", package)  # the booted system has no network
        self.booted = bare_debian.Booted(system)
        self.addCleanup(self.booted.end)
        if not self.booted.started:
            self.skipTest("systemd does not start in namespaces here")

        self.booted.run("apt-get", "install", "-y", "--no-install-recommends", package)
        self.wait_for(self.answers, "the service does not answer after the installation")
        self.assertEqual(self.booted.run("systemctl", "is-enabled", "skyquilt").strip(), "enabled")
        pid = self.main_pid()
        self.assertRegex(self.booted.run("cat", f"/proc/{pid}/status"), r"NoNewPrivs:\s+1\n")
        self.assertEqual(self.booted.run("stat", "-c", "%U", f"/proc/{pid}").strip(), "skyquilt")
        self.assertIn("all went well", self.booted.run("bash", "-c", WORK))

        # A kill ends neither the service nor what it holds.
        self.booted.run("systemctl", "kill", "--kill-who=main", "--signal=KILL", "skyquilt")
        self.wait_for(lambda: self.main_pid() not in (0, pid) and self.answers(), "it does not come back")
        flights = json.loads(self.booted.run("curl", "-fsS", "http://127.0.0.1:8080/api/v1/flights"))["flights"]
        self.assertEqual([(flight["name"], flight["revision"]) for flight in flights], [("beach", 1)])

        # A stop is clean and quick; an administrator's word outlives a reinstallation.
        self.booted.run("systemctl", "disable", "--now", "skyquilt")
        log = self.booted.run("journalctl", "-u", "skyquilt", "--no-pager")
        self.assertRegex(log, r"Skyquilt is stopping")
        self.assertNotRegex(log, re.compile(r"timed out|Failed with result 'timeout'", re.I))
        self.booted.run("apt-get", "install", "-y", "--reinstall", package)
        self.assertEqual(self.booted.run("systemctl", "is-enabled", "skyquilt", check=False).strip(), "disabled")

        self.booted.run("systemctl", "start", "skyquilt")
        self.wait_for(self.answers, "it does not start again")
        self.booted.run("apt-get", "remove", "-y", "skyquilt")
        self.assertNotEqual(self.state(), "active")
        self.assertFalse(self.answers())
        self.assertNotIn("skyquilt\n", self.booted.run("sh", "-c", "cat /proc/[0-9]*/comm", check=False))
        self.assertIn("catalogue.db", self.booted.run("ls", "/var/lib/skyquilt"))
