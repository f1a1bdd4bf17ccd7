#include "core/poses/lists/list_words.h"

#include <fmt/format.h>

#include <cmath>

#include "core/flight/logs/texts/gcp_list.h"

namespace skyquilt::poses {
namespace {

using flight::CountsIn;
using flight::ListFault;
using flight::ListKind;
using flight::ListReading;
using flight::ListUse;

// Lists that agree with what the cameras' receivers say lie within this; further off it is said.
constexpr double kSaidFromM = 50.0;

std::string Grouped(double number) {
  std::string digits = fmt::format("{:.0f}", number);
  for (auto at = static_cast<std::ptrdiff_t>(digits.size()) - 3; at > 0; at -= 3)
    digits.insert(static_cast<std::size_t>(at), ",");
  return digits;
}

std::string PlaceInWords(const geo::LatLon& place) {
  return fmt::format("{:.4f} {} {:.4f} {}", std::abs(place.lat_deg), place.lat_deg < 0.0 ? "S" : "N",
                     std::abs(place.lon_deg), place.lon_deg < 0.0 ? "W" : "E");
}

// Two numbers in degrees stand as x, y in geo.txt, and latitude first in Pix4D's lists.
bool IsEastFirst(const ListUse& use) { return use.format != "pix4d_csv"; }

std::string DegreesInWords(const ListUse& use, const ListReading& reading) {
  if (use.order_is_named && reading.is_swapped)
    return "degrees, the column named latitude as longitude and the other way round";
  if (use.order_is_named) return "latitude and longitude in degrees, as its columns are named";
  return IsEastFirst(use) != reading.is_swapped ? "longitude, latitude in degrees"
                                                : "latitude, longitude in degrees";
}

std::string UtmInWords(int code) {
  return fmt::format("WGS 84 / UTM zone {}{} (EPSG:{})", code % 100, code >= 32700 ? 'S' : 'N', code);
}

std::string_view OwnInWords(const ListUse& use) {
  if (!use.own_are_photos) return "where the other lists and tracks place the flight";
  return use.kind == ListKind::kControl || use.own_are_stale
             ? "where the photos were taken by their own records"
             : "the photos' own positions";
}

std::string_view WithoutIt(const ListUse& use) {
  return use.own_are_photos ? "Without it the photos' own positions hold"
                            : "Check which of the files is of this flight";
}

std::string WhyNotUsed(const ListUse& use) {
  const bool lacks_system = use.system.empty() && (use.fault == ListFault::kNoSystem ||
                                                   use.reading.counts_in == CountsIn::kUtmOfFlight);
  if (use.kind == ListKind::kControl && use.system.empty()) {
    std::string words = fmt::format("it {}", flight::kNoSystemWords);
    if (use.reading.counts_in == CountsIn::kUtmOfFlight && use.apart_m) {
      words += fmt::format("; read as {} its points would lie {} from {}", ReadingInWords(use, use.reading),
                           LengthInWords(*use.apart_m), OwnInWords(use));
    }
    return words;
  }
  if (lacks_system) {
    return fmt::format(
        "its numbers are metres of a projected system that it does not name{}: write the system's EPSG code, such "
        "as EPSG:32632, into a first line of its own",
        use.apart_m ? fmt::format(", and as {} they would lie {} from {}", UtmInWords(use.reading.utm_code),
                                  LengthInWords(*use.apart_m), OwnInWords(use))
                    : "");
  }
  switch (use.fault) {
    case ListFault::kNone:
      return {};
    case ListFault::kNamesNoPhoto:
      return fmt::format("its {} rows name none of the photos", use.rows);
    case ListFault::kNoSystem:
    case ListFault::kNoPlace:
      return fmt::format("most of its {} rows are no places {}, whichever way the two numbers are read",
                         use.rows,
                         use.system.empty() ? std::string("on Earth") : "in " + use.system.substr(0, 80));
    case ListFault::kFarAway:
      return fmt::format(
          "read as {}, which comes nearest, it lies {} from {}, further than {}. Is it the list of another flight, "
          "or names another reference system? {}",
          ReadingInWords(use, use.reading), LengthInWords(use.apart_m.value_or(0.0)), OwnInWords(use),
          use.own_are_photos ? "any receiver errs" : "a flight reaches", WithoutIt(use));
    case ListFault::kOtherShape:
      return fmt::format(
          "its rows are laid out otherwise than {}: shifted as a whole to fit, half of them still lie more than {} "
          "off. Is it the list of another flight with the same names, or are its rows in another order? {}",
          OwnInWords(use), LengthInWords(use.off_shape_m.value_or(0.0)), WithoutIt(use));
  }
  return {};
}

}  // namespace

std::string LengthInWords(double metres) {
  if (metres < 100.0) return fmt::format("{:.1f} m", metres);
  if (metres < 10'000.0) return Grouped(metres) + " m";
  return Grouped(metres / 1000.0) + " km";
}

std::string ReadingInWords(const ListUse& use, const ListReading& reading) {
  std::string words;
  switch (reading.counts_in) {
    case CountsIn::kSystem:
      words = use.system.substr(0, 80);
      if (reading.is_swapped) words += ", north before east";
      break;
    case CountsIn::kDegrees:
      words = DegreesInWords(use, reading);
      break;
    case CountsIn::kUtmOfFlight:
      words = UtmInWords(reading.utm_code) + (reading.is_swapped ? ", north before east" : "");
      break;
  }
  if (reading.west_is_positive) words += ", west counted as positive";
  if (reading.south_is_positive) words += ", south counted as positive";
  return words;
}

std::string UseInWords(const ListUse& use) {
  std::string words = use.file_name;
  if (!use.format.empty()) words += fmt::format(" ({})", use.format);
  if (use.fault != ListFault::kNone) return fmt::format("{}: not used: {}", words, WhyNotUsed(use));
  words += fmt::format(": read as {}, {} of {} {} used", ReadingInWords(use, use.reading), use.rows_used,
                       use.rows, use.kind == ListKind::kControl ? "points" : "rows");
  if (use.apart_m) words += fmt::format(", {} from {}", LengthInWords(*use.apart_m), OwnInWords(use));
  return words;
}

std::optional<std::string> NoteOf(const ListUse& use) {
  if (use.fault == ListFault::kNamesNoPhoto) return std::nullopt;  // said where rows are joined with photos
  if (use.fault != ListFault::kNone) {
    return fmt::format("{} is not used: {}.", use.file_name, WhyNotUsed(use));
  }
  std::string words = fmt::format("{}: read as {}", use.file_name, ReadingInWords(use, use.reading));
  if (!use.is_as_written) {
    if (use.system.empty() && use.reading.counts_in == CountsIn::kUtmOfFlight) {
      return words + fmt::format(", which it does not name: so it lies {} from {}.",
                                 LengthInWords(use.apart_m.value_or(0.0)), OwnInWords(use));
    }
    if (use.as_written_apart_m) {
      words += fmt::format(": as written it would lie {} from {}", LengthInWords(*use.as_written_apart_m),
                           OwnInWords(use));
    } else if (!use.system.empty()) {
      words += fmt::format(": as written its rows are no places within {}", use.system.substr(0, 80));
    } else {
      words += ": as written its rows are no places on Earth";
    }
    return words + ".";
  }
  if (use.other_order_apart_m && !use.apart_m) {
    return words + fmt::format(
                       ", the order of its format: nothing else says where the flight was, and the other way "
                       "round it would lie {} away. Check the map's place; a line of column names (image "
                       "longitude latitude) settles it.",
                       LengthInWords(*use.other_order_apart_m));
  }
  if (!use.is_in_area && !use.apart_m) {
    return words +
           ", though it lies outside the area that this system is made for. Check the map's place, and the "
           "system.";
  }
  if (use.kind == ListKind::kPositions && !use.own_are_stale && use.apart_m.value_or(0.0) > kSaidFromM) {
    return words +
           fmt::format(", it lies {} from {}. It is believed all the same; if they are right, leave it out.",
                       LengthInWords(*use.apart_m), OwnInWords(use));
  }
  return std::nullopt;
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
