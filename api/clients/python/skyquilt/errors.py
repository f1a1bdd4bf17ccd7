"""What can go wrong, each with a sentence that says what to do. Catch `SkyquiltError` for all of it."""
from __future__ import annotations

from typing import Any, Dict, Mapping, Optional, Type


class SkyquiltError(Exception):
    """Anything that this package raises by itself. `flight_id` is the flight that it was about, where there is one: what
    has been sent of it stays at the server, and `Client.upload(..., flight=flight_id)` goes on."""

    flight_id: Optional[str] = None


class InputError(SkyquiltError, ValueError):
    """What was asked for cannot be: no such file, no such kind of download, an address that is none."""


class ServerAway(SkyquiltError):
    """The server cannot be reached, or broke off, and did not come back within the client's patience."""


class NotASkyquilt(SkyquiltError):
    """Something answers at the address, but no Skyquilt."""


class JobFailed(SkyquiltError):
    """The map or the export could not be made. `code` is for programs, the message says why."""

    def __init__(self, message: str, code: str = "") -> None:
        super().__init__(message)
        self.code = code


class JobCancelled(SkyquiltError):
    """Somebody cancelled the job that was waited for."""


class Refused(SkyquiltError):
    """The server said no. The message is the server's own."""

    def __init__(self, status: int, problem: Mapping[str, Any]) -> None:
        self.status = status
        self.code = str(problem.get("code", ""))
        self.title = str(problem.get("title", ""))
        self.detail = str(problem.get("detail", "")) or self.title or f"The server answered {status}."
        self.request_id = str(problem.get("request_id", ""))
        self.problem: Dict[str, Any] = dict(problem)
        super().__init__(self.detail)


class BadRequest(Refused):
    """400: a request that the server does not understand."""


class Unauthorized(Refused):
    """401: the server asks for a token, or does not know this one."""


class Forbidden(Refused):
    """403: the token may not do this."""


class NotFound(Refused):
    """404: there is no such flight, job or file, or not for this token."""


class Conflict(Refused):
    """409: not while things are as they are; a job runs, a limit is reached."""


class TooLarge(Refused):
    """413: more than the server takes."""


class Unprocessable(Refused):
    """422: understood, but it cannot be; a file that is damaged, an option out of range."""


class TooMany(Refused):
    """429: too many requests for now."""


class OutOfSpace(Refused):
    """507: the server's disk or the token's quota is full."""


class ServerFailure(Refused):
    """5xx: the server failed. `request_id` finds it in its log."""


_BY_STATUS: Dict[int, Type[Refused]] = {
    400: BadRequest, 401: Unauthorized, 403: Forbidden, 404: NotFound, 409: Conflict, 413: TooLarge, 422: Unprocessable,
    429: TooMany, 507: OutOfSpace}


def refusal(status: int, problem: Mapping[str, Any]) -> Refused:
    """The error of an answer's status."""
    kind = _BY_STATUS.get(status, ServerFailure if status >= 500 else Refused)
    return kind(status, problem)
