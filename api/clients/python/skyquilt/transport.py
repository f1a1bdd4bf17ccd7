"""Requests to a server over HTTP: connections that are kept, proxies, patience with a server that is away, and answers as
values or errors. By the standard library alone, so that the package can be put into other programs as it is.

Threads: one `Transport` may be used by several; each has its own connection."""
from __future__ import annotations

import base64
import http.client
import json
import random
import socket
import ssl
import threading
import time
import urllib.parse
import urllib.request
from typing import Any, BinaryIO, Callable, Dict, Mapping, Optional, Tuple, Union

from .errors import InputError, NotASkyquilt, Refused, ServerAway, refusal

Body = Union[bytes, BinaryIO]
Waiting = Callable[[str], None]
RETRIED = (408, 429, 502, 503, 504)
LONGEST_PAUSE_S = 15.0
BLOCK_BYTES = 1 << 16
LARGEST_PROBLEM_BYTES = 1 << 20


class BrokenOff(ServerAway):
    """An answer that ended before all of it was there."""

    def __init__(self, why: str) -> None:
        super().__init__(f"The connection broke within an answer: {why}.")


class Answer:
    """An answer whose body is still to be read; `with` it, or close it."""

    def __init__(self, response: http.client.HTTPResponse, release: Callable[[bool], None]) -> None:
        self._response, self._release = response, release
        self.status = response.status
        self.headers = response.headers

    def read(self, amount: Optional[int] = None) -> bytes:
        """At most `amount` bytes of the body, or all that is left; b"" at its end. Raises `BrokenOff`."""
        try:
            return self._response.read(amount)
        except (OSError, http.client.HTTPException) as error:
            self._release(False)
            raise BrokenOff(_in_words(error)) from error

    def read_all(self) -> bytes:
        """All of the body that is left. Raises `BrokenOff`."""
        return self.read()

    def close(self) -> None:
        """Gives the connection back. One with an unread rest is closed."""
        self._release(self._response.isclosed())

    def __enter__(self) -> Answer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class Transport:
    """Where a server is, and how it is talked to. `patience_s`: for how long a request is tried again while the server is
    away (refused, broken off, 408, 429, 502, 503, 504); `on_waiting` is told, with a sentence, before each pause."""

    def __init__(self, url: str, token: Optional[str] = None, *, patience_s: float = 5.0, timeout_s: float = 60.0,
                 context: Optional[ssl.SSLContext] = None) -> None:
        try:
            parts = urllib.parse.urlsplit(url.strip())
            is_address = parts.scheme in ("http", "https") and bool(parts.hostname) and parts.port != 0
        except ValueError:  # of a port, or of brackets
            is_address = False
        if not is_address:
            raise InputError(f"{url!r} is no address of a server; one looks like http://127.0.0.1:8080.")
        if parts.query or parts.fragment:
            raise InputError(f"{url!r} has more than the address of a server; leave out what follows ? and #.")
        self.url = url.strip().rstrip("/")
        self.token = (token or "").strip() or None  # one that was read from a file ends with its line
        self.patience_s = patience_s
        self.on_waiting: Optional[Waiting] = None
        self._parts, self._timeout_s, self._context = parts, timeout_s, context
        self._kept = threading.local()

    def patient(self, patience_s: float, on_waiting: Optional[Waiting] = None) -> Transport:
        """The same server with another patience."""
        other = Transport(self.url, self.token, patience_s=patience_s, timeout_s=self._timeout_s, context=self._context)
        other.on_waiting, other._kept = on_waiting, self._kept
        return other

    def request(self, method: str, path: str, *, body: Optional[Body] = None, headers: Optional[Mapping[str, str]] = None,
                is_repeatable: Optional[bool] = None) -> Answer:
        """One request, tried again within the patience where that does no harm. `path` is quoted already. Raises
        `ServerAway`, or `Refused` and its kinds for every status above 399."""
        sent = {"Accept": "application/json, */*", "User-Agent": "skyquilt-python", **(headers or {})}
        if self.token:
            sent["Authorization"] = f"Bearer {self.token}"
        if is_repeatable is None:
            is_repeatable = method != "POST" or "Idempotency-Key" in sent
        patience = Patience(self)
        while True:
            if not is_repeatable:
                self.forget()  # a kept connection may have ended meanwhile, which cannot be told from a lost answer
            try:
                return self._once(method, path, body, sent)
            except ConnectionRefusedError as error:  # nothing was sent
                patience.wait(self._away(error), error)
            except (OSError, http.client.HTTPException) as error:
                if isinstance(error, ssl.SSLCertVerificationError):
                    raise ServerAway(f"The certificate of {self.url} is not trusted: {error.verify_message}.") from error
                if not is_repeatable or not isinstance(body, (bytes, type(None))):
                    raise ServerAway(self._away(error)) from error
                patience.wait(self._away(error), error)
            except Refused as error:
                if error.status not in RETRIED or not isinstance(body, (bytes, type(None))):
                    raise
                patience.wait(str(error), error)

    def _away(self, error: BaseException) -> str:
        if isinstance(error, ConnectionRefusedError):
            return f"Nothing answers at {self.url}. Does the server run there?"
        if isinstance(error, socket.gaierror):
            return f"There is no computer called {self._parts.hostname}, or the network is away."
        if isinstance(error, socket.timeout):  # TimeoutError from Python 3.10 on
            return f"{self.url} did not answer within {self._timeout_s:.0f} s."
        return f"The connection to {self.url} broke: {_in_words(error)}."

    def _once(self, method: str, path: str, body: Optional[Body], headers: Mapping[str, str]) -> Answer:
        connection, prefix = self._take()

        def release(is_read: bool) -> None:
            if is_read and getattr(self._kept, "connection", None) is None:
                self._kept.connection = (connection, prefix)
            else:
                connection.close()

        try:
            return self._answer(connection, prefix, method, path, body, headers, release)
        except Refused:
            raise
        except BaseException:  # a body that could not be read, or was no longer wanted, leaves half a request behind
            connection.close()
            raise

    def _answer(self, connection: http.client.HTTPConnection, prefix: str, method: str, path: str, body: Optional[Body],
                headers: Mapping[str, str], release: Callable[[bool], None]) -> Answer:
        target = f"{prefix}{self._parts.path.rstrip('/')}{path}"
        if prefix:
            headers = {**headers, **_credentials_of(self._proxy())}
        try:
            connection.request(method, target, body=body, headers=dict(headers))
        except (BrokenPipeError, ConnectionResetError):
            # A refusal may come before all was sent; it says more than the break does.
            try:
                response = connection.getresponse()
            except (OSError, http.client.HTTPException):
                response = None
            if response is None or response.status < 400:
                raise
            release = _closing(connection)  # half a request is of no use to another
        else:
            response = connection.getresponse()
        answer = Answer(response, release)
        if response.status in (301, 302, 307, 308):
            answer.close()
            raise InputError(f"{self.url} says that it is elsewhere: {response.headers.get('Location')}. Use that address.")
        if response.status < 400:
            return answer
        with answer:
            content = response.read(LARGEST_PROBLEM_BYTES)
        raise _refusal_of(response, content)

    def _take(self) -> Tuple[http.client.HTTPConnection, str]:
        """A connection, and what stands before the path where a proxy is asked: the one that this thread kept, unless an answer
        of it is still being read."""
        kept: Optional[Tuple[http.client.HTTPConnection, str]] = getattr(self._kept, "connection", None)
        self._kept.connection = None
        return kept or self._connect()

    def _connect(self) -> Tuple[http.client.HTTPConnection, str]:
        is_secure = self._parts.scheme == "https"
        host, port = self._parts.hostname or "", self._parts.port or (443 if is_secure else 80)  # else ::5 would name port 5
        context = self._context or (ssl.create_default_context() if is_secure else None)
        by = self._proxy()
        if by is None:
            if is_secure:
                return http.client.HTTPSConnection(host, port, timeout=self._timeout_s, context=context, blocksize=BLOCK_BYTES), ""
            return http.client.HTTPConnection(host, port, timeout=self._timeout_s, blocksize=BLOCK_BYTES), ""
        if is_secure:
            through = http.client.HTTPSConnection(by.hostname or "", by.port or 8080, timeout=self._timeout_s, context=context)
            through.set_tunnel(host, port, headers=_credentials_of(by))
            return through, ""
        return (http.client.HTTPConnection(by.hostname or "", by.port or 8080, timeout=self._timeout_s),
                f"http://{self._parts.netloc}")

    def _proxy(self) -> Optional[urllib.parse.SplitResult]:
        """The proxy that this machine's settings name for the server."""
        proxy = urllib.request.getproxies().get(self._parts.scheme)
        if not proxy or urllib.request.proxy_bypass(self._parts.hostname or ""):
            return None
        return urllib.parse.urlsplit(proxy if "://" in proxy else f"http://{proxy}")

    def forget(self) -> None:
        """Closes the connection that this thread keeps; the next request makes another."""
        kept = getattr(self._kept, "connection", None)
        if kept is not None:
            kept[0].close()
            self._kept.connection = None


class Patience:
    """How long is still waited for a server that is away. Progress restarts it: call `succeeded`."""

    def __init__(self, transport: Transport) -> None:
        self._transport = transport
        self.succeeded()

    def succeeded(self) -> None:
        """The server is there."""
        self._end, self._pause_s = time.monotonic() + self._transport.patience_s, 0.25

    def wait(self, why: str, error: Exception) -> None:
        """A pause, as long as the server asks for; or raises what it was, once the patience is at its end."""
        pause = max(self._pause_s * random.uniform(0.75, 1.25), _retry_after_s(error))
        if time.monotonic() + pause > self._end:
            if isinstance(error, (Refused, ServerAway)):
                raise error
            raise ServerAway(why) from error
        if self._transport.on_waiting is not None:
            self._transport.on_waiting(f"{why} Tried again in {pause:.0f} s." if pause >= 1 else why)
        time.sleep(pause)
        self._pause_s = min(2 * self._pause_s, LONGEST_PAUSE_S)


def _closing(connection: http.client.HTTPConnection) -> Callable[[bool], None]:
    return lambda _: connection.close()


def _credentials_of(proxy: Optional[urllib.parse.SplitResult]) -> Dict[str, str]:
    """What a proxy of the form http://NAME:PASSWORD@HOST:PORT is to be told."""
    if proxy is None or proxy.username is None:
        return {}
    said = urllib.parse.unquote(f"{proxy.username}:{proxy.password or ''}")
    return {"Proxy-Authorization": "Basic " + base64.b64encode(said.encode()).decode()}


def _in_words(error: BaseException) -> str:
    return str(error) or type(error).__name__


def _retry_after_s(error: Exception) -> float:
    seconds = error.problem.get("retry_after_s") if isinstance(error, Refused) else None
    return float(seconds) if isinstance(seconds, (int, float)) else 0.0


def _refusal_of(response: http.client.HTTPResponse, content: bytes) -> Refused:
    try:
        problem = json.loads(content) if content else {}
    except ValueError:
        problem = {}
    if not isinstance(problem, dict):
        problem = {}
    after = response.headers.get("Retry-After", "")
    if after.isdigit():
        problem = {**problem, "retry_after_s": min(int(after), 3600)}
    return refusal(response.status, problem)


class Calls:
    """What the operations of the contract are made of."""

    def __init__(self, transport: Transport) -> None:
        self.transport = transport

    def _send(self, method: str, path_template: str, *, path: Optional[Mapping[str, object]] = None,
              query: Optional[Mapping[str, object]] = None, headers: Optional[Mapping[str, object]] = None,
              json_body: Any = None, body: Optional[Body] = None) -> Any:
        """The document that the server answers, or None."""
        said: Dict[str, object] = dict(headers or {})
        if json_body is not None:
            body, said["Content-Type"] = json.dumps(json_body).encode(), "application/json"
        with self._stream(method, path_template, path=path, query=query, headers=said, body=body) as answer:
            content = answer.read_all()
        if not content or answer.status == 204:
            return None
        try:
            return json.loads(content)
        except ValueError as error:
            raise NotASkyquilt(f"What answers at {self.transport.url} is no Skyquilt: it speaks no JSON.") from error

    def _stream(self, method: str, path_template: str, *, path: Optional[Mapping[str, object]] = None,
                query: Optional[Mapping[str, object]] = None, headers: Optional[Mapping[str, object]] = None,
                body: Optional[Body] = None) -> Answer:
        """The answer, its body unread."""
        said = {name: str(value) for name, value in (headers or {}).items() if value is not None}
        if body is not None:
            said.setdefault("Content-Type", "application/octet-stream")
        return self.transport.request(method, target_of(path_template, path or {}, query or {}), body=body, headers=said)


def target_of(template: str, path: Mapping[str, object], query: Mapping[str, object]) -> str:
    """A path of the contract with its parameters, quoted."""
    for name, value in path.items():
        template = template.replace("{" + name + "}", urllib.parse.quote(str(value), safe=""))
    given = {name: value for name, value in query.items() if value is not None}
    return template + ("?" + urllib.parse.urlencode(given) if given else "")
