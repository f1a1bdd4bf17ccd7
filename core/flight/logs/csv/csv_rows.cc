#include "core/flight/logs/csv/csv_rows.h"

#include <algorithm>
#include <cmath>

#include "core/flight/logs/coordinate_cell.h"

namespace skyquilt::flight {
namespace {

using M = CsvMeaning;

bool IsRtkFixed(std::string_view fix) {
  const std::string lower = LowerCase(fix);
  if (const auto number = ParseNumber(lower)) return *number == 6.0;  // as MAVLink, PX4 and ArduPilot count
  return lower.find("fixed") != std::string::npos;
}

// "46.842.607": a spreadsheet took the point for one of thousands, and where it stood is lost. As whole
// numbers of 1e-7 degrees they would be places elsewhere.
bool HasLostItsPoint(std::string_view cell, double degrees) {
  constexpr double kHalfTurnDeg = 180.0;
  const auto points = std::count(cell.begin(), cell.end(), '.');
  const auto commas = std::count(cell.begin(), cell.end(), ',');
  return std::abs(degrees) > kHalfTurnDeg && ((points > 1 && commas == 0) || (commas > 1 && points == 0));
}

// Degrees, nothing where a letter behind or before them is none of `letters`.
std::optional<double> ReadDegrees(std::string_view cell, std::string_view letters) {
  const auto read = ReadCoordinateCell(cell);
  if (read && HasLostItsPoint(cell, read->value)) return std::nullopt;
  const bool fits =
      read && (read->hemisphere == 0 || letters.find(read->hemisphere) != std::string_view::npos);
  return fits ? std::optional(read->value) : std::nullopt;
}

// 'N' of "N", "north" and "Nord"; 0 for what names no hemisphere.
char LetterOf(std::string_view cell) {
  std::string angle("1 ");
  const auto read = ReadCoordinateCell(angle.append(cell.substr(0, 16)));
  return read ? read->hemisphere : '\0';
}

// A column of letters beside it makes an angle without a sign negative; beside "-46" it says the same again.
void TurnByLetter(char letter, char negative, std::optional<double>& angle_deg) {
  if (letter == 0 || !angle_deg) return;
  if (letter == negative)
    angle_deg = -std::abs(*angle_deg);
  else if (*angle_deg < 0.0)
    angle_deg.reset();
}

// "1", "true" or nothing of the kind: then it is the photo's name.
void TakePhotoCell(std::string_view cell, CsvRow& row) {
  const std::string lower = LowerCase(cell);
  std::optional<double> flag = ParseNumber(cell);
  if (lower == "true" || lower == "yes") flag = 1.0;
  if (lower == "false" || lower == "no" || IsEmptyCell(cell)) flag = 0.0;
  if (flag) {
    row.number[static_cast<std::size_t>(M::kIsPhoto)] = *flag;
  } else if (row.image.empty()) {
    row.image = cell;
  }
}

// Omega-phi-kappa turns the photogrammetric camera (x right, y up, z back) into east, north, up. The body
// whose camera looks down has x = camera y, y = camera x, z = -camera z.
Eigen::Vector3d YawPitchRollFromOpk(double omega_rad, double phi_rad, double kappa_rad) {
  const Eigen::Matrix3d enu_from_camera = (Eigen::AngleAxisd(omega_rad, Eigen::Vector3d::UnitX()) *
                                           Eigen::AngleAxisd(phi_rad, Eigen::Vector3d::UnitY()) *
                                           Eigen::AngleAxisd(kappa_rad, Eigen::Vector3d::UnitZ()))
                                              .toRotationMatrix();
  Eigen::Matrix3d swap;
  swap << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  return YawPitchRollFromNed(Eigen::Quaterniond(Eigen::Matrix3d(swap * enu_from_camera * swap)));
}

// The two coordinates of a row as its cells give them.
std::optional<WrittenPlace> WrittenPlaceOf(const CsvRow& row) {
  const bool in_degrees = row[M::kLat] && row[M::kLon];
  const auto x = in_degrees ? row[M::kLon] : row[M::kEast];
  const auto y = in_degrees ? row[M::kLat] : row[M::kNorth];
  if (!x || !y || !std::isfinite(*x) || !std::isfinite(*y)) return std::nullopt;
  return WrittenPlace{*x, *y};
}

}  // namespace

bool CsvRow::Has(CsvMeaning first, CsvMeaning last) const {
  for (auto i = static_cast<std::size_t>(first); i <= static_cast<std::size_t>(last); ++i) {
    if (!number[i]) return false;
  }
  return true;
}

std::optional<double> ReadCsvNumber(const CsvColumn& column, std::string_view cell) {
  if (column.meaning == M::kLat || column.meaning == M::kLon) {
    const auto degrees = ReadDegrees(cell, column.meaning == M::kLat ? "NS" : "EW");
    return degrees ? std::optional(*degrees * column.scale) : std::nullopt;
  }
  if (column.is_elapsed_text) return ParseElapsed(cell);
  const auto number = ReadNumber(cell, column.mark);
  const bool is_plane = column.meaning == M::kEast || column.meaning == M::kNorth;
  if (is_plane && (!number || !number->unit.empty())) {  // degrees, by their signs
    if (const auto degrees = ReadDegrees(cell, column.meaning == M::kNorth ? "NS" : "EW")) return degrees;
  }
  if (!number) return std::nullopt;
  if (number->unit.empty()) return number->value * column.scale;
  const auto factor = FactorOfUnitBehind(number->unit, CsvMeaningDimension(column.meaning));
  return factor ? std::optional(number->value * *factor) : std::nullopt;
}

CsvRow ReadCsvRow(const std::vector<CsvColumn>& columns, const std::vector<std::string_view>& cells,
                  UnreadCells* unread, std::size_t line) {
  CsvRow row;
  std::string_view date, time_of_day;
  std::array<char, 2> letters{};  // of latitude and longitude
  DateOrder date_order = DateOrder::kYearFirst;
  bool counts_gps = false;
  const std::size_t count = std::min(columns.size(), cells.size());
  for (std::size_t i = 0; i < count; ++i) {
    const CsvColumn& column = columns[i];
    if (column.meaning == M::kIgnored || cells[i].empty()) continue;
    bool is_read = true;
    const bool is_date = IsOfClock(column.meaning);
    counts_gps = counts_gps || (is_date && column.counts_gps);
    switch (column.meaning) {
      case M::kUtc:
        row.written = ParseWrittenTime(cells[i], column.date_order);
        is_read = row.written.has_value();
        break;
      case M::kDate:
        date = cells[i];
        date_order = column.date_order;
        is_read = ParseDate(date, date_order).has_value();
        break;
      case M::kTimeOfDay:
        time_of_day = cells[i];
        is_read = IsTimeOfDay(time_of_day);
        break;
      case M::kLatLetter:
      case M::kLonLetter: {
        const bool is_lat = column.meaning == M::kLatLetter;
        const char letter = LetterOf(cells[i]);
        is_read = std::string_view(is_lat ? "NS" : "EW").find(letter) != std::string_view::npos;
        if (is_read) letters[is_lat ? 0 : 1] = letter;
        break;
      }
      case M::kEvent:
        if (!IsEmptyCell(cells[i])) row.event = cells[i];
        break;
      case M::kImage:
        if (!IsEmptyCell(cells[i])) row.image = cells[i];
        break;
      case M::kFix:
        row.fix = cells[i];
        break;
      case M::kIsPhoto:
        TakePhotoCell(cells[i], row);
        break;
      default: {
        const auto value = ReadCsvNumber(column, cells[i]);
        row.number[static_cast<std::size_t>(column.meaning)] = value;
        is_read = value.has_value();
      }
    }
    if (unread != nullptr && (is_read || !IsEmptyCell(cells[i]))) unread->Count(i, is_read, line, cells[i]);
  }
  if (!row.written && !date.empty() && !time_of_day.empty())
    row.written = ParseWrittenTime(date, time_of_day, date_order);
  if (counts_gps && row.written && !row.written->names_zone)
    row.written->time = UtcFromGpsCalendar(row.written->time);
  TurnByLetter(letters[0], 'S', row.number[static_cast<std::size_t>(M::kLat)]);
  TurnByLetter(letters[1], 'W', row.number[static_cast<std::size_t>(M::kLon)]);
  return row;
}

void TakePose(const CsvRow& row, AttitudeKind kind, CameraEvent& event) {
  if (event.image_name) event.written = WrittenPlaceOf(row);
  event.height_ellipsoid_m = row[M::kHeightEllipsoid];
  event.height_amsl_m = row[M::kHeightAmsl];
  event.height_above_takeoff_m = row[M::kHeightAboveTakeoff];
  event.height_above_ground_m = row[M::kHeightAboveGround];
  if (row[M::kGimbalPitch] && row[M::kGimbalYaw]) {
    event.yaw_pitch_roll_rad =
        Eigen::Vector3d(*row[M::kGimbalYaw], *row[M::kGimbalPitch], row[M::kGimbalRoll].value_or(0.0));
    event.attitude_kind = AttitudeKind::kGimbal;
  } else if (row.Has(M::kRoll, M::kYaw)) {
    event.yaw_pitch_roll_rad = Eigen::Vector3d(*row[M::kYaw], *row[M::kPitch], *row[M::kRoll]);
    event.attitude_kind = kind;
  } else if (row.Has(M::kOmega, M::kKappa)) {
    event.yaw_pitch_roll_rad = YawPitchRollFromOpk(*row[M::kOmega], *row[M::kPhi], *row[M::kKappa]);
    event.attitude_kind = AttitudeKind::kAirframe;
    event.yaw_is_from_grid_north = true;
  }
}

std::optional<double> CsvSampler::PlaceInTime(const CsvRow& row) {
  const auto& written = row.written;
  if (rule_.has_time_column) {
    const auto t = row[M::kTime];
    if (!t) return std::nullopt;
    const double t_s = *t - rule_.first_time_s;
    if (written) {
      clock_.Add(t_s, written->time);
      clock_resolution_s_ = std::max(clock_resolution_s_, written->resolution_s);
      if (!first_utc_) first_utc_ = written->time;
      const double offset_s = SecondsBetween(*first_utc_, written->time) - t_s;
      newest_offset_s_ = std::max(newest_offset_s_, offset_s);
    }
    return t_s;
  }
  if (!written) return std::nullopt;
  if (!first_utc_) first_utc_ = written->time;
  clock_resolution_s_ = std::max(clock_resolution_s_, written->resolution_s);
  double t_s = SecondsBetween(*first_utc_, written->time);
  // Rows that share a tick of a coarse clock are spread over it.
  rows_in_tick_ = last_tick_s_ && *last_tick_s_ == t_s ? rows_in_tick_ + 1.0 : 0.0;
  last_tick_s_ = t_s;
  if (rule_.rows_per_tick > 1.2)
    t_s += written->resolution_s * std::min(rows_in_tick_ / rule_.rows_per_tick, 0.999);
  return t_s;
}

bool CsvSampler::Take(const CsvRow& row) {
  const auto t = PlaceInTime(row);
  if (!t) return false;
  const double t_s = *t;
  if (row.Has(M::kGyroX, M::kAccelZ)) {
    const double up = imu_z_is_up_ ? -1.0 : 1.0;
    builder_.Add(ImuSample{t_s,
                           {*row[M::kGyroX], up * *row[M::kGyroY], up * *row[M::kGyroZ]},
                           {*row[M::kAccelX], up * *row[M::kAccelY], up * *row[M::kAccelZ]}});
  }
  if (row.Has(M::kQw, M::kQz)) {
    const Eigen::Quaterniond ned_from_body(*row[M::kQw], *row[M::kQx], *row[M::kQy], *row[M::kQz]);
    if (std::abs(ned_from_body.norm() - 1.0) < 0.1) builder_.Add(AttitudeSample{t_s, ned_from_body});
  } else if (row[M::kRoll] && row[M::kPitch]) {
    builder_.Add(
        AttitudeSample{t_s, NedFromYawPitchRoll(row[M::kYaw].value_or(0.0), *row[M::kPitch], *row[M::kRoll]),
                       row[M::kYaw].has_value()});
  }
  if (row[M::kGimbalPitch] && row[M::kGimbalYaw]) {
    builder_.AddGimbal({t_s, NedFromYawPitchRoll(*row[M::kGimbalYaw], *row[M::kGimbalPitch],
                                                 row[M::kGimbalRoll].value_or(0.0))});
  }
  if (row[M::kLat] && row[M::kLon]) {
    GnssSample sample;
    sample.t_s = t_s;
    sample.position = {*row[M::kLat], *row[M::kLon]};
    sample.height_ellipsoid_m = row[M::kHeightEllipsoid];
    sample.height_amsl_m = row[M::kHeightAmsl];
    if (row.Has(M::kVelocityNorth, M::kVelocityDown)) {
      sample.velocity_in_ned_mps =
          Eigen::Vector3d(*row[M::kVelocityNorth], *row[M::kVelocityEast], *row[M::kVelocityDown]);
    }
    sample.sigma_horizontal_m = row[M::kSigmaHorizontal];
    sample.sigma_vertical_m = row[M::kSigmaVertical];
    sample.is_rtk_fixed = IsRtkFixed(row.fix);
    builder_.Add(sample);
  }
  if (baro_is_relative_) {
    if (const auto height = row[M::kHeightAboveTakeoff]) builder_.Add(BaroSample{t_s, *height});
  } else if (const auto height = row[M::kBaroHeight]) {
    builder_.Add(BaroSample{t_s, *height});
  } else if (const auto pressure = row[M::kPressure]; pressure && *pressure > 1000.0) {
    builder_.Add(BaroSample{t_s, StandardHeightM(*pressure)});
  }
  auto range = row[M::kRange];
  if (range && *range > 0.0) builder_.Add(RangeSample{t_s, *range});
  TakeEvent(row, t_s);
  return true;
}

void CsvSampler::TakeEvent(const CsvRow& row, double t_s) {
  const bool is_photo = row[M::kIsPhoto].value_or(0.0) != 0.0;
  const bool begins = is_photo && !was_photo_;
  was_photo_ = is_photo;
  if (row.event.empty() && row.image.empty() && !begins) return;
  CameraEvent event;
  event.t_s = t_s;
  if (!row.event.empty()) {
    event.sequence = ParseInteger(row.event);
    if (!event.sequence) event.image_name = std::string(row.event.substr(0, kMaxNameLength));
  }
  if (!row.image.empty()) {
    // A telemetry table that repeats the last photo's name in each row has one event a photo.
    if (row.image == last_image_) return;
    last_image_ = row.image;
    event.image_name = std::string(row.image.substr(0, kMaxNameLength));
  } else if (row.event.empty()) {
    event.sequence = ++photos_;
    event.is_feedback = false;  // the app's note of the command
  }
  if (row[M::kLat] && row[M::kLon]) event.position = geo::LatLon{*row[M::kLat], *row[M::kLon]};
  TakePose(row, event.attitude_kind, event);
  builder_.Add(std::move(event));
}

SampledRows SampleRows(const std::vector<CsvColumn>& columns, char separator, LineReader& lines,
                       const ConsumedUpTo& consumed, CsvSampler& sampler) {
  SampledRows sampled;
  ConsumedSteps steps(consumed);
  std::string_view line;
  std::vector<std::string_view> cells;
  while (NextFilledLine(lines, steps, line)) {
    if (line.front() == '#') continue;
    SplitFields(line, separator, cells);
    const bool has_time = sampler.Take(ReadCsvRow(columns, cells, &sampled.unread, lines.line_number()));
    ++(has_time ? sampled.rows : sampled.without_time);
  }
  return sampled;
}

void SampledRows::Tell(const std::vector<CsvColumn>& columns, LogBuilder& builder) const {
  unread.Tell(columns, builder);
  if (without_time > 0) builder.Warn({RemarkCode::kRowsWithoutTime, {{"rows", without_time}}});
}

void CsvSampler::Finish(const std::vector<CsvColumn>& columns, const SampledRows& sampled) {
  if (!baro_is_relative_) builder_.BaroStartsAtZero();
  builder_.Count("row", sampled.rows);
  builder_.log().mapping = DescribeColumns(columns);
  builder_.log().written_order_is_named = true;
  if (rule_.has_time_column) builder_.log().counter_at_zero_s = rule_.first_time_s;
  std::optional<UtcTime> zero;
  double sigma_s = 0.0;
  if (!rule_.has_time_column) {
    zero = first_utc_;
    sigma_s = rule_.rows_per_tick > 1.2 ? clock_resolution_s_ / rule_.rows_per_tick : clock_resolution_s_;
  } else if (rule_.time_is_unix) {
    zero = LaterBy(UtcTime(), rule_.first_time_s);
    sigma_s = 0.1;
  } else if (const auto fit = clock_.Solve()) {
    zero = fit->utc_at_zero;
    sigma_s = std::hypot(clock_resolution_s_, fit->scatter_s);
    newest_offset_s_ = std::clamp(newest_offset_s_, -1e9, 1e9);
    // A stamp cut to whole seconds is never late: of the newest against the fine clock least is cut off.
    const UtcTime newest = LaterBy(*first_utc_, newest_offset_s_);
    const double gain_s = SecondsBetween(fit->utc_at_zero, newest);
    if (gain_s >= 0.0 && gain_s <= clock_resolution_s_) {
      zero = newest;
      sigma_s = 0.1 * clock_resolution_s_ + 0.05;
    }
  }
  if (!zero) return;
  builder_.log().utc_sigma_s = sigma_s;
  if (rule_.utc_is_utc || rule_.time_is_unix) {
    builder_.log().utc_at_zero = zero;
  } else {
    builder_.log().local_at_zero = zero;
    builder_.Warn(RemarkCode::kDatesOfNoZone);
  }
}

}  // namespace skyquilt::flight
