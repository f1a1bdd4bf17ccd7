"""Other tile servers over the same tiles, for tiles_bench.py. Each is started where it is installed, answers on a port of
its own, and knows the addresses of the tiles: nginx (nginx-light) with the tiles as files, MapCache (libapache2-mod-mapcache,
apache2-bin), MapProxy (mapproxy, gunicorn), tileserver-gl-light (npm; its folder in SKYQUILT_TILESERVER_GL)."""
import gzip
import json
import os
import pathlib
import shutil
import socket
import sqlite3
import subprocess
import time
import urllib.error
import urllib.request

HALF_M = 20037508.342789244
LEVELS = 23

NGINX = """worker_processes 2; pid {folder}/nginx.pid; error_log stderr; daemon off; events {{ worker_connections 4096; }}
http {{ access_log off; sendfile on; tcp_nopush on; keepalive_requests 1000000; server {{ listen 127.0.0.1:{port}; root {folder}/tiles; }} }}"""

APACHE = """ServerRoot {folder}
ServerName localhost
PidFile {folder}/apache.pid
LoadModule mpm_event_module /usr/lib/apache2/modules/mod_mpm_event.so
LoadModule authz_core_module /usr/lib/apache2/modules/mod_authz_core.so
LoadModule mapcache_module /usr/lib/apache2/modules/mod_mapcache.so
Listen 127.0.0.1:{port}
User www-data
Group www-data
ErrorLog {folder}/apache.log
MaxKeepAliveRequests 0
KeepAliveTimeout 60
MapCacheAlias /mapcache "{folder}/mapcache.xml"
"""

MAPCACHE = """<mapcache>
 <grid name="drone"><extent>-{half} -{half} {half} {half}</extent><srs>EPSG:3857</srs><units>m</units><size>256 256</size>
  <resolutions>{resolutions}</resolutions></grid>
 <cache name="map" type="mbtiles"><dbfile>{mbtiles}</dbfile></cache>
 <tileset name="map"><cache>map</cache><grid>drone</grid><format>JPEG</format><metatile>1 1</metatile></tileset>
 <service type="tms" enabled="true"/>
 <errors>report</errors><lock_dir>{folder}</lock_dir>
</mapcache>
"""

MAPPROXY = """services: {{tms: {{use_grid_names: true}}}}
layers: [{{name: map, title: map, sources: [map]}}]
caches:
  map: {{grids: [drone], sources: [], format: image/jpeg, cache: {{type: mbtiles, filename: {mbtiles}}}}}
grids:
  drone: {{base: GLOBAL_WEBMERCATOR, num_levels: {levels}}}
globals: {{cache: {{base_dir: {folder}/mapproxy, lock_dir: {folder}/mapproxy/locks}}}}
"""


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def wait_for(url):
    end = time.monotonic() + 60
    while True:
        try:
            with urllib.request.urlopen(url) as answer:
                return answer.read()
        except (urllib.error.URLError, ConnectionError) as error:
            if time.monotonic() > end:
                raise AssertionError(f"{url} does not answer: {error}") from error
            time.sleep(0.2)


class Peer:
    """A running server: `pid` with its children, `url`, and `paths` of the tiles."""

    def __init__(self, name, arguments, port, paths, **options):
        self.name, self.port, self.paths = name, port, paths
        self.url = f"http://127.0.0.1:{port}"
        self.process = subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, **options)
        self.pid = self.process.pid

    def check(self, tiles):
        """It sends the very bytes (tileserver-gl-light gzips them); those that it does not send so are not asked for."""
        wait_for(self.url + self.paths[0])
        asked = []
        for path, (_, _, _, content) in zip(self.paths, tiles):
            try:
                with urllib.request.urlopen(self.url + path) as answer:
                    got = answer.read()
                    same = (gzip.decompress(got) if got[:2] == b"\x1f\x8b" else got) == content
            except urllib.error.HTTPError:
                same = False
            if same:
                asked.append(path)
        if len(asked) < len(tiles) / 2:
            raise AssertionError(f"{self.name} sends {len(asked)} of {len(tiles)} tiles as they are")
        self.paths = asked

    def stop(self):
        self.process.terminate()
        self.process.wait()


def plain_mbtiles(path, tiles):
    """With the tables that MapCache wants, and the view that the others read."""
    with sqlite3.connect(path) as db:
        db.executescript("CREATE TABLE metadata(name TEXT, value TEXT);"
                         "CREATE TABLE map(zoom_level INTEGER, tile_column INTEGER, tile_row INTEGER, tile_id TEXT);"
                         "CREATE TABLE images(tile_id TEXT, tile_data BLOB);"
                         "CREATE VIEW tiles AS SELECT map.zoom_level AS zoom_level, map.tile_column AS tile_column,"
                         " map.tile_row AS tile_row, images.tile_data AS tile_data FROM map JOIN images ON images.tile_id = map.tile_id;"
                         "CREATE UNIQUE INDEX map_index ON map(zoom_level, tile_column, tile_row);"
                         "CREATE UNIQUE INDEX images_index ON images(tile_id);")
        zooms = [zoom for zoom, _, _, _ in tiles]
        db.executemany("INSERT INTO metadata VALUES (?, ?)", [
            ("name", "map"), ("format", "jpg"), ("type", "baselayer"), ("version", "1"), ("description", ""),
            ("minzoom", str(min(zooms))), ("maxzoom", str(max(zooms))), ("bounds", "-180,-85,180,85")])
        for number, (zoom, column, row, content) in enumerate(tiles):
            db.execute("INSERT INTO map VALUES (?, ?, ?, ?)", (zoom, column, row, str(number)))
            db.execute("INSERT INTO images VALUES (?, ?)", (str(number), content))
    path.chmod(0o666)


def nginx(folder, tiles, _):
    for zoom, column, row, content in tiles:
        file = folder / "tiles" / f"{zoom}/{column}/{2**zoom - 1 - row}"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content)
    port = free_port()
    (folder / "nginx.conf").write_text(NGINX.format(folder=folder, port=port))
    paths = [f"/{zoom}/{column}/{2**zoom - 1 - row}" for zoom, column, row, _ in tiles]
    return Peer("nginx, static files", ["nginx", "-c", folder / "nginx.conf"], port, paths)


def mapcache(folder, tiles, mbtiles):
    port = free_port()
    resolutions = " ".join(repr(2 * HALF_M / 256 / 2**zoom) for zoom in range(LEVELS))
    (folder / "mapcache.xml").write_text(MAPCACHE.format(half=HALF_M, resolutions=resolutions, mbtiles=mbtiles, folder=folder))
    (folder / "apache.conf").write_text(APACHE.format(folder=folder, port=port))
    paths = [f"/mapcache/tms/1.0.0/map@drone/{zoom}/{column}/{row}.jpg" for zoom, column, row, _ in tiles]
    return Peer("MapCache, mbtiles", ["apache2", "-f", folder / "apache.conf", "-DFOREGROUND"], port, paths)


def mapproxy(folder, tiles, mbtiles):
    port = free_port()
    (folder / "mapproxy.yaml").write_text(MAPPROXY.format(mbtiles=mbtiles, levels=LEVELS, folder=folder))
    (folder / "mapproxy_app.py").write_text("from mapproxy.wsgiapp import make_wsgi_app\n"
                                            f"application = make_wsgi_app({str(folder / 'mapproxy.yaml')!r})\n")
    paths = [f"/tiles/map/drone/{zoom}/{column}/{row}.jpeg" for zoom, column, row, _ in tiles]
    return Peer("MapProxy, gunicorn 2x4", ["gunicorn", "-w", "2", "--threads", "4", "-b", f"127.0.0.1:{port}", "mapproxy_app:application"],
                port, paths, cwd=folder)


def tileserver_gl(folder, tiles, mbtiles):
    port = free_port()
    config = {"options": {"paths": {"root": str(folder), "mbtiles": str(folder)}}, "data": {"map": {"mbtiles": mbtiles.name}}, "styles": {}}
    (folder / "tileserver.json").write_text(json.dumps(config))
    paths = [f"/data/map/{zoom}/{column}/{2**zoom - 1 - row}.jpg" for zoom, column, row, _ in tiles]
    main = pathlib.Path(os.environ["SKYQUILT_TILESERVER_GL"]) / "src/main.js"
    return Peer("tileserver-gl-light", ["node", main, "-c", folder / "tileserver.json", "-b", "127.0.0.1", "-p", str(port)],
                port, paths, cwd=folder)


def start_all(folder, tiles):
    """(the peers that run, the names of those that are not here). `tiles`: zoom, column, row from the south, bytes."""
    mbtiles = folder / "plain.mbtiles"
    plain_mbtiles(mbtiles, tiles)
    folder.chmod(0o777)
    here = {
        nginx: shutil.which("nginx"),
        mapcache: shutil.which("apache2") and pathlib.Path("/usr/lib/apache2/modules/mod_mapcache.so").exists(),
        mapproxy: shutil.which("gunicorn") and shutil.which("mapproxy-util"),
        tileserver_gl: os.environ.get("SKYQUILT_TILESERVER_GL"),
    }
    peers, missing = [], [start.__name__ for start, is_here in here.items() if not is_here]
    for start, is_here in here.items():
        if not is_here:
            continue
        peer = start(folder, tiles, mbtiles)
        try:
            peer.check(tiles)
        except AssertionError as error:
            peer.stop()
            missing.append(f"{start.__name__} ({error})")
            continue
        peers.append(peer)
    return peers, missing
