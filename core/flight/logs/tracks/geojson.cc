#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/tracks/track_points.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::flight {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMaxJsonDepth = 64;
constexpr std::size_t kLongestJsonTime = 64;
constexpr std::size_t kMaxOfFeature = 500'000;  // places, and times

// Names of members that hold times, in lower case without - and _.
constexpr std::array<std::string_view, 12> kTimeNames = {
    "time", "times", "timestamp", "timestamps", "datetime", "datetimes",
    "utc",  "when",  "utctime",   "coordtimes", "isotime",  "utcdatetime"};

// The places and times of one feature after the other, flat whatever lines they are parts of.
class FeatureReader final : public nlohmann::json_sax<Json> {
 public:
  explicit FeatureReader(TrackPoints& points) : points_(points) {}

  bool null() override { return Value("", {}); }
  bool boolean(bool) override { return Value("", {}); }
  bool number_integer(number_integer_t value) override {
    return Value(in_times_ ? fmt::format("{}", value) : "", static_cast<double>(value));
  }
  bool number_unsigned(number_unsigned_t value) override {
    return Value(in_times_ ? fmt::format("{}", value) : "", static_cast<double>(value));
  }
  bool number_float(number_float_t value, const string_t& written) override {
    return Value(in_times_ ? written : "", value);
  }
  bool string(string_t& value) override {
    if (!stack_.empty() && stack_.back().is_type && value == "Feature") stack_.back().is_feature = true;
    return Value(value, {});
  }
  bool binary(binary_t&) override { return true; }

  bool key(string_t& name) override {
    Level& level = stack_.back();
    level.is_type = name == "type";
    in_places_ = name == "coordinates";
    if (name == "features") times_ = best_ = {};  // of the document, not of a feature
    std::string bare = LowerCase(std::string_view(name).substr(0, kLongestJsonTime));
    std::erase_if(bare, [](char c) { return c == '-' || c == '_'; });
    in_times_ = IsOneOf(bare, kTimeNames);
    if (in_times_ && times_.name != bare) {
      SettleTimes();
      times_.name = bare;
    }
    return true;
  }

  bool start_object(std::size_t) override {
    in_places_ = in_times_ = false;
    return Push(Level{});
  }
  bool end_object() override {
    const bool is_feature = stack_.back().is_feature;
    Pop();
    if (is_feature) Flush();
    return true;
  }
  bool start_array(std::size_t) override {
    place_size_ = 0;
    place_.fill(std::numeric_limits<double>::quiet_NaN());
    return Push(Level{false, false, true, in_places_, in_times_});
  }
  bool end_array() override {
    if (in_places_ && place_size_ >= 2) {
      if (places_.size() < kMaxOfFeature) {
        places_.push_back(place_);
      } else {
        ++left_out_;
      }
    }
    place_size_ = 0;
    Pop();
    return true;
  }
  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception&) override {
    damaged_at_ = position;
    return false;
  }

  // What a document that ends early, or is no Feature, has gathered.
  void Finish() { Flush(); }
  std::size_t left_out() const { return left_out_; }  // places beyond the bound of a feature
  std::optional<std::size_t> damaged_at() const { return damaged_at_; }
  bool is_too_deep() const { return is_too_deep_; }
  // In words, where a line has fewer or more times than places; empty elsewhere.
  const std::optional<Remark>& unequal() const { return unequal_; }

 private:
  struct Level {
    bool is_type = false;  // the member at hand is "type"
    bool is_feature = false;
    bool is_array = false;
    bool in_places = false;
    bool in_times = false;
  };

  bool Push(const Level& level) {
    is_too_deep_ = stack_.size() >= kMaxJsonDepth;
    if (!is_too_deep_) stack_.push_back(level);
    return !is_too_deep_;
  }

  // What comes next belongs to the array around, or is the next member of an object.
  void Pop() {
    stack_.pop_back();
    const bool in_array = !stack_.empty() && stack_.back().is_array;
    in_places_ = in_array && stack_.back().in_places;
    in_times_ = in_array && stack_.back().in_times;
  }

  bool Value(std::string_view words, std::optional<double> number) {
    if (in_places_ && place_size_ < place_.size()) {
      place_[place_size_++] = number.value_or(std::numeric_limits<double>::quiet_NaN());
    } else if (in_times_ && times_.written.size() < kMaxOfFeature) {
      times_.written.emplace_back(words.substr(0, kLongestJsonTime));
      times_.is_read = times_.is_read || TrackTime(words).has_value();
    }
    return true;
  }

  // Of several members with times the longest counts of those that can be read.
  void SettleTimes() {
    const bool is_better =
        times_.is_read != best_.is_read ? times_.is_read : times_.written.size() > best_.written.size();
    if (is_better) std::swap(best_, times_);
    times_ = {};
  }

  void Flush() {
    SettleTimes();
    const std::vector<std::string>& times = best_.written;
    const bool is_timed = times.size() == places_.size();
    if (!is_timed && times.size() > 1 && !places_.empty() && !unequal_)
      unequal_ = {RemarkCode::kTimesAndPlacesUnequal,
                  {{"places", places_.size()}, {"times_read", times.size()}}};
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const auto& [lon_deg, lat_deg, height_m, fourth] = places_[i];
      TrackPoint point{lat_deg, lon_deg, {}, {}, {}};
      if (!std::isnan(height_m)) point.height_amsl_m = height_m;
      const std::string counted = std::isnan(fourth) ? std::string() : fmt::format("{:.6f}", fourth);
      const bool is_counted = times.empty() && TrackTime(counted);
      points_.Add(point, is_timed ? times[i] : is_counted ? counted : std::string());
    }
    places_.clear();
    best_ = {};
  }

  TrackPoints& points_;
  std::vector<Level> stack_;
  bool in_places_ = false;
  bool in_times_ = false;
  std::vector<std::array<double, 4>> places_;  // longitude, latitude, height, what stands behind it
  std::array<double, 4> place_{};
  std::size_t place_size_ = 0;
  std::size_t left_out_ = 0;
  struct Times {
    std::string name;
    std::vector<std::string> written;
    bool is_read = false;
  };
  Times times_;  // of the member at hand
  Times best_;   // of those before it
  std::optional<Remark> unequal_;
  std::optional<std::size_t> damaged_at_;
  bool is_too_deep_ = false;
};

}  // namespace

bool LooksLikeGeoJson(LogBytes head) {
  std::string_view text = TextOf(head);
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  return Trim(text).starts_with('{') && HoldsOneOf(text, {"\"Feature\"", "\"FeatureCollection\""});
}

bool HasGeoJsonAreas(LogBytes bytes) {
  return HoldsOneOf(TextOf(bytes), {"\"Polygon\"", "\"MultiPolygon\""});
}

Result<FlightLog> ParseGeoJson(std::string_view name, LogBytes bytes, const ConsumedUpTo& /*consumed*/) {
  TrackPoints points("geojson", name, TrackPoints::BareTime::kLocal);
  FeatureReader reader(points);
  const std::string_view text = TextOf(bytes);
  Json::sax_parse(text.begin(), text.end(), &reader);
  reader.Finish();
  auto log = std::move(points).Finish({"third coordinate -> height above mean sea level, m (assumed)"});
  if (reader.is_too_deep()) {
    return Because(ErrorCode::kCorrupt,
                   {RemarkCode::kJsonTooDeep, {{"file", name}, {"most", kMaxJsonDepth}}});
  }
  if (reader.unequal() && !log)
    return Because(ErrorCode::kNoPosition,
                   {RemarkCode::kTrackNotUsed, {{"file", name}, {"why", *reader.unequal()}}});
  const bool is_without_times = !log && WhyOf(log.error()).code == RemarkCode::kTrackWithoutTimes;
  if (is_without_times && !reader.damaged_at() && HasGeoJsonAreas(bytes))
    return Because(ErrorCode::kNoPosition, {RemarkCode::kAreasNoTrack, {{"file", name}}});
  if (reader.unequal()) log->warnings.push_back(*reader.unequal());
  if (log && reader.left_out() > 0) {
    log->warnings.push_back(
        {RemarkCode::kPlacesBeyond, {{"places", reader.left_out()}, {"most", kMaxOfFeature}}});
  }
  if (!reader.damaged_at()) return log;
  if (!log) {
    return Because(ErrorCode::kCorrupt,
                   {RemarkCode::kJsonDamaged, {{"file", name}, {"byte", *reader.damaged_at()}}},
                   log.error().message);
  }
  log->warnings.push_back({RemarkCode::kDamagedAtByte, {{"byte", *reader.damaged_at()}}});
  return log;
}

}  // namespace skyquilt::flight
