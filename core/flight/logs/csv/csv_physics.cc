#include "core/flight/logs/csv/csv_physics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/median.h"
#include "core/base/try.h"
#include "core/flight/bytes/text_fields.h"
#include "core/geo/geodesic.h"

namespace skyquilt::flight {
namespace {

using M = CsvMeaning;

// A column of exposures with more than noughts and ones numbers the photos.
void TellNumbersFromFlags(std::vector<CsvColumn>& columns, const std::vector<CsvRow>& preview) {
  CsvColumn* column = ColumnOf(columns, M::kIsPhoto);
  if (column == nullptr || HasColumn(columns, M::kEvent)) return;
  const bool is_numbered = std::any_of(
      preview.begin(), preview.end(), [](const CsvRow& row) { return row[M::kIsPhoto].value_or(0.0) > 1.0; });
  if (is_numbered) column->meaning = M::kEvent;
}

// Rows of exposures alone come seconds apart, where a recorder's come tenths apart.
double FactorOfTriggerStep(double step) {
  if (step >= 1.5e8) return 1e-9;
  if (step >= 1.5e5) return 1e-6;
  return step >= 150.0 ? 1e-3 : 1.0;
}

double FactorOfRecorderStep(double step) {
  if (step >= 2e6) return 1e-9;
  if (step > 2000.0) return 1e-6;
  return step >= 2.0 ? 1e-3 : 1.0;
}

bool HoldsExposuresAlone(std::vector<CsvColumn>& columns) {
  return std::all_of(columns.begin(), columns.end(), [](const CsvColumn& column) {
    return column.meaning <= M::kTimeOfDay || column.meaning >= M::kEvent;
  });
}

// Between places that differ, were the time column's unit a second; nothing where rows hold no two places.
std::optional<double> MedianSpeedMps(const std::vector<CsvRow>& preview) {
  std::optional<geo::LatLon> last;
  double last_t = 0.0;
  std::vector<double> speeds_mps;
  for (const CsvRow& row : preview) {
    const auto place = PlaceOf(row);
    if (!place || *place == geo::LatLon{} || !row[M::kTime]) continue;  // 0, 0: before the first fix
    const double metres = last ? geo::MetresApart(*last, *place) : 0.0;
    if (last && metres <= 0.0) continue;  // not measured anew
    const double step = *row[M::kTime] - last_t;
    if (last && step > 0.0) speeds_mps.push_back(metres / step);
    last = place;
    last_t = *row[M::kTime];
  }
  constexpr std::size_t kFewestSteps = 3;
  return speeds_mps.size() < kFewestSteps ? std::nullopt : MedianIfAny(std::move(speeds_mps));
}

// Rows of exposures and slow receivers come seconds apart, which is a recorder's step in milliseconds: where
// it flew says which.
double FactorOfSpeed(const std::vector<CsvRow>& preview, double factor) {
  constexpr double kFastestMps = 150.0;  // of what takes photos for maps
  const std::optional<double> mps_of_seconds = MedianSpeedMps(preview);
  if (!mps_of_seconds) return factor;
  for (const double larger : {1e-6, 1e-3, 1.0}) {
    const double speed_mps = *mps_of_seconds / factor;
    if (larger > factor && speed_mps > kFastestMps) factor = larger;
  }
  return factor;
}

// The unit of the time column from its size (Unix times) or its step.
Result<double> CheckTime(std::vector<CsvColumn>& columns, const std::vector<CsvRow>& preview,
                         CsvFindings& findings) {
  CsvColumn* column = ColumnOf(columns, M::kTime);
  if (column == nullptr) return 1.0;
  std::vector<double> steps;
  std::optional<double> first, last;
  std::size_t back = 0;
  for (const CsvRow& row : preview) {
    const auto t = row[M::kTime];
    if (!t) continue;
    if (!first) first = t;
    if (last && *t > *last) steps.push_back(*t - *last);
    if (last && *t < *last) ++back;
    last = t;
  }
  if (!first) return 1.0;
  if (back > steps.size()) return Contradiction(*column, RemarkCode::kTimesFall);
  double factor = 1.0;
  if (!column->unit_is_written && !steps.empty()) {
    const double size = std::abs(*first);
    const double step = Median(steps);
    if (size > 3e17)
      factor = 1e-9;  // Unix times in ns, us, ms
    else if (size > 3e14)
      factor = 1e-6;
    else if (size > 3e11)
      factor = 1e-3;
    else if (size > 3e8 && step <= 60.0)
      factor = 1.0;
    else
      factor = HoldsExposuresAlone(columns) ? FactorOfTriggerStep(step)
                                            : FactorOfSpeed(preview, FactorOfRecorderStep(step));
    column->scale *= factor;
    column->unit = factor == 1.0 ? "s" : factor == 1e-3 ? "ms" : factor == 1e-6 ? "us" : "ns";
  }
  findings.clock.has_time_column = true;
  findings.clock.first_time_s = *first * factor;
  findings.clock.time_is_unix = findings.clock.first_time_s > 6e8 && findings.clock.first_time_s < 4.2e9;
  return factor;
}

void CheckDate(const std::vector<CsvColumn>& columns, const std::vector<CsvRow>& preview,
               CsvFindings& findings) {
  bool has_date = false;
  bool says_utc = false;
  for (const CsvColumn& column : columns) {
    const bool is_clock = IsOfClock(column.meaning);
    has_date = has_date || is_clock;
    says_utc = says_utc || (is_clock && column.says_utc);
  }
  if (has_date) findings.clock.utc_is_utc = says_utc;
  std::size_t ticks = 0;
  std::size_t rows = 0;
  std::optional<UtcTime> last;
  for (const CsvRow& row : preview) {
    if (!row.written) continue;
    if (++rows == 1 && row.written->names_zone) findings.clock.utc_is_utc = true;
    if (row.written->time != last) ++ticks;
    last = row.written->time;
  }
  if (ticks > 2) findings.clock.rows_per_tick = static_cast<double>(rows) / static_cast<double>(ticks);
}

// The sizes of a column's numbers that are not 0.
struct Sizes {
  double median = 0.0;
  double range = 0.0;  // of nine in ten
  bool are_whole = true;
};

std::optional<Sizes> SizesOf(const std::vector<CsvRow>& preview, M meaning) {
  std::vector<double> values;
  for (const CsvRow& row : preview) {
    if (row[meaning] && *row[meaning] != 0.0) values.push_back(std::abs(*row[meaning]));
  }
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  const std::size_t few = values.size() / 20;
  return Sizes{
      values[values.size() / 2], values[values.size() - 1 - few] - values[few],
      std::all_of(values.begin(), values.end(), [](double value) { return value == std::floor(value); })};
}

// Heights beside positions that are whole numbers are so in millimetres: no flight climbs a kilometre.
void CheckHeights(std::vector<CsvColumn>& columns, std::vector<CsvRow>& preview) {
  constexpr double kHighestM = 9000.0, kHighestClimbM = 1000.0;
  for (const M meaning : {M::kHeightEllipsoid, M::kHeightAmsl, M::kHeightAboveTakeoff}) {
    const CsvColumn* column = ColumnOf(columns, meaning);
    const auto sizes = SizesOf(preview, meaning);
    if (column == nullptr || column->unit_is_written || !sizes || !sizes->are_whole) continue;
    if (sizes->median > kHighestM || sizes->range > kHighestClimbM)
      Rescale(columns, preview, {meaning, meaning}, 1e-3, "mm");
  }
}

// "altitude" alone that begins at 0 and climbs from there counts from the take-off, as Litchi writes it: a
// sea as near would hardly lie lower. One that leaps from 0 was not known before.
void SettleZeroOfAltitudes(std::vector<CsvColumn>& columns, const std::vector<CsvRow>& preview,
                           CsvFindings& findings) {
  constexpr double kAtZeroM = 0.3, kLeapM = 10.0, kAloftM = 5.0;
  CsvColumn* column = ColumnOf(columns, M::kHeightAmsl);
  if (column == nullptr || !column->is_bare_height || HasColumn(columns, M::kHeightEllipsoid) ||
      HasColumn(columns, M::kHeightAboveTakeoff))
    return;
  std::optional<double> last_m;
  double highest_m = 0.0;
  for (const CsvRow& row : preview) {
    const auto place = PlaceOf(row);
    const auto height_m = row[M::kHeightAmsl];
    if (!place || *place == geo::LatLon{} || !height_m) continue;  // 0, 0: before the first fix
    if (!(std::abs(*height_m - last_m.value_or(0.0)) <= (last_m ? kLeapM : kAtZeroM))) return;
    highest_m = std::max(highest_m, *height_m);
    last_m = height_m;
  }
  if (highest_m < kAloftM) return;
  column->meaning = M::kHeightAboveTakeoff;
  findings.warnings.push_back({RemarkCode::kAltitudesFromTakeoff, {{"column", Quoted(column->header)}}});
}

}  // namespace

// Positions may be whole numbers of 1e-7 degrees. What else is no degrees is metres of a plane, degrees with
// their minutes ("4650.5565") or the other coordinate, and would lie in the sea before Africa.
Result<void> SettlePositions(std::vector<CsvColumn>& columns, std::vector<CsvRow>& preview) {
  constexpr double kSmallUnit = 1e-7, kNearestDeg = 1.0;
  constexpr std::array kBoth = {std::pair{M::kLat, 90.0}, std::pair{M::kLon, 180.0}};
  const std::array sizes = {SizesOf(preview, M::kLat), SizesOf(preview, M::kLon)};
  if (!sizes[0] || !sizes[1]) return {};
  const auto& [low, high] = std::minmax(sizes[0]->median, sizes[1]->median);
  // Rows between those of the receiver may be worked out: they are not whole, and less is believed of them.
  const bool are_whole = sizes[0]->are_whole && sizes[1]->are_whole;
  const bool may_be_small = (are_whole ? high : low) * kSmallUnit > kNearestDeg;
  bool are_small = false;
  for (std::size_t i = 0; i < kBoth.size(); ++i) {
    const auto& [meaning, most_deg] = kBoth[i];
    const double median = sizes[i]->median;
    if (median <= most_deg) continue;
    if (!may_be_small || median * kSmallUnit > most_deg) {
      const RemarkCode why = meaning == M::kLat ? RemarkCode::kIsNoLatitude : RemarkCode::kIsNoLongitude;
      return Contradiction(*ColumnOf(columns, meaning), {why, {{"degrees", median}}});
    }
    are_small = true;
  }
  if (!are_small) return {};
  Rescale(columns, preview, {M::kLat, M::kLon}, kSmallUnit, "1e-7 deg");
  CheckHeights(columns, preview);
  return {};
}

Result<CsvFindings> CheckCsvPhysics(std::vector<CsvColumn>& columns, std::vector<CsvRow>& preview) {
  CsvFindings findings;
  SKYQUILT_TRY(SettlePositions(columns, preview));
  SKYQUILT_TRY_ASSIGN(const double seconds_per_time, CheckTime(columns, preview, findings));
  CheckDate(columns, preview, findings);
  TellNumbersFromFlags(columns, preview);
  SettleZeroOfAltitudes(columns, preview, findings);
  SettleAngleUnits(columns, preview);
  SettlePressureUnit(columns, preview);
  SKYQUILT_TRY_ASSIGN(findings.axes, SettleInertialUnits(columns, preview, seconds_per_time));
  return findings;
}

}  // namespace skyquilt::flight
