"""The map as files.

Written by generate.py from api/openapi.json; changes belong there."""
from typing import Any, Dict, Literal, Mapping, Optional, cast

from . import models
from ..transport import Calls, Answer


class Downloads(Calls):
    """The map as files."""

    def add_export(self, flight: str, body: models.AddExportBody) -> models.Export:
        """Have the map written in another format, coordinate system, area or resolution. It is made beside the
        requests, one at a time, and kept for a day. Who may read the flight may ask. The same wish for the same map
        is answered with the export that is there. 422 says what of the wish cannot be: a map that is not
        georeferenced, a boundary outside it, a coordinate system of elsewhere, a resolution finer than the map's.
        409: the flight has 12 exports, or the share that asks has one that is not made yet. Those of shares come
        last and go with them."""
        return cast("models.Export", self._send("POST", "/api/v1/flights/{flight}/exports", json_body=body,
                                                path={"flight": flight}))

    def cameras(self, flight: str) -> Any:
        """The cameras, in OpenSfM's form."""
        return cast("Any", self._send("GET", "/api/v1/flights/{flight}/cameras.json", path={"flight": flight}))

    def download_all(self, flight: str, *, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """Everything in one archive, with Range."""
        return self._stream("GET", "/api/v1/flights/{flight}/download.zip", path={"flight": flight}, headers=headers)

    def download_bands(self, flight: str, *, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """All bands of a camera that has several, as values (float32, NaN where nothing is known): a cloud-optimised
        GeoTIFF; docs/bands.md says what of it is calibrated. 404 for maps of photos in colour."""
        return self._stream("GET", "/api/v1/flights/{flight}/bands.tif", path={"flight": flight}, headers=headers)

    def download_contours(self, flight: str, *, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """Lines of equal height of the ground (dtm.tif), each with its height as z and as height_m: a GeoPackage in
        the UTM zone."""
        return self._stream("GET", "/api/v1/flights/{flight}/contours.gpkg", path={"flight": flight}, headers=headers)

    def download_contours_dxf(self, flight: str, *, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """The same for CAD, each line at its height."""
        return self._stream("GET", "/api/v1/flights/{flight}/contours.dxf", path={"flight": flight}, headers=headers)

    def download_contours_geo_json(self, flight: str) -> Dict[str, Any]:
        """The same as GeoJSON."""
        return cast("Dict[str, Any]", self._send("GET", "/api/v1/flights/{flight}/contours.geojson",
                                                 path={"flight": flight}))

    def download_dsm(self, flight: str, *, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """Heights of ground, roofs and trees as the photos show them (metres, float32, NaN where no photo looks;
        heights_from in report.json says what they count from), in the UTM zone: a cloud-optimised GeoTIFF. 404 for
        maps whose job did not ask for heights."""
        return self._stream("GET", "/api/v1/flights/{flight}/dsm.tif", path={"flight": flight}, headers=headers)

    def download_dsm_hillshade(self, flight: str, *, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """The slopes of dsm.tif lit from four sides, on its cells; 0 where there is no height. 404 for maps whose job
        did not ask for heights, or that were made by an earlier version."""
        return self._stream("GET", "/api/v1/flights/{flight}/dsm_hillshade.tif", path={"flight": flight},
                            headers=headers)

    def download_dsm_photos(self, flight: str, *, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """On the cells of dsm.tif: how many photos agree on the height; 0 where it was filled from around."""
        return self._stream("GET", "/api/v1/flights/{flight}/dsm_photos.tif", path={"flight": flight}, headers=headers)

    def download_dtm(self, flight: str, *, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """The ground below houses and trees, on the cells of dsm.tif. 404 for maps whose job did not ask for it."""
        return self._stream("GET", "/api/v1/flights/{flight}/dtm.tif", path={"flight": flight}, headers=headers)

    def download_dtm_ground(self, flight: str, *, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """On the cells of dtm.tif: 1 where that ground was seen and measured, 0 where it is bridged."""
        return self._stream("GET", "/api/v1/flights/{flight}/dtm_ground.tif", path={"flight": flight}, headers=headers)

    def download_export(self, flight: str, export: str, *, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """The file of an export."""
        return self._stream("GET", "/api/v1/flights/{flight}/exports/{export}/file",
                            path={"flight": flight, "export": export}, headers=headers)

    def download_geotiff(self, flight: str, *, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """The map as cloud-optimised GeoTIFF in Web Mercator, for web maps. Distances in it are too long (by 46 % at
        47 degrees): to measure, for GIS and CAD, export it with the crs "utm"."""
        return self._stream("GET", "/api/v1/flights/{flight}/download.tif", path={"flight": flight}, headers=headers)

    def download_layer_error(self, flight: str, *, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """MBTiles of the layer "error", where the map was made with it."""
        return self._stream("GET", "/api/v1/flights/{flight}/layer_error.mbtiles", path={"flight": flight},
                            headers=headers)

    def download_layer_height(self, flight: str, *, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """MBTiles of the layer "height", where the map was made with it."""
        return self._stream("GET", "/api/v1/flights/{flight}/layer_height.mbtiles", path={"flight": flight},
                            headers=headers)

    def download_layer_photo(self, flight: str, *, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """MBTiles of the layer "photo", where the map was made with it."""
        return self._stream("GET", "/api/v1/flights/{flight}/layer_photo.mbtiles", path={"flight": flight},
                            headers=headers)

    def download_mbtiles(self, flight: str, *, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """The map as MBTiles 1.3."""
        return self._stream("GET", "/api/v1/flights/{flight}/download.mbtiles", path={"flight": flight},
                            headers=headers)

    def download_pmtiles(self, flight: str, *, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """The map as PMTiles v3, with Range."""
        return self._stream("GET", "/api/v1/flights/{flight}/download.pmtiles", path={"flight": flight},
                            headers=headers)

    def geo_txt(self, flight: str, *, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """The photos' positions, for other engines."""
        return self._stream("GET", "/api/v1/flights/{flight}/geo.txt", path={"flight": flight}, headers=headers)

    def get_export(self, flight: str, export: str) -> models.Export:
        """State of an export."""
        return cast("models.Export", self._send("GET", "/api/v1/flights/{flight}/exports/{export}",
                                                path={"flight": flight, "export": export}))

    def get_footprints(self, flight: str) -> Dict[str, Any]:
        """Footprint of every photo."""
        return cast("Dict[str, Any]", self._send("GET", "/api/v1/flights/{flight}/photos.geojson",
                                                 path={"flight": flight}))

    def get_layers_json(self, flight: str) -> Any:
        """What the colours of the map's layers mean, where it was made with layers."""
        return cast("Any", self._send("GET", "/api/v1/flights/{flight}/layers.json", path={"flight": flight}))

    def get_report(self, flight: str) -> Dict[str, Any]:
        """What was made and how good it is."""
        return cast("Dict[str, Any]", self._send("GET", "/api/v1/flights/{flight}/report", path={"flight": flight}))

    def get_small_thumbnail(self, flight: str, *, size: Optional[Literal[160, 320, 512, 1024]] = None,
                            headers: Optional[Mapping[str, str]] = None) -> Answer:
        """The whole map as one small picture, as WebP. Made when it is asked for, and kept in memory: the sizes 160,
        320 and 512 from thumbnail.png; 1024 from the tiles, exactly as far as the map's bounds reach and in Web
        Mercator, for laying it where the map will be. A map with fewer pixels is not enlarged."""
        return self._stream("GET", "/api/v1/flights/{flight}/thumbnail.webp", path={"flight": flight},
                            query={"size": size}, headers=headers)

    def get_thumbnail(self, flight: str, *, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """The whole map in 512 pixels, as PNG."""
        return self._stream("GET", "/api/v1/flights/{flight}/thumbnail.png", path={"flight": flight}, headers=headers)

    def list_exports(self, flight: str) -> models.ListExportsAnswer:
        """The exports of a flight's maps, newest first."""
        return cast("models.ListExportsAnswer", self._send("GET", "/api/v1/flights/{flight}/exports",
                                                           path={"flight": flight}))

    def remove_export(self, flight: str, export: str) -> None:
        """Cancel an export, or remove it with its file. For the token that asked for it, and those that may change the
        flight."""
        self._send("DELETE", "/api/v1/flights/{flight}/exports/{export}", path={"flight": flight, "export": export})
