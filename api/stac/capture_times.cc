#include "api/stac/capture_times.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <charconv>
#include <chrono>
#include <cmath>

namespace skyquilt::api {
namespace {

constexpr std::size_t kWholeSeconds = 19;  // "2024-06-01T10:00:00"
constexpr double kDegreesOfAnHour = 15.0;

std::optional<int> NumberAt(std::string_view text, std::size_t at, std::size_t digits) {
  int value = 0;
  const char* end = text.data() + at + digits;
  const auto parsed = std::from_chars(text.data() + at, end, value);
  if (parsed.ec != std::errc() || parsed.ptr != end || value < 0) return std::nullopt;
  return value;
}

std::optional<std::chrono::sys_seconds> SecondsOf(std::string_view text) {
  if (text.size() < kWholeSeconds || text[4] != '-' || text[7] != '-' || text[10] != 'T' || text[13] != ':' ||
      text[16] != ':')
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

}  // namespace

std::optional<std::string> UtcOfCapture(std::string_view recorded, double lon_deg) {
  const auto seconds = SecondsOf(recorded);
  if (!seconds) return std::nullopt;
  std::string_view fraction = recorded.substr(kWholeSeconds);
  const bool is_utc = fraction.ends_with('Z');
  if (is_utc) fraction.remove_suffix(1);
  const bool is_fraction = fraction.empty() || (fraction.size() > 1 && fraction[0] == '.' &&
                                                fraction.find_first_not_of("0123456789", 1) == fraction.npos);
  if (!is_fraction || !std::isfinite(lon_deg)) return std::nullopt;
  if (is_utc) return std::string(recorded);
  const auto utc = *seconds - std::chrono::hours(std::lround(lon_deg / kDegreesOfAnHour));
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}{}Z", fmt::gmtime(std::chrono::system_clock::to_time_t(utc)),
                     fraction);
}

}  // namespace skyquilt::api
