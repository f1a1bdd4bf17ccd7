"""The package on a bare Debian 12: installed by apt, used as README says, installed anew, removed, purged.

The system has no systemd running, as in a container: what the unit says is then started by hand."""
import hashlib
import json
import math
import pathlib
import re
import shutil
import unittest

import bare_debian
from built_package import ROOT, WHY_NOT, built_package

REASON = WHY_NOT or bare_debian.why_not()

# As the unit starts it, and then the words of README in a folder with photos.
USE = r"""
set -e
setpriv --reuid skyquilt --regid skyquilt --init-groups --no-new-privs {start} > /tmp/server.log 2>&1 &
server=$!
for _ in $(seq 600); do curl -fsS http://127.0.0.1:8080/healthz >/dev/null 2>&1 && break; sleep 0.1; done
cd /home/card
{work}
kill -TERM $server
wait $server
"""
WAIT = r"""
for _ in $(seq 2400); do
  state=$(curl -fsS http://127.0.0.1:8080/api/v1/jobs/$(cat /home/card/job))
  case $state in *'"state":"successful"'*) break ;; *'"state":"failed"'*) echo "$state"; exit 1 ;; esac
  sleep 0.1
done
"""


def digests(folder):
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in folder.rglob("*") if path.is_file()}


@unittest.skipIf(REASON, REASON)
class Installed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.system = bare_debian.BareDebian()
        cls.addClassCleanup(cls.system.end)
        cls.root = cls.system.root
        shutil.copy(built_package(), cls.root / "root")
        cls.package = f"./{built_package().name}"
        cls.system.apt("update")
        cls.system.apt("install", "curl")

    def tearDown(self):
        self.system.run("dpkg", "--purge", "skyquilt", check=False)
        shutil.rmtree(self.root / "var/lib/skyquilt", ignore_errors=True)

    def install(self):
        return self.system.apt("install", f"/root/{self.package}")

    def installed_files(self):
        listed = self.system.run("dpkg", "-L", "skyquilt").split()
        return [path for path in listed if (self.root / path[1:]).is_file()]

    def start(self):
        unit = (self.root / "lib/systemd/system/skyquilt.service").read_text()
        return re.search(r"^ExecStart=(.*)$", unit, re.M)[1]

    def use(self, work):
        script = USE.format(start=self.start(), work=work)
        said = self.system.run("bash", "-c", script, alone=True, check=False)
        log = self.root / "tmp/server.log"
        return said + (log.read_text() if log.exists() else "")

    def test_from_apt_install_to_a_map_and_away_again(self):
        self.install()
        files = self.installed_files()
        self.assertIn("/usr/bin/skyquilt", files)
        data = self.root / "var/lib/skyquilt"
        user = self.system.run("getent", "passwd", "skyquilt")
        self.assertRegex(user, r"^skyquilt:x:\d+:\d+:.*:/var/lib/skyquilt:/usr/sbin/nologin")
        self.assertEqual((data.stat().st_mode & 0o777, data.stat().st_uid), (0o700, int(user.split(":")[2])))
        wants = self.root / "etc/systemd/system/multi-user.target.wants/skyquilt.service"
        self.assertTrue(wants.is_symlink())

        # README's own words, in a folder with a card's photos.
        readme = (ROOT / "README.md").read_text()
        curl = re.search(r"^photos=\(\);.*\ncurl -F name=beach .*flights$", readme, re.M)[0]
        self.system.run("skyquilt", "simulate", "-o", "/home/card", "--photos", "6", "--size", "640x480", "--no-world")
        (self.root / "home/card/DCIM").mkdir()
        (self.root / "home/card/photos").rename(self.root / "home/card/DCIM/100MEDIA")
        sent = digests(self.root / "home/card/DCIM")
        self.assertEqual(len(sent), 6)
        work = (f"({curl}) > answer\n"
                "grep -o '\"job\":{\"id\":\"[^\"]*' answer | head -1 | cut -d'\"' -f6 > job; test -s job\n" + WAIT +
                "curl -fsS http://127.0.0.1:8080/api/v1/flights > flights\n"
                "curl -fsS http://127.0.0.1:8080/ > page\n"
                "curl -fsS http://127.0.0.1:8080/vendor/maplibre-gl.mjs > library\n"
                "id=$(grep -o '\"id\":\"[^\"]*' flights | head -1 | cut -d'\"' -f4)\n"
                "curl -fsS http://127.0.0.1:8080/tiles/$id.json > tiles\n"
                "echo all went well\n")
        self.assertIn("all went well", self.use(work))
        card = self.root / "home/card"
        tiles = json.loads((card / "tiles").read_text())
        self.assertNotIn("preview", tiles["tiles"][0])
        self.assertEqual((card / "page").read_text(), (ROOT / "web/index.html").read_text())
        self.assertGreater((card / "library").stat().st_size, 100_000)
        flights = data / "flights"
        kept = digests(flights)
        self.assertEqual(set(sent.values()) - set(kept.values()), set())

        # The same package once more leaves a configuration that was changed, and the flights.
        config = self.root / "etc/skyquilt.conf"
        config.write_text(config.read_text() + "\ntrash-days = 7\n")
        self.system.apt("install", "--reinstall", f"/root/{self.package}")
        self.assertTrue(config.read_text().endswith("trash-days = 7\n"))
        self.assertEqual(digests(flights), kept)

        # Removed: nothing of the package is left but its configuration, and nothing of the user's is gone.
        self.system.apt("remove", "skyquilt")
        left = [path for path in files if (self.root / path[1:]).exists()]
        self.assertEqual(left, ["/etc/skyquilt.conf"])
        self.assertEqual(digests(flights), kept)

        # Purged: the configuration too; where the data lies is said.
        said = self.system.apt("purge", "skyquilt")
        self.assertFalse(config.exists())
        self.assertFalse(wants.is_symlink())
        self.assertIn("/var/lib/skyquilt are kept", said)
        self.assertEqual(digests(flights), kept)

        # Installed again it serves the same map.
        self.install()
        work = (f"curl -fsS http://127.0.0.1:8080/tiles/{flight_of(tiles)}.json > again\n"
                f"curl -fsS '{middle_tile(tiles)}' > tile\n"
                "echo all went well\n")
        self.assertIn("all went well", self.use(work))
        self.assertEqual(json.loads((card / "again").read_text()), tiles)
        tile = (card / "tile").read_bytes()
        self.assertTrue(tile.startswith((b"\xff\xd8\xff", b"\x89PNG")), tile[:20])
        self.assertGreater(len(tile), 2000)

    def test_without_flights_purging_leaves_nothing(self):
        before = everything(self.root)
        self.install()
        self.system.apt("purge", "skyquilt")
        self.assertFalse((self.root / "var/lib/skyquilt").exists())
        left = {path for path in everything(self.root) - before if "skyquilt" in path}
        self.assertEqual(left - {f"root/{built_package().name}"}, set())

    def test_a_data_folder_of_another_is_left_as_it_is(self):
        data = self.root / "var/lib/skyquilt"
        data.mkdir()
        (data / "note.txt").write_text("mine")
        self.install()
        self.assertIn("/var/lib/skyquilt are kept", self.system.apt("purge", "skyquilt"))
        self.assertEqual((data / "note.txt").read_text(), "mine")
        self.assertEqual(data.stat().st_uid, 0)


def flight_of(tiles):
    return re.search(r"/tiles/([^/]+)/", tiles["tiles"][0])[1]


def middle_tile(tiles):
    """The address of the finest tile in the middle of the map."""
    zoom = tiles["maxzoom"]
    lon_deg, lat_deg = tiles["center"][:2]
    column = int((lon_deg + 180) / 360 * 2**zoom)
    row = int((1 - math.asinh(math.tan(math.radians(lat_deg))) / math.pi) / 2 * 2**zoom)
    return tiles["tiles"][0].replace("{z}", str(zoom)).replace("{x}", str(column)).replace("{y}", str(row))


def everything(root):
    skipped = ("proc", "sys", "dev", "tmp", "var/cache", "var/log")
    return {name for name in (str(path.relative_to(root)) for path in pathlib.Path(root).rglob("*"))
            if not name.startswith(skipped)}
