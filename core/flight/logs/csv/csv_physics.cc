#include "core/flight/logs/csv/csv_physics.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/median.h"
#include "core/base/try.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::flight {
namespace {

using M = CsvMeaning;
constexpr double kGravity = 9.80665;

void Rescale(std::vector<CsvColumn>& columns, M first, M last, double factor, const char* unit) {
  for (CsvColumn& column : columns) {
    if (column.meaning >= first && column.meaning <= last) {
      column.scale *= factor;
      column.unit = unit;
    }
  }
}

Error Contradiction(const CsvColumn& column, Remark why) {
  return Because(ErrorCode::kUnprocessable, {RemarkCode::kColumnContradicts,
                                             {{"column", Quoted(column.header)}, {"why", std::move(why)}}});
}

// Median |specific force| is one gravity, whatever the motion of an ordinary flight.
Result<void> CheckAcceleration(std::vector<CsvColumn>& columns, const std::vector<CsvRow>& preview,
                               CsvFindings& findings) {
  std::vector<double> norms, x, y, z;
  for (const CsvRow& row : preview) {
    if (!row.Has(M::kAccelX, M::kAccelZ)) continue;
    x.push_back(*row[M::kAccelX]);
    y.push_back(*row[M::kAccelY]);
    z.push_back(*row[M::kAccelZ]);
    norms.push_back(std::sqrt(x.back() * x.back() + y.back() * y.back() + z.back() * z.back()));
  }
  if (norms.size() < 10) return {};
  CsvColumn* column = ColumnOf(columns, M::kAccelX);
  const double norm = Median(norms);
  double factor = 0.0;
  const auto near = [&](double one_gravity) { return norm > 0.7 * one_gravity && norm < 1.4 * one_gravity; };
  if (near(kGravity))
    factor = 1.0;
  else if (column->unit_is_written) {
    return Contradiction(*column,
                         {RemarkCode::kUnitMakesGravity, {{"unit", column->unit}, {"gravity_mps2", norm}}});
  } else if (near(1.0))
    factor = kGravity;
  else if (near(1000.0))
    factor = kGravity * 1e-3;
  if (factor == 0.0) {
    return Contradiction(*column, {RemarkCode::kGravityOfNoUnit, {{"force", norm}}});
  }
  if (factor != 1.0) Rescale(columns, M::kAccelX, M::kAccelZ, factor, factor > 1.0 ? "g" : "mg");
  const double up = Median(z);
  if (std::abs(up) < 0.6 * norm) {
    return Contradiction(*ColumnOf(columns, M::kAccelZ), RemarkCode::kGravityOffAxis);
  }
  findings.imu_z_is_up = up > 0.0;
  findings.notes.push_back(
      findings.imu_z_is_up
          ? "IMU axes -> forward, left, up (az is positive at rest); turned to forward, right, down"
          : "IMU axes -> forward, right, down");
  return {};
}

// Turns seen by the attitude column against the turns of the integrated rates.
Result<void> CheckRates(std::vector<CsvColumn>& columns, const std::vector<CsvRow>& preview,
                        double seconds_per_time) {
  CsvColumn* column = ColumnOf(columns, M::kGyroX);
  if (column == nullptr) return {};
  std::optional<Eigen::Quaterniond> last_attitude;
  std::optional<double> last_t;
  double turned = 0.0;
  std::vector<double> rates, ratios;
  for (const CsvRow& row : preview) {
    const auto t = row[M::kTime];
    if (!row.Has(M::kGyroX, M::kGyroZ) || !t) continue;
    const double rate = std::sqrt(*row[M::kGyroX] * *row[M::kGyroX] + *row[M::kGyroY] * *row[M::kGyroY] +
                                  *row[M::kGyroZ] * *row[M::kGyroZ]);
    rates.push_back(rate);
    if (last_t) turned += rate * std::clamp((*t - *last_t) * seconds_per_time, 0.0, 1.0);
    last_t = t;
    std::optional<Eigen::Quaterniond> attitude;
    if (row.Has(M::kQw, M::kQz))
      attitude = Eigen::Quaterniond(*row[M::kQw], *row[M::kQx], *row[M::kQy], *row[M::kQz]).normalized();
    else if (row.Has(M::kRoll, M::kYaw))
      attitude = NedFromYawPitchRoll(*row[M::kYaw], *row[M::kPitch], *row[M::kRoll]);
    if (!attitude) continue;
    if (last_attitude) {
      const double angle = last_attitude->angularDistance(*attitude);
      if (angle < 0.05) continue;  // wait until a turn stands out of the noise
      if (angle < 1.0 && turned > 0.0) ratios.push_back(turned / angle);
    }
    last_attitude = attitude;
    turned = 0.0;
  }
  if (rates.empty()) return {};
  const double limit = 20.0;  // rad/s; nothing that takes photos turns faster for long
  const double factor_deg = geo::DegToRad(1.0);
  bool is_deg = false;
  if (ratios.size() >= 5)
    is_deg = std::abs(std::log(Median(ratios) * factor_deg)) < std::abs(std::log(Median(ratios)));
  else
    is_deg = Median(rates) > limit;
  if (!is_deg) return {};
  if (column->unit_is_written) {
    return Contradiction(*column, {RemarkCode::kRatesLookLikeDegrees, {{"unit", column->unit}}});
  }
  Rescale(columns, M::kGyroX, M::kGyroZ, factor_deg, "deg/s");
  return {};
}

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
      factor = HoldsExposuresAlone(columns) ? FactorOfTriggerStep(step) : FactorOfRecorderStep(step);
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
    const bool is_clock = column.meaning >= M::kUtc && column.meaning <= M::kTimeOfDay;
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

}  // namespace

Result<CsvFindings> CheckCsvPhysics(std::vector<CsvColumn>& columns, const std::vector<CsvRow>& preview) {
  CsvFindings findings;
  SKYQUILT_TRY_ASSIGN(const auto time_factor, CheckTime(columns, preview, findings));
  CheckDate(columns, preview, findings);
  TellNumbersFromFlags(columns, preview);
  SKYQUILT_TRY(CheckAcceleration(columns, preview, findings));
  SKYQUILT_TRY(CheckRates(columns, preview, time_factor));
  // Positions as integers of 1e-7 degrees.
  for (const M meaning : {M::kLat, M::kLon}) {
    std::vector<double> sizes;
    for (const CsvRow& row : preview) {
      if (row[meaning] && *row[meaning] != 0.0) sizes.push_back(std::abs(*row[meaning]));
    }
    CsvColumn* column = ColumnOf(columns, meaning);
    if (sizes.empty() || column == nullptr) continue;
    const double most = meaning == M::kLat ? 90.0 : 180.0;
    const double median = Median(sizes);
    if (median <= most) continue;
    if (median * 1e-7 > most) {
      const bool is_lat = meaning == M::kLat;
      return Contradiction(
          *column, {is_lat ? RemarkCode::kIsNoLatitude : RemarkCode::kIsNoLongitude, {{"degrees", median}}});
    }
    Rescale(columns, meaning, meaning, 1e-7, "1e-7 deg");
  }
  return findings;
}

}  // namespace skyquilt::flight
