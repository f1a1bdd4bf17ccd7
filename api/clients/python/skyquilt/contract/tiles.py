"""The map, tile by tile.

Written by generate.py from api/openapi.json; changes belong there."""
from typing import Any, List, Literal, Mapping, Optional, Union, cast

from . import models
from ..transport import Calls, Answer


class Tiles(Calls):
    """The map, tile by tile."""

    def get_change_tile(self, flight: str, z: int, x: int, y: str, since: str, *,
                        of: Optional[Literal['dsm', 'dtm']] = None, rev: Optional[int] = None,
                        since_rev: Optional[int] = None, align: Optional[Literal['auto', 'none']] = None,
                        headers: Optional[Mapping[str, str]] = None) -> Answer:
        """A tile of that as a PNG of 256 pixels: blue where it is higher than then, red where lower, nothing where
        either flight measured nothing or too little changed to tell."""
        return self._stream("GET", "/tiles/{flight}/change/{z}/{x}/{y}",
                            path={"flight": flight, "z": z, "x": x, "y": y},
                            query={"since": since, "of": of, "rev": rev, "since_rev": since_rev, "align": align},
                            headers=headers)

    def get_change_tile_json(self, flight: str, since: str, *, of: Optional[Literal['dsm', 'dtm']] = None,
                             align: Optional[Literal['auto', 'none']] = None) -> models.TileJson:
        """TileJSON 3.0.0 of how a map's heights differ from those of another flight of the same ground, in colours."""
        return cast("models.TileJson", self._send("GET", "/tiles/{flight}/change.json", path={"flight": flight},
                                                  query={"since": since, "of": of, "align": align}))

    def get_layer_tile(self, flight: str, layer: Literal['photo', 'error', 'height'], z: int, x: int, y: str, *,
                       empty: Optional[Literal['blank', '204', '404']] = None, rev: Optional[Union[int, str]] = None,
                       headers: Optional[Mapping[str, str]] = None) -> Answer:
        """A tile of a layer: which photo a pixel came from, how far off it may lie, how high the ground is. Always
        PNG: the colours are codes, which layers.json explains."""
        return self._stream("GET", "/tiles/{flight}/{layer}/{z}/{x}/{y}",
                            path={"flight": flight, "layer": layer, "z": z, "x": x, "y": y},
                            query={"empty": empty, "rev": rev}, headers=headers)

    def get_layer_tile_json(self, flight: str, layer: Literal['photo', 'error', 'height'], *,
                            rev: Optional[Union[int, str]] = None) -> models.TileJson:
        """TileJSON 3.0.0 of a layer beside a flight's map; height says its encoding (terrarium)."""
        return cast("models.TileJson", self._send("GET", "/tiles/{flight}/{layer}.json",
                                                  path={"flight": flight, "layer": layer}, query={"rev": rev}))

    def get_terrain_tile(self, flight: str, z: int, x: int, y: str, *, of: Optional[Literal['dsm', 'dtm']] = None,
                         rev: Optional[Union[int, str]] = None, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """A tile of heights as a PNG of 256 pixels in terrarium coding. There is one everywhere on Earth: beyond the
        map its height goes on."""
        return self._stream("GET", "/tiles/{flight}/terrain/{z}/{x}/{y}",
                            path={"flight": flight, "z": z, "x": x, "y": y}, query={"of": of, "rev": rev},
                            headers=headers)

    def get_terrain_tile_json(self, flight: str, *, of: Optional[Literal['dsm', 'dtm']] = None) -> models.TileJson:
        """TileJSON 3.0.0 of a map's heights, for views in three dimensions and hillshades."""
        return cast("models.TileJson", self._send("GET", "/tiles/{flight}/terrain.json", path={"flight": flight},
                                                  query={"of": of}))

    def get_tile(self, flight: str, z: int, x: int, y: str, *, empty: Optional[Literal['blank', '204', '404']] = None,
                 rev: Optional[Union[int, str]] = None, index: Optional[str] = None, expression: Optional[str] = None,
                 rescale: Optional[str] = None, colormap: Optional[str] = None,
                 headers: Optional[Mapping[str, str]] = None) -> Answer:
        """One tile (XYZ, Web Mercator)."""
        return self._stream("GET", "/tiles/{flight}/{z}/{x}/{y}", path={"flight": flight, "z": z, "x": x, "y": y},
                            query={"empty": empty, "rev": rev, "index": index, "expression": expression, "rescale": rescale, "colormap": colormap},
                            headers=headers)

    def get_tile_json(self, flight: str, *, rev: Optional[Union[int, str]] = None, index: Optional[str] = None,
                      expression: Optional[str] = None, rescale: Optional[str] = None,
                      colormap: Optional[str] = None) -> models.TileJson:
        """TileJSON 3.0.0 of a flight's map."""
        return cast("models.TileJson", self._send("GET", "/tiles/{flight}.json", path={"flight": flight},
                                                  query={"rev": rev, "index": index, "expression": expression, "rescale": rescale, "colormap": colormap}))

    def get_usual_tile(self, flight: str, z: int, x: int, y: str, *,
                       empty: Optional[Literal['blank', '204', '404']] = None, rev: Optional[Union[int, str]] = None,
                       index: Optional[str] = None, expression: Optional[str] = None, rescale: Optional[str] = None,
                       colormap: Optional[str] = None, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """One tile of 256 pixels, whatever the size of the stored ones: of one of 512, a quarter a zoom deeper."""
        return self._stream("GET", "/tiles/{flight}/256/{z}/{x}/{y}", path={"flight": flight, "z": z, "x": x, "y": y},
                            query={"empty": empty, "rev": rev, "index": index, "expression": expression, "rescale": rescale, "colormap": colormap},
                            headers=headers)

    def get_usual_tile_json(self, flight: str, *, rev: Optional[Union[int, str]] = None, index: Optional[str] = None,
                            expression: Optional[str] = None, rescale: Optional[str] = None,
                            colormap: Optional[str] = None) -> models.TileJson:
        """TileJSON 3.0.0 of a flight's map in tiles of 256 pixels, whatever the size of the stored ones."""
        return cast("models.TileJson", self._send("GET", "/tiles/{flight}/256.json", path={"flight": flight},
                                                  query={"rev": rev, "index": index, "expression": expression, "rescale": rescale, "colormap": colormap}))

    def tile_json_index(self, *, limit: Optional[int] = None, cursor: Optional[str] = None) -> List[Any]:
        """TileJSON of all maps, the newest flights first."""
        return cast("List[Any]", self._send("GET", "/tiles/index.json", query={"limit": limit, "cursor": cursor}))
