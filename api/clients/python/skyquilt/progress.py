"""What a long call tells while it goes on."""
from __future__ import annotations

import dataclasses
from typing import Callable, Optional


@dataclasses.dataclass(frozen=True)
class Progress:
    """How far a long call is. `stage` is "upload", "waiting" (for a server that is away), "download", or the server's word for
    what a job does; `fraction` is 0 to 1 of the call, `message` a line for people."""

    stage: str
    fraction: float
    message: str = ""
    done_bytes: int = 0
    total_bytes: int = 0
    flight_id: Optional[str] = None


# Called from the thread that called. What it raises ends the call and passes through: that is how to cancel one.
OnProgress = Callable[[Progress], None]


def ignore(_: Progress) -> None:
    """Tells nobody."""


def megabytes(count: int) -> str:
    """For people."""
    return f"{count / 1e6:.1f} MB" if count < 100e6 else f"{count / 1e6:.0f} MB"
