#include "core/flight/photos/correct_heights.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "core/base/median.h"
#include "core/geo/geoid.h"

namespace skyquilt::flight {
namespace {

struct CorrectedZero {
  bool is_sea = false;
  RemarkCode told_by = RemarkCode::kFromEllipsoidAssumed;
};

// How far the altitudes in XMP lie from EXIF's in the median, with these counted from one zero and from the
// other.
struct ByZero {
  double ellipsoid_m = 0.0;
  double sea_m = 0.0;
};

// Nothing where the geoid is not known or XMP has no height.
std::optional<ByZero> DistancesByZero(const std::vector<Photo*>& photos) {
  std::vector<double> from_ellipsoid_m, from_sea_m;
  for (const Photo* photo : photos) {
    const RecordedPosition& position = *photo->position;
    const auto geoid_m = geo::GeoidHeightM(position.position);
    if (!geoid_m || (!position.height_ellipsoid_m && !position.height_amsl_m)) continue;
    const double xmp_m =
        position.height_ellipsoid_m ? *position.height_ellipsoid_m : *position.height_amsl_m + *geoid_m;
    from_ellipsoid_m.push_back(photo->exif_beside_xmp->altitude_m - xmp_m);
    from_sea_m.push_back(photo->exif_beside_xmp->altitude_m + *geoid_m - xmp_m);
  }
  if (from_sea_m.empty()) return std::nullopt;
  return ByZero{std::abs(Median(std::move(from_ellipsoid_m))), std::abs(Median(std::move(from_sea_m)))};
}

CorrectedZero ZeroOfCorrected(const std::vector<Photo*>& photos) {
  const auto is_said = [](const Photo* photo) { return photo->exif_beside_xmp->is_altitude_from_sea; };
  if (std::all_of(photos.begin(), photos.end(), is_said)) return {true, RemarkCode::kFromSeaSaid};
  const auto apart = DistancesByZero(photos);
  if (!apart) return {};
  // What altitudes may be off: of a receiver that knows the ellipsoid, and of one beside a barometer.
  constexpr double kReceiverM = 5.0, kBarometerM = 12.0;
  constexpr double kClearly = 2.5;
  const bool is_by_receiver = std::all_of(photos.begin(), photos.end(), [](const Photo* photo) {
    return photo->position->height_ellipsoid_m.has_value();
  });
  const double near_m = is_by_receiver ? kReceiverM : kBarometerM;
  const double far_m = kClearly * near_m;
  if (apart->ellipsoid_m < near_m && apart->sea_m > far_m) return {false, RemarkCode::kFromEllipsoidFound};
  if (apart->sea_m < near_m && apart->ellipsoid_m > far_m) return {true, RemarkCode::kFromSeaFound};
  return {};
}

}  // namespace

void TakeCorrectedHeights(std::vector<Photo>& photos, std::vector<Remark>& warnings) {
  constexpr std::size_t kFewest = 3, kOneOf = 10;
  std::vector<Photo*> corrected;
  std::vector<double> apart_m, altitudes_apart_m;
  for (Photo& photo : photos) {
    if (!photo.position || !photo.exif_beside_xmp) continue;
    corrected.push_back(&photo);
    apart_m.push_back(photo.exif_beside_xmp->apart_m);
    altitudes_apart_m.push_back(photo.exif_beside_xmp->altitudes_apart_m);
  }
  if (corrected.size() < kFewest || kOneOf * corrected.size() < photos.size()) return;
  const CorrectedZero zero = ZeroOfCorrected(corrected);
  for (Photo* photo : corrected) {
    RecordedPosition& position = *photo->position;
    position.height_amsl_m.reset();
    position.height_ellipsoid_m.reset();
    (zero.is_sea ? position.height_amsl_m : position.height_ellipsoid_m) = photo->exif_beside_xmp->altitude_m;
    std::erase_if(photo->notes, [](const Remark& note) { return note.code == RemarkCode::kAltitudesApart; });
  }
  warnings.push_back({RemarkCode::kExifCorrected,
                      {{"photos", corrected.size()},
                       {"total", photos.size()},
                       {"apart_m", Median(std::move(apart_m))},
                       {"differ_m", Median(std::move(altitudes_apart_m))},
                       {"zero", Remark(zero.told_by)}}});
}

}  // namespace skyquilt::flight
