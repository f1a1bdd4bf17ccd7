#include "core/flight/logs/tracks/unknown_track.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "core/flight/bytes/text_fields.h"

namespace skyquilt::flight {
namespace {

struct NamedTrack {
  std::string_view ending;
  RemarkCode lacks;  // the mark by which it is known
};

constexpr std::array<NamedTrack, 6> kNamedTracks = {{
    {".gpx", RemarkCode::kNamedAsGpx},
    {".kml", RemarkCode::kNamedAsKml},
    {".geojson", RemarkCode::kNamedAsGeojson},
    {".nmea", RemarkCode::kNamedAsNmea},
    {".srt", RemarkCode::kNamedAsSrt},
    {".ass", RemarkCode::kNamedAsAss},
}};

}  // namespace

std::optional<Remark> ExplainUnknownTrack(LogBytes head, std::string_view name) {
  constexpr std::size_t kQuotedLine = 60;
  const std::string lower = LowerCase(name);
  if (lower.ends_with(".kmz")) return Remark{RemarkCode::kKmzNotRead, {{"file", name}}};
  const auto named = std::find_if(kNamedTracks.begin(), kNamedTracks.end(),
                                  [&](const NamedTrack& track) { return lower.ends_with(track.ending); });
  if (named == kNamedTracks.end()) return std::nullopt;
  Remark begins = RemarkCode::kFirstBytesNoText;
  if (LooksLikeText(TextOf(head))) {
    const std::string_view text = Trim(TextOf(head));
    begins = {RemarkCode::kFirstLineIs,
              {{"text", Quoted(text.substr(0, text.find_first_of("\r\n")), kQuotedLine)}}};
  }
  return Remark{named->lacks, {{"file", name}, {"begins", std::move(begins)}}};
}

}  // namespace skyquilt::flight
