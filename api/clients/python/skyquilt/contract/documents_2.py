"""The documents that the server takes and answers.

Written by generate.py from api/openapi.json; changes belong there."""
from typing import Any, Dict, List, Literal, Optional, TypedDict, Union

from .documents_1 import *  # noqa: F401,F403


class TileJson(TileJsonForSure, total=False):
    """TileJSON 3.0.0."""
    name: str
    version: str
    scheme: Literal['xyz']
    # west, south, east, north; across the antimeridian -180 and 180
    bounds: List[float]
    # Of what lies across the antimeridian alone: west, south, east, north, the east beyond 180
    across_bounds: List[float]
    # Longitude, latitude, zoom
    center: List[float]
    minzoom: int
    maxzoom: int
    # Pixels on a side of a tile
    tileSize: int
    attribution: str
    description: str
    layers: List[TileJsonLayersItem]
    # Of the layer of heights and of terrain: metres = red * 256 + green + blue / 256 - 32768
    encoding: Literal['terrarium']
    # That expressions can name
    bands: List[str]
    # Where indices have tiles, if that is not where the map has: west, south, east, north
    bands_bounds: List[float]
    # That the bands are enough for
    indices: List[MapIndex]
    index: MapIndex
    # Of the map: heights that it has beside it
    heights: List[Literal['dsm', 'dtm']]
    # Of the map, where it has heights: the address of their tiles' TileJSON
    terrain: str
    # Of changes of heights: the other flight
    since: str
    shift: HeightShift
    # Of changes of heights: smaller ones are not shown, for two flights do not tell them
    least_shown_m: float
    # What the colours mean, straight between them; above 0: higher than then
    stops: List[TileJsonStopsItem]


class PointOfMapColour(TypedDict):
    red: int
    green: int
    blue: int
    alpha: int


class PointOfMapIndex(TypedDict):
    """Of the index asked for."""
    title: str
    expression: str
    # null: there is none here
    value: Optional[float]


class PointOfMapForSure(TypedDict):
    """What PointOfMap always has."""
    lon: float
    lat: float
    revision: int
    # Of the finest pixel there; null: the map has nothing
    colour: Optional[PointOfMapColour]
    # Of the ground, counted from the zero that the flight's heights have
    height_m: Optional[float]
    # The photo that shows the place; null: none is known
    photo: Optional[Any]


class PointOfMap(PointOfMapForSure, total=False):
    """What a map shows at a place."""
    # Of the index asked for
    index: PointOfMapIndex
    # Of what the photos show there (dsm.tif), of maps that have heights; null: not known there
    dsm_m: Optional[float]
    # Of the ground below (dtm.tif)
    dtm_m: Optional[float]


class GroundProfileSamplesItemForSure(TypedDict):
    """What GroundProfileSamplesItem always has."""
    # From the line's beginning
    distance_m: float
    lon: float
    lat: float
    # null beside the map
    height_m: Optional[float]


class GroundProfileSamplesItem(GroundProfileSamplesItemForSure, total=False):
    # Of what the photos show (dsm.tif), where "surfaces" names it
    dsm_m: Optional[float]
    # Of the ground below (dtm.tif)
    dtm_m: Optional[float]


class GroundProfile(TypedDict):
    revision: int
    # plane: the map was rendered on level ground, so that all heights are the same
    ground: Literal['plane', 'grid']
    # Of the grid; null of a plane
    cell_m: Optional[float]
    # Of the line, along the ellipsoid
    length_m: float
    # The longest between two samples
    step_m: float
    # null: the line meets no ground that the map knows
    lowest_m: Optional[float]
    highest_m: Optional[float]
    # The sum of what goes up from sample to sample
    climb_m: float
    descent_m: float
    samples: List[GroundProfileSamplesItem]
    # Heights that the map has besides (its job's option heights)
    surfaces: List[Literal['dsm', 'dtm']]


class MapStatisticsBandsItem(TypedDict):
    name: str
    min: Optional[float]
    max: Optional[float]
    mean: Optional[float]
    std: Optional[float]
    # Pixels of each value from 0 to 255
    histogram: List[int]


class MapStatisticsIndexPercentiles(TypedDict):
    p2: Optional[float]
    p5: Optional[float]
    p10: Optional[float]
    p25: Optional[float]
    p50: Optional[float]
    p75: Optional[float]
    p90: Optional[float]
    p95: Optional[float]
    p98: Optional[float]


class MapStatisticsIndex(TypedDict):
    """Of the index asked for."""
    title: str
    expression: str
    # That have a value
    pixels: int
    min: Optional[float]
    max: Optional[float]
    mean: Optional[float]
    std: Optional[float]
    percentiles: MapStatisticsIndexPercentiles
    # Pixels in 64 equal steps from min to max
    histogram: List[int]


class MapStatisticsForSure(TypedDict):
    """What MapStatistics always has."""
    revision: int
    # Of the pixels that were counted: the finest at which they are at most 8 million
    zoom: int
    # Of such a pixel, on the ground
    pixel_m: float
    # Of the polygon, on the ellipsoid
    area_m2: float
    # Of the ground within it that the map shows
    covered_m2: float
    pixels: int
    bands: List[MapStatisticsBandsItem]


class MapStatistics(MapStatisticsForSure, total=False):
    """What a map shows within a polygon."""
    # Of the index asked for
    index: MapStatisticsIndex


class ControlMark(TypedDict):
    # Name of the photo
    photo: str
    # Column in pixels; the centre of the first is 0
    x: float
    # Row in pixels; the centre of the first is 0
    y: float


class ControlPointForSure(TypedDict):
    """What ControlPoint always has."""
    name: str
    # East or longitude, in the reference system
    x: float
    # North or latitude, in the reference system
    y: float


class ControlPoint(ControlPointForSure, total=False):
    # In the unit of the reference system; null where it was not surveyed
    height: Optional[float]
    # Degrees east; said by the server, and not read
    lon: float
    # Degrees north; said by the server, and not read
    lat: float
    marks: List[ControlMark]


class ControlPointsForSure(TypedDict):
    """What ControlPoints always has."""
    points: List[ControlPoint]


class ControlPoints(ControlPointsForSure, total=False):
    # Of x, y and height, as a gcp_list.txt names it in its first line: EPSG:32611, WGS84 UTM 11N, +proj=...
    reference_system: str
    # Said by the server: rows of the list that were left out, and why
    warnings: List[str]


class NotePosition(TypedDict, total=False):
    """Longitude and latitude in degrees of WGS84."""


class MapNoteGeometry(TypedDict):
    type: Literal['Point']
    coordinates: NotePosition


class MapNoteGeometry1(TypedDict):
    type: Literal['LineString']
    coordinates: List[NotePosition]


class MapNoteGeometry2(TypedDict):
    type: Literal['Polygon']
    coordinates: List[List[NotePosition]]


class MapNotePropertiesForSure(TypedDict):
    """What MapNoteProperties always has."""
    # One line, at most 200 bytes
    name: str


class MapNoteProperties(MapNotePropertiesForSure, total=False):
    # At most 4,000 bytes
    text: str


class MapNote(TypedDict):
    type: Literal['Feature']
    # Chosen by who writes the note
    id: str
    # A note, a distance, an area
    geometry: Union[MapNoteGeometry, MapNoteGeometry1, MapNoteGeometry2]
    properties: MapNoteProperties


class MapNotes(TypedDict):
    """GeoJSON (RFC 7946), at most 1 MiB."""
    type: Literal['FeatureCollection']
    features: List[MapNote]


class MapBandsColormapsItem(TypedDict):
    id: str
    # #rrggbb, at equal steps from the least to the greatest value
    colours: List[str]


class MapBands(TypedDict):
    """What can be computed from a map."""
    revision: int
    # Names for expressions
    bands: List[str]
    indices: List[MapIndex]
    colormaps: List[MapBandsColormapsItem]


class MapVolumeForSure(TypedDict):
    """What MapVolume always has."""
    revision: int
    of: Literal['dsm', 'dtm']
    base: Literal['lowest', 'plane', 'given', 'flight']
    # Its height; of a plane the mean within the polygon
    base_m: float
    # Of the polygon, also of what of it lies beside the map
    area_m2: float
    # Of the cells in it that have a height
    covered_m2: float
    # Of the polygon: 0 to 1. The rest has no height, or one from around
    measured_share: float
    # On the ground
    cell_m: float
    # Above the base; with since: added since then
    cut_m3: float
    # Below it; with since: removed since then
    fill_m3: float
    # cut - fill
    net_m3: float
    # One standard deviation of it, but for what a calibration makes all heights off; null where less than four fifths
    # of what has a height was measured, over a given height, and with since where its shift has no sigma_m
    net_sigma_m3: Optional[float]
    lowest_m: float
    highest_m: float
    mean_m: float


class MapVolume(MapVolumeForSure, total=False):
    # With the base "flight": whose heights it is
    since: str
    shift: HeightShift


class AddExportBodyForSure(TypedDict):
    """What AddExportBody always has."""
    # "report": a PDF about the whole map, where the server has a program that prints
    format: Literal['geotiff', 'pmtiles', 'mbtiles', 'kmz', 'report']


class AddExportBody(AddExportBodyForSure, total=False):
    # Of a GeoTIFF: "utm" (the zone of the map's middle: to measure, for GIS and CAD) or a code such as EPSG:2056.
    # Without it Web Mercator, the tiles' own bytes, for web maps
    crs: Optional[str]
    # GeoJSON Polygon or MultiPolygon (or a Feature or FeatureCollection of them) with longitudes and latitudes of WGS
    # 84
    boundary: Optional[Dict[str, Any]]
    # Ground that a pixel shows, in metres. Of tiles the zooms down to it are written
    resolution_m: Optional[float]
    # Of a GeoTIFF: the values of an index by its name, as floats, instead of colours
    index: Optional[str]
    # The same by a formula over the bands of the map
    expression: Optional[str]
    # Of a report: what it calls the map; else the name of the flight
    name: Optional[str]


class ListExportsAnswer(TypedDict):
    exports: List[Export]


class AddWebhookBodyForSure(TypedDict):
    """What AddWebhookBody always has."""
    url: str


class AddWebhookBody(AddWebhookBodyForSure, total=False):
    # Made when not given
    secret: str


class ListWebhooksAnswer(TypedDict):
    webhooks: List[Webhook]


class ListFilesAnswer(TypedDict):
    files: List[File]


class PutFileAnswer2011(TypedDict):
    files: List[FileOutcome]


class AddShareAnswer(TypedDict):
    id: str
    created_at: str
    # null: it never ends
    expires_at: Optional[str]
    token: str
    # Where the page shows the flight with this token
    page: str
    # The map alone, for frames of other pages, with this token
    embed: str


class AddShareBody(TypedDict, total=False):
    # null: it never ends
    expires_in_days: Optional[int]


class GetAccessAnswer(TypedDict):
    # Whether this server asks for a token
    needs_token: bool
    # What the token may do; admin where no token is asked for, read for one in the address
    scope: Literal['read', 'upload', 'admin']
    # The one flight that the token opens; null for all
    flight: Optional[str]
    # After how many days the server puts a flight that nobody changes into the trash; 0: never
    keep_days: int


class GroundOfPixelAnswer(TypedDict):
    lon: float
    lat: float
    # Metres, 1-sigma, of where the camera was, as it shows on the ground; null where nothing supports the map's place
    sigma_m: Optional[float]


class ListFlightsAnswer(TypedDict):
    flights: List[Flight]
    next_cursor: Optional[str]


class ListSharesAnswerSharesItem(TypedDict):
    id: str
    created_at: str
    # null: it never ends
    expires_at: Optional[str]


class ListSharesAnswer(TypedDict):
    # false: this server asks nobody for a token; whoever reaches it may change and delete flights. A share only reads
    # all the same
    needs_token: bool
    # true: openNetwork lets this network see the server, and whoever asks may do it
    may_open_network: bool
    # Where other machines reach this server, the likeliest first; empty: it listens to its own machine alone, or was
    # asked from another one and not told its public address
    addresses: List[str]
    shares: List[ListSharesAnswerSharesItem]


class ListTrashAnswer(TypedDict):
    # For how many days deleted flights are kept; 0: not at all
    days: int
    flights: List[TrashedFlight]


class PhotosAtAnswer(TypedDict):
    lon: float
    lat: float
    photos: List[SeenPhoto]
