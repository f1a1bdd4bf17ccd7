// Photo: what one photo file says of itself, normalised. Values; any thread. Angles are the CAMERA's, or
// marked as the airframe's: yaw clockwise from true north, pitch 0 = horizon and -90 deg = straight down,
// roll right wing down; intrinsic Z-Y-X in NED, radians.
#pragma once

#include <Eigen/Core>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error_code.h"
#include "core/camera/intrinsics.h"
#include "core/flight/remarks/remark.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::flight {

using UtcTime = std::chrono::sys_time<std::chrono::microseconds>;

inline double SecondsBetween(UtcTime from, UtcTime to) {
  return std::chrono::duration<double>(to - from).count();
}

inline UtcTime LaterBy(UtcTime time, double seconds) {
  return time + std::chrono::microseconds(std::llround(seconds * 1e6));
}

// Height zero matters more than the number: each kind is kept apart, absent when not recorded.
struct GnssHeights {
  std::optional<double> height_ellipsoid_m, height_amsl_m;
  bool is_rtk_fixed = false;  // the fix that these and the place are of
};

struct RecordedHeights : GnssHeights {
  std::optional<double> height_above_takeoff_m;
  std::optional<double> height_above_ground_m;  // measured (range finder)
};

struct RecordedPosition : RecordedHeights {
  geo::LatLon position;
  std::optional<double> sigma_horizontal_m;
  std::optional<double> sigma_vertical_m;
  std::optional<double> system_error_m;  // that all share whose datum's place on Earth is not known better
  bool is_repeated = false;              // of a fix of before, and moved on from there: it places nothing
  std::string source;                    // "xmp", "exif", "geo.txt", ...
};

// What EXIF says beside the maker's XMP, where both say place and altitude: programs of post-processing
// correct EXIF alone (correct_heights.h).
struct ExifBesideXmp {
  geo::LatLon place, makers_place;
  double step_m = 0.0;                // in which EXIF's place is written
  double altitude_m = 0.0;            // EXIF's, from a zero that is not known yet
  double makers_altitude_m = 0.0;     // from whatever zero
  bool is_altitude_from_sea = false;  // EXIF's, as it says itself
};

// One sigma of a horizontal axis, assumed: of a receiver by itself (DJI and u-blox state it), and with fixed
// corrections: base and antenna, and the moment of the exposure.
inline constexpr double kPlainSigmaM = 1.5, kFixedSigmaM = 0.03;
inline constexpr double kMinStatedM = 0.002;  // what is below is a number for "none", or in another unit

// As the position states it, else as assumed: for whoever weighs it.
inline double SigmaOfRecordM(const RecordedPosition& position) {
  const double assumed_m = position.is_rtk_fixed ? kFixedSigmaM : kPlainSigmaM;
  const double stated_m = position.sigma_horizontal_m.value_or(assumed_m);
  return stated_m >= kMinStatedM ? stated_m : assumed_m;
}

enum class AttitudeKind {
  kGimbal,    // the camera's own angles
  kAirframe,  // the body's angles; the camera is fixed to it, looking down, image top forward unless told
              // otherwise
};

struct RecordedAttitude {
  AttitudeKind kind = AttitudeKind::kGimbal;
  double yaw_rad = 0.0;
  double pitch_rad = 0.0;  // horizon zero, also for sources that count from nadir
  double roll_rad = 0.0;
  std::string source;  // "drone-dji", "sensefly", "Camera", ...
};

// Where the top of the picture as it is stored points, seen from above, by a compass: all that cameras
// without angles say. Of a camera that looks ahead it is where it looks: the same once it is tipped down.
struct RecordedDirection {
  double yaw_rad = 0.0;
  bool is_from_true_north = false;  // false: from magnetic north, or it is not said
};

// How fast a camera turned at one moment.
struct TurnRate {
  double time_s = 0.0;  // since the first row began to be read
  Eigen::Vector3d in_cam_radps = Eigen::Vector3d::Zero();
};

// How a camera turned around the exposure of one photo, by its gyro; in time order, without long gaps.
struct RecordedTurning {
  std::vector<TurnRate> samples;
};

enum class FocalSource {
  kDewarpData,
  kCalibrated,
  kXmpCamera,
  kFocalPlane,
  kSensorTable,
  k35mmEquivalent,
  kDoubtful,  // recorded, and contradicted by a zoom or another focal length on record
  kAssumed
};

// Which of the lenses of one aircraft took a picture, as its maker writes it.
enum class Lens { kUnsaid, kWide, kZoom, kThermal };

// What tells a picture as the camera wrote it from what another program made of it.
struct PictureOrigin {
  std::optional<UtcTime> clock;  // the camera's as it was written, of whatever zone
  bool is_edited = false;        // its tags name a program that changes pictures
  int makers_records = 0;        // how many kinds of what only makers write: a note, XMP, a sensor's levels
};

// What a sample of a picture is.
enum class SampleKind {
  kBytes,         // 8 bits, drawn as they are
  kLevels,        // whole numbers above zero of up to 16 bits, one channel
  kColourLevels,  // the same, three channels or four
  kSigned,        // whole numbers of either sign, one channel
  kFloating,      // one channel
};

// Of samples that are more than bytes: drawn black at `low` and below, white from `high` on.
struct SampleRange {
  double low = 0.0;
  double high = 65536.0;
};

struct Photo {
  std::string name;            // as the user named the file; of a name given twice with folders in front
  std::filesystem::path path;  // where the bytes are
  std::string make;
  std::string model;
  std::string software;
  std::string camera_key;  // photos with the same key share one physical camera at one image size
  std::string band_name;   // as a camera of one band a picture writes it; empty for colour
  std::vector<std::string> other_names;  // as lists may call it too: of the pictures that are placed with it
  Lens lens = Lens::kUnsaid;
  PictureOrigin origin;
  SampleKind sample_kind = SampleKind::kBytes;
  std::optional<SampleRange> sample_range;  // the camera's of a whole flight (sample_format.h)
  camera::Intrinsics intrinsics;
  FocalSource focal_source = FocalSource::kAssumed;
  std::optional<UtcTime> captured_at;
  bool captured_at_is_local = false;                    // the clock was local and the zone is unknown
  std::optional<std::chrono::minutes> clock_minus_utc;  // the zone of the camera's clock, where it is known
  std::optional<UtcTime> receiver_time;  // as a receiver of GNSS told it, whatever the camera's clock
  // Without its day, which the flight tells (TakeZoneOfFlight), beside a camera's clock of unknown zone.
  std::optional<std::chrono::microseconds> receiver_time_of_day;
  std::optional<RecordedPosition> position;
  std::optional<ExifBesideXmp> exif_beside_xmp;
  std::optional<double> lone_height_above_takeoff_m;  // recorded without a position, which has its own
  std::optional<RecordedAttitude> attitude;
  std::optional<RecordedDirection> direction;
  std::optional<Eigen::Vector3d> velocity_in_enu_mps;
  std::optional<RecordedTurning> turning;
  std::optional<double> exposure_time_s;
  std::optional<double> exposure_log2;  // how much light counts: log2(time x ISO / 100 / f-number^2)
  std::optional<double> readout_s;    // from the first row to the last, of a camera known to read row by row
  bool is_resaved_by_viewer = false;  // the picture may have been turned after its angles were recorded
  std::vector<Remark> notes;          // what was corrected or doubted on reading
};

// A photo or file that takes no part in the map, and why.
struct LeftOutPhoto {
  std::string name;
  ErrorCode code = ErrorCode::kCorrupt;
  Remark reason = "";  // for the user, says what to do
};

// What took it, as a person says it: many makers repeat themselves in the model's name.
std::string MakeAndModel(const Photo& photo);

// The order of a flight: by time of capture, then by name, "9" before "10"; photos without a time come last.
bool ComesBefore(const Photo& a, const Photo& b);

const char* FocalSourceName(FocalSource source);

}  // namespace skyquilt::flight
