#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/median.h"
#include "core/base/try.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/csv/canonical_csv.h"
#include "core/flight/logs/csv/csv_physics.h"
#include "core/flight/logs/csv/list_columns.h"
#include "core/flight/logs/csv/settle_columns.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/system_line.h"
#include "core/flight/remarks/because.h"
#include "core/geo/crs/reference_system.h"

namespace skyquilt::flight {
namespace {

using M = CsvMeaning;

struct CsvHeader {
  std::vector<CsvColumn> columns;
  char separator = ',';
  bool is_timed = true;             // false: rows name photos and say where they were taken, not when
  SystemLine system;                // that a line above names
  std::optional<ListHeading> list;  // what it is where each row names a photo, beside a column of times
};

// "Easting (UTM 33U)": what stands in the brackets; nothing where they hold no zone.
std::string_view UtmInBrackets(std::string_view line) {
  const std::size_t utm = LowerCase(line).find("utm");
  const std::size_t open = utm == std::string::npos ? utm : line.find_last_of("([", utm);
  const std::size_t close = line.find_first_of(")]", utm);
  if (open == std::string_view::npos || close == std::string_view::npos) return {};
  const std::string_view inside = line.substr(open + 1, close - open - 1);
  return geo::ReferenceSystem::Parse(inside).ok() ? inside : std::string_view();
}

// The first line with a time and something to time, or with photos and where they were taken; a few title
// lines may stand before it.
std::optional<CsvHeader> FindHeader(LineReader& lines) {
  SystemLine system;
  std::string_view line;
  std::vector<std::string_view> cells;
  for (int i = 0; i < 20 && lines.Next(line);) {
    if (Trim(line).empty()) continue;
    ++i;
    CsvHeader header;
    header.system = system;
    auto list = ReadListHeading(line, lines);
    // No log says where it was in a plane, so that a column of times makes none of a list.
    const bool is_in_plane = list && list->fits_row && HasPlane(list->columns);
    if (list && (is_in_plane || !HasColumn(list->columns, M::kTime))) {
      header.columns = std::move(list->columns);
      header.separator = list->separator;
      header.is_timed =
          !is_in_plane && (HasColumn(header.columns, M::kUtc) || HasColumn(header.columns, M::kDate));
      LineReader below = lines;
      SystemLine own = SystemOfLine(line, below);  // "northing (EPSG:25832)", of degrees beside it not
      if (!own.is_certain) own = {UtmInBrackets(line), true};
      if (HasPlane(header.columns)) TakeSystem(own, header.system);
      return header;
    }
    header.separator = GuessSeparator(line);
    SplitFields(line, header.separator, cells);
    // Names apart by blanks are columns only where all of them are known: prose has such words too.
    if (cells.size() == 1) {
      SplitBlanks(line, cells);
      header.separator = ' ';
    }
    header.columns = MapTolerantColumns(cells);
    header.list = std::move(list);
    const bool may_be_prose = header.separator == ' ' && HasColumn(header.columns, M::kIgnored);
    const auto has = [&](M meaning) { return HasColumn(header.columns, meaning); };
    const bool timed = has(M::kTime) || has(M::kUtc) || has(M::kDate);
    const bool useful = HasDegrees(header.columns) || (has(M::kGyroX) && has(M::kAccelX)) || has(M::kQw) ||
                        (has(M::kRoll) && has(M::kPitch)) || has(M::kEvent) || NamesPhotos(header.columns);
    if (timed && useful && !may_be_prose) return header;
    if (!StartsWithIgnoringCase(line, "sep=")) TakeSystem(SystemOfLine(line, lines), system);
  }
  return std::nullopt;
}

// The systems that a column of zones names in its rows ("33N"), each once; of words that are none, nothing.
std::vector<std::string_view> ZonesOfRows(const CsvHeader& header, LineReader lines) {
  constexpr std::array<std::string_view, 5> kNames = {"zone", "utmzone", "zoneutm", "zona", "huso"};
  const auto column = std::find_if(header.columns.begin(), header.columns.end(), [&](const CsvColumn& one) {
    return one.meaning == M::kIgnored && IsOneOf(LettersAndDigits(LowerCase(one.header)), kNames);
  });
  std::vector<std::string_view> seen, zones, cells;
  if (column == header.columns.end()) return zones;
  const auto at = static_cast<std::size_t>(column - header.columns.begin());
  std::vector<std::string> systems;
  constexpr std::size_t kMaxLookedUp = 8;
  while (seen.size() < kMaxLookedUp && NextRow(lines, header.separator, cells)) {
    if (at >= cells.size() || cells[at].empty() || IsOneOf(cells[at], seen)) continue;
    seen.push_back(cells[at]);
    // A number alone is one of fields, though it may be the code of a system as well.
    if (cells[at].find_first_not_of("0123456789") == std::string_view::npos) continue;
    const auto system = geo::ReferenceSystem::Parse(cells[at]);
    if (!system || system->is_geographic() || IsOneOf(system->definition(), systems)) continue;
    systems.push_back(system->definition());
    zones.push_back(cells[at]);
  }
  return zones;
}

// Of a list in a plane that names no system above its rows. Error: kUnsupportedFormat, for several.
Result<void> TakeZoneOfRows(std::string_view name, LineReader lines, CsvHeader& header) {
  if (header.system.is_certain || !HasPlane(header.columns)) return {};
  const std::vector<std::string_view> zones = ZonesOfRows(header, lines);
  if (zones.size() > 1) {
    return Because(ErrorCode::kUnsupportedFormat,
                   {RemarkCode::kListOfSeveralZones,
                    {{"file", name}, {"first", Quoted(zones[0])}, {"other", Quoted(zones[1])}}});
  }
  if (!zones.empty()) header.system = {zones.front(), true};
  return {};
}

// Lists of photos may say when these were taken, too.
Result<SettledColumns> SettleHeader(std::string_view name, const LineReader& lines, CsvHeader& header) {
  if (header.list) {
    ListHeading& list = *header.list;
    SKYQUILT_TRY_ASSIGN(SettledColumns settled, SettleColumns(name, lines, list.separator, list.columns));
    if (settled.rows_name_photos) {
      header.columns = std::move(list.columns);
      header.separator = list.separator;
      return settled;
    }
  }
  return SettleColumns(name, lines, header.separator, header.columns);
}

std::vector<CsvRow> PreviewOf(LineReader lines, const CsvHeader& header) {
  std::vector<CsvRow> preview;
  std::vector<std::string_view> cells;
  const std::size_t end = lines.offset() + kBytesLookedAhead;
  while (preview.size() < kRowsLookedAhead && NextRow(lines, header.separator, cells, end))
    preview.push_back(ReadCsvRow(header.columns, cells));
  return preview;
}

// Whether most pitches lie within 45 degrees of zero.
bool PitchIsLevel(const std::vector<CsvRow>& preview) {
  std::size_t pitches = 0, level = 0;
  for (const CsvRow& row : preview) {
    if (!row[M::kPitch]) continue;
    ++pitches;
    level += std::abs(*row[M::kPitch]) < geo::DegToRad(45.0) ? 1 : 0;
  }
  return 2 * level > pitches;
}

constexpr double kHighestFlightM = 150.0;

// "height" whose name does not say above what; null where the columns have none, or another one that does.
CsvColumn* FindOpenHeight(std::vector<CsvColumn>& columns) {
  CsvColumn* column = ColumnOf(columns, M::kHeightAboveTakeoff);
  if (column == nullptr || HasColumn(columns, M::kHeightEllipsoid)) return nullptr;
  const std::string name = LowerCase(column->header);
  const bool is_open =
      StartsWithOneOf(name, {"height", "hauteur", "altura"}) && !HoldsOneOf(name, {"take", "rel"});
  return is_open ? column : nullptr;
}

// "height" alone: of drones' own programs above take-off, of surveys above the ellipsoid, of Mission Planner
// above take-off or the sea. Nobody maps from as high above the take-off as much land lies above the sea, and
// no drone's program writes metres of a plane.
void SettleListHeight(std::vector<CsvColumn>& columns, const std::vector<CsvRow>& preview, bool is_survey) {
  constexpr double kMaxGeoidM = 120.0;
  CsvColumn* column = FindOpenHeight(columns);
  if (column == nullptr) return;
  std::vector<double> heights_m;
  for (const CsvRow& row : preview) {
    const auto height_m = row[M::kHeightAboveTakeoff], amsl_m = row[M::kHeightAmsl];
    if (height_m && amsl_m && std::abs(*height_m - *amsl_m) > kMaxGeoidM) return;  // another than that
    if (height_m) heights_m.push_back(*height_m);
  }
  const auto typical_m = MedianIfAny(std::move(heights_m));
  if (is_survey || (typical_m && *typical_m > kHighestFlightM)) {
    const bool is_mission_planners = LowerCase(column->header) == "height/z";
    column->meaning = is_mission_planners ? M::kHeightAmsl : M::kHeightEllipsoid;
    column->is_bare_height = !is_mission_planners;
  }
}

// In logs too: receivers write "height" above the ellipsoid. Those above the take-off begin low.
void SettleLogHeight(std::vector<CsvColumn>& columns, const std::vector<CsvRow>& preview) {
  CsvColumn* column = FindOpenHeight(columns);
  if (column == nullptr || HasColumn(columns, M::kHeightAmsl)) return;
  std::optional<double> lowest_m;  // nothing: they begin behind the rows looked at
  for (const CsvRow& row : preview) {
    const auto height_m = row[M::kHeightAboveTakeoff];
    if (height_m && (!lowest_m || *height_m < *lowest_m)) lowest_m = height_m;
  }
  if (lowest_m && *lowest_m > kHighestFlightM) column->meaning = M::kHeightEllipsoid;
}

// "altura" and "hauteur" by themselves: tables of receivers write heights above the sea so, which taken for
// those above the take-off would put the flight hundreds of metres up.
void LeaveOpenHeight(std::vector<CsvColumn>& columns) {
  CsvColumn* column = ColumnOf(columns, M::kHeightAboveTakeoff);
  if (column == nullptr || HasColumn(columns, M::kHeightAmsl) || HasColumn(columns, M::kHeightEllipsoid))
    return;
  const std::string name = LowerCase(column->header);
  if (!name.starts_with("altura") && !name.starts_with("hauteur")) return;
  column->meant = std::exchange(column->meaning, M::kIgnored);
  column->unknown_words = column->header;
}

// Heights whose name does not say above what count, in lists of photos, as in those without names: from the
// zero of the system, which is the ellipsoid where none is named, and in its unit.
void SettleZeroOfHeights(const geo::ReferenceSystem* system, std::vector<CsvColumn>& columns) {
  const bool is_above_sea = system != nullptr && system->heights_are_above_sea();
  const bool has_ellipsoid = HasColumn(columns, M::kHeightEllipsoid);
  for (CsvColumn& column : columns) {
    const bool is_absolute = column.meaning == M::kHeightEllipsoid || column.meaning == M::kHeightAmsl;
    if (is_absolute && system != nullptr && !column.unit_is_written) {
      column.scale *= system->metres_per_height_unit();
      if (system->metres_per_height_unit() != 1.0) column.unit = "unit of the system";
    }
    if (!is_absolute || !column.is_bare_height) continue;
    if (is_above_sea) {
      column.meaning = M::kHeightAmsl;
    } else if (!has_ellipsoid) {
      column.meaning = M::kHeightEllipsoid;
    }
  }
}

// Replay rows: "4000,imu,ax,ay,az,gx,gy,gz", "200000,gps,alt_mm,lon_e7,lat_e7,vn,ve,vd", "4000,baro,height".
bool IsReplayRow(const std::vector<std::string_view>& cells) {
  if (cells.size() < 3 || !ParseInteger(cells[0])) return false;
  return IsOneOf(cells[1], {"imu", "gps", "baro", "mag", "airspeed", "range", "flow", "landed"});
}

bool LooksLikeReplay(LogBytes bytes) {
  return HasLine(TextOf(bytes), 1, [](std::string_view line) {
    std::vector<std::string_view> cells;
    SplitFields(line, ',', cells);
    return IsReplayRow(cells);
  });
}

Result<FlightLog> ParseReplay(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed) {
  LogBuilder builder("tolerant_csv", name);
  LineReader lines(TextOf(bytes));
  std::string_view line;
  std::vector<std::string_view> cells;
  std::array<double, 6> v{};
  ConsumedSteps steps(consumed);
  while (NextFilledLine(lines, steps, line)) {
    SplitFields(line, ',', cells);
    if (!IsReplayRow(cells)) {
      builder.SkipRow();
      continue;
    }
    const double t_s = static_cast<double>(*ParseInteger(cells[0])) * 1e-6;
    std::size_t numbers = 0;
    while (numbers < v.size() && numbers + 2 < cells.size()) {
      const auto value = ParseNumber(cells[numbers + 2]);
      if (!value) break;
      v[numbers++] = *value;
    }
    builder.Count(std::string(cells[1]), 1);
    if (cells[1] == "imu" && numbers == 6) {
      builder.Add(ImuSample{t_s, {v[3], v[4], v[5]}, {v[0], v[1], v[2]}});
    } else if (cells[1] == "gps" && numbers == 6) {
      GnssSample sample;
      sample.t_s = t_s;
      sample.position = {v[2] * 1e-7, v[1] * 1e-7};
      sample.height_amsl_m = v[0] * 1e-3;
      sample.velocity_in_ned_mps = Eigen::Vector3d(v[3], v[4], v[5]);
      builder.Add(sample);
    } else if (cells[1] == "baro" && numbers >= 1) {
      builder.Add(BaroSample{t_s, v[0]});
    } else if (cells[1] == "range" && numbers >= 1 && v[0] > 0.0) {
      builder.Add(RangeSample{t_s, v[0]});
    }
  }
  if (builder.log().message_counts.empty()) return builder.Refuse(RemarkCode::kFileWithoutRows);
  builder.BaroStartsAtZero();
  builder.log().mapping = {
      "column 1 -> time, us", "imu -> specific force x y z, m/s2; angular rate x y z, rad/s",
      "gps -> height above mean sea level, mm; longitude, latitude, 1e-7 deg; velocity N E D, m/s",
      "baro -> barometric height, m"};
  return std::move(builder).Finish();
}

}  // namespace

bool LooksLikeNamedPlaces(LogBytes head) {
  LineReader lines(TextOf(head));
  const auto header = FindHeader(lines);
  return header && NamesPhotos(header->columns) && (HasDegrees(header->columns) || HasPlane(header->columns));
}

bool LooksLikeTolerantCsv(LogBytes head) {
  LineReader lines(TextOf(head));
  return LooksLikeReplay(head) || FindHeader(lines).has_value();
}

Result<FlightLog> ParseTolerantCsv(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed) {
  if (LooksLikeReplay(bytes)) return ParseReplay(name, bytes, consumed);
  LogBuilder builder("tolerant_csv", name);
  LineReader lines(TextOf(bytes));
  auto header = FindHeader(lines);
  if (!header) {
    return Because(ErrorCode::kUnsupportedFormat, {RemarkCode::kFileWithoutHeader, {{"file", name}}});
  }
  SKYQUILT_TRY_ASSIGN(SettledColumns settled, SettleHeader(name, lines, *header));
  std::vector<CsvRow> preview = PreviewOf(lines, *header);
  if (!header->is_timed || settled.rows_are_photos) {
    SKYQUILT_TRY(TakeZoneOfRows(name, lines, *header));
    SKYQUILT_TRY_ASSIGN(const auto system, SystemOfList(name, header->system));
    const geo::ReferenceSystem* const named = system ? &*system : nullptr;
    // What a counter says of such rows their names say better.
    CsvColumn* counter = ColumnOf(header->columns, M::kTime);
    if (counter != nullptr && HasPlane(header->columns)) counter->meaning = M::kIgnored;
    // Other numbers under these names may be exchanged, or metres: core/poses/lists judges.
    static_cast<void>(SettlePositions(header->columns, preview));
    SettleAngleUnits(header->columns, preview);
    settled.pitch_is_level = PitchIsLevel(preview);
    SettleListHeight(header->columns, preview, named != nullptr || HasPlane(header->columns));
    SettleZeroOfHeights(named, header->columns);
    return ReadImageRows(header->columns, settled, header->separator, lines, std::move(builder), named);
  }
  LeaveOpenHeight(header->columns);
  const auto found = CheckCsvPhysics(header->columns, preview);
  if (!found) {
    return Because(found.error().code,
                   {RemarkCode::kTableNotUsed, {{"file", name}, {"why", WhyOf(found.error())}}});
  }
  const CsvFindings& findings = *found;
  SettleLogHeight(header->columns, preview);
  preview = std::vector<CsvRow>();
  for (Remark& said : SayUnknownWords(header->columns)) builder.Warn(std::move(said));

  CsvSampler sampler(builder, findings.clock, findings.axes.imu_z_is_up,
                     HasColumn(header->columns, M::kHeightAboveTakeoff));
  const SampledRows sampled = SampleRows(header->columns, header->separator, lines, consumed, sampler);
  if (sampled.rows == 0) {
    auto why = sampled.unread.WhyNothing(header->columns, M::kTime, M::kTimeOfDay);
    if (!why) return builder.Refuse(RemarkCode::kTableWithoutTimes);
    return Because(ErrorCode::kCorrupt,
                   {RemarkCode::kTableTimesUnread, {{"file", name}, {"why", *std::move(why)}}});
  }
  sampler.Finish(header->columns, sampled);
  for (const auto* notes : {&std::as_const(settled.notes), &findings.axes.notes})
    builder.log().mapping.insert(builder.log().mapping.end(), notes->begin(), notes->end());
  for (const auto* warnings : {&std::as_const(settled.warnings), &findings.warnings}) {
    for (const Remark& warning : *warnings) builder.Warn(warning);
  }
  sampled.Tell(header->columns, builder);
  return std::move(builder).Finish();
}

}  // namespace skyquilt::flight
