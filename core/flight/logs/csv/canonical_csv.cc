#include "core/flight/logs/csv/canonical_csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/try.h"
#include "core/flight/logs/csv/csv_rows.h"
#include "core/flight/logs/csv/csv_units.h"
#include "core/flight/logs/csv/list_columns.h"
#include "core/flight/logs/formats.h"

namespace skyquilt::flight {
namespace {

using M = CsvMeaning;

// Of meanings that follow each other; in lower case, in any order of the columns.
struct CanonicalNames {
  M first;
  std::string_view names;
};
constexpr CanonicalNames kCanonicalNames[] = {
    {M::kTime, "t utc"},
    {M::kLat, "lat lon"},
    {M::kHeightEllipsoid, "alt_ell alt_msl rel_alt"},
    {M::kRange, "range baro_alt press"},
    {M::kVelocityNorth, "vn ve vd sh sv fix"},
    {M::kGyroX, "wx wy wz ax ay az qw qx qy qz roll pitch yaw"},
    {M::kSigmaTilt, "s_rp s_yaw event"},
    {M::kImage, "image"},
};

// kIgnored for any other name.
M MeaningOfCanonical(std::string_view name) {
  std::vector<std::string_view> names;
  for (const CanonicalNames& each : kCanonicalNames) {
    SplitBlanks(each.names, names);
    const auto found = std::find(names.begin(), names.end(), name);
    if (found != names.end()) return static_cast<M>(static_cast<int>(each.first) + (found - names.begin()));
  }
  return M::kIgnored;
}

void DropRepeated(std::vector<CsvColumn>& columns) {
  std::array<bool, static_cast<std::size_t>(M::kCount)> seen{};
  for (CsvColumn& column : columns) {
    bool& taken = seen[static_cast<std::size_t>(column.meaning)];
    if (taken) column.meaning = M::kIgnored;
    taken = true;
  }
}

// Of the header, where it has no others; else empty.
std::vector<std::string_view> CanonicalNamesIn(LogBytes head) {
  LineReader lines(TextOf(head));
  std::vector<std::string_view> names;
  const auto is_canonical = [](std::string_view name) { return MeaningOfCanonical(name) != M::kIgnored; };
  const bool are_all = NextRow(lines, ',', names) && names.size() >= 2 &&
                       std::all_of(names.begin(), names.end(), is_canonical);
  if (!are_all) names.clear();
  return names;
}

std::vector<CsvColumn> MapCanonicalColumns(const std::vector<std::string_view>& header) {
  std::vector<CsvColumn> columns;
  columns.reserve(header.size());
  for (const std::string_view name : header) {
    CsvColumn column;
    column.header = name;
    column.meaning = MeaningOfCanonical(name);
    const auto [scale, unit] = DefaultUnit(CsvMeaningDimension(column.meaning));
    column.scale = scale;
    column.unit = unit;
    column.unit_is_written = true;  // the format fixes it
    column.says_utc = column.meaning == M::kUtc;
    columns.push_back(std::move(column));
  }
  DropRepeated(columns);
  return columns;
}

CameraEvent EventOf(const CsvRow& row, AttitudeKind kind) {
  CameraEvent event;
  event.image_name = std::string(row.image.substr(0, kMaxNameLength));
  TakePose(row, kind, event);
  event.sigma_in_ned_m = SigmaInNedM(row[M::kSigmaHorizontal], row[M::kSigmaVertical]);
  event.sigma_tilt_rad = row[M::kSigmaTilt];
  event.sigma_yaw_rad = row[M::kSigmaYaw];
  return event;
}

// Where the rows of one list are, as they are written and in the plain reading of it.
class RowPlaces {
 public:
  RowPlaces(const std::vector<CsvColumn>& columns, const geo::ReferenceSystem* system)
      : system_(system),
        is_plane_(HasPlane(columns) && !HasDegrees(columns)),
        has_pair_(is_plane_ || HasDegrees(columns)),
        order_(is_plane_ ? OrderOfPair(columns) : PairOrder::kNamed) {}

  void Take(std::size_t line, CameraEvent& event) {
    if (!event.written) return;
    const WrittenPlace at = *event.written;
    const bool may_be_degrees = std::abs(at.x) <= 180.0 && std::abs(at.y) <= 180.0;
    are_degrees_ = are_degrees_ && may_be_degrees;
    if (system_ != nullptr) {
      if (++placed_ <= kMaxPlaced) event.position = system_->ToLatLon(at.x, at.y);
      return;
    }
    const bool is_on_earth = geo::LatLon::Make(at.y, at.x).ok();
    if (is_plane_ && !is_on_earth) return;
    event.position = geo::LatLon{at.y, at.x};  // LogBuilder looks at it
    if (!is_on_earth && ++off_earth_ == 1) first_off_ = {line, at};
  }

  void Tell(LogBuilder& builder) const {
    const auto& [line, at] = first_off_;
    if (off_earth_ > 0)
      builder.Warn({RemarkCode::kRowsNowhere,
                    {{"rows", off_earth_}, {"line", line}, {"lat_deg", at.y}, {"lon_deg", at.x}}});
    FlightLog& log = builder.log();
    log.written_order_is_named = has_pair_ && order_ == PairOrder::kNamed;
    log.written_order_is_assumed = order_ == PairOrder::kOpen && are_degrees_ && system_ == nullptr;
    if (system_ == nullptr) return;
    log.written_system = system_->definition();
    log.mapping.push_back(fmt::format("x, y -> {}", system_->name()));
  }

 private:
  static constexpr std::uint64_t kMaxPlaced =
      200'000;  // more events no log holds; each costs a transformation

  const geo::ReferenceSystem* system_;
  bool is_plane_, has_pair_;
  PairOrder order_;
  bool are_degrees_ = true;
  std::uint64_t placed_ = 0;
  // Rows whose place cannot be one as the columns are named.
  std::uint64_t off_earth_ = 0;
  std::pair<std::size_t, WrittenPlace> first_off_;  // and its line
};

// Angles are used only as a whole.
std::optional<Remark> SayLackingAngles(const std::vector<CsvColumn>& columns) {
  const auto has = [&](M meaning) { return HasColumn(columns, meaning); };
  if (has(M::kGimbalPitch) && has(M::kGimbalYaw)) return std::nullopt;
  std::string names;
  for (const auto& angles :
       {std::array{M::kYaw, M::kPitch, M::kRoll}, std::array{M::kOmega, M::kPhi, M::kKappa}}) {
    if (std::all_of(angles.begin(), angles.end(), has)) return std::nullopt;
    for (const M angle : angles) {
      if (const CsvColumn* column = ColumnOf(columns, angle))
        names += (names.empty() ? "" : ", ") + Quoted(column->header);
    }
  }
  if (names.empty()) return std::nullopt;
  return Remark{RemarkCode::kAnglesLackOthers, {{"columns", names}}};
}

}  // namespace

bool LooksLikeFlightCsv(LogBytes head) {
  const auto names = CanonicalNamesIn(head);
  return (IsOneOf("t", names) || IsOneOf("utc", names)) && !IsOneOf("image", names);
}

bool LooksLikeImagesCsv(LogBytes head) { return IsOneOf("image", CanonicalNamesIn(head)); }

Result<FlightLog> ParseFlightCsv(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed) {
  LogBuilder builder("flight_csv", name);
  LineReader lines(TextOf(bytes));
  std::vector<std::string_view> cells;
  if (!NextRow(lines, ',', cells)) return builder.Refuse(RemarkCode::kFileEmpty);
  const auto columns = MapCanonicalColumns(cells);
  CsvClockRule rule;
  rule.has_time_column = HasColumn(columns, M::kTime);
  CsvSampler sampler(builder, rule, false, HasColumn(columns, M::kHeightAboveTakeoff));
  const SampledRows sampled = SampleRows(columns, ',', lines, consumed, sampler);
  if (sampled.rows == 0) return builder.Refuse(RemarkCode::kFileWithoutTimes);
  sampler.Finish(columns, sampled);
  sampled.Tell(columns, builder);
  return std::move(builder).Finish();
}

Result<FlightLog> ParseImagesCsv(std::string_view name, LogBytes bytes, const ConsumedUpTo&) {
  LogBuilder builder("images_csv", name);
  LineReader lines(TextOf(bytes));
  std::vector<std::string_view> cells;
  if (!NextRow(lines, ',', cells)) return builder.Refuse(RemarkCode::kFileEmpty);
  std::vector<CsvColumn> columns = MapCanonicalColumns(cells);
  SKYQUILT_TRY_ASSIGN(const SettledColumns settled, SettleColumns(name, lines, ',', columns));
  return ReadImageRows(columns, settled, ',', lines, std::move(builder));
}

Result<FlightLog> ReadImageRows(const std::vector<CsvColumn>& columns, const SettledColumns& settled,
                                char separator, LineReader lines, LogBuilder builder,
                                const geo::ReferenceSystem* system) {
  std::vector<std::string_view> cells;
  const bool has_time = HasColumn(columns, M::kTime);
  const bool says_utc = std::any_of(columns.begin(), columns.end(), [](const CsvColumn& column) {
    return column.says_utc && IsOfClock(column.meaning);
  });
  const AttitudeKind kind = settled.pitch_is_level ? AttitudeKind::kAirframe : AttitudeKind::kGimbal;
  std::optional<UtcTime> first;
  std::uint64_t rows = 0;
  std::uint64_t bad = 0;
  UnreadCells unread;
  RowPlaces places(columns, system);
  while (NextRow(lines, separator, cells)) {
    const CsvRow row = ReadCsvRow(columns, cells, &unread, lines.line_number());
    if (row.image.empty()) {
      ++bad;
      continue;
    }
    CameraEvent event = EventOf(row, kind);
    places.Take(lines.line_number(), event);
    // A local clock says nothing that the name does not say better.
    const bool is_utc = row.written && (says_utc || row.written->names_zone);
    event.has_time = true;
    if (has_time && row[M::kTime]) {
      event.t_s = *row[M::kTime];
      if (is_utc && !first && std::abs(event.t_s) < 1e9) first = LaterBy(row.written->time, -event.t_s);
    } else if (!has_time && is_utc) {
      if (!first) first = row.written->time;
      event.t_s = SecondsBetween(*first, row.written->time);
    } else {
      event.has_time = false;
      event.t_s = static_cast<double>(rows);
    }
    ++rows;
    builder.Add(std::move(event));
  }
  if (rows == 0) return builder.Refuse(RemarkCode::kFileNamesNoPhoto);
  builder.Count("row", rows);
  builder.log().utc_at_zero = first;
  if (has_time) builder.log().counter_at_zero_s = 0.0;
  builder.log().utc_sigma_s = 0.05;
  builder.log().mapping = DescribeColumns(columns);
  builder.log().mapping.insert(builder.log().mapping.end(), settled.notes.begin(), settled.notes.end());
  if (settled.pitch_is_level)
    builder.log().mapping.emplace_back("pitch -> 0 is straight down, as most of its cells are near 0");
  unread.Tell(columns, builder);
  places.Tell(builder);
  for (Remark& said : SayUnknownWords(columns)) builder.Warn(std::move(said));
  if (auto said = SayLackingAngles(columns)) builder.Warn(*std::move(said));
  for (const Remark& warning : settled.warnings) builder.Warn(warning);
  if (bad > 0) builder.Warn({RemarkCode::kRowsWithoutImage, {{"rows", bad}}});
  return std::move(builder).Finish();
}

}  // namespace skyquilt::flight
