"""Stitching.

Written by generate.py from api/openapi.json; changes belong there."""
from typing import Optional, cast

from . import models
from ..transport import Calls


class Jobs(Calls):
    """Stitching."""

    def cancel_job(self, job: str) -> models.Job:
        """Cancel a job."""
        return cast("models.Job", self._send("DELETE", "/api/v1/jobs/{job}", path={"job": job}))

    def get_job(self, job: str) -> models.Job:
        """State and progress of a job."""
        return cast("models.Job", self._send("GET", "/api/v1/jobs/{job}", path={"job": job}))

    def job_log(self, job: str) -> models.JobLogAnswer:
        """What a job went through."""
        return cast("models.JobLogAnswer", self._send("GET", "/api/v1/jobs/{job}/log", path={"job": job}))

    def list_jobs(self, *, flight: Optional[str] = None, limit: Optional[int] = None,
                  cursor: Optional[str] = None) -> models.ListJobsAnswer:
        """Jobs, newest first."""
        return cast("models.ListJobsAnswer", self._send("GET", "/api/v1/jobs",
                                                        query={"flight": flight, "limit": limit, "cursor": cursor}))

    def retry_job(self, job: str) -> models.Job:
        """A new job with the options of one that has ended."""
        return cast("models.Job", self._send("POST", "/api/v1/jobs/{job}/retry", path={"job": job}))

    def start_job(self, flight: str, body: models.StartJobBody, *, idempotency_key: Optional[str] = None) -> models.Job:
        """Queue the stitching of a flight."""
        return cast("models.Job", self._send("POST", "/api/v1/flights/{flight}/jobs", json_body=body,
                                             path={"flight": flight}, headers={"Idempotency-Key": idempotency_key}))
