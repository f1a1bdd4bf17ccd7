"""The lines of docs/tasks on a bare Debian 12 with the package and nothing else, as they stand: by a user who is not root, against
a server that is started as the page says."""
import os
import shutil
import subprocess
import unittest

import bare_debian
from built_package import WHY_NOT, built_package
from pages.tasks_test import TaskPages

REASON = WHY_NOT or bare_debian.why_not()
HOME = "home/pilot"
AS_PILOT = ["setpriv", "--reuid", "pilot", "--regid", "pilot", "--init-groups", "--no-new-privs",
            "env", f"HOME=/{HOME}", "bash", "-euo", "pipefail", "-c"]
SERVED = """
skyquilt serve --data data >server.log 2>&1 &
server=$!
for _ in $(seq 600); do curl -fsS http://127.0.0.1:8080/healthz >/dev/null 2>&1 && break; sleep 0.1; done
{text}
kill -TERM $server
wait $server
"""


@unittest.skipIf(REASON, REASON)
class InstalledTasks(TaskPages, unittest.TestCase):
    prints = has_gdalinfo = True

    @classmethod
    def setUpClass(cls):
        cls.system = bare_debian.BareDebian()
        cls.addClassCleanup(cls.system.end)
        shutil.copy(built_package(), cls.system.root / "root")
        recommended = subprocess.run(["dpkg-deb", "-f", built_package(), "Recommends"], check=True, capture_output=True, text=True).stdout
        cls.system.apt("update")
        # What apt brings along for a package, and what the pages' own lines ask for.
        cls.system.apt("install", f"/root/{built_package().name}", *(names.split("|")[0].strip() for names in recommended.split(",")), "curl", "gdal-bin")
        cls.system.run("useradd", "--create-home", "pilot")

    def setUp(self):
        self.folder = self.system.root / HOME / "card"
        self.folder.mkdir()
        self.addCleanup(shutil.rmtree, self.folder)

    def serve(self):
        return "served"

    def run_block(self, text, server=None):
        pilot = self.system.root / HOME
        for path in [self.folder, *self.folder.rglob("*")]:
            os.chown(path, pilot.stat().st_uid, pilot.stat().st_gid)
        lines = f"cd /{HOME}/card\n" + (SERVED.format(text=text) if server else text)
        said = self.system.run(*AS_PILOT, f"{lines}\necho all lines were run", alone=True, check=False)
        self.assertTrue(said.endswith("all lines were run\n"), f"{text}\n{said}")
        return said
