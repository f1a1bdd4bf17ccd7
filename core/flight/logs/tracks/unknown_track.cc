#include "core/flight/logs/tracks/unknown_track.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>

#include "core/flight/logs/text_fields.h"

namespace skyquilt::flight {
namespace {

struct NamedTrack {
  std::string_view ending;
  std::string_view what;
  std::string_view mark;  // by which it is known
};

constexpr std::array<NamedTrack, 6> kNamedTracks = {{
    {".gpx", "a GPX track", "an element <gpx> at its beginning"},
    {".kml", "a KML track", "an element <kml> at its beginning"},
    {".geojson", "a GeoJSON track", "a Feature or FeatureCollection at its beginning"},
    {".nmea", "an NMEA recording", "a sentence ($GPGGA, $GNRMC) in its first 200 lines"},
    {".srt", "a file of subtitles", "a line like 00:00:01,000 --> 00:00:02,000 in its first 8"},
    {".ass", "a file of subtitles", "[Script Info], [Events] or Dialogue in its first line"},
}};

}  // namespace

std::optional<std::string> ExplainUnknownTrack(LogBytes head, std::string_view name) {
  constexpr std::size_t kQuotedLine = 60;
  const std::string lower = LowerCase(name);
  if (lower.ends_with(".kmz")) {
    return fmt::format(
        "{} is not used: it is a zip around a KML file. Unzip it and give the .kml that is in it.", name);
  }
  const auto named = std::find_if(kNamedTracks.begin(), kNamedTracks.end(),
                                  [&](const NamedTrack& track) { return lower.ends_with(track.ending); });
  if (named == kNamedTracks.end()) return std::nullopt;
  std::string begins = "its first bytes are no text";
  if (LooksLikeText(TextOf(head))) {
    std::string_view line = Trim(TextOf(head));
    begins =
        fmt::format("its first line is {}", Quoted(line.substr(0, line.find_first_of("\r\n")), kQuotedLine));
  }
  return fmt::format("{} is not used: it is named like {}, but lacks {}; {}.", name, named->what, named->mark,
                     begins);
}

}  // namespace skyquilt::flight
