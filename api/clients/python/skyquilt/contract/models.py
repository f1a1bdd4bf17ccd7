"""The documents that the server takes and answers.

Written by generate.py from api/openapi.json; changes belong there."""
from typing import Any, List, Optional, TypedDict

from .documents_1 import *  # noqa: F401,F403
from .documents_2 import *  # noqa: F401,F403


class JobLogAnswerEventsItem(TypedDict):
    seq: Any
    at: Any
    job: Any


class JobLogAnswer(TypedDict):
    events: List[JobLogAnswerEventsItem]


class ListJobsAnswer(TypedDict):
    jobs: List[Job]
    next_cursor: Optional[str]


class StartJobBody(TypedDict, total=False):
    options: JobOptions
    # Higher ones first; above 0 asks for scope admin. Among equals, those who asked take turns.
    priority: int


class BasemapAnswerPublicItem(TypedDict):
    name: str
    title: str
    tiles: List[str]
    # Plain text, not markup
    attribution: str
    maxzoom: int


class BasemapAnswerForSure(TypedDict):
    """What BasemapAnswer always has."""
    tilejson: str
    tiles: List[str]
    # What each browser may choose, where the operator left it to them
    public: List[BasemapAnswerPublicItem]


class BasemapAnswer(BasemapAnswerForSure, total=False):
    pmtiles: str
    # Plain text, not markup
    attribution: str
    # The last zoom that the tiles have
    maxzoom: int


class OpenNetworkAnswer(TypedDict):
    # Where other machines reach this server, the likeliest first
    addresses: List[str]


class VersionAnswer(TypedDict):
    name: str
    version: str
