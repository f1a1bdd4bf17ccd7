#include <map>

#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/log_builder.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::flight {

bool LooksLikeSenseflyGeoinfo(LogBytes head) {
  const std::string lower = LowerCase(TextOf(head).substr(0, 400));
  return lower.find("sensefly/geoinfo") != std::string::npos ||
         (lower.starts_with("filename\t") && lower.find("altitude_wgs84") != std::string::npos);
}

Result<FlightLog> ParseSenseflyGeoinfo(std::string_view name, LogBytes bytes, const ConsumedUpTo&) {
  LogBuilder builder("sensefly_geoinfo", name);
  LineReader lines(TextOf(bytes));
  std::vector<std::string_view> cells;
  std::map<std::string, std::size_t> columns;
  std::uint64_t rows = 0;
  while (NextRow(lines, '\t', cells)) {
    if (columns.empty()) {
      for (std::size_t i = 0; i < cells.size(); ++i) columns.emplace(LowerCase(cells[i]), i);
      if (!columns.contains("filename") || !columns.contains("latitude") || !columns.contains("longitude")) {
        return Because(ErrorCode::kCorrupt, {RemarkCode::kFileLacksColumns,
                                             {{"file", name}, {"columns", "fileName, latitude, longitude"}}});
      }
      continue;
    }
    const auto number = [&](const char* column) -> std::optional<double> {
      const auto found = columns.find(column);
      if (found == columns.end() || found->second >= cells.size()) return std::nullopt;
      return ParseNumber(cells[found->second]);
    };
    const auto lat = number("latitude");
    const auto lon = number("longitude");
    const std::size_t name_column = columns["filename"];
    if (!lat || !lon || name_column >= cells.size() || cells[name_column].empty()) {
      builder.SkipRow();
      continue;
    }
    CameraEvent event = EventByName(rows, cells[name_column]);
    event.written = WrittenPlace{*lon, *lat};
    event.position = geo::LatLon{*lat, *lon};
    event.height_amsl_m = number("altitude_amsl");
    event.height_ellipsoid_m = number("altitude_wgs84");
    event.yaw_pitch_roll_rad = YawPitchRollRad(number("heading"), number("pitch"), number("roll"));
    ++rows;
    builder.Add(std::move(event));
  }
  if (rows == 0) return builder.Refuse(RemarkCode::kFileNamesNoPlace);
  builder.Count("row", rows);
  builder.log().written_order_is_named = true;
  builder.log().mapping = {"heading, pitch, roll -> the airframe's, degrees, camera looking down"};
  return std::move(builder).Finish();
}

}  // namespace skyquilt::flight
