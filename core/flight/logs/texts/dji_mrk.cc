#include <algorithm>
#include <array>
#include <cmath>

#include "core/flight/bytes/gps_time.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/log_builder.h"

namespace skyquilt::flight {
namespace {

struct MrkRow {
  UtcTime time;
  CameraEvent event;
};

// "47.6436,Lat" -> its number when the label fits.
std::optional<double> Labelled(std::string_view cell, std::string_view label) {
  const std::size_t comma = cell.rfind(',');
  if (comma == std::string_view::npos || LowerCase(Trim(cell.substr(comma + 1))) != label)
    return std::nullopt;
  return ParseNumber(cell.substr(0, comma));
}

bool IsLabelled(std::string_view cell) {
  constexpr std::array<std::string_view, 7> kLabels = {"lat", "lon", "ellh", "q", "n", "e", "v"};
  return std::any_of(kLabels.begin(), kLabels.end(),
                     [&](std::string_view label) { return Labelled(cell, label).has_value(); });
}

std::optional<MrkRow> ParseRow(std::string_view line, std::vector<std::string_view>& cells) {
  SplitFields(line, '\t', cells);
  if (cells.size() < 9) return std::nullopt;
  MrkRow row;
  const auto sequence = ParseInteger(cells[0]);
  const auto tow_s = ParseNumber(cells[1]);
  std::string_view week_text = Trim(cells[2]);
  const bool has_brackets = week_text.size() >= 2 && week_text.front() == '[';
  if (has_brackets) week_text = week_text.substr(1, week_text.size() - 2);
  const auto week = ParseInteger(week_text);
  // Nine numbers between tabs are a row of many a table (a planned mission's, say).
  if (!has_brackets && std::none_of(cells.begin() + 3, cells.end(), IsLabelled)) return std::nullopt;
  if (!sequence || !tow_s || !week || std::abs(*tow_s) > 1e6) return std::nullopt;
  const auto time = UtcFromGpsWeek(*week, std::llround(*tow_s * 1e6));
  if (!time) return std::nullopt;
  row.time = *time;
  row.event.sequence = *sequence;
  std::optional<double> lat, lon;
  for (std::size_t i = 3; i < cells.size(); ++i) {
    if (const auto value = Labelled(cells[i], "lat")) lat = value;
    if (const auto value = Labelled(cells[i], "lon")) lon = value;
    if (const auto value = Labelled(cells[i], "ellh")) row.event.height_ellipsoid_m = value;
    if (const auto value = Labelled(cells[i], "q")) row.event.is_rtk_fixed = *value == 50.0;
    if (i >= 8 && !row.event.sigma_in_ned_m) {
      std::vector<std::string_view> sigmas;
      SplitFields(cells[i], ',', sigmas);
      if (sigmas.size() == 3) {
        row.event.sigma_in_ned_m =
            PositiveSigmas(ParseNumber(sigmas[0]), ParseNumber(sigmas[1]), ParseNumber(sigmas[2]));
      }
    }
  }
  // (0, 0) is written while there is no fix: the exposure still counts.
  if (lat && lon && !(*lat == 0.0 && *lon == 0.0)) row.event.position = geo::LatLon{*lat, *lon};
  return row;
}

}  // namespace

bool LooksLikeDjiMrk(LogBytes head) {
  std::vector<std::string_view> cells;
  return HasLine(TextOf(head), 3, [&](std::string_view line) { return ParseRow(line, cells).has_value(); });
}

Result<FlightLog> ParseDjiMrk(std::string_view name, LogBytes bytes, const ConsumedUpTo&) {
  LogBuilder builder("dji_mrk", name);
  LineReader lines(TextOf(bytes));
  std::string_view line;
  std::vector<std::string_view> cells;
  std::optional<UtcTime> first;
  std::uint64_t rows = 0;
  while (lines.Next(line)) {
    if (Trim(line).empty()) continue;
    auto row = ParseRow(line, cells);
    if (!row) {
      builder.SkipRow();
      continue;
    }
    if (!first) first = row->time;
    row->event.t_s = SecondsBetween(*first, row->time);
    ++rows;
    builder.Add(std::move(row->event));
  }
  if (rows == 0) return builder.Refuse(RemarkCode::kMrkEmpty);
  builder.Count("exposure", rows);
  builder.log().utc_at_zero = first;
  builder.log().utc_sigma_s = 0.001;  // the exposure is stamped by the receiver
  return std::move(builder).Finish();
}

}  // namespace skyquilt::flight
