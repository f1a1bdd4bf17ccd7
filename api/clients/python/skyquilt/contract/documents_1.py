"""The documents that the server takes and answers.

Written by generate.py from api/openapi.json; changes belong there."""
from typing import Any, Dict, List, Literal, Optional, TypedDict, Union


class Remark(TypedDict):
    """What a sentence of the server says, by a code that stays, for who says it in other words or languages."""
    code: str
    # Numbers, names, and lists of remarks that are said within; the unit ends a name (limit_s); what ends with _words
    # is English
    values: Dict[str, Any]


class ProblemForSure(TypedDict):
    """What Problem always has."""
    type: str
    title: str
    status: int
    detail: str


class Problem(ProblemForSure, total=False):
    """RFC 9457."""
    code: str
    reason: Remark
    instance: str
    request_id: str


JobOptionsPlaceItem = TypedDict("JobOptionsPlaceItem", {"shown": List[float], "is": List[float]})


class JobOptions(TypedDict, total=False):
    # Ground size of a pixel in metres. More than 20 times that of the photos is refused, unless any_gsd says that it
    # is meant
    gsd_m: Optional[float]
    # A gsd_m far coarser than the photos is meant
    any_gsd: bool
    # gsd_m counts only where it is coarser than the photos' own pixels
    not_finer_than_photos: bool
    # Nothing is drawn that a photo sees further off the vertical than this, in degrees
    max_look_deg: float
    # Rolling shutter: milliseconds from reading a photo's first row to its last, 0 for none; without it as known of
    # the camera. Undone where photos or logs say how fast the aircraft flew
    readout_ms: Optional[float]
    # Of the tiles. auto: JPEG inside, WebP with alpha at the fringe, which is smallest; jpeg-png: PNG at the fringe,
    # for programs that open the map's MBTiles or PMTiles themselves and know no WebP; webp: WebP throughout
    format: Literal['auto', 'jpeg-png', 'webp']
    # JPEG or WebP quality of the tiles
    quality: int
    # How photos are placed. auto: poses refined by image features, and where angles, heights or positions are missing
    # or wrong photos placed by what they show alone; images: all photos placed by what they show alone; imu: recorded
    # poses alone, no pixel compared
    method: Literal['auto', 'images', 'imu']
    # smooth: photos are projected to the ground, and what stands on it leans as it does in them; dense: houses, walls
    # and trees stand upright (a true orthophoto), by heights of every two pixels that are matched in the photos
    # first, which takes several times as long; auto: dense where what stands on the ground leans by more than two
    # pixels and three photos see most of it. A flight that would be cut into units is made by one worker where it is
    # not smooth
    surface: Literal['smooth', 'dense', 'auto']
    # Heights beside the map: of ground, roofs and trees as the photos show them (dsm), or those and of the ground
    # below with its contours (dtm). Takes several times as long as the map; a flight that would be cut into units is
    # made by one worker then. A job that only moves a map (place) makes those anew that the map has
    heights: Literal['none', 'dsm', 'dtm']
    # Latitude and longitude of the take-off in degrees, for a flight that recorded no position at all
    origin: Optional[List[float]]
    # Polygon, MultiPolygon, Feature or FeatureCollection of polygons (GeoJSON, WGS 84): the map is cut to it; photos
    # are placed as without. All options together have at most 64 KiB
    boundary: Optional[Dict[str, Any]]
    # Height of the place of take-off in metres above sea level (EGM96), where photos record heights above take-off
    # alone, or wrong ones above sea level
    takeoff_height_m: Optional[float]
    # Of a job for a finished map: it is brought to where things that it shows really are, and no photo is compared
    # again. One pair shifts it, two or more turn and scale it too. "control": it is brought to the surveyed points
    # among the flight's files, and aligned anew where it fits them only when it is bent
    place: Union[List[JobOptionsPlaceItem], Literal['control']]
    # A flight without any position landed where it took off
    landed_at_start: bool
    # Tilesets of their own beside the map: which photo a pixel came from, how far off it may lie, how high the ground
    # is
    layers: List[Literal['photo', 'error', 'height']]
    # Name of one of the flight's files that is a finished map of others: a georeferenced GeoTIFF (8 bits a colour,
    # any coordinate system) or an MBTiles of pictures. It becomes the flight's map; no photo is looked at. Of the
    # other options only quality goes with it, for tiles that are made from a GeoTIFF
    import_file: Optional[str]


class FlightFields(TypedDict, total=False):
    name: str
    options: JobOptions
    # All of its tags; an empty list takes them off. Upper and lower case differ; no commas, no spaces at the ends
    tags: List[str]
    # true: never put it into the trash by itself (serve --keep-days)
    keep: bool


class JobError(TypedDict):
    code: str
    message: str
    # The same as the message; null where that alone tells
    reason: Optional[Remark]


class JobPartsItem(TypedDict):
    kind: Literal['look', 'render']
    part: int
    worker: str
    since: str
    attempt: int


class JobWorkersAsideItem(TypedDict):
    worker: str
    # Its first trouble with nothing done since
    since: str
    # It tries again
    until: str
    # In a row
    times: int
    code: str
    message: str


class JobForSure(TypedDict):
    """What Job always has."""
    id: str
    flight_id: str
    state: Literal['accepted', 'running', 'successful', 'failed', 'dismissed']
    stage: str
    progress: float
    message: str
    eta_s: Optional[float]
    attempts: int
    created_at: str
    started_at: Optional[str]
    finished_at: Optional[str]
    error: Optional[JobError]
    # Four of five jobs end within these
    eta_low_s: Optional[float]
    # Four of five jobs end within these
    eta_high_s: Optional[float]
    priority: int
    options: JobOptions


class Job(JobForSure, total=False):
    # Of a running job, asked for by its id with a token of scope admin: which worker has which part of a large flight
    parts: List[JobPartsItem]
    # With the parts: workers of any job that take nothing until then because their machines are in trouble (disk,
    # network, store)
    workers_aside: List[JobWorkersAsideItem]


class MapQualityAbsolute(TypedDict):
    """Where it lies on Earth."""
    # Horizontal, one sigma: 68 % of the map's places lie within this many metres of the truth; null where nothing
    # supports a number
    sigma_m: Optional[float]
    # What supports it
    by: Literal['none', 'hand', 'gnss', 'rtk', 'control_points', 'check_points']
    # Positions or points
    count: int


class MapQualityRelative(TypedDict):
    """How well it fits itself."""
    # Null where the scale is a guess too
    error_m: Optional[float]
    error_px: Optional[float]
    by: Literal['none', 'tie_points', 'seams']
    count: int


class MapQualityLimitsItem(TypedDict):
    kind: Literal['not_georeferenced', 'scale_guessed', 'north_guessed', 'few_positions', 'positions_contradicted', 'far_off', 'control_contradicted', 'checks_missed', 'placed_by_hand', 'left_out', 'none_aligned', 'pose_only']
    count: int
    of: int


class MapQuality(TypedDict):
    """How true the map is and whether it is fit for use, as report.json has it under the same name."""
    # ready; of use but for its limits; placed by so little that nobody should rely on where it lies; not
    # georeferenced; of an imported map of which that is not known
    status: Literal['ready', 'limited', 'doubtful', 'unplaced', 'unknown']
    # Where it lies on Earth
    absolute: MapQualityAbsolute
    # How well it fits itself
    relative: MapQualityRelative
    limits: List[MapQualityLimitsItem]


class FlightPhotos(TypedDict):
    total: int
    aligned: int
    pose_only: int
    left_out: int


class FlightCaptured(TypedDict):
    """When the photos in the map were taken, by the clock on the wall there: with the offset of its zone, with Z where
    that is not known, and without either where the camera's clock was local and nothing tells its zone. Null where
    no photo knows it, and for maps made before version 15 of the catalogue."""
    first: str
    last: str


class Preview(TypedDict):
    """The coarse map of a flight that has no map yet, from the photos that have arrived."""
    # Grows with every change
    edition: int
    photos: int
    # west, south, east, north
    bounds: List[float]
    tilejson: str


class FlightForSure(TypedDict):
    """What Flight always has."""
    id: str
    name: str
    state: Literal['empty', 'uploaded', 'queued', 'processing', 'ready', 'failed']
    created_at: str
    file_count: int
    bytes: int
    # Words by which it is found again, in the order of their bytes
    tags: List[str]
    # Whether it is to be kept: the server never puts it into the trash by itself (serve --keep-days)
    keep: bool
    revision: Optional[int]
    job: Optional[Job]
    # west, south, east, north
    bounds: Optional[List[float]]
    # false: nothing says where on Earth the map lies, and it is drawn around latitude 0, longitude 0 until it is
    # placed. null: there is no map yet
    georeferenced: Optional[bool]
    min_zoom: Optional[int]
    max_zoom: Optional[int]
    photos: Optional[FlightPhotos]
    # When the photos in the map were taken, by the clock on the wall there: with the offset of its zone, with Z where
    # that is not known, and without either where the camera's clock was local and nothing tells its zone. Null where
    # no photo knows it, and for maps made before version 15 of the catalogue
    captured: Optional[FlightCaptured]
    gsd_m: Optional[float]
    quality: Optional[MapQuality]
    tilejson: Optional[str]
    error: Optional[JobError]
    preview: Optional[Preview]
    # Whether who asks may change it: the token that made it, one of scope admin, and everybody where no token is
    # asked for
    may_change: bool


class Flight(FlightForSure, total=False):
    options: JobOptions


class File(TypedDict):
    name: str
    bytes: int


class FileOutcomeForSure(TypedDict):
    """What FileOutcome always has."""
    name: str


class FileOutcome(FileOutcomeForSure, total=False):
    bytes: int
    note: str
    error: str
    code: str
    reason: Remark


class WebhookForSure(TypedDict):
    """What Webhook always has."""
    id: str
    url: str
    created_at: str


class Webhook(WebhookForSure, total=False):
    # Said once, in the answer to POST
    secret: str


class TrashedFlight(TypedDict):
    id: str
    name: str
    created_at: str
    file_count: int
    bytes: int
    deleted_at: str
    # Removed for good then, or later: the days count while the server's machine runs
    removed_at: str
    days_left: int


class ExportError(TypedDict):
    code: str
    message: str
    # The same as the message; null where that alone tells
    reason: Optional[Remark]


class Export(TypedDict):
    id: str
    flight_id: str
    # The map that it is of
    revision: int
    # false: the flight shows another map since
    is_current: bool
    format: Literal['geotiff', 'pmtiles', 'mbtiles', 'kmz', 'report']
    crs: Optional[str]
    resolution_m: Optional[float]
    # GeoJSON Polygon or MultiPolygon (or a Feature or FeatureCollection of them) with longitudes and latitudes of WGS
    # 84
    boundary: Optional[Dict[str, Any]]
    # Of a GeoTIFF of values: the name of the index
    index: Optional[str]
    # Of a GeoTIFF of values: the formula
    expression: Optional[str]
    # What is to be known of the file: its system counts from an older datum, whose place on Earth is not known to a
    # metre
    remark: Optional[Remark]
    state: Literal['accepted', 'running', 'successful', 'failed']
    progress: float
    # Of the file, once it is there
    bytes: Optional[int]
    error: Optional[ExportError]
    created_at: str
    finished_at: Optional[str]
    # When it is removed, with its file; null while it waits or runs
    expires_at: Optional[str]
    # Where its state is
    href: str
    # Where its file is, once it is there
    download: Optional[str]


class SeenPhoto(TypedDict):
    """A photo that sees a place."""
    name: str
    # Where in the photo the place shows: column in pixels; the centre of the first is 0
    x: float
    # Row in pixels; the centre of the first is 0
    y: float
    # How far off the vertical the photo sees the place
    off_nadir_deg: float
    # How the photo was placed: aligned with others, or pose_only, by its record alone
    placement: str
    # Metres, 1-sigma, of where the camera was, as it shows on the ground; null where nothing supports the map's place
    sigma_m: Optional[float]
    # The fine detail that the photo shows, as a share of what others show of the same ground: about 1 for a sharp
    # one; null where too few others show it
    sharpness: Optional[float]
    # By which the list is sorted, best first: min(1, sharpness / 0.8) * cos(off_nadir_deg)^2, a photo of unknown
    # sharpness counting as sharp
    quality: float


class TileJsonLayersItem(TypedDict):
    id: str
    tilejson: str
    legends: str


class MapIndexForSure(TypedDict):
    """What MapIndex always has."""
    title: str
    expression: str
    rescale: List[float]
    colormap: str


class MapIndex(MapIndexForSure, total=False):
    """An index that a map has the bands for, and how it is coloured unless somebody says otherwise."""
    # For "index"; absent: an expression of the user's own
    id: str
    # Where its legend is, as SVG; at .png instead of .svg as PNG
    legend: str
    # Where its tiles are described
    tilejson: str


class HeightShift(TypedDict):
    """How far one map's heights lie off another's, by the ground that stayed as it was."""
    east_m: Optional[float]
    # Both null where the ground does not tell
    north_m: Optional[float]
    up_m: float
    # What levels are unsure by once it is taken out; null where nothing was taken out (align=none)
    sigma_m: Optional[float]
    # Of what both measured: 0 to 1, differs by less than half a metre then. Where it is small, most of the ground has
    # changed, and what was taken out may be that
    alike_share: float


class TileJsonStopsItem(TypedDict):
    change_m: float
    colour: str


class TileJsonForSure(TypedDict):
    """What TileJson always has."""
    tilejson: str
    # Templates with {z}, {x} and {y}
    tiles: List[str]
