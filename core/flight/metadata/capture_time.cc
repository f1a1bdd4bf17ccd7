#include "core/flight/metadata/capture_time.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <utility>

#include "core/flight/bytes/gps_time.h"
#include "core/flight/bytes/text_fields.h"

namespace skyquilt::flight {
namespace {

constexpr std::int64_t kMicrosPerSecond = 1000000;
constexpr std::chrono::seconds kClocksAgreeWithin(5);  // of two clocks, but for their zones
constexpr std::chrono::minutes kSetByHandWithin(5);

UtcTime InUtc(const ExifTime& time) {
  return time.clock_minus_utc ? UtcTime(time.as_written - *time.clock_minus_utc) : time.as_written;
}

// Zones are quarters of an hour; what is left over is the error of one of the clocks.
struct ClockStep {
  std::chrono::minutes zone;
  std::chrono::microseconds left_over;
};

std::optional<ClockStep> StepBetween(UtcTime clock, UtcTime utc) {
  constexpr std::int64_t kQuarter = 900 * kMicrosPerSecond;
  constexpr std::int64_t kWidestZone = std::int64_t{15} * 3600 * kMicrosPerSecond;
  const std::int64_t ahead = (clock - utc).count();
  if (std::abs(ahead) > kWidestZone) return std::nullopt;
  const auto quarters = static_cast<std::int64_t>(std::llround(static_cast<double>(ahead) / kQuarter));
  return ClockStep{std::chrono::minutes(15 * quarters),
                   std::chrono::microseconds(ahead - quarters * kQuarter)};
}

// The zone of the camera's clock beside a UTC that another clock told. A clock that is set by hand is off by
// minutes; one that is off by more shows no zone.
std::optional<std::chrono::minutes> ZoneOf(const ExifRecord& exif, UtcTime utc) {
  if (exif.clock_minus_utc) return exif.clock_minus_utc;
  if (!exif.taken_at) return std::nullopt;
  const std::optional<ClockStep> step = StepBetween(*exif.taken_at, utc);
  if (!step || std::chrono::abs(step->left_over) > kSetByHandWithin) return std::nullopt;
  return step->zone;
}

// The time of exposure as the receiver counts it.
std::optional<UtcTime> UtcInXmp(const XmpTags& xmp) {
  for (const std::string_view name : {"drone-dji:UTCAtExposure", "sensefly:UTCTime"}) {
    if (const auto time = ParseExifTime(xmp.Text(name))) return InUtc(*time);
  }
  return std::nullopt;
}

// On the day on which the clock is at most so far ahead of it, and less than a day less.
UtcTime OnDayOf(UtcTime clock, std::chrono::microseconds time_of_day, std::chrono::seconds most_ahead) {
  using namespace std::chrono_literals;
  UtcTime time = UtcTime(std::chrono::floor<std::chrono::days>(clock)) + time_of_day;
  while (clock - time > most_ahead) time += 24h;
  while (clock - time <= most_ahead - 24h) time -= 24h;
  return time;
}

// Where EXIF names no day for it, that on which a clock whose zone is written shows it too; of a clock of
// unknown zone the flight tells it (TakeZoneOfFlight).
std::optional<UtcTime> GpsTimeOf(const ExifRecord& exif) {
  if (exif.gps_time || !exif.gps_time_of_day || !exif.taken_at || !exif.clock_minus_utc) return exif.gps_time;
  const UtcTime clock = *exif.taken_at - *exif.clock_minus_utc;
  const UtcTime time = OnDayOf(clock, *exif.gps_time_of_day, std::chrono::hours(12));
  if (std::chrono::abs(clock - time) > kClocksAgreeWithin) return std::nullopt;
  return time;
}

struct ClockTime {
  std::optional<UtcTime> at;
  bool is_local = false;
  std::optional<std::chrono::minutes> clock_minus_utc;  // a time zone's; absent where nothing tells it
};

ClockTime TimeOfClocks(const ExifRecord& exif, const std::optional<UtcTime>& gps_time, const XmpTags& xmp,
                       std::vector<Remark>& notes) {
  if (const auto utc = UtcInXmp(xmp)) return {utc, false, ZoneOf(exif, *utc)};
  if (exif.taken_at && exif.clock_minus_utc) {
    return {UtcTime(*exif.taken_at - *exif.clock_minus_utc), false, exif.clock_minus_utc};
  }
  if (exif.taken_at && gps_time) {
    const std::optional<ClockStep> step = StepBetween(*exif.taken_at, *gps_time);
    if (step && std::chrono::abs(step->left_over) <= kClocksAgreeWithin) {
      return {UtcTime(*exif.taken_at - step->zone), false, step->zone};
    }
    notes.push_back(RemarkCode::kClocksDisagree);
    return {gps_time, false, std::nullopt};
  }
  if (gps_time) return {gps_time, false, std::nullopt};
  if (exif.taken_at) return {exif.taken_at, true, std::nullopt};
  for (const std::string_view name : {"exif:DateTimeOriginal", "xmp:CreateDate"}) {
    if (const auto time = ParseExifTime(xmp.Text(name))) {
      return {InUtc(*time), !time->clock_minus_utc, time->clock_minus_utc};
    }
  }
  return {};
}

}  // namespace

void TakeCaptureTime(const ExifRecord& exif, const XmpTags& xmp, Photo& photo) {
  const std::optional<UtcTime> gps_time = GpsTimeOf(exif);
  const ClockTime time = TimeOfClocks(exif, gps_time, xmp, photo.notes);
  photo.captured_at = time.at;
  photo.captured_at_is_local = time.is_local;
  photo.clock_minus_utc = time.clock_minus_utc;
  photo.receiver_time = UtcInXmp(xmp);
  if (!photo.receiver_time) photo.receiver_time = gps_time;
  if (exif.taken_at && time.is_local) photo.receiver_time_of_day = exif.gps_time_of_day;
}

void TakeZoneOfFlight(std::vector<Photo>& photos) {
  using namespace std::chrono_literals;
  constexpr std::chrono::seconds kMaxAhead = 13h + 450s;
  struct TwoClocks {
    Photo* photo = nullptr;
    UtcTime by_receiver;
    ClockStep step;
  };
  std::vector<TwoClocks> told;
  std::map<std::chrono::minutes, std::size_t> shown;  // by how many photos
  for (Photo& photo : photos) {
    if (!photo.captured_at || !photo.captured_at_is_local || !photo.receiver_time_of_day) continue;
    const UtcTime by_receiver = OnDayOf(*photo.captured_at, *photo.receiver_time_of_day, kMaxAhead);
    const std::optional<ClockStep> step = StepBetween(*photo.captured_at, by_receiver);
    if (!step) continue;
    told.push_back({&photo, by_receiver, *step});
    if (std::chrono::abs(step->left_over) <= kClocksAgreeWithin) ++shown[step->zone];
  }
  const auto zone =
      std::find_if(shown.begin(), shown.end(), [&](const auto& one) { return 2 * one.second > told.size(); });
  if (zone == shown.end()) return;
  for (const TwoClocks& one : told) {
    if (one.step.zone != zone->first || std::chrono::abs(one.step.left_over) > kSetByHandWithin) continue;
    one.photo->captured_at = *one.photo->captured_at - zone->first;
    one.photo->captured_at_is_local = false;
    one.photo->clock_minus_utc = zone->first;
    one.photo->receiver_time = one.by_receiver;
  }
}

namespace {

// Reads a name from left to right; characters beyond its end are zero.
class NameReader {
 public:
  NameReader(std::string_view text, std::size_t at) : text_(text), at_(at) {}

  char Peek(std::size_t ahead = 0) const { return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0'; }
  // Exactly `count` digits.
  std::optional<int> Digits(std::size_t count) {
    int value = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (!IsDigit(Peek(i))) return std::nullopt;
      value = 10 * value + (Peek(i) - '0');
    }
    at_ += count;
    return value;
  }
  bool TakeOneOf(std::string_view wanted) {
    if (Peek() == '\0' || wanted.find(Peek()) == std::string_view::npos) return false;
    ++at_;
    return true;
  }
  std::size_t DigitsAhead(std::size_t from = 0) const {
    std::size_t count = 0;
    while (IsDigit(Peek(from + count))) ++count;
    return count;
  }
  // One to six digits as the decimals of a second.
  double Fraction(std::size_t count) {
    double unit = 0.1;
    double value = 0.0;
    for (std::size_t i = 0; i < count; ++i, unit *= 0.1) value += unit * (Peek(i) - '0');
    at_ += count;
    return value;
  }

 private:
  std::string_view text_;
  std::size_t at_;
};

constexpr std::size_t kMaxDecimals = 6;

// What may follow whole seconds: "80" in 2018080501004480, ".250", ",250".
std::optional<double> ReadDecimals(NameReader& reader) {
  if (const std::size_t attached = reader.DigitsAhead(); attached > 0) {
    if (attached > kMaxDecimals) return std::nullopt;
    return reader.Fraction(attached);
  }
  const std::size_t behind_point = reader.DigitsAhead(1);
  const bool has_point = reader.Peek() == '.' || reader.Peek() == ',';
  if (!has_point || behind_point == 0 || behind_point > kMaxDecimals) return 0.0;
  reader.TakeOneOf(".,");
  return reader.Fraction(behind_point);
}

// Two parts behind one another are separated alike: both by a character of `separators`, or neither.
bool ReadTwo(NameReader& reader, std::string_view separators, int& first, int& second) {
  const bool is_separated = reader.TakeOneOf(separators);
  const auto one = reader.Digits(2);
  if (!one || reader.TakeOneOf(separators) != is_separated) return false;
  const auto other = reader.Digits(2);
  if (!other) return false;
  first = *one;
  second = *other;
  return true;
}

std::optional<NameTime> CivilTimeAt(std::string_view stem, std::size_t at) {
  constexpr int kFirstYear = 1990, kLastYear = 2099;
  NameReader reader(stem, at);
  const auto year = reader.Digits(4);
  if (!year || *year < kFirstYear || *year > kLastYear) return std::nullopt;
  int month = 0, day = 0, minute = 0, second = 0;
  if (!ReadTwo(reader, "-_.:", month, day)) return std::nullopt;
  reader.TakeOneOf("-_. Tt");
  const auto hour = reader.Digits(2);
  if (!hour || *hour > 23 || !ReadTwo(reader, "-_.:", minute, second)) return std::nullopt;
  if (minute > 59 || second > 59) return std::nullopt;
  const auto decimals = ReadDecimals(reader);
  if (!decimals) return std::nullopt;
  const auto time = UtcFromCivil(*year, month, day, *hour, minute, second + *decimals);
  if (!time) return std::nullopt;
  const bool says_utc = (reader.Peek() == 'Z' || reader.Peek() == 'z') &&
                        std::isalnum(static_cast<unsigned char>(reader.Peek(1))) == 0;
  return NameTime{*time, !says_utc && !stem.starts_with("PXL_")};
}

// 1537200000, 1537200000.25, 1537200000250, 1537200000250000.
std::optional<NameTime> EpochTimeAt(std::string_view stem, std::size_t at) {
  NameReader reader(stem, at);
  const std::size_t count = reader.DigitsAhead();
  if (count != 10 && count != 13 && count != 16) return std::nullopt;
  std::int64_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value = 10 * value + (reader.Peek(i) - '0');
  std::int64_t micros = value * (count == 10 ? 1'000'000 : count == 13 ? 1'000 : 1);
  constexpr std::int64_t kYear2001 = 978'307'200'000'000, kYear2100 = 4'102'444'800'000'000;
  if (micros < kYear2001 || micros >= kYear2100) return std::nullopt;
  if (count == 10) {
    reader = NameReader(stem, at + count);
    const auto decimals = ReadDecimals(reader);
    micros += std::llround(decimals.value_or(0.0) * 1e6);
  }
  return NameTime{UtcTime(std::chrono::microseconds(micros)), false};
}

// Without folders, " (2)" of a second file of one name, and the ending.
std::string_view StemOf(std::string_view name) {
  name = name.substr(name.find_last_of("/\\") + 1);
  if (const auto copy = name.rfind(" ("); copy != std::string_view::npos && name.ends_with(")")) {
    name = name.substr(0, copy);
  }
  const auto dot = name.rfind('.');
  if (dot == std::string_view::npos) return name;
  const std::string_view ending = name.substr(dot + 1);
  return std::any_of(ending.begin(), ending.end(), IsDigit) ? name : name.substr(0, dot);
}

bool LooksLikeARunningNumber(const std::set<std::pair<std::int64_t, bool>>& times) {
  constexpr std::int64_t kSecond = 1'000'000, kDay = 86'400 * kSecond, kNearMidnight = 100 * kSecond;
  if (times.size() < 3 || times.begin()->first % kDay > kNearMidnight) return false;
  for (auto it = times.begin(), next = std::next(it); next != times.end(); ++it, ++next) {
    if (next->first - it->first != kSecond) return false;
  }
  return true;
}

}  // namespace

std::optional<NameTime> TimeInName(std::string_view name) {
  const std::string_view stem = StemOf(name);
  for (const auto read_at : {CivilTimeAt, EpochTimeAt}) {
    for (std::size_t at = 0; at < stem.size(); ++at) {
      if (!IsDigit(stem[at]) || (at > 0 && IsDigit(stem[at - 1]))) continue;
      if (const auto time = read_at(stem, at)) return time;
    }
  }
  return std::nullopt;
}

int TakeTimesFromNames(std::vector<Photo>& photos) {
  std::vector<std::pair<Photo*, NameTime>> named;
  std::set<std::pair<std::int64_t, bool>> distinct;
  std::size_t untimed = 0;
  for (Photo& photo : photos) {
    if (photo.captured_at) continue;
    ++untimed;
    const auto time = TimeInName(photo.name);
    if (!time) continue;
    named.emplace_back(&photo, *time);
    distinct.emplace(time->time.time_since_epoch().count(), time->is_local);
  }
  const bool are_nearly_all = 10 * named.size() >= 9 * untimed;
  const bool differ = 3 * distinct.size() >= named.size();  // a serial number or the flight's start does not
  if (!are_nearly_all || !differ || LooksLikeARunningNumber(distinct)) return 0;
  for (auto& [photo, time] : named) {
    photo->captured_at = time.time;
    photo->captured_at_is_local = time.is_local;
  }
  return static_cast<int>(named.size());
}

}  // namespace skyquilt::flight
