"""A proxy before a store of objects: it holds every request's signature against its own reckoning (Signature Version 4,
independently of the program), counts what is asked for, and fails as it is told."""
import hashlib
import hmac
import http.client
import http.server
import random
import threading
import time
import urllib.parse


def signature_of(method, path, query, headers, names, payload, scope, stamp, secret):
    """As Amazon's documents have it."""
    pairs = sorted(tuple(part.partition("=")[::2]) for part in query.split("&") if part)
    canonical = "\n".join([
        method, urllib.parse.quote(urllib.parse.unquote(path), safe="/-_.~"),
        "&".join(f"{name}={value}" for name, value in pairs),
        *(f"{name}:{' '.join(headers[name].split())}" for name in names), "", ";".join(names), payload])
    to_sign = "\n".join(["AWS4-HMAC-SHA256", stamp, scope, hashlib.sha256(canonical.encode()).hexdigest()])
    key = f"AWS4{secret}".encode()
    for part in scope.split("/"):
        key = hmac.new(key, part.encode(), hashlib.sha256).digest()
    return hmac.new(key, to_sign.encode(), hashlib.sha256).hexdigest()


class StoreProxy:
    """`fails` and `stalls`: shares of requests; half of those that fail are carried out, and only their answer is lost."""

    def __init__(self, port, secret, fails=0.0, stalls=0.0, stall_s=30, seed=1):
        self.to_port, self.secret, self.fails, self.stalls, self.stall_s = port, secret, fails, stalls, stall_s
        self.random, self.lock = random.Random(seed), threading.Lock()
        self.asked, self.forged, self.faults = [], [], 0
        self.is_cut = threading.Event()  # set: connections break without a word
        self.harm = None  # what it makes of the bytes of a range goes out instead, as if they were right
        self.spoil = None  # what it makes of the bytes of any object goes out instead; of None, half of them and then nothing
        self.slow_s = {}  # how late answers to a method are
        self.held = threading.Event()  # set: nothing is answered with more than a body's first half
        proxy = self

        class Handler(http.server.BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def handle_one(self):
                proxy.handle(self)

            do_GET = do_PUT = do_POST = do_DELETE = do_HEAD = handle_one

            def log_message(self, *_):
                pass

        class Quiet(http.server.ThreadingHTTPServer):
            daemon_threads = True
            request_queue_size = 64

            def handle_error(self, *_):
                """Clients hang up on what stalls."""

        self.server = Quiet(("127.0.0.1", 0), Handler)
        self.endpoint = f"http://127.0.0.1:{self.server.server_port}"
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def handle(self, handler):
        length = int(handler.headers.get("Content-Length", 0))
        body = handler.rfile.read(length)
        if len(body) < length or self.is_cut.is_set():  # whoever sent it was killed, or the network is
            handler.close_connection = True
            return None
        path, _, query = handler.path.partition("?")
        is_genuine = self.is_genuine(handler, path, query, body)
        with self.lock:
            self.asked.append((handler.command, urllib.parse.unquote(path), query, handler.headers.get("Range")))
            if not is_genuine:
                self.forged.append(handler.path)
            chance = self.random.random()
            is_lost, is_refused = chance < self.fails / 2, chance < self.fails
            stalls = self.fails <= chance < self.fails + self.stalls
            self.faults += is_refused or stalls
        if not is_genuine:
            return self.answer(handler, 403, {}, b"<Error><Code>SignatureDoesNotMatch</Code></Error>")
        if stalls:
            time.sleep(self.stall_s)
        if is_refused and not is_lost:
            return self.answer(handler, 503, {}, b"<Error><Code>SlowDown</Code></Error>")
        connection = http.client.HTTPConnection("127.0.0.1", self.to_port, timeout=60)
        headers = {name: value for name, value in handler.headers.items() if name.lower() not in ("host", "connection")}
        connection.request(handler.command, handler.path, body=body, headers=headers)
        response = connection.getresponse()
        content = response.read()
        connection.close()
        if is_lost:
            return self.answer(handler, 500, {}, b"<Error><Code>InternalError</Code></Error>")
        time.sleep(self.slow_s.get(handler.command, 0))
        if self.spoil and handler.command == "GET" and response.status in (200, 206) and not query:
            spoilt = self.spoil(path, content)
            if spoilt is None:
                handler.close_connection = True
                return self.answer(handler, response.status, dict(response.headers), content, content[:len(content) // 2])
            content = spoilt
        if self.harm and handler.command == "GET" and "Range" in handler.headers:
            content = self.harm(path, content)
        return self.answer(handler, response.status, dict(response.headers), content)

    def answer(self, handler, status, headers, content, sent=None):
        handler.send_response_only(status)
        length = headers.get("content-length") or headers.get("Content-Length")
        for name, value in headers.items():
            if name.lower() not in ("content-length", "transfer-encoding", "connection"):
                handler.send_header(name, value)
        handler.send_header("Content-Length", length if handler.command == "HEAD" and length else str(len(content)))
        handler.end_headers()
        if handler.command != "HEAD":
            handler.wfile.write(content if sent is None else sent)

    def is_genuine(self, handler, path, query, body):
        said = handler.headers.get("Authorization", "")
        if not said.startswith("AWS4-HMAC-SHA256 "):
            return False
        parts = dict(part.strip().split("=", 1) for part in said.split(" ", 1)[1].split(","))
        headers = {name.lower(): value for name, value in handler.headers.items()}
        payload = headers["x-amz-content-sha256"]
        names = parts["SignedHeaders"].split(";")
        wanted = signature_of(handler.command, path, query, headers, names, payload, parts["Credential"].split("/", 1)[1],
                              headers["x-amz-date"], self.secret)
        is_all_signed = all(name in names for name in headers if name == "host" or name.startswith("x-amz-"))
        return wanted == parts["Signature"] and payload == hashlib.sha256(body).hexdigest() and is_all_signed

    def reads_of(self, part):
        """How many times bytes of keys with this in them were asked for."""
        with self.lock:
            return sum(1 for method, path, query, _ in self.asked if method == "GET" and part in path and not query)

    def stop(self):
        self.server.shutdown()
        self.server.server_close()
