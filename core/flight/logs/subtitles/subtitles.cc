#include <algorithm>
#include <cmath>
#include <functional>

#include "core/base/try.h"
#include "core/flight/bytes/gps_time.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/log_builder.h"
#include "core/flight/logs/subtitles/cue_text.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::flight {
namespace {

constexpr std::size_t kLongestCue = 16384;
constexpr std::size_t kHeadBytes = 4096;
constexpr std::string_view kCueArrow = "-->";

using TakeCue = std::function<void(double start_s, const std::string& cue)>;
using ForEachCue = void (*)(LogBytes bytes, const ConsumedUpTo& consumed, const TakeCue& take);

// Of "00:07:47,000 --> 00:07:48,000".
std::optional<double> SrtStart(std::string_view line) {
  const std::size_t arrow = line.find(kCueArrow);
  return arrow == std::string_view::npos ? std::nullopt : ParseElapsed(line.substr(0, arrow));
}

void ForEachSrtCue(LogBytes bytes, const ConsumedUpTo& consumed, const TakeCue& take) {
  LineReader lines(TextOf(bytes));
  std::string_view line;
  std::optional<double> start_s;
  std::string cue;
  ConsumedSteps steps(consumed);
  while (lines.Next(line)) {
    steps.At(lines.offset());
    if (line.find(kCueArrow) != std::string_view::npos) {
      if (start_s) take(*start_s, cue);
      start_s = SrtStart(line);
      cue.clear();
    } else if (cue.size() + line.size() < kLongestCue) {
      cue += line;
      cue += '\n';
    }
  }
  if (start_s) take(*start_s, cue);
}

// The fields of a Dialogue, as a line "Format:" above names them; the last is the text and may hold commas.
struct AssFormat {
  std::size_t start = 1;
  std::size_t text = 9;

  void Read(std::string_view line, std::vector<std::string_view>& fields) {
    SplitFields(line, ',', fields);
    for (std::size_t i = 0; i < fields.size(); ++i) {
      if (LowerCase(fields[i]) == "start" && i + 1 < fields.size()) *this = {i, fields.size() - 1};
    }
  }
};

// Without the codes for its looks: {\b1}, and \N for a new line.
std::string PlainAssText(std::string_view text) {
  std::string plain;
  bool is_code = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '{' || text[i] == '}') {
      is_code = text[i] == '{';
    } else if (!is_code && text[i] == '\\' && i + 1 < text.size()) {
      plain += text[++i] == 'h' ? ' ' : '\n';
    } else if (!is_code) {
      plain += text[i];
    }
  }
  return plain;
}

void ForEachAssCue(LogBytes bytes, const ConsumedUpTo& consumed, const TakeCue& take) {
  LineReader lines(TextOf(bytes));
  std::string_view line;
  AssFormat format;
  std::vector<std::string_view> fields;
  ConsumedSteps steps(consumed);
  while (NextFilledLine(lines, steps, line)) {
    line = Trim(line);
    const std::size_t colon = std::min(line.find(':'), line.size());
    std::string_view rest = line.substr(std::min(colon + 1, line.size()));
    if (StartsWithIgnoringCase(line, "Format:")) format.Read(rest, fields);
    if (!StartsWithIgnoringCase(line, "Dialogue:")) continue;
    std::optional<double> start_s;
    for (std::size_t i = 0; i < format.text; ++i) {
      const std::size_t comma = std::min(rest.find(','), rest.size());
      if (i == format.start) start_s = ParseElapsed(rest.substr(0, comma));
      rest.remove_prefix(std::min(rest.size(), comma + 1));
    }
    if (start_s) take(*start_s, PlainAssText(rest.substr(0, kLongestCue)));
  }
}

// The camera's clock beside the film's time.
class CueClock {
 public:
  // Seconds of the film's time plus what was left out of the film so far.
  double At(double film_s, const std::optional<WrittenTime>& date, bool follows_clock) {
    if (!date) return film_s + left_out_s_;
    resolution_s_ = std::max(resolution_s_, date->resolution_s);
    names_zone_ = names_zone_ || date->names_zone;
    if (!first_) first_ = date->time;
    // The clock was read somewhere within the last digit that it wrote.
    const double least_s = SecondsBetween(*first_, date->time) - film_s;
    const double most_s = least_s + date->resolution_s;
    const bool has_jumped = most_s_ && (least_s > *most_s_ + kSlackS || most_s < least_s_ - kSlackS);
    if (has_jumped && follows_clock && least_s - base_s_ < kLongestGapS)
      left_out_s_ = std::max(0.0, least_s - base_s_);
    if (!most_s_) base_s_ = least_s;
    if (!most_s_ || least_s > *most_s_ || most_s < least_s_) {
      least_s_ = least_s;
      most_s_ = most_s;
    }
    least_s_ = std::max(least_s_, least_s);
    most_s_ = std::min(*most_s_, most_s);
    const double t_s = film_s + left_out_s_;
    pairs_.Add(t_s, date->time);
    return t_s;
  }

  void Tell(LogBuilder& builder) const {
    const auto fit = pairs_.Solve();
    if (!fit) return;
    (names_zone_ ? builder.log().utc_at_zero : builder.log().local_at_zero) = fit->utc_at_zero;
    builder.log().utc_sigma_s = std::hypot(resolution_s_, fit->scatter_s);
    if (!names_zone_) builder.Warn(RemarkCode::kClockIsLocal);
    if (left_out_s_ > 0.0) {
      builder.Warn({RemarkCode::kFilmShorter, {{"shorter_s", left_out_s_}}});
    }
  }

 private:
  static constexpr double kSlackS = 0.5;
  static constexpr double kLongestGapS = 86'400.0;  // more is a clock that was set
  ClockPairs pairs_;
  std::optional<UtcTime> first_;
  double base_s_ = 0.0;
  double left_out_s_ = 0.0;
  double least_s_ = 0.0;  // the clock less the film's time, from its first reading on
  std::optional<double> most_s_;
  double resolution_s_ = 0.0;
  bool names_zone_ = false;
};

AttitudeSample AttitudeOf(double t_s, const Eigen::Vector3d& yaw_pitch_roll_deg) {
  const auto rad = [&](int i) { return geo::DegToRad(yaw_pitch_roll_deg[i]); };
  return {t_s, NedFromYawPitchRoll(rad(0), rad(1), rad(2))};
}

void AddCue(double t_s, const CueFacts& facts, LogBuilder& builder) {
  if (facts.position) {
    GnssSample sample;
    sample.t_s = t_s;
    sample.position = *facts.position;
    // A consumer receiver, plus what the digits cut away.
    const double step_m = 111'320.0 * std::pow(10.0, -facts.decimals);
    sample.sigma_horizontal_m = std::hypot(2.0, step_m / std::sqrt(12.0));
    sample.height_amsl_m = facts.height_amsl_m;
    builder.Add(sample);
  }
  if (facts.height_above_takeoff_m) builder.Add(BaroSample{t_s, *facts.height_above_takeoff_m});
  if (facts.airframe_yaw_pitch_roll_deg) builder.Add(AttitudeOf(t_s, *facts.airframe_yaw_pitch_roll_deg));
  if (facts.gimbal_yaw_pitch_roll_deg) builder.AddGimbal(AttitudeOf(t_s, *facts.gimbal_yaw_pitch_roll_deg));
}

Result<FlightLog> ParseCues(std::string_view format, std::string_view name, LogBytes bytes,
                            const ConsumedUpTo& consumed, ForEachCue for_each, bool follows_clock) {
  constexpr std::size_t kQuotedOfCue = 100;
  LogBuilder builder(std::string(format), name);
  CueClock clock;
  std::uint64_t cues = 0;
  std::uint64_t fixes = 0;
  std::string first_words;
  for_each(bytes, consumed, [&](double start_s, const std::string& cue) {
    if (++cues == 1) first_words = Quoted(Trim(cue), kQuotedOfCue);
    const CueFacts facts = ReadCue(cue);
    if (facts.position) ++fixes;
    AddCue(clock.At(start_s, CueDate(cue), follows_clock), facts, builder);
  });
  if (cues == 0) return builder.Refuse(RemarkCode::kSubtitlesEmpty);
  if (fixes == 0) {
    return Because(ErrorCode::kNoPosition, {RemarkCode::kSubtitlesWithoutPlace,
                                            {{"file", name}, {"cues", cues}, {"text", first_words}}});
  }
  builder.Count("subtitle", cues);
  clock.Tell(builder);
  builder.log().mapping = {"altitude, abs_alt, third of GPS(W: N:) -> height above mean sea level, m",
                           "rel_alt, BAROMETER, ReH, Hb, H -> height above take-off, m"};
  return std::move(builder).Finish();
}

}  // namespace

bool LooksLikeDjiSrt(LogBytes head) {
  return HasLine(TextOf(head), 8, [](std::string_view line) { return SrtStart(line).has_value(); });
}

bool LooksLikeAss(LogBytes head) {
  const std::string_view text = Trim(TextOf(head));
  return StartsWithIgnoringCase(text, "[Script Info]") || StartsWithIgnoringCase(text, "[Events]") ||
         StartsWithIgnoringCase(text, "Dialogue:");
}

Result<FlightLog> ParseDjiSrt(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed) {
  return ParseCues("dji_srt", name, bytes, consumed, ForEachSrtCue, true);
}

Result<FlightLog> ParseAss(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed) {
  return ParseCues("ass", name, bytes, consumed, ForEachAssCue, true);
}

Result<FlightLog> ParseFilmSubtitles(std::string_view name, LogBytes bytes) {
  SKYQUILT_TRY_ASSIGN(const auto text, LogText::Of(name, bytes));
  bytes = text.bytes();
  const LogBytes head = bytes.first(std::min(bytes.size(), kHeadBytes));
  if (LooksLikeText(TextOf(head)) && LooksLikeAss(head))
    return ParseCues("ass", name, bytes, {}, ForEachAssCue, false);
  return ParseCues("dji_srt", name, bytes, {}, ForEachSrtCue, false);
}

}  // namespace skyquilt::flight
