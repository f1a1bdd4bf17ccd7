#include "api/common/feature_query.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "api/http/parameters.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

constexpr std::size_t kWholeSeconds = 19;  // "2024-06-01T10:00:00"
constexpr std::size_t kZone = 6;           // "+02:00"
constexpr double kDegreesOfAnHour = 15.0;

std::optional<int> NumberAt(std::string_view text, std::size_t at, std::size_t digits) {
  const std::optional<int> value = ParseNumber<int>(text.substr(at, digits));
  return value && *value >= 0 ? value : std::nullopt;
}

// What a time says: its second, what follows it (".25", as written) and how far its clock is ahead of UTC;
// without a zone, absent.
struct WrittenTime {
  std::chrono::sys_seconds second;
  std::string_view fraction;
  std::optional<std::chrono::minutes> ahead_of_utc;
};

std::optional<std::chrono::sys_seconds> SecondsOf(std::string_view text) {
  if (text.size() < kWholeSeconds || text[4] != '-' || text[7] != '-' ||
      (text[10] != 'T' && text[10] != 't') || text[13] != ':' || text[16] != ':')
    return std::nullopt;
  const auto year = NumberAt(text, 0, 4), month = NumberAt(text, 5, 2), day = NumberAt(text, 8, 2);
  const auto hour = NumberAt(text, 11, 2), minute = NumberAt(text, 14, 2), second = NumberAt(text, 17, 2);
  if (!year || !month || !day || !hour || !minute || !second) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(*year), std::chrono::month(*month),
                                         std::chrono::day(*day)};
  if (!date.ok() || *hour > 23 || *minute > 59 || *second > 60) return std::nullopt;
  return std::chrono::sys_days(date) + std::chrono::hours(*hour) + std::chrono::minutes(*minute) +
         std::chrono::seconds(*second);
}

// "+02:00" or "-05:30".
std::optional<std::chrono::minutes> ZoneOf(std::string_view text) {
  if (text.size() != kZone || (text[0] != '+' && text[0] != '-') || text[3] != ':') return std::nullopt;
  const auto hours = NumberAt(text, 1, 2), minutes = NumberAt(text, 4, 2);
  if (!hours || !minutes || *hours > 23 || *minutes > 59) return std::nullopt;
  const std::chrono::minutes ahead = std::chrono::hours(*hours) + std::chrono::minutes(*minutes);
  return text[0] == '-' ? -ahead : ahead;
}

std::optional<WrittenTime> Read(std::string_view text) {
  const auto second = SecondsOf(text);
  if (!second) return std::nullopt;
  WrittenTime time{*second, text.substr(kWholeSeconds), std::nullopt};
  std::string_view& fraction = time.fraction;
  if (fraction.ends_with('Z') || fraction.ends_with('z')) {
    time.ahead_of_utc = std::chrono::minutes(0);
    fraction.remove_suffix(1);
  } else if (fraction.size() >= kZone && ZoneOf(fraction.substr(fraction.size() - kZone))) {
    time.ahead_of_utc = ZoneOf(fraction.substr(fraction.size() - kZone));
    fraction.remove_suffix(kZone);
  }
  const bool is_fraction = fraction.empty() || (fraction.size() > 1 && fraction[0] == '.' &&
                                                fraction.find_first_not_of("0123456789", 1) == fraction.npos);
  if (!is_fraction) return std::nullopt;
  return time;
}

Error BadQuery(std::string message) { return {ErrorCode::kInvalidArgument, std::move(message)}; }

Result<std::optional<Instant>> EndOfSpan(std::string_view text) {
  if (text.empty() || text == "..") return std::optional<Instant>();
  const auto instant = InstantOf(text);
  if (!instant) {
    return BadQuery(
        "\"datetime\" must be a time as 2024-06-01T10:00:00Z, or two with a slash between; \"..\" is an open "
        "end.");
  }
  return instant;
}

}  // namespace

std::optional<std::string> UtcOfCapture(std::string_view recorded, double lon_deg) {
  const auto time = Read(recorded);
  if (!time || !std::isfinite(lon_deg)) return std::nullopt;
  const auto utc =
      time->second - time->ahead_of_utc.value_or(std::chrono::hours(std::lround(lon_deg / kDegreesOfAnHour)));
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}{}Z", fmt::gmtime(std::chrono::system_clock::to_time_t(utc)),
                     time->fraction);
}

std::optional<Instant> InstantOf(std::string_view text) {
  const auto time = Read(text);
  if (!time || !time->ahead_of_utc) return std::nullopt;
  std::int64_t microseconds = 0;
  for (std::size_t digit = 1; digit <= 6; ++digit)
    microseconds = 10 * microseconds + (digit < time->fraction.size() ? time->fraction[digit] - '0' : 0);
  return Instant(time->second - *time->ahead_of_utc) + std::chrono::microseconds(microseconds);
}

Result<geo::LatLonBounds> BboxOf(const std::vector<double>& numbers) {
  const Error bad = BadQuery(
      "\"bbox\" must be west,south,east,north in degrees: longitudes from -180 to 180, latitudes from -90 to "
      "90, south not above north.");
  if (numbers.size() != 4 && numbers.size() != 6) return bad;
  const std::size_t half = numbers.size() / 2;
  geo::LatLonBounds box{numbers[0], numbers[1], numbers[half], numbers[half + 1]};
  for (const double lon_deg : {box.west_deg, box.east_deg})
    if (!(std::abs(lon_deg) <= 180.0)) return bad;
  for (const double lat_deg : {box.south_deg, box.north_deg})
    if (!(std::abs(lat_deg) <= 90.0)) return bad;
  if (box.south_deg > box.north_deg) return bad;
  if (box.west_deg > box.east_deg) box.east_deg += 360.0;
  return box;
}

Result<TimeSpan> ParseTimeSpan(std::string_view text) {
  const std::vector<std::string_view> ends = PartsOf(text, '/');
  TimeSpan span;  // one time alone is both its ends
  SKYQUILT_TRY_ASSIGN(span.from, EndOfSpan(ends.front()));
  SKYQUILT_TRY_ASSIGN(span.to, EndOfSpan(ends.back()));
  const bool is_one_time = ends.size() == 1 && span.from;
  const bool is_span =
      ends.size() == 2 && (span.from || span.to) && !(span.from && span.to && *span.from > *span.to);
  if (!is_one_time && !is_span)
    return BadQuery("\"datetime\" must be one time, or two in their order with a slash between.");
  return span;
}

Result<geo::LatLonBounds> ParseBbox(std::string_view text) {
  std::vector<double> numbers;
  for (const std::string_view part : PartsOf(text.substr(0, 400), ',')) {
    numbers.push_back(ParseNumber<double>(part).value_or(std::nan("")));
  }
  return BboxOf(numbers);
}

std::array<double, 4> GeoJsonBbox(const geo::LatLonBounds& bounds) {
  const auto& [west, south, east, north] = bounds;
  if (east - west >= 360.0) return {-180.0, south, 180.0, north};
  return {west, south, east > 180.0 ? east - 360.0 : east, north};
}

bool BoxesMeet(const geo::LatLonBounds& a, const geo::LatLonBounds& b) {
  if (a.south_deg > b.north_deg || a.north_deg < b.south_deg) return false;
  return std::ranges::any_of(std::array{-360.0, 0.0, 360.0}, [&](double turn_deg) {
    return a.west_deg + turn_deg <= b.east_deg && a.east_deg + turn_deg >= b.west_deg;
  });
}

Result<int> ParseLimit(std::string_view text, int otherwise, int most) {
  if (text.empty()) return otherwise;
  const auto limit = ParseNumber<std::int64_t>(text);
  if (!limit || *limit < 1) return BadQuery("\"limit\" must be a whole number from 1 on.");
  return static_cast<int>(std::min<std::int64_t>(*limit, most));
}

}  // namespace skyquilt::api
