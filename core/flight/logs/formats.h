// The formats of logs. Of each, LooksLike* recognises the first bytes of a file and Parse* makes a FlightLog
// of all of them; read_log.h chooses among them. t_s is in seconds on the log's own clock, 0 at the first
// sample unless it is said otherwise; damaged parts and rows are skipped and counted in the warnings. Any
// thread. Errors: kCorrupt where nothing could be read, and what else is said below. Sources are
// below autopilots, csv, texts, subtitles and tracks; two formats that share most of their reading share one.
#pragma once

#include <string_view>

#include "core/base/result.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/logs/flight_log.h"

namespace skyquilt::flight {

// PX4 ULog (.ulg), versions 0 and 1: typed topics with nested types, appended data sections, drop-outs.
// sensor_combined, vehicle_attitude, vehicle_gps_position or sensor_gps (old integer and new double fields),
// vehicle_air_data or sensor_baro, distance_sensor, camera_capture (else camera_trigger). Of topics with
// several instances the first one is read. Time: microseconds since boot; UTC from time_utc_usec. Damage is
// skipped to the next sync mark. Method: the ULog file format page of the PX4 guide.
bool LooksLikeUlog(LogBytes head);
Result<FlightLog> ParseUlog(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

// ArduPilot DataFlash logs (.BIN, and .log where they were converted to text): self-describing binary
// messages, 0xA3 0x95 id. The FMT messages (id 128) name the fields of all others, so old and new layouts are
// read alike. IMU, ATT (else AHR2, XKF1, NKF1, EKF1), GPS with GPA (else POS), BARO, RFND, CAM (else TRIG).
// Where a sensor is there more than once, one instance serves the whole run: the IMU with the fewest clips,
// the GPS with the best fix. Time: TimeUS (old: TimeMS) since boot; UTC from the GPS week and its leap
// seconds. Method: "DataFlash logs" of the ArduPilot documentation and AP_Logger's list of format characters.
bool LooksLikeDataflash(LogBytes head);
Result<FlightLog> ParseDataflash(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});
bool LooksLikeDataflashText(LogBytes head);
Result<FlightLog> ParseDataflashText(std::string_view name, LogBytes bytes,
                                     const ConsumedUpTo& consumed = {});

// MAVLink telemetry logs (.tlog), protocol 1 and 2: each packet behind an 8-byte big-endian Unix time in
// microseconds, taken by the ground station's clock. The vehicle's own clock (time_boot_ms) times the
// samples, so that the jitter of the radio link does not; UTC comes from SYSTEM_TIME where the vehicle knows
// it, else from the ground station. GPS_RAW_INT (else GLOBAL_POSITION_INT), ATTITUDE, HIGHRES_IMU,
// DISTANCE_SENSOR or RANGEFINDER, MOUNT_ORIENTATION, CAMERA_FEEDBACK, CAMERA_IMAGE_CAPTURED, CAMERA_TRIGGER.
// The vehicle with the most ATTITUDE messages is read. Known messages must pass their checksum. Method:
// mavlink.io, "Packet Serialization" and common.xml.
bool LooksLikeMavlinkTlog(LogBytes head);
Result<FlightLog> ParseMavlinkTlog(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

// The documented CSV pair.
// flight.csv, sparse rows, any subset of: t (s) or utc (ISO 8601); wx wy wz (rad/s), ax ay az (m/s2, specific
// force, body x forward, y right, z down: at rest az = -9.81); qw qx qy qz (body to NED) or roll pitch yaw
// (deg); lat lon (deg), alt_ell or alt_msl (m), vn ve vd (m/s), sh sv (m, 1 sigma), fix (6 or "fixed": RTK);
// baro_alt (m) or press (Pa); range (m); rel_alt (m above take-off); event (image name or number).
// images.csv: image, t or utc, lat, lon, alt_ell, alt_msl, rel_alt, yaw pitch roll (deg, horizon zero, the
// camera's), sh, sv, s_rp, s_yaw (deg, 1 sigma). Its rows become camera events.
bool LooksLikeFlightCsv(LogBytes head);
Result<FlightLog> ParseFlightCsv(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});
bool LooksLikeImagesCsv(LogBytes head);
Result<FlightLog> ParseImagesCsv(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

// CSV logs of other makers (AirData, phone recorders, research rigs): columns are recognised by synonyms,
// units by what the headers say, and both are checked against physics: gravity for accelerations, the
// attitude column for angular rates, the step of the clock for times. The outcome is echoed in
// FlightLog::mapping; a unit that a header states and the numbers contradict is an error that names the
// column. A column of photos may hold flags, numbers or names: `time_s,photo` is a table of exposures; rows
// that name photos and say where they were taken, not when, become camera events without a time. What the
// cells say of their columns beyond the names, settle_columns.h finds; cells that cannot be read are told
// (unread_cells.h). Also the headerless replay rows "time_us,imu|gps|baro,values" of the PX4 estimator
// library. Errors: kUnprocessable (contradiction), kUnsupportedFormat (no column we know).
bool LooksLikeTolerantCsv(LogBytes head);
// A list of photos with names of columns, whichever program wrote it: image, two coordinates in degrees or of
// a plane, and what else the names say (list_columns.h), below a line that names the system or without one.
bool LooksLikeNamedPlaces(LogBytes head);
Result<FlightLog> ParseTolerantCsv(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

// Exposure logs of DJI and Autel RTK cameras (.MRK): one tab-separated row an exposure, GPS week and time of
// week, the position of the image sensor (the offset from the antenna is already applied), sigma north, east,
// down, and a flag (16 single, 34 float, 50 fixed). Rows become camera events with their sequence number.
bool LooksLikeDjiMrk(LogBytes head);
Result<FlightLog> ParseDjiMrk(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

// Solutions of RTKLIB and its kin (.pos): "%" header, then date and time or GPS week and seconds, latitude,
// longitude (degrees, or degrees minutes seconds), ellipsoidal height, quality (1 fixed), satellites, sigma
// north, east, up. Also its ECEF form, and fields apart by commas or semicolons where the header's are. Times
// are GPS time or UTC as the header says; positions are the ANTENNA's.
bool LooksLikeRtklibPos(LogBytes head);
Result<FlightLog> ParseRtklibPos(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

// geo.txt of OpenDroneMap: a reference system in the first line, then "image x y [z [yaw pitch roll [sh
// sv]]]" per photo, x before y, degrees, pitch 0 = straight down, NaN for an angle that is not known; cut at
// blanks, tabs, semicolons or commas; below a line of column names it is a table. What the rows say is
// kept as written beside its plain reading; which reading is true, core/poses/lists judges, also of rows
// without a system. Angles counted from nadir are those of an airframe whose camera looks down, and are kept
// as such. Rows become camera events without a time; z is taken as a height above the ellipsoid. Error:
// kUnsupportedFormat for an unknown reference system.
bool LooksLikeGeoTxt(LogBytes head);
Result<FlightLog> ParseGeoTxt(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

// Geolocation CSV of Pix4D without a header line (with one it is a table): "image,latitude,longitude,height[,
// three angles][,accH,accV]"; coordinates of a projected system stand east first, as "image,x,y,z". Without
// names yaw-pitch-roll and omega-phi-kappa look alike: they are left out with a warning. What the rows say is
// kept as written; core/poses/lists judges how to read it. Rows become camera events without a time.
bool LooksLikePix4dCsv(LogBytes head);
Result<FlightLog> ParsePix4dCsv(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

// geoinfo files of senseFly: "#Rev: sensefly/geoinfo", a header, then tab-separated rows with file name,
// latitude, longitude, altitude_amsl, altitude_wgs84, heading, pitch, roll of the airframe in degrees. Rows
// become camera events without a time.
bool LooksLikeSenseflyGeoinfo(LogBytes head);
Result<FlightLog> ParseSenseflyGeoinfo(std::string_view name, LogBytes bytes,
                                       const ConsumedUpTo& consumed = {});

// Subtitles that the cameras of DJI and Autel write beside a film: SubRip (.SRT) and Advanced SubStation
// Alpha
// (.ASS); cue_text.h says what is read of their words. Fixes become GNSS samples whose sigma follows the
// digits written; the camera's clock is kept as local_at_zero. t_s is the time in the film; where the clock
// runs ahead of it (a time lapse, films joined) t_s follows the clock. Error: kNoPosition without any.
bool LooksLikeDjiSrt(LogBytes head);
Result<FlightLog> ParseDjiSrt(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});
bool LooksLikeAss(LogBytes head);
Result<FlightLog> ParseAss(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});
// Either of them, in the time of the film.
Result<FlightLog> ParseFilmSubtitles(std::string_view name, LogBytes bytes);

// GPX: every point with a time becomes a GNSS sample: those of tracks, else of routes, else waypoints. <ele>
// is a height above mean sea level, <geoidheight> what the ellipsoid lies below it. Any prefix of the
// namespace, points in any order. Scanned, not built into a tree, so that size does not matter. Error:
// kNoPosition when no point with position and time could be read. Source: GPX 1.1 (topografix.com).
bool LooksLikeGpx(LogBytes head);
Result<FlightLog> ParseGpx(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

// KML tracks: gx:Track (the k-th <when> and the k-th <gx:coord> are a point) and Placemarks with a TimeStamp
// and a Point. Heights are above mean sea level; above the place of take-off where altitudeMode is relative,
// which is how flight apps write it; none where it is clamped. Scanned as GPX is. Error: kNoPosition where no
// point has position and time, as in the lines and areas that KML mostly holds. Source: OGC KML 2.3
// (12-007r2), Google's extensions.
bool LooksLikeKml(LogBytes head);
Result<FlightLog> ParseKml(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

// GeoJSON tracks: Features whose places have times, in a member `time`, `timestamp`, `datetime` and the like
// (one of a Point, as many as places of a line: coordTimes, times, datetimes), or in the fourth number of a
// place. The third number is taken for a height above mean sea level, which is what converters of GPX and KML
// write. Read as a stream: no document is built, 64 levels at most. Points in any order. Errors: kNoPosition
// where no place has a time, kCorrupt for what is no JSON. Source: RFC 7946, OGC Moving Features JSON
// (19-045r3), togeojson and kepler.gl for times.
bool LooksLikeGeoJson(LogBytes head);
// Areas, which no aircraft flew: what a map is cut to, whatever they are members of.
bool HasGeoJsonAreas(LogBytes bytes);
Result<FlightLog> ParseGeoJson(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

// NMEA 0183 recordings: GGA and GNS (position, fix, height and geoid separation), RMC (date; the position too
// where no sentence has a height), ZDA (date), GST (sigma), from any talker, alone in a line or behind what a
// recorder puts before it. Those with a wrong checksum are skipped; without one they count. UTC needs a date.
bool LooksLikeNmea(LogBytes head);
Result<FlightLog> ParseNmea(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

}  // namespace skyquilt::flight
