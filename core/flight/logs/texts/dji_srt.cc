#include "core/flight/logs/texts/dji_srt.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>

#include "core/flight/logs/gps_time.h"
#include "core/flight/logs/log_builder.h"
#include "core/flight/logs/text_fields.h"

namespace skyquilt::flight {
namespace {

constexpr std::size_t kLongestCue = 16384;

// "00:07:47,000 --> ..." as seconds.
std::optional<double> CueStart(std::string_view line) {
  std::array<double, 4> part{};
  std::string_view rest = Trim(line.substr(0, line.find("-->")));
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t end = std::min(rest.find_first_of(":,."), rest.size());
    const auto value = ParseInteger(rest.substr(0, end));
    if (!value || *value < 0 || *value > 9999) return std::nullopt;
    part[i] = static_cast<double>(*value);
    rest.remove_prefix(std::min(rest.size(), end + 1));
  }
  return part[0] * 3600.0 + part[1] * 60.0 + part[2] + part[3] * 1e-3;
}

// The number at the start of a text, after blanks; also the text of it.
std::optional<double> LeadingNumber(std::string_view text, std::string_view* written = nullptr) {
  while (!text.empty() && (text.front() == ' ' || text.front() == ':' || text.front() == '+'))
    text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] =
      std::from_chars(text.data(), text.data() + std::min<std::size_t>(text.size(), 40), value);
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  if (written != nullptr) *written = text.substr(0, static_cast<std::size_t>(end - text.data()));
  return value;
}

// "key : 1.5" anywhere in the (lower-case) text, where no letter stands before the key.
std::optional<double> KeyNumber(std::string_view text, std::string_view key,
                                std::string_view* written = nullptr) {
  for (std::size_t at = text.find(key); at != std::string_view::npos; at = text.find(key, at + 1)) {
    const bool starts = at == 0 || !((text[at - 1] >= 'a' && text[at - 1] <= 'z') || text[at - 1] == '_' ||
                                     text[at - 1] == '.');
    const std::string_view rest = text.substr(at + key.size());
    const bool ends = !rest.empty() && (rest.front() == ' ' || rest.front() == ':');
    if (!starts || !ends) continue;
    if (const auto value = LeadingNumber(rest, written)) return value;
  }
  return std::nullopt;
}

struct Triple {
  std::array<double, 3> value{};
  int decimals = 0;              // of the first value
  bool third_is_metres = false;  // "12.0M"
};

// "gps(1.5,2.5,19)" or "f.pry (2.7 deg, ...)".
std::optional<Triple> CallTriple(std::string_view text, std::string_view key) {
  std::size_t at = text.find(key);
  if (at == std::string_view::npos) return std::nullopt;
  at += key.size();
  while (at < text.size() && text[at] == ' ') ++at;
  if (at >= text.size() || text[at] != '(') return std::nullopt;
  const std::size_t close = text.find(')', at);
  if (close == std::string_view::npos) return std::nullopt;
  std::vector<std::string_view> parts;
  SplitFields(text.substr(at + 1, close - at - 1), ',', parts);
  if (parts.size() < 3) return std::nullopt;
  Triple triple;
  for (std::size_t i = 0; i < 3; ++i) {
    std::string_view written;
    const auto value = LeadingNumber(parts[i], &written);
    if (!value) return std::nullopt;
    triple.value[i] = *value;
    if (i == 0) triple.decimals = DecimalPlaces(written);
  }
  triple.third_is_metres = !parts[2].empty() && parts[2].back() == 'm';
  return triple;
}

struct Fix {
  geo::LatLon position;
  int decimals = 6;
};

std::optional<Fix> FindFix(std::string_view text) {
  if (const auto gps = CallTriple(text, "gps")) {
    // Longitude comes first, but latitude where the third value is a height in metres.
    double lat = gps->third_is_metres ? gps->value[0] : gps->value[1];
    double lon = gps->third_is_metres ? gps->value[1] : gps->value[0];
    if (std::abs(lat) > 90.0 && std::abs(lon) <= 90.0) std::swap(lat, lon);
    return Fix{{lat, lon}, gps->decimals};
  }
  std::string_view written;
  const auto lat = KeyNumber(text, "latitude", &written);
  auto lon = KeyNumber(text, "longitude");
  if (!lon) lon = KeyNumber(text, "longtitude");  // as some firmware spells it
  if (!lat || !lon) return std::nullopt;
  return Fix{{*lat, *lon}, DecimalPlaces(written)};
}

std::optional<WrittenTime> FindDate(std::string_view text) {
  // A date starts with four digits and a separator: "2017.8.5 14:11:51".
  for (std::size_t i = 0; i + 14 < text.size(); ++i) {
    const bool fresh = i == 0 || text[i - 1] < '0' || text[i - 1] > '9';
    if (fresh && text[i] == '2' && text[i + 1] == '0' &&
        (text[i + 4] == '.' || text[i + 4] == '-' || text[i + 4] == '/')) {
      std::size_t end = i;
      while (end < text.size() && end < i + 32 && text[end] != '\n' && text[end] != '<' && text[end] != ')')
        ++end;
      if (auto date = ParseWrittenTime(text.substr(i, end - i))) return date;
    }
  }
  return std::nullopt;
}

class SrtReader {
 public:
  explicit SrtReader(LogBuilder& builder) : builder_(builder) {}

  void Take(double t_s, const std::string& cue) {
    ++cues_;
    const std::string text = LowerCase(cue);
    if (const auto date = FindDate(text)) {
      clock_.Add(t_s, date->time);
      resolution_s_ = std::max(resolution_s_, date->resolution_s);
    }
    if (const auto fix = FindFix(text)) {
      ++fixes_;
      GnssSample sample;
      sample.t_s = t_s;
      sample.position = fix->position;
      // A consumer receiver, plus what the digits cut away.
      const double step_m = 111'320.0 * std::pow(10.0, -fix->decimals);
      sample.sigma_horizontal_m = std::hypot(2.0, step_m / std::sqrt(12.0));
      auto absolute = KeyNumber(text, "abs_alt");
      if (!absolute) absolute = KeyNumber(text, "altitude");
      sample.height_amsl_m = absolute;
      builder_.Add(sample);
    }
    for (const std::string_view key : {"rel_alt", "barometer", "hb", "h"}) {
      if (const auto height_m = KeyNumber(text, key)) {
        builder_.Add(BaroSample{t_s, *height_m});
        break;
      }
    }
    if (const auto pry = CallTriple(text, "f.pry")) builder_.Add(FromPitchRollYaw(t_s, pry->value));
    if (const auto pry = CallTriple(text, "g.pry")) {
      builder_.AddGimbal(FromPitchRollYaw(t_s, pry->value));
    } else {
      const auto yaw = KeyNumber(text, "gb_yaw");
      const auto pitch = KeyNumber(text, "gb_pitch");
      const auto roll = KeyNumber(text, "gb_roll");
      if (yaw && pitch && roll) builder_.AddGimbal(FromPitchRollYaw(t_s, {*pitch, *roll, *yaw}));
    }
  }

  void Finish() {
    builder_.Count("subtitle", cues_);
    if (const auto fit = clock_.Solve()) {
      builder_.log().local_at_zero = fit->utc_at_zero;
      builder_.log().utc_sigma_s = std::hypot(resolution_s_, fit->scatter_s);
      builder_.Warn("the camera's clock is local; its zone is not written");
    }
  }
  std::uint64_t fixes() const { return fixes_; }
  std::uint64_t cues() const { return cues_; }

 private:
  static AttitudeSample FromPitchRollYaw(double t_s, const std::array<double, 3>& deg) {
    AttitudeSample sample;
    sample.t_s = t_s;
    sample.ned_from_body =
        NedFromYawPitchRoll(geo::DegToRad(deg[2]), geo::DegToRad(deg[0]), geo::DegToRad(deg[1]));
    return sample;
  }
  LogBuilder& builder_;
  ClockPairs clock_;
  double resolution_s_ = 0.0;
  std::uint64_t cues_ = 0;
  std::uint64_t fixes_ = 0;
};

}  // namespace

bool LooksLikeDjiSrt(LogBytes head) {
  if (!LooksLikeText(TextOf(head))) return false;
  LineReader lines(TextOf(head));
  std::string_view line;
  for (int i = 0; i < 8 && lines.Next(line); ++i) {
    if (line.find("-->") != std::string_view::npos && CueStart(line)) return true;
  }
  return false;
}

Result<FlightLog> ParseDjiSrt(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed) {
  LogBuilder builder("dji_srt", name);
  SrtReader reader(builder);
  LineReader lines(TextOf(bytes));
  std::string_view line;
  std::optional<double> start_s;
  std::string cue;
  ConsumedSteps steps(consumed);
  while (lines.Next(line)) {
    steps.At(lines.offset());
    if (line.find("-->") != std::string_view::npos) {
      if (start_s) reader.Take(*start_s, cue);
      start_s = CueStart(line);
      cue.clear();
    } else if (cue.size() + line.size() < kLongestCue) {
      cue += line;
      cue += '\n';
    }
  }
  if (start_s) reader.Take(*start_s, cue);
  if (reader.cues() == 0) {
    return Error{ErrorCode::kCorrupt,
                 fmt::format("{} holds no subtitle; copy it from the camera's card again.", name), ""};
  }
  if (reader.fixes() == 0) {
    return Error{
        ErrorCode::kNoPosition,
        fmt::format("{} holds no position; switch on video captions in the camera's settings.", name), ""};
  }
  reader.Finish();
  builder.log().mapping = {"altitude, abs_alt -> height above mean sea level, m",
                           "rel_alt, BAROMETER, Hb, H -> height above take-off, m"};
  return std::move(builder).Finish();
}

}  // namespace skyquilt::flight
