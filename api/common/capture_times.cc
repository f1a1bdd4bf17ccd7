#include "api/common/capture_times.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <charconv>
#include <chrono>
#include <cmath>

namespace skyquilt::api {
namespace {

constexpr std::size_t kWholeSeconds = 19;  // "2024-06-01T10:00:00"
constexpr std::size_t kZone = 6;           // "+02:00"
constexpr double kDegreesOfAnHour = 15.0;

std::optional<int> NumberAt(std::string_view text, std::size_t at, std::size_t digits) {
  int value = 0;
  const char* end = text.data() + at + digits;
  const auto parsed = std::from_chars(text.data() + at, end, value);
  if (parsed.ec != std::errc() || parsed.ptr != end || value < 0) return std::nullopt;
  return value;
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

}  // namespace skyquilt::api
