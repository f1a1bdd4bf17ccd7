"""One flight at a server: its state, its map, and what can be done with it."""
from __future__ import annotations

import math
import pathlib
import time
from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Optional, cast

from .contract import Operations, models
from .errors import InputError, JobCancelled, JobFailed, NotFound
from .fetching import Open, fetch
from .listing import Path
from .progress import OnProgress, Progress, ignore
from .transport import Answer, Transport

if TYPE_CHECKING:
    from .client import Client

# What can be downloaded of a map: path below the flight.
DOWNLOADS: Dict[str, str] = {
    "geotiff": "download.tif", "mbtiles": "download.mbtiles", "pmtiles": "download.pmtiles", "zip": "download.zip",
    "report": "report", "footprints": "photos.geojson", "cameras": "cameras.json", "geo.txt": "geo.txt",
    "thumbnail": "thumbnail.png", "layer_photo": "layer_photo.mbtiles", "layer_error": "layer_error.mbtiles",
    "layer_height": "layer_height.mbtiles", "layers": "layers.json", "dsm": "dsm.tif", "dsm_photos": "dsm_photos.tif",
    "dsm_hillshade": "dsm_hillshade.tif", "bands": "bands.tif",
    "dtm": "dtm.tif", "dtm_ground": "dtm_ground.tif", "contours": "contours.gpkg", "contours_geojson": "contours.geojson",
    "contours_dxf": "contours.dxf"}
_ENDINGS = {"geotiff": "tif", "report": "pdf"}  # those of other formats are their names
POLL_FIRST_S, POLL_LONGEST_S = 0.3, 3.0


class Flight:
    """A flight as the server last described it in `record`; `refresh()` asks again. Made by `Client`."""

    def __init__(self, client: Client, record: models.Flight) -> None:
        self.client, self.record = client, record

    def __repr__(self) -> str:
        return f"<Flight {self.id} {self.name!r}, {self.state}>"

    @property
    def id(self) -> str:
        """26 letters and digits."""
        return self.record["id"]

    @property
    def name(self) -> str:
        """What people call it."""
        return self.record["name"]

    @property
    def state(self) -> str:
        """empty, uploaded, queued, processing, ready or failed."""
        return self.record["state"]

    @property
    def has_map(self) -> bool:
        """Whether there is a finished map, also while a newer one is made."""
        return self.record["revision"] is not None

    @property
    def bounds(self) -> Optional[List[float]]:
        """West, south, east, north of the map in degrees; across the antimeridian the east is beyond 180."""
        return self.record["bounds"]

    @property
    def page(self) -> str:
        """Where a browser shows it."""
        return f"{self.client.url}/#/flights/{self.id}"

    def refresh(self) -> Flight:
        """Asks the server how the flight is now."""
        self.record = self.client.api.get_flight(self.id)
        return self

    def start(self, options: Optional[models.JobOptions] = None) -> models.Job:
        """Has a map made, with the flight's options changed by these. `Conflict` where one is being made."""
        body: models.StartJobBody = {"options": options} if options else {}
        return self.client.patient().start_job(self.id, body, idempotency_key=self.client.new_key())

    def wait(self, progress: OnProgress = ignore) -> Flight:
        """Waits for the flight's job, through restarts of the server. Raises `JobFailed` with the server's reason, or
        `JobCancelled`."""
        last = Progress("queued", 0.0, flight_id=self.id)

        def waits(why: str) -> None:
            progress(Progress("waiting", last.fraction, why, flight_id=self.id))

        api, pause_s = self.client.patient(waits), POLL_FIRST_S
        while True:
            self.record = api.get_flight(self.id)
            job = self.record["job"]
            if job is None:
                raise InputError(f"No map of {self.name} is being made; start() has one made.")
            if job["state"] == "successful":
                progress(Progress("done", 1.0, "The map is there.", flight_id=self.id))
                return self
            if job["state"] in ("failed", "dismissed"):
                raise self._about(_why(job["state"], job["error"]))
            last = Progress(job["stage"] or job["state"], job["progress"], job["message"], flight_id=self.id)
            progress(last)
            time.sleep(pause_s)
            pause_s = min(1.3 * pause_s, POLL_LONGEST_S)

    def download(self, kind: str, path: Path, progress: OnProgress = ignore) -> pathlib.Path:
        """Writes a file of the map (`DOWNLOADS` has the kinds: geotiff, mbtiles, pmtiles, zip, report, ...) to `path`, or into
        that folder. Goes on where an earlier try was broken off."""
        if kind not in DOWNLOADS:
            raise InputError(f"There is no download {kind!r}; there are {', '.join(DOWNLOADS)}.")
        below = DOWNLOADS[kind]
        ending = below if "." in below else "report.json"
        target = _target(path, f"{self.id}_{ending.replace('download.', 'map.')}")
        self._fetch(f"/api/v1/flights/{{flight}}/{below}", {}, target, progress)
        return target

    def export(self, format: str, path: Path, *, crs: Optional[str] = None, boundary: Optional[Mapping[str, Any]] = None,
               resolution_m: Optional[float] = None, index: Optional[str] = None, expression: Optional[str] = None,
               progress: OnProgress = ignore) -> pathlib.Path:
        """Has the map written as geotiff, pmtiles, mbtiles, kmz or report (a PDF about it), in another coordinate system ("utm", "EPSG:2056"), within a
        boundary (GeoJSON, degrees) or coarser, or the values of an index ("ndvi", or a formula), and writes it to `path`. `Unprocessable` says what of that cannot be."""
        body = {"format": format, "crs": crs, "boundary": boundary, "resolution_m": resolution_m, "index": index,
                "expression": expression}
        wish = cast("models.AddExportBody", {key: value for key, value in body.items() if value is not None})
        api = self.client.patient(lambda why: progress(Progress("waiting", 0.0, why, flight_id=self.id)))
        # The same wish for the same map is the same export: this goes on where an earlier call was broken off.
        export, pause_s = api.add_export(self.id, wish), POLL_FIRST_S
        while export["state"] in ("accepted", "running"):
            progress(Progress("export", export["progress"], flight_id=self.id))
            time.sleep(pause_s)
            pause_s = min(1.3 * pause_s, POLL_LONGEST_S)
            export = api.get_export(self.id, export["id"])
        if export["state"] != "successful":
            error = export["error"]
            raise self._about(JobFailed(f"The export could not be made: {error['message'] if error else 'no reason is known'}",
                                        error["code"] if error else ""))
        target = _target(path, f"{self.id}_map.{_ENDINGS.get(format, format)}")
        self._fetch("/api/v1/flights/{flight}/exports/{export}/file", {"export": export["id"]}, target, progress)
        return target

    def tile_url(self, *, tile_px: Optional[int] = None, layer: Optional[str] = None, with_token: bool = True) -> str:
        """The address of the map's tiles with {z}, {x} and {y}, for any XYZ client. `tile_px=256` gives tiles of 256 pixels of a
        map that has larger ones; `layer` is photo, error or height; `with_token` ends it with the token, for programs that
        send no headers: anybody who sees that address can read what the token can."""
        below = f"{layer}/" if layer else f"{tile_px}/" if tile_px else ""
        token = self.client.transport.token
        return f"{self.client.url}/tiles/{self.id}/{below}{{z}}/{{x}}/{{y}}" + (f"?token={token}" if with_token and token else "")

    def tile_json(self, *, is_256: bool = False) -> models.TileJson:
        """What the map's tiles are: zooms, bounds, size. `is_256`: of those of 256 pixels."""
        return self.client.api.get_usual_tile_json(self.id) if is_256 else self.client.api.get_tile_json(self.id)

    def photos_at(self, lon: float, lat: float) -> List[models.SeenPhoto]:
        """The photos that see a place (degrees; a longitude beyond 180 too, as `bounds` has it), the most vertical view first, with
        the place's pixel in each."""
        return self.client.api.photos_at(self.id, lon if abs(lon) <= 180 else math.remainder(lon, 360), lat)["photos"]

    def ground_at(self, photo: str, x: float, y: float) -> models.GroundOfPixelAnswer:
        """Where a photo's pixel lies."""
        return self.client.api.ground_of_pixel(self.id, photo, x, y)

    def points(self, photo: str, pixels: "List[tuple[float, float]]") -> List[models.GroundOfPixelAnswer]:
        """Where several pixels of a photo lie, in their order."""
        return [self.ground_at(photo, x, y) for x, y in pixels]

    def report(self) -> Dict[str, Any]:
        """What was made and how good it is."""
        return self.client.api.get_report(self.id)

    def footprints(self) -> Dict[str, Any]:
        """GeoJSON: the ground that each photo shows, and where it was taken."""
        return self.client.api.get_footprints(self.id)

    def files(self) -> List[models.File]:
        """What was uploaded."""
        return self.client.api.list_files(self.id)["files"]

    def photo(self, name: str) -> bytes:
        """An uploaded file's bytes."""
        with self.client.api.get_file(self.id, name) as answer:
            return answer.read_all()

    def rename(self, name: str) -> Flight:
        """Gives it another name."""
        self.record = self.client.api.change_flight(self.id, {"name": name})
        return self

    def delete(self) -> None:
        """Puts it into the server's trash (or removes it, where the server keeps none); `Client.restore` takes it back."""
        self.client.api.delete_flight(self.id)

    def _fetch(self, template: str, more: Mapping[str, str], target: pathlib.Path, progress: OnProgress) -> None:
        def open_at(transport: Transport) -> Open:
            api = Operations(transport)

            def open_once(headers: Mapping[str, str]) -> Answer:
                return api._stream("GET", template, path={"flight": self.id, **more}, headers=headers)
            return open_once
        try:
            fetch(self.client.transport.patient(self.client.patience_s), open_at, target, progress)
        except NotFound as error:
            self._about(error)
            raise

    def _about(self, error: Any) -> Any:
        error.flight_id = self.id
        return error


def _why(state: str, error: Optional[models.JobError]) -> Exception:
    if state == "dismissed":
        return JobCancelled("The job was cancelled.")
    return JobFailed(error["message"] if error else "The map could not be made.", error["code"] if error else "")


def _target(path: Path, name: str) -> pathlib.Path:
    target = pathlib.Path(path)
    return target / name if target.is_dir() else target
