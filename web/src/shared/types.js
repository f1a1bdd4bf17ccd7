// The values that travel between the server and this page (see api/openapi.json). Types only; no code.

/**
 * @typedef {'empty'|'uploaded'|'queued'|'processing'|'ready'|'failed'} FlightState
 * @typedef {'accepted'|'running'|'successful'|'failed'|'dismissed'} JobState
 * @typedef {{code: string, message: string, reason?: Remark|null}} ServerError
 * What the server remarks, as a code of core/flight/remarks/remark.h with its values; a list is to be said within.
 * @typedef {{code: string, values: Record<string, any>}} Remark
 */

/**
 * @typedef {{name: string, code?: string, reason: string, remark?: Remark}} LeftOut a photo that is not in the map, and why
 * @typedef {[number, number, number, number]} Bounds west, south, east, north in degrees
 * @typedef {{total: number, aligned: number, pose_only: number, left_out: number}} PhotoCounts
 */

/**
 * @typedef {object} Job
 * @property {string} id
 * @property {string} flight_id
 * @property {JobState} state
 * @property {string} [stage]
 * @property {number} [progress] 0..1
 * @property {string} [message]
 * @property {number|null} [eta_s]
 * @property {Record<string, any>} [options] what it was asked for
 * @property {number|null} [eta_low_s] four of five jobs end between these
 * @property {number|null} [eta_high_s]
 * @property {number} [attempts]
 * @property {string|null} [created_at]
 * @property {ServerError|null} [error]
 * @property {JobPart[]} [parts] of a large flight, at work; for those who run the server
 * @property {WorkerAside[]} [workers_aside] for those too
 */

/**
 * @typedef {object} JobPart
 * @property {string} kind
 * @property {number} part
 * @property {string} worker
 * @property {string} since
 * @property {number} attempt
 */

/**
 * @typedef {object} WorkerAside takes nothing: its machine is in trouble
 * @property {string} worker
 * @property {string} until
 * @property {string} code
 * @property {string} message
 */

/**
 * @typedef {object} Flight
 * @property {string} id
 * @property {string} name
 * @property {FlightState} state
 * @property {string} created_at
 * @property {number} file_count
 * @property {number} bytes
 * @property {number|null} [revision]
 * @property {Job|null} [job]
 * @property {Bounds|null} [bounds]
 * @property {boolean|null} [georeferenced] false: its map lies nowhere on Earth
 * @property {number|null} [min_zoom]
 * @property {number|null} [max_zoom]
 * @property {PhotoCounts|null} [photos]
 * @property {Captured|null} [captured] when the photos in the map were taken; null where that is not known
 * @property {number|null} [gsd_m]
 * @property {MapQuality|null} [quality] null of maps of before it was known
 * @property {string[]} [tags]
 * @property {boolean} [keep] the server never puts it into the trash by itself
 * @property {string|null} [tilejson]
 * @property {Preview|null} [preview] until there is a map
 * @property {ServerError|string|null} [error]
 * @property {boolean} [may_change] whether this client may change it; true where the server does not say
 */

/**
 * By the clock on the wall there: "2015-10-27T09:31:02-04:00", with Z where the zone is not known, with neither where
 * the camera's clock was a local one.
 * @typedef {{first: string, last: string}} Captured
 */

/**
 * What who asks may do here.
 * @typedef {{needs_token: boolean, scope: 'read'|'upload'|'admin', flight: string|null, keep_days?: number}} Access keep_days: after
 *   which the server puts a flight that nobody changes into the trash; 0: never
 */

/**
 * What the server makes of the files that it has (as far as the page shows it).
 * @typedef {object} ServerVerdict
 * @property {number} photos_readable
 * @property {number} photos_placeable by what they record
 * @property {number} photos_by_images by what they show alone
 * @property {number} gsd_m 0 where it is not known
 * @property {number} area_m2
 * @property {number} expected_seconds
 * @property {LeftOut[]} left_out
 * @property {string[]} warnings in English
 * @property {Remark[]} [remarks] the same, one for each
 */

/**
 * @typedef {'dsm'|'dtm'} Surface what the photos show: ground, roofs, crowns; the ground below them
 * @typedef {{dsm_m?: number|null, dtm_m?: number|null}} SurfaceHeights of those that the map has; null where they are not known
 */

/**
 * @typedef {{distance_m: number, lon: number, lat: number, height_m: number|null} & SurfaceHeights} ProfileSample height_m: null beside the map
 */

/**
 * The ground along a line.
 * @typedef {object} GroundProfile
 * @property {'plane'|'grid'} ground plane: the map was made on level ground
 * @property {number} length_m
 * @property {number|null} lowest_m null where no sample has a height
 * @property {number|null} highest_m
 * @property {number} climb_m
 * @property {number} descent_m
 * @property {ProfileSample[]} samples
 * @property {Surface[]} [surfaces] that the samples have as well
 */

/**
 * What lies above and below a base, within an outline.
 * @typedef {object} VolumeFigures
 * @property {'lowest'|'plane'|'given'|'flight'} base
 * @property {HeightShift} [shift] of a flight's heights, taken out
 * @property {number} base_m its height; of a plane the mean
 * @property {number} area_m2 of the outline
 * @property {number} covered_m2 of it, where heights are known
 * @property {number} measured_share 0..1, of the outline; the rest is filled from around, or not known
 * @property {number} cut_m3 above the base
 * @property {number} fill_m3 below it
 * @property {number} net_m3
 * @property {number|null} net_sigma_m3 null: too little was measured to say, or the base is a given height
 */

/** How far one map's heights lie off another's. @typedef {{east_m: number|null, north_m: number|null, up_m: number, sigma_m: number|null, alike_share: number}} HeightShift */

/** @typedef {TileJson & {shift: HeightShift, least_shown_m: number, stops: {change_m: number, colour: string}[]}} ChangeTileJson */

/** @typedef {GeoJSON.FeatureCollection<GeoJSON.LineString, {height_m: number}>} ContourCollection */

/** @typedef {{id: string, created_at: string, expires_at: string|null}} Share */

/**
 * A map in another format, coordinate system, area or resolution, made by the server and kept for a day.
 * @typedef {object} MapExport
 * @property {string} id
 * @property {string} format
 * @property {string|null} crs
 * @property {number|null} resolution_m
 * @property {object|null} boundary
 * @property {string|null} index by its name, of a file of values
 * @property {string|null} expression likewise
 * @property {Remark|null} [remark] what is to be known of the file
 * @property {boolean} is_current of the map that is shown now
 * @property {'accepted'|'running'|'successful'|'failed'} state
 * @property {number} progress 0..1
 * @property {number|null} bytes
 * @property {ServerError|null} error
 * @property {string|null} expires_at
 * @property {string|null} download address of the file
 */

/**
 * A deleted flight that can be restored.
 * @typedef {object} TrashedFlight
 * @property {string} id
 * @property {string} name
 * @property {string} created_at
 * @property {number} file_count
 * @property {number} bytes
 * @property {string} deleted_at
 * @property {number} days_left
 */

/** @typedef {{days: number, flights: TrashedFlight[]}} Trash days: 0 where deleted flights are not kept */

/**
 * The coarse map of the photos that have arrived.
 * @typedef {{edition: number, photos: number, bounds: Bounds, tilejson: string}} Preview
 */

/** @typedef {{kind: 'not_georeferenced'|'scale_guessed'|'north_guessed'|'few_positions'|'positions_contradicted'|'far_off'|'control_contradicted'|'checks_missed'|'placed_by_hand'|'left_out'|'none_aligned'|'pose_only', count: number, of: number}} MapLimit */

/**
 * How true a map is and whether it is fit for use.
 * @typedef {object} MapQuality
 * @property {'ready'|'limited'|'doubtful'|'unplaced'|'unknown'} status
 * @property {{sigma_m: number|null, by: 'none'|'hand'|'gnss'|'rtk'|'control_points'|'check_points', count: number}} absolute where it lies
 * @property {{error_m: number|null, error_px: number|null, by: 'none'|'tie_points'|'seams', count: number}} relative how well it fits itself
 * @property {MapLimit[]} limits the weightiest first
 */

/**
 * @typedef {object} Report
 * @property {PhotoCounts} photos
 * @property {LeftOut[]} left_out_photos
 * @property {number} gsd_m
 * @property {number} area_m2
 * @property {Bounds} bounds
 * @property {number} min_zoom
 * @property {number} max_zoom
 * @property {{stage: string, wall_s: number}[]} timings
 * @property {number} peak_memory_bytes
 * @property {string[]} warnings in English
 * @property {Remark[]} [remarks] the same, one for each
 * @property {boolean} [is_placed] false: nothing says where on Earth the flight was
 * @property {MapQuality} [quality]
 * @property {{placed_by?: 'images'|'records', ground_control?: ControlFigures[]}|null} [alignment]
 * @property {{bands: ReportedBand[]}} [bands] of a camera with several
 * @property {{cell_m: number, measured_share: number, heights_from?: 'survey'|'records', records_from?: 'ellipsoid'|'take_off', contour_interval_m?: number}} [surface] of heights that were matched
 */

/**
 * @typedef {object} ReportedBand
 * @property {string} name
 * @property {'levels'|'radiance'|'relative reflectance'|'reflectance'|'kelvin'} calibration
 * @property {'panel'|'targets'|null} [held_against] what of known reflectance
 */

/**
 * A surveyed point in a report: adjusted minus surveyed, and how far its marks lie off.
 * @typedef {object} ControlFigures
 * @property {string} name
 * @property {number} sightings
 * @property {boolean} is_used
 * @property {string} reason in English: why it is not used, or not all of its marks
 * @property {Remark} [remark] the same; without it in what was written by earlier versions
 * @property {number} miss_east_m
 * @property {number} miss_north_m
 * @property {number|null} miss_up_m null: no height was compared
 * @property {number} residual_px
 * @property {boolean} [is_check] compared with the finished map, which it does not place
 * @property {{miss_east_m: number, miss_north_m: number, miss_up_m: number|null}} [left_out] where a map placed by the other points alone puts it
 * @property {{photo: string, residual_px: number, residual_m: number, is_used: boolean}[]} [marks]
 */

/**
 * @typedef {object} TileJson
 * @property {string[]} tiles
 * @property {string} [name]
 * @property {string} [attribution] whose map it is, where somebody says so
 * @property {number} [minzoom]
 * @property {number} [maxzoom]
 * @property {string} [version] of a preview it begins with "0."
 * @property {Bounds} [bounds]
 * @property {Bounds} [across_bounds] of a map across the antimeridian, whose `bounds` go around the Earth; its east is beyond 180
 * @property {number} [tileSize] side of a tile's picture in pixels; 256 when not said
 * @property {MapLayer[]} [layers] beside the map
 * @property {string[]} [bands] that expressions can name
 * @property {Bounds} [bands_bounds] where indices have tiles, if that is not where the map has
 * @property {MapIndex[]} [indices] that the bands are enough for
 * @property {Surface[]} [heights] that the map has
 * @property {string} [terrain] address of their tiles' TileJSON
 */

/**
 * @typedef {object} MapIndex
 * @property {string} [id] absent: an expression of the user's own
 * @property {string} title
 * @property {string} expression
 * @property {[number, number]} rescale
 * @property {string} colormap
 */

/**
 * @typedef {object} MapBands
 * @property {string[]} bands
 * @property {MapIndex[]} indices
 * @property {{id: string, colours: string[]}[]} colormaps
 */

/**
 * What an index comes to; null where it has no value anywhere.
 * @typedef {object} IndexStatistics
 * @property {number|null} min
 * @property {number|null} max
 * @property {number|null} mean
 * @property {Record<string, number|null>} percentiles
 * @property {number[]} histogram
 */

/**
 * @typedef {object} MapLayer
 * @property {'photo'|'error'|'height'} id
 * @property {string} tilejson address
 * @property {string} legends address
 */

/**
 * What the colours of a map's layers mean.
 * @typedef {object} LayerLegends
 * @property {{colours: {photo: string, colour: string}[]}} [photo]
 * @property {{stops: {error_radius_m: number, colour: string}[]}} [error]
 * @property {{range_m: [number, number]}} [height]
 */

/**
 * @typedef {object} PhotoRecord
 * @property {string} name
 * @property {'aligned'|'pose_only'} placement
 * @property {string|null} [reason] in English: why it is not aligned, or what was corrected
 * @property {Remark[]} [remarks] the same; without them in what was written by earlier versions
 * @property {number|null} [error_radius_m]
 * @property {number} camera_lon
 * @property {number} camera_lat
 * @property {number|null} [camera_height_above_ground_m]
 * @property {number|null} [yaw_deg]
 * @property {number|null} [pitch_deg]
 * @property {number|null} [roll_deg]
 * @property {string|null} [captured_at]
 */

/**
 * @typedef {{type: 'Feature', id?: string|number, properties: PhotoRecord,
 *            geometry: {type: 'Polygon', coordinates: number[][][]}}} PhotoFeature
 * @typedef {{type: 'FeatureCollection', features: PhotoFeature[]}} PhotoCollection
 */

/**
 * A photo that sees a place, and the pixel that shows it (the centre of the first one is (0, 0)).
 * @typedef {{name: string, x: number, y: number, off_nadir_deg?: number, sharpness?: number|null, quality?: number, sigma_m?: number|null, placement?: 'aligned'|'pose_only'}} Sighting
 */

/**
 * @typedef {{name: string, bytes: number}} StoredFile
 */

export {};
