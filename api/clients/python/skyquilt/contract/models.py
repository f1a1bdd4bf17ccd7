"""The documents that the server takes and answers.

Written by generate.py from api/openapi.json; changes belong there."""
from typing import List, TypedDict

from .documents_1 import *  # noqa: F401,F403
from .documents_2 import *  # noqa: F401,F403


class OpenNetworkAnswer(TypedDict):
    # Where other machines reach this server, the likeliest first
    addresses: List[str]


class VersionAnswer(TypedDict):
    name: str
    version: str
