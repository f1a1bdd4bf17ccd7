#include "core/flight/metadata/exif.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <string_view>
#include <utility>

#include "core/flight/bytes/text_fields.h"
#include "core/flight/bytes/written_time.h"

namespace skyquilt::flight {
namespace {

namespace tag {
constexpr std::uint16_t kMake = 0x010F, kModel = 0x0110, kOrientation = 0x0112, kSoftware = 0x0131;
constexpr std::uint16_t kDateTime = 0x0132, kExposureTime = 0x829A, kFNumber = 0x829D, kIso = 0x8827;
constexpr std::uint16_t kIsoSpeed = 0x8833;
constexpr std::uint16_t kDateTimeOriginal = 0x9003, kDateTimeDigitized = 0x9004, kOffsetTime = 0x9010,
                        kOffsetTimeOriginal = 0x9011;
constexpr std::uint16_t kOffsetTimeDigitized = 0x9012, kFocalLength = 0x920A, kSubSecTime = 0x9290;
constexpr std::uint16_t kSubSecTimeOriginal = 0x9291, kSubSecTimeDigitized = 0x9292, kPixelWidth = 0xA002;
constexpr std::uint16_t kFocalPlaneX = 0xA20E, kFocalPlaneY = 0xA20F;
constexpr std::uint16_t kFocalPlaneUnit = 0xA210, kDigitalZoom = 0xA404, kFocalLength35 = 0xA405;
constexpr std::uint16_t kBodySerialNumber = 0xA431;
constexpr std::uint16_t kLatitudeRef = 1, kLatitude = 2, kLongitudeRef = 3, kLongitude = 4, kAltitudeRef = 5;
constexpr std::uint16_t kAltitude = 6, kTimeStamp = 7, kStatus = 9, kDirectionRef = 0x10, kDirection = 0x11;
constexpr std::uint16_t kMapDatum = 0x12, kDateStamp = 0x1D, kPositioningError = 0x1F;
}  // namespace tag

constexpr double kMetresPerDegree = 111320.0;  // of latitude, roughly: for how fine a number is written

std::optional<double> Within(std::optional<double> value, double low, double high) {
  if (!value || !(*value >= low) || !(*value <= high)) return std::nullopt;
  return value;
}

struct Angle {
  double degrees = 0.0;
  double step_deg = 0.0;
  bool is_written_twice = false;  // the decimals of a part, and as the parts behind it
  bool is_contradictory = false;  // other parts behind decimals than these say
};

// Degrees with decimals and minutes behind them, or minutes and seconds, from the smaller to the larger: what
// both say the same counts once.
void JudgeDecimals(std::array<double, 3>& parts, Angle& angle) {
  constexpr double kWhole = 1e-6;     // of what floating point leaves of a whole number
  constexpr double kRepeated = 0.06;  // of 60: decimals to a thousandth
  for (const std::size_t i : {std::size_t{1}, std::size_t{0}}) {
    const double behind = parts[i + 1] + (i == 0 ? parts[2] / 60.0 : 0.0);
    const double decimals = parts[i] - std::floor(parts[i]);
    if (behind == 0.0 || std::abs(parts[i] - std::round(parts[i])) < kWhole) continue;
    if (std::abs(60.0 * decimals - behind) > kRepeated) angle.is_contradictory = true;
    angle.is_written_twice = true;
    parts[i] = std::floor(parts[i]);
  }
}

// Degrees, minutes, seconds; a fraction of 0/0 behind a part that has decimals counts as zero.
std::optional<Angle> ReadAngle(const ExifValue* value) {
  if (value == nullptr) return std::nullopt;
  constexpr double kUnit[3] = {1.0, 1.0 / 60.0, 1.0 / 3600.0};
  Angle angle;
  std::array<double, 3> parts{};
  bool is_negative = false;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto fraction = value->Rational(i);
    auto number = value->Number(i);
    if (!number) {
      const bool is_written_by_decimals = i > 0 && angle.step_deg < kUnit[i - 1];
      const bool is_empty = !fraction || fraction->numerator == 0.0;
      if (i > 0 && is_written_by_decimals && is_empty) break;
      return std::nullopt;
    }
    if (*number < 0.0) is_negative = true;
    parts[i] = std::abs(*number);
    const double step_deg = fraction ? kUnit[i] / std::max(1.0, std::abs(fraction->denominator)) : 0.0;
    angle.step_deg =
        i == 0 ? step_deg : std::min(angle.step_deg, step_deg);  // decimals may stand before zeros
  }
  // More than the whole of a part before it: another unit, or a point that was lost.
  constexpr double kWhole = 60.0;
  if ((parts[0] > 0.0 && parts[1] > kWhole) || (parts[0] + parts[1] > 0.0 && parts[2] > kWhole))
    return std::nullopt;
  JudgeDecimals(parts, angle);
  for (std::size_t i = 0; i < 3; ++i) angle.degrees += parts[i] * kUnit[i];
  if (is_negative) angle.degrees = -angle.degrees;
  return angle;
}

// +1 or -1 by the first letter in any case, whatever follows ("N", "n", "North"); 0 when it says nothing.
int HemisphereSign(const std::string& reference, char positive, char negative) {
  if (reference.empty()) return 0;
  const char letter = static_cast<char>(std::toupper(static_cast<unsigned char>(reference[0])));
  return letter == positive ? 1 : (letter == negative ? -1 : 0);
}

// Datums that may lie further from WGS 84 than receivers err, as EXIF's specification and makers write them.
bool LiesBesideWgs84(const std::string& datum) {
  std::string name;
  for (const char c : datum) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0) name += static_cast<char>(std::toupper(byte));
  }
  return StartsWithOneOf(name, {"TOKYO", "NAD27", "ED50", "OSGB36", "GCJ02"});
}

void ReadPosition(const ExifTable& table, ExifRecord& record) {
  const auto latitude = ReadAngle(table.Find(ExifIfd::kGps, tag::kLatitude));
  const auto longitude = ReadAngle(table.Find(ExifIfd::kGps, tag::kLongitude));
  if (!latitude || !longitude) {
    if (table.Find(ExifIfd::kGps, tag::kLatitude)) record.notes.push_back(RemarkCode::kPositionUnread);
    return;
  }
  if (latitude->is_contradictory || longitude->is_contradictory) {
    record.notes.push_back(RemarkCode::kPositionContradictory);
    return;
  }
  if (latitude->is_written_twice || longitude->is_written_twice)
    record.notes.push_back(RemarkCode::kPositionWrittenTwice);
  const int north = HemisphereSign(table.Text(ExifIfd::kGps, tag::kLatitudeRef), 'N', 'S');
  const int east = HemisphereSign(table.Text(ExifIfd::kGps, tag::kLongitudeRef), 'E', 'W');
  const bool is_signed = latitude->degrees < 0.0 || longitude->degrees < 0.0;
  const auto with_sign = [](double degrees, int sign) {
    return sign == 0 ? degrees : sign * std::abs(degrees);
  };
  const double lat_deg = with_sign(latitude->degrees, north);
  const double lon_deg = with_sign(longitude->degrees, east);
  if (std::abs(lat_deg) < 1e-6 && std::abs(lon_deg) < 1e-6) {
    record.notes.push_back(RemarkCode::kPositionZero);
    return;
  }
  const auto position = geo::LatLon::Make(lat_deg, lon_deg);
  if (!position) {
    record.notes.push_back({RemarkCode::kPositionNotOnEarth, {{"lat_deg", lat_deg}, {"lon_deg", lon_deg}}});
    return;
  }
  record.position = *position;
  record.is_hemisphere_known = (north != 0 && east != 0) || is_signed;
  record.position_resolution_m = kMetresPerDegree * std::max(latitude->step_deg, longitude->step_deg);
  if (table.Text(ExifIfd::kGps, tag::kStatus) == "V") {
    record.notes.push_back(RemarkCode::kPositionNotValid);
  }
  std::string datum = table.Text(ExifIfd::kGps, tag::kMapDatum);
  record.is_beside_wgs84 = LiesBesideWgs84(datum);
  if (record.is_beside_wgs84)
    record.notes.push_back({RemarkCode::kPositionOfOtherDatum, {{"datum", std::move(datum)}}});
}

// 0 to 3; some programs write the character of the figure, as text or where a number is due.
std::optional<int> AltitudeReference(const ExifTable& table) {
  const ExifValue* value = table.Find(ExifIfd::kGps, tag::kAltitudeRef);
  if (value == nullptr || value->bytes.empty()) return std::nullopt;
  constexpr double kCharacterOfZero = '0';
  const double written = value->Number().value_or(static_cast<double>(value->bytes.front()));
  const auto figure = Within(written >= kCharacterOfZero ? written - kCharacterOfZero : written, 0.0, 3.0);
  if (!figure) return std::nullopt;
  return static_cast<int>(*figure);
}

void ReadAltitude(const ExifTable& table, ExifRecord& record) {
  auto altitude = table.Number(ExifIfd::kGps, tag::kAltitude);
  if (!altitude) return;
  const int reference = AltitudeReference(table).value_or(0);
  if (reference == 1 || reference == 3) altitude = -std::abs(*altitude);
  record.is_altitude_from_sea = reference == 2 || reference == 3;
  constexpr double kLowest = -500.0, kHighest = 10000.0;
  record.altitude_m = Within(altitude, kLowest, kHighest);
  if (!record.altitude_m) {
    record.notes.push_back({RemarkCode::kAltitudeImpossible, {{"altitude_m", *altitude}}});
  }
}

// Where the device looked, by its compass.
void ReadDirection(const ExifTable& table, ExifRecord& record) {
  const auto direction_deg = table.Number(ExifIfd::kGps, tag::kDirection);
  if (!direction_deg || !(*direction_deg >= 0.0) || !(*direction_deg < 360.0)) return;
  record.image_direction_deg = direction_deg;
  record.is_direction_from_true_north = table.Text(ExifIfd::kGps, tag::kDirectionRef) == "T";
}

double FocalPlaneUnitMm(const ExifTable& table) {
  const double unit = table.Number(ExifIfd::kExif, tag::kFocalPlaneUnit).value_or(2.0);
  return unit == 3.0 ? 10.0 : unit == 4.0 ? 1.0 : unit == 5.0 ? 0.001 : 25.4;
}

std::optional<double> PixelsPerMm(const ExifTable& table, std::uint16_t resolution_tag) {
  const auto resolution = table.Number(ExifIfd::kExif, resolution_tag);
  if (!resolution || *resolution <= 0.0) return std::nullopt;
  // Pixels of 0.5 to 100 micrometres exist.
  return Within(*resolution / FocalPlaneUnitMm(table), 10.0, 2000.0);
}

std::optional<double> SideMm(const ExifTable& table, std::uint16_t resolution_tag) {
  const auto side = table.Number(ExifIfd::kExif, resolution_tag);
  if (!side) return std::nullopt;
  return Within(*side * FocalPlaneUnitMm(table), 1.0, 100.0);
}

// In millimetres, of a lens that exists; the same as of a picture of 36 mm by 24.
std::optional<double> OfLens(std::optional<double> mm) { return Within(mm, 0.5, 2000.0); }
std::optional<double> OfFullFrame(std::optional<double> mm) { return Within(mm, 5.0, 5000.0); }

std::optional<std::chrono::minutes> ParseZone(const std::string& text) {
  if (text == "Z" || text == "z") return std::chrono::minutes(0);
  int hours = 0, minutes = 0;
  char sign = 0;
  if (std::sscanf(text.c_str(), "%c%2d:%2d", &sign, &hours, &minutes) != 3) return std::nullopt;
  if ((sign != '+' && sign != '-') || hours < 0 || hours > 14 || minutes < 0 || minutes > 59)
    return std::nullopt;
  const std::chrono::minutes offset(hours * 60 + minutes);
  return sign == '-' ? -offset : offset;
}

// "05" is 0.05 s: the digits behind the point; MicaSense writes "-05" too: before the second.
std::chrono::microseconds ReadSubSeconds(std::string_view text) {
  const bool is_before = text.starts_with('-');
  if (is_before) text.remove_prefix(1);
  std::int64_t micros = 0;
  std::int64_t unit = is_before ? -100000 : 100000;
  for (const char c : text) {
    if (c < '0' || c > '9' || unit == 0) break;
    micros += (c - '0') * unit;
    unit /= 10;
  }
  return std::chrono::microseconds(micros);
}

// Some cameras write the day of their own clock beside the hours of UTC. It shows where the two make a zone
// in which nobody lives, but on a few islands.
UtcTime OnDayOfReceiver(UtcTime time, UtcTime clock) {
  constexpr double kHourS = 3600.0, kQuarterS = 900.0, kApartS = 5.0;
  constexpr double kWesternmostS = -11.0 * kHourS, kEasternmostS = 13.0 * kHourS;
  constexpr std::chrono::hours kDay(24);
  const bool is_one_day =
      std::chrono::floor<std::chrono::days>(time) == std::chrono::floor<std::chrono::days>(clock);
  const double ahead_s = SecondsBetween(time, clock);
  const double zone_s = kQuarterS * std::round(ahead_s / kQuarterS);
  if (!is_one_day || std::abs(ahead_s - zone_s) > kApartS) return time;
  if (zone_s > kEasternmostS) return time + kDay;
  return zone_s < kWesternmostS ? time - kDay : time;
}

void ReadClock(const ExifTable& table, ExifRecord& record) {
  struct Source {
    ExifIfd ifd;
    std::uint16_t time, sub_seconds, zone;
  };
  constexpr Source kSources[] = {
      {ExifIfd::kExif, tag::kDateTimeOriginal, tag::kSubSecTimeOriginal, tag::kOffsetTimeOriginal},
      {ExifIfd::kExif, tag::kDateTimeDigitized, tag::kSubSecTimeDigitized, tag::kOffsetTimeDigitized},
      {ExifIfd::kImage, tag::kDateTimeOriginal, tag::kSubSecTimeOriginal, tag::kOffsetTimeOriginal},
      {ExifIfd::kImage, tag::kDateTime, tag::kSubSecTime, tag::kOffsetTime}};
  for (const Source& source : kSources) {
    const std::string own_time = table.Text(source.ifd, source.time);
    const auto time = ParseExifTime(own_time);
    if (!time) continue;
    const std::string file_time = table.Text(ExifIfd::kImage, tag::kDateTime);
    std::string sub_seconds = table.Text(ExifIfd::kExif, source.sub_seconds);
    // The same second as of the file's own time, whose fraction alone MicaSense's cameras write.
    if (sub_seconds.empty() && file_time == own_time)
      sub_seconds = table.Text(ExifIfd::kExif, tag::kSubSecTime);
    record.taken_at = time->as_written + ReadSubSeconds(sub_seconds);
    record.clock_minus_utc = ParseZone(table.Text(ExifIfd::kExif, source.zone));
    // Of a file that was changed later it is the zone in which that was done.
    if (!record.clock_minus_utc && (file_time.empty() || file_time == own_time))
      record.clock_minus_utc = ParseZone(table.Text(ExifIfd::kExif, tag::kOffsetTime));
    break;
  }
  const std::string date = table.Text(ExifIfd::kGps, tag::kDateStamp);
  const auto hours = Within(table.Number(ExifIfd::kGps, tag::kTimeStamp, 0), 0.0, 23.0);
  const auto minutes = Within(table.Number(ExifIfd::kGps, tag::kTimeStamp, 1), 0.0, 59.0);
  const auto seconds = Within(table.Number(ExifIfd::kGps, tag::kTimeStamp, 2), 0.0, 60.999999);
  if (!hours || !minutes || !seconds) return;
  const std::chrono::microseconds of_day(std::llround((*hours * 3600.0 + *minutes * 60.0 + *seconds) * 1e6));
  if (date.empty()) {
    if (of_day.count() > 0) record.gps_time_of_day = of_day;  // zeros stand there without a fix
    return;
  }
  const auto day = ParseExifTime(date + " 00:00:00");
  // Without a fix a receiver counts from where its clock (1980) or its weeks (1999) begin.
  constexpr std::chrono::sys_days kFirstFix = std::chrono::year(2000) / 1 / 1;
  if (!day) return;
  // Receivers count 1024 weeks and begin anew: the camera's clock, of whatever zone, tells which they mean.
  constexpr std::chrono::days kWeeksCounted(1024 * 7);
  constexpr std::chrono::hours kWidestZone(15);
  // Some (Workswell's Wiris) repeat the time behind the day.
  UtcTime time = std::chrono::floor<std::chrono::days>(day->as_written) + of_day;
  if (record.taken_at && std::chrono::abs(*record.taken_at - (time + kWeeksCounted)) <= kWidestZone)
    time += kWeeksCounted;
  if (time < kFirstFix) return;
  record.gps_time = record.taken_at ? OnDayOfReceiver(time, *record.taken_at) : time;
}

}  // namespace

std::optional<ExifTime> ParseExifTime(const std::string& text) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0, used = 0;
  if (std::sscanf(text.c_str(), "%4d%*1[:/-]%2d%*1[:/-]%2d%*1[ T]%2d:%2d:%2d%n", &year, &month, &day, &hour,
                  &minute, &second, &used) != 6 ||
      used == 0) {
    return std::nullopt;
  }
  const auto as_written = UtcFromCivil(year, month, day, hour, minute, second);
  if (!as_written || year < 1980 || hour > 23) return std::nullopt;
  ExifTime time;
  time.as_written = *as_written;
  std::size_t at = static_cast<std::size_t>(used);
  if (at < text.size() && (text[at] == '.' || text[at] == ',')) {
    const std::size_t begin = ++at;
    while (at < text.size() && std::isdigit(static_cast<unsigned char>(text[at]))) ++at;
    time.as_written += ReadSubSeconds(text.substr(begin, at - begin));
  }
  if (at < text.size()) time.clock_minus_utc = ParseZone(text.substr(at));
  return time;
}

std::optional<double> ExposureTimeS(const ExifTable& table) {
  return Within(table.Number(ExifIfd::kExif, tag::kExposureTime), 1e-7, 60.0);
}

std::optional<double> IsoOf(const ExifTable& table) {
  // MicaSense's cameras write their gain as the speed alone.
  for (const std::uint16_t written : {tag::kIsoSpeed, tag::kIso}) {
    if (const auto iso = Within(table.Number(ExifIfd::kExif, written), 1.0, 1e7)) return iso;
  }
  return std::nullopt;
}

ExifRecord InterpretExif(const ExifTable& table) {
  ExifRecord record;
  record.make = table.Text(ExifIfd::kImage, tag::kMake);
  record.model = table.Text(ExifIfd::kImage, tag::kModel);
  record.software = table.Text(ExifIfd::kImage, tag::kSoftware);
  record.serial_number = table.Text(ExifIfd::kExif, tag::kBodySerialNumber);
  if (const auto value = Within(table.Number(ExifIfd::kImage, tag::kOrientation), 1.0, 8.0)) {
    record.orientation = static_cast<int>(*value);
  }
  record.exposure_time_s = ExposureTimeS(table);
  record.iso = IsoOf(table);
  record.f_number = Within(table.Number(ExifIfd::kExif, tag::kFNumber), 0.3, 200.0);
  record.focal_length_mm = OfLens(table.Number(ExifIfd::kExif, tag::kFocalLength));
  record.focal_length_35mm_mm = OfFullFrame(table.Number(ExifIfd::kExif, tag::kFocalLength35));
  record.focal_plane_x_px_per_mm = PixelsPerMm(table, tag::kFocalPlaneX);
  record.focal_plane_y_px_per_mm = PixelsPerMm(table, tag::kFocalPlaneY);
  record.focal_plane_x_mm = SideMm(table, tag::kFocalPlaneX);
  record.focal_plane_y_mm = SideMm(table, tag::kFocalPlaneY);
  constexpr double kMaxSide = 100000.0;
  if (const auto value = Within(table.Number(ExifIfd::kExif, tag::kPixelWidth), 1.0, kMaxSide)) {
    record.recorded_width_px = static_cast<int>(*value);
  }
  record.digital_zoom = Within(table.Number(ExifIfd::kExif, tag::kDigitalZoom), 1.0, 100.0).value_or(1.0);
  record.position_error_m = Within(table.Number(ExifIfd::kGps, tag::kPositioningError), 1e-4, 10000.0);
  ReadPosition(table, record);
  ReadAltitude(table, record);
  ReadDirection(table, record);
  ReadClock(table, record);
  return record;
}

void FillFromXmp(const XmpTags& xmp, ExifRecord& record) {
  // The EXIF of Autel's XL715 calls its maker "Camera".
  if (const std::string make = xmp.Text("tiff:Make");
      !make.empty() && (record.make.empty() || record.make == "Camera"))
    record.make = make;
  if (record.model.empty()) record.model = xmp.Text("tiff:Model");
  if (!record.focal_length_mm) record.focal_length_mm = OfLens(xmp.Number("exif:FocalLength"));
  if (!record.focal_length_35mm_mm)
    record.focal_length_35mm_mm = OfFullFrame(xmp.Number("exif:FocalLengthIn35mmFilm"));
}

}  // namespace skyquilt::flight
