#include "core/poses/lists/list_words.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "core/flight/remarks/remark_words.h"
#include "core/geo/crs/reference_system.h"

namespace skyquilt::poses {
namespace {

using flight::CountsIn;
using flight::ListFault;
using flight::ListKind;
using flight::ListReading;
using flight::ListUse;
using flight::Remark;
using flight::RemarkCode;

// Lists that agree with what the cameras' receivers say lie within this; further off it is said.
constexpr double kSaidFromM = 50.0;
// What no receiver errs by all along a flight, but one datum taken for another does.
constexpr double kSharedSaidFromM = 20.0;

std::string PlaceInWords(const geo::LatLon& place) {
  return fmt::format("{:.4f} {} {:.4f} {}", std::abs(place.lat_deg), place.lat_deg < 0.0 ? "S" : "N",
                     std::abs(place.lon_deg), place.lon_deg < 0.0 ? "W" : "E");
}

// Two numbers in degrees stand as x, y in geo.txt, and latitude first in Pix4D's lists.
bool IsEastFirst(const ListUse& use) { return use.format != "pix4d_csv"; }

RemarkCode DegreesOf(const ListUse& use, const ListReading& reading) {
  if (use.order_is_named)
    return reading.is_swapped ? RemarkCode::kReadingDegreesAgainstNames : RemarkCode::kReadingDegreesAsNamed;
  return IsEastFirst(use) != reading.is_swapped ? RemarkCode::kReadingDegreesEastFirst
                                                : RemarkCode::kReadingDegreesNorthFirst;
}

std::string SystemOf(const ListUse& use) { return use.system.substr(0, 80); }

// What the two numbers were taken for, in parts.
std::vector<Remark> ReadingOf(const ListUse& use, const ListReading& reading) {
  std::vector<Remark> parts;
  switch (reading.counts_in) {
    case CountsIn::kSystem:
      parts.push_back({RemarkCode::kReadingSystem, {{"system", SystemOf(use)}}});
      break;
    case CountsIn::kDegrees:
      parts.push_back(DegreesOf(use, reading));
      break;
    case CountsIn::kUtmOfFlight:
      parts.push_back(
          {RemarkCode::kReadingUtm,
           {{"zone", fmt::format("{}{}", reading.utm_code % 100, reading.utm_code >= 32700 ? 'S' : 'N')},
            {"epsg", reading.utm_code}}});
      break;
  }
  if (reading.is_swapped && reading.counts_in != CountsIn::kDegrees)
    parts.push_back(RemarkCode::kReadingNorthFirst);
  if (reading.west_is_positive) parts.push_back(RemarkCode::kReadingWestPositive);
  if (reading.south_is_positive) parts.push_back(RemarkCode::kReadingSouthPositive);
  return parts;
}

Remark OwnOf(const ListUse& use) {
  if (!use.own_are_photos) return RemarkCode::kOwnLists;
  return use.kind == ListKind::kControl || use.own_are_stale ? RemarkCode::kOwnRecords
                                                             : RemarkCode::kOwnPhotos;
}

// With the file, as what it was read, and what it was compared with.
std::map<std::string, flight::RemarkValue> ValuesOf(const ListUse& use) {
  return {{"file", use.file_name}, {"reading", ReadingOf(use, use.reading)}, {"own", OwnOf(use)}};
}

std::map<std::string, flight::RemarkValue> ApartValuesOf(const ListUse& use, double apart_m) {
  auto values = ValuesOf(use);
  values.emplace("apart_m", apart_m);
  return values;
}

// Metres of a system that nothing names.
Remark WithoutSystem(const ListUse& use) {
  const bool is_apart_known =
      use.apart_m && (use.kind != ListKind::kControl || use.reading.counts_in == CountsIn::kUtmOfFlight);
  if (use.kind == ListKind::kControl) {
    if (is_apart_known) return {RemarkCode::kPointsWithoutSystemApart, ApartValuesOf(use, *use.apart_m)};
    return {RemarkCode::kPointsWithoutSystem, {{"file", use.file_name}}};
  }
  if (is_apart_known) return {RemarkCode::kListWithoutSystemApart, ApartValuesOf(use, *use.apart_m)};
  return {RemarkCode::kListWithoutSystem, {{"file", use.file_name}}};
}

std::optional<Remark> WhyNotUsed(const ListUse& use) {
  if (use.fault == ListFault::kOtherTime)
    return Remark{RemarkCode::kListOfOtherTime,
                  {{"file", use.file_name}, {"apart_days", use.apart_days.value_or(0.0)}}};
  const bool lacks_system =
      use.system.empty() && (use.kind == ListKind::kControl || use.fault == ListFault::kNoSystem ||
                             use.reading.counts_in == CountsIn::kUtmOfFlight);
  if (lacks_system) return WithoutSystem(use);
  switch (use.fault) {
    case ListFault::kNone:
    case ListFault::kOtherTime:
    case ListFault::kNamesNoPhoto:  // said where rows are joined with photos
      break;
    case ListFault::kNoSystem:
    case ListFault::kNoPlace:
      if (use.system.empty())
        return Remark{RemarkCode::kListNowhere, {{"file", use.file_name}, {"rows", use.rows}}};
      return Remark{RemarkCode::kListOutsideSystem,
                    {{"file", use.file_name}, {"rows", use.rows}, {"system", SystemOf(use)}}};
    case ListFault::kFarAway:
      return Remark{use.own_are_photos ? RemarkCode::kListFarFromPhotos : RemarkCode::kListFarFromLists,
                    ApartValuesOf(use, use.apart_m.value_or(0.0))};
    case ListFault::kOtherPixels:
      return Remark{RemarkCode::kControlOfOtherPixels,
                    {{"file", use.file_name}, {"wrong", use.marks_outside}, {"marks", use.marks}}};
    case ListFault::kOtherShape:
      return Remark{
          use.own_are_photos ? RemarkCode::kListOfOtherShape : RemarkCode::kListOfOtherShapeThanLists,
          {{"file", use.file_name}, {"own", OwnOf(use)}, {"off_m", use.off_shape_m.value_or(0.0)}}};
  }
  return std::nullopt;
}

}  // namespace

std::string ReadingInWords(const ListUse& use, const ListReading& reading) {
  std::string words;
  for (const Remark& part : ReadingOf(use, reading)) words += flight::InWords(part);
  return words;
}

std::string UseInWords(const ListUse& use) {
  std::string words = use.file_name;
  if (!use.format.empty()) words += fmt::format(" ({})", use.format);
  if (use.fault == ListFault::kNamesNoPhoto)
    return fmt::format("{}: not used: its {} rows name none of the photos", words, use.rows);
  if (const auto why = WhyNotUsed(use); why && use.fault != ListFault::kNone) return flight::InWords(*why);
  words += fmt::format(": read as {}, {} of {} {} used", ReadingInWords(use, use.reading), use.rows_used,
                       use.rows, use.kind == ListKind::kControl ? "points" : "rows");
  if (!use.held_by.empty()) words += fmt::format(" (those of {} hold)", use.held_by);
  if (use.apart_m) {
    words += fmt::format(", {} from {}", flight::LengthInWords(*use.apart_m), flight::InWords(OwnOf(use)));
  }
  return words;
}

std::optional<Remark> RemarkOf(const ListUse& use) {
  if (use.fault != ListFault::kNone) return WhyNotUsed(use);
  if (use.apart_days) {
    auto values = ValuesOf(use);
    values.emplace("apart_days", *use.apart_days);
    return Remark{RemarkCode::kListOfOtherTimeTaken, std::move(values)};
  }
  if (!use.is_as_written) {
    if (use.system.empty() && use.reading.counts_in == CountsIn::kUtmOfFlight)
      return Remark{RemarkCode::kListReadInUnnamedZone, ApartValuesOf(use, use.apart_m.value_or(0.0))};
    if (use.as_written_apart_m)
      return Remark{RemarkCode::kListReadOtherwise, ApartValuesOf(use, *use.as_written_apart_m)};
    if (use.system.empty()) return Remark{RemarkCode::kListReadOtherwiseNowhere, ValuesOf(use)};
    auto values = ValuesOf(use);
    values.emplace("system", SystemOf(use));
    return Remark{RemarkCode::kListReadOtherwiseOutsideSystem, std::move(values)};
  }
  if (use.other_order_apart_m && !use.apart_m)
    return Remark{RemarkCode::kListOrderAssumed, ApartValuesOf(use, *use.other_order_apart_m)};
  if (!use.is_in_area && !use.apart_m) return Remark{RemarkCode::kListOutsideArea, ValuesOf(use)};
  const bool is_shifted = use.own_are_photos && use.shifted_m.value_or(0.0) > kSharedSaidFromM;
  if (use.kind == ListKind::kPositions && !use.own_are_stale && use.apart_m &&
      (*use.apart_m > kSaidFromM || is_shifted))
    return Remark{RemarkCode::kListFarFromOthers, ApartValuesOf(use, *use.apart_m)};
  return std::nullopt;
}

std::optional<Remark> RemarkOnSystem(const ListUse& use) {
  if (use.fault != ListFault::kNone || !use.system_error_m) return std::nullopt;
  return Remark{use.lacks_grid ? RemarkCode::kListSystemLacksGrid : RemarkCode::kListSystemInexact,
                {{"file", use.file_name}, {"system", SystemOf(use)}, {"error_m", *use.system_error_m}}};
}

std::optional<Remark> RemarkOnRounding(const ListUse& use) {
  if (use.fault != ListFault::kNone || !use.rounded_to_m) return std::nullopt;
  return Remark{RemarkCode::kListRounded, {{"file", use.file_name}, {"step_m", *use.rounded_to_m}}};
}

std::optional<Remark> RemarkOnUnit(const ListUse& use, const std::optional<geo::LatLon>& middle) {
  // No land lies so near to where both are zero, and all radians do.
  constexpr double kMaxLat = geo::kPi / 2.0, kMaxLon = geo::kPi;
  const bool are_degrees = use.reading.counts_in == CountsIn::kDegrees || use.system == "EPSG:4326";
  if (use.fault != ListFault::kNone || use.apart_m || !middle || !are_degrees) return std::nullopt;
  if (std::abs(middle->lat_deg) > kMaxLat || std::abs(middle->lon_deg) > kMaxLon) return std::nullopt;
  return Remark{RemarkCode::kListLikeRadians,
                {{"file", use.file_name}, {"lat_deg", middle->lat_deg}, {"lon_deg", middle->lon_deg}}};
}

std::optional<Remark> RemarkOnHalf(const ListUse& use, const std::optional<geo::LatLon>& middle) {
  // Where the northings of band S, 32 to 40 degrees north, lie in the southern half; little of it is land.
  constexpr double kSouthDeg = -58.2, kNorthDeg = -50.0;
  constexpr std::string_view kSouthernUtm = "EPSG:327", kLastZone = "60";
  if (use.fault != ListFault::kNone || use.apart_m || !middle || use.reading.counts_in != CountsIn::kSystem)
    return std::nullopt;
  if (middle->lat_deg < kSouthDeg || middle->lat_deg > kNorthDeg) return std::nullopt;
  const auto system = geo::ReferenceSystem::Parse(use.system);
  if (!system || !system->definition().starts_with(kSouthernUtm)) return std::nullopt;
  const std::string_view zone = std::string_view(system->definition()).substr(kSouthernUtm.size());
  if (zone.size() != kLastZone.size() || zone > kLastZone) return std::nullopt;
  return Remark{
      RemarkCode::kListInSouthernHalf,
      {{"file", use.file_name}, {"zone", zone}, {"lat_deg", middle->lat_deg}, {"lon_deg", middle->lon_deg}}};
}

std::string QuestionOf(const ListUse& use, const geo::LatLon& as_read, const ListReading& other,
                       const geo::LatLon& as_other) {
  return fmt::format(
      "{} can be read in two ways: as {}, the flight lies at {}; as {}, at {}. Nothing else says which is right. Name "
      "the columns in a line above its rows, such as image,longitude,latitude or image,latitude,longitude, or correct "
      "the line that names the reference system, and try again.",
      use.file_name, ReadingInWords(use, use.reading), PlaceInWords(as_read), ReadingInWords(use, other),
      PlaceInWords(as_other));
}

}  // namespace skyquilt::poses
