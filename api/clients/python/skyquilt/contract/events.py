"""What happens, as it happens.

Written by generate.py from api/openapi.json; changes belong there."""
from typing import Mapping, Optional, cast

from . import models
from ..transport import Calls, Answer


class Events(Calls):
    """What happens, as it happens."""

    def add_webhook(self, body: models.AddWebhookBody) -> models.Webhook:
        """Tell an address of ended jobs and new maps. Needs serve --webhooks. Each message is signed:
        X-Skyquilt-Signature is "t=<seconds>,v1=<HMAC-SHA256 of 't.body' under the secret, hex>". What is not
        answered by a 2xx is sent again, up to eight times."""
        return cast("models.Webhook", self._send("POST", "/api/v1/webhooks", json_body=body))

    def events(self, *, flight: Optional[str] = None, job: Optional[str] = None, after: Optional[int] = None,
               last_event_id: Optional[int] = None, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """Events as they happen (Server-Sent Events), with replay by Last-Event-ID. Events are named job, map (a
        revision is shown), preview (the preview of a flight without a map has grown, and where: "changed" as west,
        south, east, north), file, deleted ("in_trash" says whether it can be restored), restored, and progress,
        which is not replayed."""
        return self._stream("GET", "/api/v1/events", query={"flight": flight, "job": job, "after": after},
                            headers={"Last-Event-ID": last_event_id, **(headers or {})})

    def list_webhooks(self) -> models.ListWebhooksAnswer:
        """Who is told of ended jobs and new maps."""
        return cast("models.ListWebhooksAnswer", self._send("GET", "/api/v1/webhooks"))

    def remove_webhook(self, webhook: str) -> None:
        """Tell it no more."""
        self._send("DELETE", "/api/v1/webhooks/{webhook}", path={"webhook": webhook})
