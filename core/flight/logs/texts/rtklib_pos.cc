#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/flight/bytes/gps_time.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/log_builder.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::flight {
namespace {

// Where rows are cut: RTKLIB may be told to write a comma or a semicolon between fields, beside its blanks.
constexpr std::string_view kAtBlanks = " \t\r\n";
constexpr std::string_view kAtCommasToo = " \t\r\n,";
constexpr std::string_view kAtSemicolonsToo = " \t\r\n;";

struct PosHeader {
  std::string_view between = kAtBlanks;
  bool is_utc = false;
  bool is_ecef = false;
  bool is_dms = false;
  bool is_above_sea = false;  // heights, by its geoid
  bool is_baseline = false;   // metres from a base
  std::chrono::hours ahead_of_utc{0};
};

// Times of Japan and of China, as its programs write them.
constexpr std::array kZones = {std::pair{"jst", std::chrono::hours(9)},
                               std::pair{"bjt", std::chrono::hours(8)}};

void ReadHeaderLine(std::string_view line, PosHeader& header) {
  const std::string lower = LowerCase(line);
  if (lower.find("latitude(d'\")") != std::string::npos) header.is_dms = true;
  if (lower.find("x-ecef") != std::string::npos) header.is_ecef = true;
  if (lower.find("lat/lon/height=") != std::string::npos && lower.find("/geodetic") != std::string::npos)
    header.is_above_sea = true;
  if (lower.find("e-baseline(m)") != std::string::npos) header.is_baseline = true;
  if (HoldsOneOf(lower, {"latitude(", "x-ecef("})) {
    const bool has_commas = lower.find(',') != std::string::npos;
    const bool has_semicolons = lower.find(';') != std::string::npos;
    header.between = has_commas ? kAtCommasToo : has_semicolons ? kAtSemicolonsToo : kAtBlanks;
  }
  const std::string_view start = Trim(std::string_view(lower).substr(1));
  if (start.starts_with("utc")) header.is_utc = true;
  if (start.starts_with("gpst")) header.is_utc = false;
  for (const auto& [name, ahead] : kZones) {
    if (!start.starts_with(name)) continue;
    header.is_utc = true;
    header.ahead_of_utc = ahead;
  }
}

std::optional<double> DegreesOf(std::string_view d, std::string_view m, std::string_view s) {
  const auto degrees = ParseNumber(d);
  const auto minutes = ParseNumber(m);
  const auto seconds = ParseNumber(s);
  if (!degrees || !minutes || !seconds || *minutes < 0.0 || *minutes >= 60.0 || *seconds < 0.0 ||
      *seconds >= 61.0) {
    return std::nullopt;
  }
  const double size = std::abs(*degrees) + *minutes / 60.0 + *seconds / 3600.0;
  return d.front() == '-' ? -size : size;
}

struct Solution {
  UtcTime time;
  GnssSample sample;
};

std::optional<Solution> ParseRow(std::string_view line, const PosHeader& header,
                                 std::vector<std::string_view>& words) {
  SplitBlanks(line, words, header.between);
  if (words.size() < 6) return std::nullopt;
  Solution solution;
  if (words[0].find_first_of("/-") != std::string_view::npos) {
    const auto written = ParseWrittenTime(
        fmt::format("{} {}", std::string(words[0].substr(0, 16)), std::string(words[1].substr(0, 24))));
    if (!written) return std::nullopt;
    const UtcTime time = header.is_utc ? written->time : UtcFromGpsCalendar(written->time);
    solution.time = time - header.ahead_of_utc;
  } else {
    const auto week = ParseInteger(words[0]);
    const auto tow_s = ParseNumber(words[1]);
    if (!week || !tow_s || std::abs(*tow_s) > 1e6) return std::nullopt;
    const std::int64_t tow_us = std::llround(*tow_s * 1e6);
    const auto time = UtcFromGpsWeek(*week, tow_us);
    if (!time) return std::nullopt;
    // Told to write UTC, it counts the weeks of that, without leap seconds.
    const UtcTime by_utc(std::chrono::microseconds(kGpsEpochUnixUs + *week * kGpsWeekUs + tow_us));
    solution.time = header.is_utc ? by_utc - header.ahead_of_utc : *time;
  }
  std::size_t at = 2;
  const auto number = [&](std::size_t i) { return i < words.size() ? ParseNumber(words[i]) : std::nullopt; };
  if (header.is_ecef) {
    const auto x = number(2), y = number(3), z = number(4);
    if (!x || !y || !z) return std::nullopt;
    const Eigen::Vector3d point_in_ecef(*x, *y, *z);
    if (point_in_ecef.norm() < 6.2e6 || point_in_ecef.norm() > 7e6) return std::nullopt;
    const geo::Wgs84 wgs84 = geo::Wgs84FromEcef(point_in_ecef);
    solution.sample.position = {wgs84.lat_deg, wgs84.lon_deg};
    solution.sample.height_ellipsoid_m = wgs84.height_ellipsoid_m;
    at = 5;
  } else {
    std::optional<double> lat = number(2);
    std::optional<double> lon = number(3);
    at = 4;
    if (header.is_dms) {
      if (words.size() < 9) return std::nullopt;
      lat = DegreesOf(words[2], words[3], words[4]);
      lon = DegreesOf(words[5], words[6], words[7]);
      at = 8;
    }
    const auto height = number(at++);
    if (!lat || !lon || !height) return std::nullopt;
    solution.sample.position = {*lat, *lon};
    (header.is_above_sea ? solution.sample.height_amsl_m : solution.sample.height_ellipsoid_m) = height;
  }
  const auto quality = number(at);
  if (!quality || *quality < 1.0) return std::nullopt;  // 0 is no solution
  solution.sample.is_rtk_fixed = *quality == 1.0;
  if (const auto sigmas = PositiveSigmas(number(at + 2), number(at + 3), number(at + 4))) {
    const double x = sigmas->x(), y = sigmas->y(), z = sigmas->z();
    const double each = std::sqrt((x * x + y * y + z * z) / 3.0);
    solution.sample.sigma_horizontal_m = header.is_ecef ? each : std::max(x, y);
    solution.sample.sigma_vertical_m = header.is_ecef ? each : z;
  }
  return solution;
}

}  // namespace

bool LooksLikeRtklibPos(LogBytes head) {
  LineReader lines(TextOf(head));
  std::string_view line;
  PosHeader header;
  std::vector<std::string_view> words;
  bool has_header = false;
  while (lines.Next(line)) {
    if (Trim(line).empty()) continue;
    if (line.front() != '%') return has_header && ParseRow(line, header, words).has_value();
    has_header = has_header || HoldsOneOf(LowerCase(line), {"rtklib", "gpst", "latitude", "ecef"});
    ReadHeaderLine(line, header);
  }
  return has_header;
}

Result<FlightLog> ParseRtklibPos(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed) {
  LogBuilder builder("rtklib_pos", name);
  LineReader lines(TextOf(bytes));
  std::string_view line;
  PosHeader header;
  std::vector<std::string_view> words;
  std::optional<UtcTime> first;
  std::uint64_t rows = 0;
  ConsumedSteps steps(consumed);
  while (NextFilledLine(lines, steps, line)) {
    if (line.front() == '%') {
      ReadHeaderLine(line, header);
      continue;
    }
    if (header.is_baseline)
      return Because(ErrorCode::kUnprocessable, {RemarkCode::kSolutionFromBase, {{"file", name}}});
    auto solution = ParseRow(line, header, words);
    if (!solution) {
      builder.SkipRow();
      continue;
    }
    if (!first) first = solution->time;
    solution->sample.t_s = SecondsBetween(*first, solution->time);
    ++rows;
    builder.Add(solution->sample);
  }
  if (rows == 0) return builder.Refuse(RemarkCode::kSolutionEmpty);
  builder.Count("solution", rows);
  builder.log().utc_at_zero = first;
  builder.log().utc_sigma_s = 1e-3;
  builder.log().mapping = {fmt::format("time -> {}", header.is_utc ? "UTC" : "GPS time"),
                           "position -> the antenna"};
  return std::move(builder).Finish();
}

}  // namespace skyquilt::flight
