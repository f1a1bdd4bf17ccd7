
#include <charconv>
#include <cmath>

#include "core/flight/bytes/gps_time.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/log_builder.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::flight {
namespace {

constexpr double kDayS = 86'400.0;
constexpr std::size_t kQuotedSentence = 100;
constexpr int kLinesLookedAt = 200;  // until the first sentence

// "hhmmss.ss" as seconds of the day.
std::optional<double> SecondsOfDay(std::string_view text) {
  if (text.size() < 6) return std::nullopt;
  const auto hours = ParseInteger(text.substr(0, 2));
  const auto minutes = ParseInteger(text.substr(2, 2));
  const auto seconds = ParseNumber(text.substr(4));
  if (!hours || !minutes || !seconds || *hours < 0 || *hours > 23 || *minutes < 0 || *minutes > 59 ||
      *seconds < 0.0 || *seconds >= 61.0) {
    return std::nullopt;
  }
  return static_cast<double>(*hours * 3600 + *minutes * 60) + *seconds;
}

// "ddmm.mmmm" and its hemisphere as degrees.
std::optional<double> Degrees(std::string_view text, std::string_view hemisphere) {
  const auto value = ParseNumber(text);
  if (!value || *value < 0.0 || hemisphere.size() != 1) return std::nullopt;
  const double whole = std::floor(*value / 100.0);
  const double degrees = whole + (*value - whole * 100.0) / 60.0;
  if (hemisphere == "N" || hemisphere == "E") return degrees;
  if (hemisphere == "S" || hemisphere == "W") return -degrees;
  return std::nullopt;
}

enum class Sentence { kNone, kDamaged, kWhole };

// The fields between $ and * of the sentence in a line, whatever a recorder puts before it (time stamps, the
// words of logcat) and behind it. Its checksum, where written, must be right.
Sentence SplitSentence(std::string_view line, std::vector<std::string_view>& fields) {
  const std::size_t dollar = line.find('$');
  if (dollar == std::string_view::npos) return Sentence::kNone;
  line = Trim(line.substr(dollar + 1));
  const std::size_t star = line.find('*');
  const std::string_view body = line.substr(0, star);
  if (star != std::string_view::npos) {
    unsigned written = 0;
    const std::string_view digits = line.substr(star + 1, 2);
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), written, 16);
    unsigned sum = 0;
    for (const char c : body) sum ^= static_cast<unsigned char>(c);
    if (digits.size() != 2 || error != std::errc() || end != digits.data() + 2 || sum != written)
      return Sentence::kDamaged;
  }
  SplitFields(body, ',', fields);
  return fields[0].size() >= 5 ? Sentence::kWhole : Sentence::kNone;
}

class NmeaReader {
 public:
  explicit NmeaReader(LogBuilder& builder) : builder_(builder) {}

  void Take(const std::vector<std::string_view>& f) {
    const std::string_view kind = f[0].substr(f[0].size() - 3);
    if (kind == "GGA" && f.size() >= 12) TakeFix(f, ParseInteger(f[6]).value_or(0) >= 1, f[6] == "4", f[11]);
    // A letter for each system of satellites: N without a fix, R with whole wavelengths.
    if (kind == "GNS" && f.size() >= 11) {
      TakeFix(f, f[6].find_first_not_of('N') != std::string_view::npos,
              f[6].find('R') != std::string_view::npos, f[10]);
    }
    if (kind == "RMC" && f.size() >= 10) TakeRmc(f);
    if (kind == "GST" && f.size() >= 9) TakeGst(f);
    if (kind == "ZDA" && f.size() >= 5) {
      const auto seconds = SecondsOfDay(f[1]);
      const auto day = ParseInteger(f[2]);
      const auto month = ParseInteger(f[3]);
      const auto year = ParseInteger(f[4]);
      if (seconds && day && month && year) SetDate(*seconds, *year, *month, *day);
    }
  }

  void Finish() {
    Flush();
    if (const auto fit = clock_.Solve()) {
      builder_.log().utc_at_zero = fit->utc_at_zero;
      builder_.log().utc_sigma_s = 0.05;
    } else {
      builder_.Warn(RemarkCode::kNoDate);
    }
  }

 private:
  // Seconds since midnight of the first day, across midnights.
  double Continuous(double seconds) {
    if (last_seconds_ && seconds < *last_seconds_ - 0.5 * kDayS) days_ += 1.0;
    if (!last_seconds_ || seconds > *last_seconds_ || seconds < *last_seconds_ - 0.5 * kDayS)
      last_seconds_ = seconds;
    if (!first_s_) first_s_ = seconds;
    return days_ * kDayS + seconds - *first_s_;
  }

  void SetDate(double seconds, std::int64_t year, std::int64_t month, std::int64_t day) {
    if (year < 0 || year > 9999) return;
    const auto midnight =
        UtcFromCivil(static_cast<int>(year), static_cast<int>(month), static_cast<int>(day), 0, 0, 0.0);
    if (midnight) clock_.Add(Continuous(seconds), LaterBy(*midnight, seconds));
  }

  void Flush() {
    if (sample_) builder_.Add(*sample_);
    sample_.reset();
  }

  // GGA and GNS. Receivers that speak for several systems say an epoch more than once: its first fix counts.
  void TakeFix(const std::vector<std::string_view>& f, bool has_fix, bool is_rtk_fixed,
               std::string_view separation_m) {
    const auto seconds = SecondsOfDay(f[1]);
    const auto lat = Degrees(f[2], f[3]);
    const auto lon = Degrees(f[4], f[5]);
    if (!seconds || !lat || !lon || !has_fix) return;
    has_heights_ = true;
    GnssSample sample;
    sample.t_s = Continuous(*seconds);
    sample.position = {*lat, *lon};
    sample.height_amsl_m = ParseNumber(f[9]);
    const auto separation = ParseNumber(separation_m);
    if (sample.height_amsl_m && separation) sample.height_ellipsoid_m = *sample.height_amsl_m + *separation;
    sample.is_rtk_fixed = is_rtk_fixed;
    const bool is_same_epoch = sample_ && sample_->t_s == sample.t_s;
    if (is_same_epoch && sample_->height_amsl_m) return;
    if (!is_same_epoch) Flush();
    sample_ = sample;
  }

  // The place of an epoch only where no sentence with a height tells it.
  void TakeRmc(const std::vector<std::string_view>& f) {
    const auto seconds = SecondsOfDay(f[1]);
    const auto date = f[9].size() == 6 ? ParseInteger(f[9]) : std::nullopt;
    if (!seconds || f[2] != "A") return;
    if (date) SetDate(*seconds, 2000 + *date % 100, *date / 100 % 100, *date / 10000);
    const auto lat = Degrees(f[3], f[4]);
    const auto lon = Degrees(f[5], f[6]);
    if (has_heights_ || !lat || !lon) return;
    GnssSample sample;
    sample.t_s = Continuous(*seconds);
    sample.position = {*lat, *lon};
    if (sample_ && sample_->t_s == sample.t_s) return;
    Flush();
    sample_ = sample;
  }

  void TakeGst(const std::vector<std::string_view>& f) {
    const auto lat = ParseNumber(f[6]);
    const auto lon = ParseNumber(f[7]);
    const auto height = ParseNumber(f[8]);
    if (!sample_ || !lat || !lon || !height) return;
    sample_->sigma_horizontal_m = std::max(*lat, *lon);
    sample_->sigma_vertical_m = *height;
  }

  LogBuilder& builder_;
  ClockPairs clock_;
  bool has_heights_ = false;
  std::optional<GnssSample> sample_;  // waits for the GST of its epoch
  std::optional<double> last_seconds_;
  std::optional<double> first_s_;
  double days_ = 0.0;
};

}  // namespace

bool LooksLikeNmea(LogBytes head) {
  std::vector<std::string_view> fields;
  return HasLine(TextOf(head), kLinesLookedAt, [&](std::string_view line) {
    return SplitSentence(line, fields) == Sentence::kWhole &&
           IsOneOf(fields[0].substr(fields[0].size() - 3),
                   {"GGA", "RMC", "GNS", "GSA", "GSV", "VTG", "GLL", "ZDA", "GST"});
  });
}

Result<FlightLog> ParseNmea(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed) {
  LogBuilder builder("nmea", name);
  NmeaReader reader(builder);
  LineReader lines(TextOf(bytes));
  std::string_view line;
  std::vector<std::string_view> fields;
  std::uint64_t bad = 0;
  std::size_t first_bad_line = 0;
  std::string first_bad;
  ConsumedSteps steps(consumed);
  while (NextFilledLine(lines, steps, line)) {
    const Sentence found = SplitSentence(line, fields);
    if (found == Sentence::kDamaged && ++bad == 1) {
      first_bad_line = lines.line_number();
      first_bad = Quoted(line, kQuotedSentence);
    }
    if (found != Sentence::kWhole) continue;
    builder.Count(std::string(fields[0].substr(0, 8)), 1);
    reader.Take(fields);
  }
  reader.Finish();
  if (builder.gnss_count() == 0) {
    if (bad == 0) return builder.Refuse(RemarkCode::kNmeaWithoutFix);
    return Because(ErrorCode::kCorrupt,
                   {RemarkCode::kNmeaDamaged,
                    {{"file", name}, {"wrong", bad}, {"line", first_bad_line}, {"sentence", first_bad}}});
  }
  if (bad > 0)
    builder.Warn(
        {RemarkCode::kChecksumsWrong, {{"wrong", bad}, {"line", first_bad_line}, {"sentence", first_bad}}});
  return std::move(builder).Finish();
}

}  // namespace skyquilt::flight
