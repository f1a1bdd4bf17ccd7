#include "core/flight/logs/csv/canonical_csv.h"

#include <fmt/format.h>

#include <cmath>

#include "core/flight/logs/csv/csv_rows.h"
#include "core/flight/logs/text_fields.h"

namespace skyquilt::flight {
namespace {

using M = CsvMeaning;

// The first line that holds anything; lines starting with # before it are comments.
bool ReadHeader(LineReader& lines, std::vector<std::string_view>& cells) {
  std::string_view line;
  while (lines.Next(line)) {
    if (Trim(line).empty() || line.front() == '#') continue;
    SplitFields(line, ',', cells);
    return true;
  }
  return false;
}

bool HasColumn(const std::vector<CsvColumn>& columns, M meaning) {
  for (const CsvColumn& column : columns) {
    if (column.meaning == meaning) return true;
  }
  return false;
}

CameraEvent EventOf(const CsvRow& row) {
  CameraEvent event;
  event.image_name = std::string(row.image.substr(0, 512));
  if (row[M::kLat] && row[M::kLon]) {
    event.written = WrittenPlace{*row[M::kLon], *row[M::kLat]};
    event.position = geo::LatLon{*row[M::kLat], *row[M::kLon]};
  }
  event.height_ellipsoid_m = row[M::kHeightEllipsoid];
  event.height_amsl_m = row[M::kHeightAmsl];
  event.height_above_takeoff_m = row[M::kHeightAboveTakeoff];
  if (row.Has(M::kRoll, M::kYaw)) {
    event.yaw_pitch_roll_rad = Eigen::Vector3d(*row[M::kYaw], *row[M::kPitch], *row[M::kRoll]);
    event.attitude_kind = AttitudeKind::kGimbal;
  }
  const auto horizontal = row[M::kSigmaHorizontal];
  if (horizontal && *horizontal > 0.0) {
    const double vertical = row[M::kSigmaVertical].value_or(2.0 * *horizontal);
    event.sigma_in_ned_m = Eigen::Vector3d(*horizontal, *horizontal, vertical);
  }
  event.sigma_tilt_rad = row[M::kSigmaTilt];
  event.sigma_yaw_rad = row[M::kSigmaYaw];
  return event;
}

}  // namespace

bool LooksLikeFlightCsv(LogBytes head) {
  LineReader lines(TextOf(head));
  std::vector<std::string_view> cells;
  return LooksLikeText(TextOf(head)) && ReadHeader(lines, cells) && IsCanonicalFlightHeader(cells);
}

bool LooksLikeImagesCsv(LogBytes head) {
  LineReader lines(TextOf(head));
  std::vector<std::string_view> cells;
  return LooksLikeText(TextOf(head)) && ReadHeader(lines, cells) && IsCanonicalImagesHeader(cells);
}

Result<FlightLog> ParseFlightCsv(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed) {
  LogBuilder builder("flight_csv", name);
  LineReader lines(TextOf(bytes));
  std::vector<std::string_view> cells;
  if (!ReadHeader(lines, cells)) return Error{ErrorCode::kCorrupt, fmt::format("{} is empty.", name), ""};
  const auto columns = MapCanonicalColumns(cells);
  CsvClockRule rule;
  rule.has_time_column = HasColumn(columns, M::kTime);
  CsvSampler sampler(builder, rule, false, HasColumn(columns, M::kHeightAboveTakeoff));
  std::string_view line;
  std::uint64_t rows = 0;
  std::uint64_t bad = 0;
  ConsumedSteps steps(consumed);
  while (lines.Next(line)) {
    steps.At(lines.offset());
    if (Trim(line).empty() || line.front() == '#') continue;
    SplitFields(line, ',', cells);
    if (sampler.Take(ReadCsvRow(columns, cells)))
      ++rows;
    else
      ++bad;
  }
  if (rows == 0) {
    return Error{ErrorCode::kCorrupt,
                 fmt::format("{} has no row with a time; fill the column t (seconds) or utc.", name), ""};
  }
  if (!HasColumn(columns, M::kHeightAboveTakeoff)) builder.BaroStartsAtZero();
  sampler.Finish();
  builder.Count("row", rows);
  builder.log().mapping = DescribeColumns(columns);
  if (bad > 0) builder.Warn(fmt::format("{} rows without a time were skipped", bad));
  return std::move(builder).Finish();
}

Result<FlightLog> ParseImagesCsv(std::string_view name, LogBytes bytes, const ConsumedUpTo&) {
  LineReader lines(TextOf(bytes));
  std::vector<std::string_view> cells;
  if (!ReadHeader(lines, cells)) return Error{ErrorCode::kCorrupt, fmt::format("{} is empty.", name), ""};
  return ReadImageRows(MapCanonicalColumns(cells), ',', lines, LogBuilder("images_csv", name));
}

Result<FlightLog> ReadImageRows(const std::vector<CsvColumn>& columns, char separator, LineReader lines,
                                LogBuilder builder) {
  const std::string name = builder.log().file_name;
  std::vector<std::string_view> cells;
  const bool has_time = HasColumn(columns, M::kTime);
  std::string_view line;
  std::optional<UtcTime> first;
  std::uint64_t rows = 0;
  std::uint64_t bad = 0;
  while (lines.Next(line)) {
    if (Trim(line).empty() || line.front() == '#') continue;
    SplitFields(line, separator, cells);
    const CsvRow row = ReadCsvRow(columns, cells);
    if (row.image.empty()) {
      ++bad;
      continue;
    }
    CameraEvent event = EventOf(row);
    const auto written = row.utc.empty() ? std::nullopt : ParseWrittenTime(row.utc);
    event.has_time = true;
    if (has_time && row[M::kTime]) {
      event.t_s = *row[M::kTime];
      if (written && !first && std::abs(event.t_s) < 1e9)
        first = written->time - std::chrono::microseconds(std::llround(event.t_s * 1e6));
    } else if (!has_time && written) {
      if (!first) first = written->time;
      event.t_s = std::chrono::duration<double>(written->time - *first).count();
    } else {
      event.has_time = false;
      event.t_s = static_cast<double>(rows);
    }
    ++rows;
    builder.Add(std::move(event));
  }
  if (rows == 0) return Error{ErrorCode::kCorrupt, fmt::format("{} names no photo in its rows.", name), ""};
  builder.Count("row", rows);
  builder.log().utc_at_zero = first;
  builder.log().written_order_is_named = true;
  if (has_time) builder.log().counter_at_zero_s = 0.0;
  builder.log().utc_sigma_s = 0.05;
  builder.log().mapping = DescribeColumns(columns);
  if (bad > 0) builder.Warn(fmt::format("{} rows without an image were skipped", bad));
  return std::move(builder).Finish();
}

}  // namespace skyquilt::flight
