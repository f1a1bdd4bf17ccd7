#include "core/flight/photos/correct_heights.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <optional>
#include <utility>

#include "core/base/median.h"
#include "core/geo/geoid.h"
#include "core/geo/local_frame.h"

namespace skyquilt::flight {
namespace {

using EastNorth = std::complex<double>;  // east and north: what turns both is a factor

constexpr std::size_t kFewestCorrected = 5, kOneOf = 10;

// What EXIF says otherwise than the maker's XMP in one photo.
struct Correction {
  Photo* photo = nullptr;
  EastNorth moved_m;  // EXIF's place less the maker's
  double higher_m = 0.0;
  bool is_moved = false;    // by more than the steps in which both are written
  EastNorth way_of_flight;  // of length 1; zero where the aircraft stands
};

EastNorth ApartM(const geo::LatLon& from, const geo::LatLon& to) {
  const geo::LocalFrame frame(geo::Wgs84{from.lat_deg, from.lon_deg, 0.0});
  const Eigen::Vector3d apart_m = frame.EnuAtHeight(to, 0.0);
  return {apart_m.x(), apart_m.y()};
}

// Of photos that say both.
std::vector<Correction> CorrectionsIn(std::vector<Photo>& photos) {
  constexpr double kStepsOfXmpM = 0.2;  // of six decimals of a degree
  constexpr double kElsewhereM = 50.0;  // by more no receiver is corrected
  std::vector<Correction> found;
  for (Photo& photo : photos) {
    if (!photo.position || !photo.exif_beside_xmp) continue;
    const ExifBesideXmp& beside = *photo.exif_beside_xmp;
    Correction one;
    one.photo = &photo;
    one.moved_m = ApartM(beside.makers_place, beside.place);
    one.higher_m = beside.altitude_m - beside.makers_altitude_m;
    if (std::abs(one.moved_m) > kElsewhereM) continue;
    one.is_moved = std::abs(one.moved_m) >= kStepsOfXmpM + 2.0 * beside.step_m;
    found.push_back(one);
  }
  constexpr double kStandsM = 1.0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Photo& before = *found[i > 0 ? i - 1 : i].photo;
    const Photo& after = *found[std::min(i + 1, found.size() - 1)].photo;
    const EastNorth flown_m = ApartM(before.exif_beside_xmp->place, after.exif_beside_xmp->place);
    if (std::abs(flown_m) > kStandsM) found[i].way_of_flight = flown_m / std::abs(flown_m);
  }
  return found;
}

bool IsOtherAltitude(const Correction& one) {
  constexpr double kStepsOfHeightM = 0.3;
  return std::abs(one.higher_m) >= kStepsOfHeightM;
}

// By least squares each photo is moved by one shift and by a factor of its way of flight, which is all that
// another moment or another antenna can do.
bool IsOneShift(const std::vector<Correction>& corrected) {
  constexpr double kMinShiftM = 0.5;  // no antenna is further from its camera
  constexpr double kTurns = 0.3;  // of ways of flight about their mean: 1 there and back, 0 in one direction
  const auto count = static_cast<double>(corrected.size());
  EastNorth mean_m, mean_way;
  for (const Correction& one : corrected) {
    mean_m += one.moved_m / count;
    mean_way += one.way_of_flight / count;
  }
  EastNorth product;
  double turns = 0.0;
  for (const Correction& one : corrected) {
    const EastNorth turned = one.way_of_flight - mean_way;
    product += std::conj(turned) * (one.moved_m - mean_m);
    turns += std::norm(turned);
  }
  if (turns < kTurns * count) return false;
  const EastNorth by_way_m = product / turns;
  const EastNorth shift_m = mean_m - by_way_m * mean_way;
  double left_m2 = 0.0;
  for (const Correction& one : corrected)
    left_m2 += std::norm(one.moved_m - shift_m - by_way_m * one.way_of_flight) / count;
  return std::abs(shift_m) > kMinShiftM && std::norm(shift_m) > left_m2;
}

// EXIF's altitude is the height above take-off, maybe of another moment.
bool AreAboveTakeoff(const std::vector<Correction>& corrected) {
  std::vector<double> from_takeoff_m, from_makers_m;
  for (const Correction& one : corrected) {
    const auto& above_takeoff_m = one.photo->position->height_above_takeoff_m;
    if (!above_takeoff_m) continue;
    from_takeoff_m.push_back(std::abs(one.photo->exif_beside_xmp->altitude_m - *above_takeoff_m));
    from_makers_m.push_back(std::abs(one.higher_m));
  }
  constexpr double kNearM = 3.0;
  if (from_takeoff_m.empty()) return false;
  const double apart_m = Median(std::move(from_takeoff_m));
  return apart_m < kNearM && apart_m < Median(std::move(from_makers_m));
}

// The photos of the flight whose EXIF was corrected; none where that is not clear.
std::vector<Correction> CorrectedOf(std::vector<Photo>& photos) {
  const std::vector<Correction> both = CorrectionsIn(photos);
  std::vector<Correction> corrected;
  for (const Correction& one : both) {
    if (one.is_moved && IsOtherAltitude(one)) corrected.push_back(one);
  }
  if (corrected.size() < kFewestCorrected || kOneOf * corrected.size() < photos.size()) return {};
  if (!IsOneShift(corrected) || AreAboveTakeoff(corrected)) return {};
  // Where most are, the correction moved the others by little: heights of two zeros would bend the flight.
  if (2 * corrected.size() <= both.size()) return corrected;
  std::vector<Correction> with_near;
  for (const Correction& one : both) {
    if (IsOtherAltitude(one)) with_near.push_back(one);
  }
  return with_near;
}

struct CorrectedZero {
  bool is_sea = false;
  RemarkCode told_by = RemarkCode::kFromEllipsoidAssumed;
};

// How far the altitudes in XMP lie from EXIF's in the median, with these counted from either zero.
struct ByZero {
  double ellipsoid_m = 0.0;
  double sea_m = 0.0;
};

// Nothing where the geoid is not known or XMP has no height.
std::optional<ByZero> DistancesByZero(const std::vector<Correction>& corrected) {
  std::vector<double> from_ellipsoid_m, from_sea_m;
  for (const Correction& one : corrected) {
    const RecordedPosition& position = *one.photo->position;
    const auto geoid_m = geo::GeoidHeightM(position.position);
    if (!geoid_m || (!position.height_ellipsoid_m && !position.height_amsl_m)) continue;
    const double xmp_m =
        position.height_ellipsoid_m ? *position.height_ellipsoid_m : *position.height_amsl_m + *geoid_m;
    from_ellipsoid_m.push_back(one.photo->exif_beside_xmp->altitude_m - xmp_m);
    from_sea_m.push_back(one.photo->exif_beside_xmp->altitude_m + *geoid_m - xmp_m);
  }
  if (from_sea_m.empty()) return std::nullopt;
  return ByZero{std::abs(Median(std::move(from_ellipsoid_m))), std::abs(Median(std::move(from_sea_m)))};
}

CorrectedZero ZeroOfCorrected(const std::vector<Correction>& corrected) {
  const auto is_said = [](const Correction& one) { return one.photo->exif_beside_xmp->is_altitude_from_sea; };
  if (std::all_of(corrected.begin(), corrected.end(), is_said)) return {true, RemarkCode::kFromSeaSaid};
  const auto apart = DistancesByZero(corrected);
  if (!apart) return {};
  // What altitudes may be off: of a receiver that knows the ellipsoid, and of one beside a barometer.
  constexpr double kReceiverM = 5.0, kBarometerM = 12.0;
  constexpr double kClearly = 2.5;
  const bool is_by_receiver = std::all_of(corrected.begin(), corrected.end(), [](const Correction& one) {
    return one.photo->position->height_ellipsoid_m.has_value();
  });
  const double near_m = is_by_receiver ? kReceiverM : kBarometerM;
  const double far_m = kClearly * near_m;
  if (apart->ellipsoid_m < near_m && apart->sea_m > far_m) return {false, RemarkCode::kFromEllipsoidFound};
  if (apart->sea_m < near_m && apart->ellipsoid_m > far_m) return {true, RemarkCode::kFromSeaFound};
  return {};
}

}  // namespace

void TakeCorrectedHeights(std::vector<Photo>& photos, std::vector<Remark>& warnings) {
  const std::vector<Correction> corrected = CorrectedOf(photos);
  if (corrected.empty()) return;
  const CorrectedZero zero = ZeroOfCorrected(corrected);
  std::vector<double> apart_m, altitudes_apart_m;
  for (const Correction& one : corrected) {
    apart_m.push_back(std::abs(one.moved_m));
    altitudes_apart_m.push_back(std::abs(one.higher_m));
    RecordedPosition& position = *one.photo->position;
    position.height_amsl_m.reset();
    position.height_ellipsoid_m.reset();
    (zero.is_sea ? position.height_amsl_m : position.height_ellipsoid_m) =
        one.photo->exif_beside_xmp->altitude_m;
    std::erase_if(one.photo->notes,
                  [](const Remark& note) { return note.code == RemarkCode::kAltitudesApart; });
  }
  warnings.push_back({RemarkCode::kExifCorrected,
                      {{"photos", corrected.size()},
                       {"total", photos.size()},
                       {"apart_m", Median(std::move(apart_m))},
                       {"differ_m", Median(std::move(altitudes_apart_m))},
                       {"zero", Remark(zero.told_by)}}});
}

void DropAltitudesOfZero(std::vector<Photo>& photos, std::vector<Remark>& warnings) {
  constexpr std::size_t kFewestZeros = 3;
  std::size_t zeros = 0;
  for (const Photo& photo : photos) {
    if (!photo.position) continue;
    const std::optional<double>& amsl_m = photo.position->height_amsl_m;
    const std::optional<double>& ellipsoid_m = photo.position->height_ellipsoid_m;
    if (amsl_m.value_or(0.0) != 0.0 || ellipsoid_m.value_or(0.0) != 0.0) return;
    if (amsl_m || ellipsoid_m) ++zeros;
  }
  if (zeros < kFewestZeros) return;
  for (Photo& photo : photos) {
    if (!photo.position) continue;
    photo.position->height_amsl_m.reset();
    photo.position->height_ellipsoid_m.reset();
  }
  warnings.push_back({RemarkCode::kAltitudesOfZero, {{"photos", zeros}}});
}

}  // namespace skyquilt::flight
