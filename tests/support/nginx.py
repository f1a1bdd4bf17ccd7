"""nginx as tests run it: Debian's, by the user of the test, with all its files in a folder of the test's own."""
import os
import pathlib
import re
import shutil
import socket
import subprocess
import time

NGINX = shutil.which("nginx") or shutil.which("nginx", path="/usr/sbin")
OPENSSL = shutil.which("openssl")
CONFIGURATIONS = pathlib.Path(__file__).resolve().parents[2] / "docker"
PATIENCE_S = 30


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def start_nginx(test, folder, port, http):
    """Runs nginx with this content of `http {}` until the test, or the class of tests, is over; its process, once it answers at this
    port."""
    kept = " ".join(f"{kind}_temp_path {folder}/{kind};" for kind in ("client_body", "proxy", "fastcgi", "uwsgi", "scgi"))
    user = "user root;" if os.geteuid() == 0 else ""
    file = pathlib.Path(folder, "nginx.conf")
    file.write_text(f"{user} daemon off; worker_processes 1; pid {folder}/pid; error_log {folder}/error.log;\n"
                    f"events {{ worker_connections 512; }}\nhttp {{\naccess_log off; {kept}\n{http}\n}}\n")
    nginx = subprocess.Popen([NGINX, "-c", file, "-p", folder, "-e", f"{folder}/error.log"], stderr=subprocess.DEVNULL)
    clean_up = test.addClassCleanup if isinstance(test, type) else test.addCleanup
    clean_up(lambda: (nginx.terminate(), nginx.wait(timeout=PATIENCE_S)))
    end = time.monotonic() + PATIENCE_S
    while True:
        try:
            socket.create_connection(("127.0.0.1", port)).close()
            return nginx
        except OSError:
            if time.monotonic() > end or nginx.poll() is not None:
                raise AssertionError("nginx does not start: " + pathlib.Path(folder, "error.log").read_text()) from None
            time.sleep(0.05)


def http_of(name, folder, ports, nodes):
    """A configuration of docker/ as this machine can run it: places and `ports` ({80: port, 443: port}) of the test's own, the ports
    of its `nodes` by their names, a new certificate, and HTTP/2 as Debian's older nginx says it."""
    subprocess.run([OPENSSL, "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "1", "-subj", "/CN=localhost",
                    "-keyout", f"{folder}/privkey.pem", "-out", f"{folder}/fullchain.pem"], check=True, capture_output=True)
    text = (CONFIGURATIONS / name).read_text().replace("  http2 on;\n", "")
    for there, here in (("/var/cache/nginx/tiles", "kept"), ("/etc/nginx/certs/", ""), ("/var/log/nginx/", "")):
        text = text.replace(there, f"{folder}/{here}")
    for node, port in nodes.items():
        text = text.replace(f"server {node}:8080;", f"server 127.0.0.1:{port};")
    for inside, outside in ports.items():
        text = text.replace(f"  listen {inside} ", f"  listen 127.0.0.1:{outside} ")
        text = re.sub(rf"  listen \[::\]:{inside} .*\n", "", text)
    return text
