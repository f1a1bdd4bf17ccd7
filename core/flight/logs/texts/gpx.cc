#include "core/flight/logs/texts/gpx.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/flight/logs/gps_time.h"
#include "core/flight/logs/log_builder.h"
#include "core/flight/logs/text_fields.h"

namespace skyquilt::flight {
namespace {

constexpr std::size_t kLongestPoint = 65536;
constexpr std::size_t kLongestTag = 1024;  // up to the >

std::size_t SkipBlanks(std::string_view text, std::size_t at) {
  return std::min(text.find_first_not_of(" \t\r\n", at), text.size());
}

// The attributes of a tag one after the other, each looked at once.
std::optional<double> Attribute(std::string_view tag, std::string_view attribute) {
  tag = tag.substr(0, kLongestTag);
  std::size_t at = 0;
  while (at < tag.size()) {
    const std::size_t equals = tag.find('=', at);
    if (equals == std::string_view::npos) return std::nullopt;
    const std::string_view before = Trim(tag.substr(at, equals - at));
    const std::size_t quote = SkipBlanks(tag, equals + 1);
    if (quote == tag.size() || (tag[quote] != '"' && tag[quote] != '\'')) {
      at = equals + 1;
      continue;
    }
    const std::size_t end = tag.find(tag[quote], quote + 1);
    if (end == std::string_view::npos) return std::nullopt;
    const std::string_view name = before.substr(std::min(before.find_last_of(" \t\r\n") + 1, before.size()));
    if (name == attribute) return ParseNumber(tag.substr(quote + 1, end - quote - 1));
    at = end + 1;
  }
  return std::nullopt;
}

std::string_view Element(std::string_view point, std::string_view open) {
  const std::size_t at = point.find(open);
  if (at == std::string_view::npos) return {};
  const std::string_view rest = point.substr(at + open.size());
  return rest.substr(0, rest.find('<'));
}

}  // namespace

bool LooksLikeGpx(LogBytes head) {
  return LooksLikeText(TextOf(head)) && TextOf(head).substr(0, 2048).find("<gpx") != std::string_view::npos;
}

Result<FlightLog> ParseGpx(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed) {
  LogBuilder builder("gpx", name);
  const std::string_view text = TextOf(bytes);
  const bool has_track = text.find("<trkpt") != std::string_view::npos;
  const std::string_view open = has_track ? "<trkpt" : "<wpt";
  const std::string_view close = has_track ? "</trkpt" : "</wpt";
  std::optional<UtcTime> first;
  std::uint64_t points = 0;
  std::uint64_t bad = 0;
  ConsumedSteps steps(consumed);
  for (std::size_t at = text.find(open); at != std::string_view::npos;) {
    steps.At(at);
    const std::size_t next = text.find(open, at + open.size());
    std::string_view point =
        text.substr(at, std::min(kLongestPoint, (next == std::string_view::npos ? text.size() : next) - at));
    point = point.substr(0, point.find(close));
    at = next;
    ++points;
    const std::string_view tag = point.substr(0, point.find('>'));
    const auto lat = Attribute(tag, "lat");
    const auto lon = Attribute(tag, "lon");
    const auto time = ParseWrittenTime(Element(point, "<time>"));
    if (!lat || !lon || !time) {
      ++bad;
      continue;
    }
    if (!first) first = time->time;
    GnssSample sample;
    sample.t_s = std::chrono::duration<double>(time->time - *first).count();
    sample.position = {*lat, *lon};
    sample.height_amsl_m = ParseNumber(Element(point, "<ele>"));
    builder.Add(sample);
  }
  if (builder.gnss_count() == 0) {
    return Error{ErrorCode::kCorrupt,
                 fmt::format("{} holds no track point with a position and a time.", name),
                 fmt::format("{} points, {} unusable", points, bad)};
  }
  builder.Count("point", points);
  builder.log().utc_at_zero = first;
  builder.log().utc_sigma_s = 0.5;  // most recorders write whole seconds
  if (bad > 0) builder.Warn(fmt::format("{} points without a position or a time were skipped", bad));
  return std::move(builder).Finish();
}

}  // namespace skyquilt::flight
