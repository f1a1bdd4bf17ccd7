#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/median.h"
#include "core/base/try.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/csv/csv_physics.h"
#include "core/flight/remarks/because.h"
#include "core/geo/lat_lon.h"
#include "core/geo/local_frame.h"

namespace skyquilt::flight {
namespace {

using M = CsvMeaning;
constexpr double kGravity = 9.80665;

// Median |specific force| is one gravity, whatever the motion of an ordinary flight.
Result<SensorAxes> CheckAcceleration(std::vector<CsvColumn>& columns, std::vector<CsvRow>& preview) {
  SensorAxes axes;
  std::vector<double> norms, z;
  for (const CsvRow& row : preview) {
    if (!row.Has(M::kAccelX, M::kAccelZ)) continue;
    z.push_back(*row[M::kAccelZ]);
    norms.push_back(std::hypot(*row[M::kAccelX], *row[M::kAccelY], *row[M::kAccelZ]));
  }
  if (norms.size() < 10) return axes;
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
  if (factor != 1.0) Rescale(columns, preview, {M::kAccelX, M::kAccelZ}, factor, factor > 1.0 ? "g" : "mg");
  const double up = Median(z);
  if (std::abs(up) < 0.6 * norm) {
    return Contradiction(*ColumnOf(columns, M::kAccelZ), RemarkCode::kGravityOffAxis);
  }
  axes.imu_z_is_up = up > 0.0;
  axes.notes.emplace_back(
      axes.imu_z_is_up
          ? "IMU axes -> forward, left, up (az is positive at rest); turned to forward, right, down"
          : "IMU axes -> forward, right, down");
  return axes;
}

// Turns seen by the attitude column against the turns of the integrated rates.
Result<void> CheckRates(std::vector<CsvColumn>& columns, std::vector<CsvRow>& preview,
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
    const double rate = std::hypot(*row[M::kGyroX], *row[M::kGyroY], *row[M::kGyroZ]);
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
  Rescale(columns, preview, {M::kGyroX, M::kGyroZ}, factor_deg, "deg/s");
  return {};
}

// East and north; of rows in a plane in its unit. Nothing where one of them has no place.
std::optional<Eigen::Vector2d> WayInEnM(const CsvRow& from, const CsvRow& to) {
  if (from.Has(M::kEast, M::kNorth) && to.Has(M::kEast, M::kNorth))
    return Eigen::Vector2d(*to[M::kEast] - *from[M::kEast], *to[M::kNorth] - *from[M::kNorth]);
  const auto here = PlaceOf(from), there = PlaceOf(to);
  if (!here || !there) return std::nullopt;
  const geo::LocalFrame frame({here->lat_deg, here->lon_deg, 0.0});
  return Eigen::Vector2d(frame.EnuAtHeight(*there, 0.0).head<2>());
}

// Of rows that moved: the share whose yaw, times `factor`, points along the way since the last of them.
double ShareAlongCourse(const std::vector<CsvRow>& preview, M yaw, double factor) {
  constexpr double kMinWayM = 3.0, kAlongRad = 0.5;
  constexpr std::size_t kFewestRows = 5;
  const CsvRow* last = nullptr;
  std::size_t moved = 0, along = 0;
  for (const CsvRow& row : preview) {
    if (!row[yaw]) continue;
    const auto way_in_en_m = last != nullptr ? WayInEnM(*last, row) : std::nullopt;
    if (way_in_en_m && way_in_en_m->norm() < kMinWayM) continue;
    if (way_in_en_m) {
      const double off_rad = *row[yaw] * factor - std::atan2(way_in_en_m->x(), way_in_en_m->y());
      ++moved;
      along += std::abs(std::remainder(off_rad, 2.0 * geo::kPi)) < kAlongRad ? 1 : 0;
    }
    last = &row;
  }
  return moved < kFewestRows ? 0.0 : static_cast<double>(along) / static_cast<double>(moved);
}

// Between the least and the greatest.
double TurnedRad(const std::vector<CsvRow>& preview, M yaw) {
  std::vector<double> yaws;
  for (const CsvRow& row : preview) {
    if (row[yaw]) yaws.push_back(*row[yaw]);
  }
  if (yaws.empty()) return 0.0;
  const auto [least, greatest] = std::minmax_element(yaws.begin(), yaws.end());
  return *greatest - *least;
}

bool IsUnitWritten(const std::vector<CsvColumn>& columns, CsvMeanings meanings) {
  return std::any_of(columns.begin(), columns.end(), [&](const CsvColumn& column) {
    return column.meaning >= meanings.first && column.meaning <= meanings.last && column.unit_is_written;
  });
}

// The largest size of these meanings' numbers.
double LargestOf(const std::vector<CsvRow>& preview, CsvMeanings meanings) {
  double largest = 0.0;
  for (const CsvRow& row : preview) {
    for (auto i = static_cast<std::size_t>(meanings.first); i <= static_cast<std::size_t>(meanings.last); ++i)
      largest = std::max(largest, std::abs(row.number[i].value_or(0.0)));
  }
  return largest;
}

}  // namespace

void Rescale(std::vector<CsvColumn>& columns, std::vector<CsvRow>& preview, CsvMeanings meanings,
             double factor, const char* unit) {
  for (CsvColumn& column : columns) {
    if (column.meaning < meanings.first || column.meaning > meanings.last) continue;
    column.scale *= factor;
    column.unit = unit;
  }
  for (CsvRow& row : preview) {
    for (auto i = static_cast<std::size_t>(meanings.first); i <= static_cast<std::size_t>(meanings.last);
         ++i) {
      if (row.number[i]) *row.number[i] *= factor;
    }
  }
}

Error Contradiction(const CsvColumn& column, Remark why) {
  return Because(ErrorCode::kUnprocessable, {RemarkCode::kColumnContradicts,
                                             {{"column", Quoted(column.header)}, {"why", std::move(why)}}});
}

std::optional<geo::LatLon> PlaceOf(const CsvRow& row) {
  if (!row[M::kLat] || !row[M::kLon]) return std::nullopt;
  const auto place = geo::LatLon::Make(*row[M::kLat], *row[M::kLon]);
  return place ? std::optional(*place) : std::nullopt;
}

Result<SensorAxes> SettleInertialUnits(std::vector<CsvColumn>& columns, std::vector<CsvRow>& preview,
                                       double seconds_per_time) {
  SKYQUILT_TRY_ASSIGN(SensorAxes axes, CheckAcceleration(columns, preview));
  SKYQUILT_TRY(CheckRates(columns, preview, seconds_per_time));
  return axes;
}

void SettleAngleUnits(std::vector<CsvColumn>& columns, std::vector<CsvRow>& preview) {
  constexpr double kMinAlong = 0.6,
                   kMinMoreAlong = 0.1;               // of rows; degrees about 0 fit the legs to the north
  constexpr double kOneTurn = 2.0 * geo::kPi + 0.01;  // as written, rounded
  constexpr double kMinTurn = 1.0;  // as written: a nose that is held one way proves nothing
  const double per_degree = geo::DegToRad(1.0);
  // A kappa beyond a full turn of degrees counts gons, and omega and phi beside it.
  constexpr CsvMeanings kOfCamera{M::kOmega, M::kKappa};
  constexpr double kTurnDeg = 360.01, kTurnGon = 400.01;
  const double largest = LargestOf(preview, kOfCamera) / per_degree;
  if (!IsUnitWritten(columns, kOfCamera) && largest > kTurnDeg && largest < kTurnGon)
    Rescale(columns, preview, kOfCamera, 0.9, "gon");
  for (const CsvMeanings angles :
       {CsvMeanings{M::kRoll, M::kYaw}, CsvMeanings{M::kGimbalRoll, M::kGimbalYaw}, kOfCamera}) {
    if (IsUnitWritten(columns, angles) || LargestOf(preview, angles) > kOneTurn * per_degree) continue;
    if (TurnedRad(preview, angles.last) < kMinTurn * per_degree) continue;
    const double clockwise = angles.last == M::kKappa ? -1.0 : 1.0;
    const double as_radians = ShareAlongCourse(preview, angles.last, clockwise / per_degree),
                 as_degrees = ShareAlongCourse(preview, angles.last, clockwise);
    if (as_radians < kMinAlong || as_radians < as_degrees + kMinMoreAlong) continue;
    Rescale(columns, preview, angles, 1.0 / per_degree, "rad");
  }
}

void SettlePressureUnit(std::vector<CsvColumn>& columns, std::vector<CsvRow>& preview) {
  constexpr double kMaxChange = 0.15;  // of a flight of a kilometre; heights change by more
  const CsvColumn* column = ColumnOf(columns, M::kPressure);
  if (column == nullptr || column->unit_is_written || LowerCase(column->header) == "baro") return;
  std::vector<double> values;
  for (const CsvRow& row : preview) {
    if (row[M::kPressure] && *row[M::kPressure] > 0.0) values.push_back(*row[M::kPressure]);
  }
  if (values.empty()) return;
  const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
  const double change = *greatest - *least, typical = Median(std::move(values));
  if (change > kMaxChange * typical) return;
  for (const auto& [pascals, unit] : {std::pair{100.0, "hPa"}, {1000.0, "kPa"}, {3386.389, "inHg"}}) {
    if (typical > 40'000.0 / pascals && typical < 120'000.0 / pascals)
      return Rescale(columns, preview, {M::kPressure, M::kPressure}, pascals, unit);
  }
}

}  // namespace skyquilt::flight
