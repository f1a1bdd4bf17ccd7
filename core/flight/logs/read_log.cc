#include "core/flight/logs/read_log.h"

#include <algorithm>
#include <array>

#include "core/base/try.h"
#include "core/flight/bytes/byte_source.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/texts/gcp_list.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::flight {
namespace {

using Recognises = bool (*)(LogBytes head);
using Parse = Result<FlightLog> (*)(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed);

struct Format {
  Recognises recognises;
  Parse parse;             // null: a list of points, no flight log
  bool is_binary = false;  // the others are asked of text alone
};

// In the order of certainty: the first that fits is meant. The tolerant CSV fits most and comes last.
constexpr std::array kFormats = {
    Format{LooksLikeUlog, ParseUlog, true},
    Format{LooksLikeDataflash, ParseDataflash, true},
    Format{LooksLikeMavlinkTlog, ParseMavlinkTlog, true},
    Format{LooksLikeDataflashText, ParseDataflashText},
    Format{LooksLikeGpx, ParseGpx},
    Format{LooksLikeKml, ParseKml},
    Format{LooksLikeGeoJson, ParseGeoJson},
    Format{LooksLikeSenseflyGeoinfo, ParseSenseflyGeoinfo},
    Format{LooksLikeDjiMrk, ParseDjiMrk},
    Format{LooksLikeDjiSrt, ParseDjiSrt},
    Format{LooksLikeAss, ParseAss},
    Format{LooksLikeRtklibPos, ParseRtklibPos},
    Format{LooksLikeNmea, ParseNmea},
    Format{LooksLikeGeoTxt, ParseGeoTxt},
    Format{LooksLikeGcpList, nullptr},
    Format{LooksLikeFlightCsv, ParseFlightCsv},
    Format{LooksLikeImagesCsv, ParseImagesCsv},
    Format{LooksLikeNamedPlaces, ParseTolerantCsv},
    Format{LooksLikePix4dCsv, ParsePix4dCsv},
    Format{LooksLikeTolerantCsv, ParseTolerantCsv},
};

const Format* Recognise(LogBytes head) {
  const bool is_text = LooksLikeText(TextOf(head));
  for (const Format& format : kFormats) {
    if ((is_text || format.is_binary) && format.recognises(head)) return &format;
  }
  return nullptr;
}

// DJI's own flight records hold no text and no header we could check, but their names are fixed.
bool IsDjiFlightRecord(LogBytes head, std::string_view name) {
  const std::string lower = LowerCase(name);
  const std::string_view base = std::string_view(lower).substr(lower.find_last_of('/') + 1);
  const bool named = (base.starts_with("djiflightrecord") && base.ends_with(".txt")) ||
                     (base.starts_with("fly") && base.ends_with(".dat"));
  return named && !LooksLikeText(TextOf(head));
}

// What a ground station plans, before anything is flown: Mission Planner's waypoints, QGroundControl's plan.
bool IsPlannedRoute(std::string_view text) {
  text = Trim(text);
  const bool is_plan = text.starts_with('{') && text.find("\"fileType\"") != std::string_view::npos &&
                       text.find("\"Plan\"") != std::string_view::npos;
  return text.starts_with("QGC WPL") || is_plan;
}

// A watch's or a cycle computer's track (FIT SDK, file header).
bool IsFit(LogBytes head) { return head.size() >= 12 && TextOf(head).substr(8, 4) == ".FIT"; }

// A table as Excel, Calc and Numbers save it by themselves. OPC (ECMA-376, part 2) and ODF (OASIS, part 2)
// are zips whose first entry is called so; others than tables look alike, and are none that is read either.
bool IsOfficeDocument(LogBytes head, std::string_view name) {
  constexpr std::size_t kFirstNameAt = 30;  // APPNOTE.TXT 6.3, section 4.3.7
  const std::string_view text = TextOf(head);
  const std::string lower = LowerCase(name);
  if (text.starts_with("\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1")) return lower.ends_with(".xls");
  if (!text.starts_with("PK\3\4") || text.size() < kFirstNameAt) return false;
  return lower.ends_with(".numbers") ||
         StartsWithOneOf(text.substr(kFirstNameAt), {"[Content_Types].xml", "_rels/", "docProps/", "xl/",
                                                     "mimetypeapplication/vnd.oasis.opendocument."});
}

// What a receiver observed, before any position was computed of it: RTCM 3 (RTCM 10403, transport layer).
bool IsRtcm3(LogBytes head, std::string_view name) {
  constexpr std::size_t kHeader = 3, kParity = 3;
  const auto begins_at = [&](std::size_t at) {
    return at + kHeader <= head.size() && head[at] == 0xD3 && (head[at + 1] & 0xFC) == 0;
  };
  if (!begins_at(0)) return false;
  if (LowerCase(name).find("ppkraw") != std::string::npos) return true;
  const std::size_t length = 256U * (head[1] & 0x03U) + head[2];
  return begins_at(kHeader + length + kParity);
}

Result<const Format*> RecogniseOrExplain(LogBytes head, std::string_view name) {
  const auto refuse = [&](RemarkCode why) {
    return Because(ErrorCode::kUnsupportedFormat, {why, {{"file", name}}});
  };
  if (IsPlannedRoute(TextOf(head))) return refuse(RemarkCode::kFileIsPlan);
  if (IsFit(head)) return refuse(RemarkCode::kFileIsFit);
  if (IsOfficeDocument(head, name)) return refuse(RemarkCode::kFileIsOffice);
  if (IsRtcm3(head, name)) return refuse(RemarkCode::kFileIsObservations);
  if (IsDjiFlightRecord(head, name)) return refuse(RemarkCode::kFileEncrypted);
  return Recognise(head);
}

}  // namespace

Result<std::optional<LogKind>> RecogniseLog(LogBytes head, std::string_view name) {
  SKYQUILT_TRY_ASSIGN(const auto text, LogText::Of(name, head));
  SKYQUILT_TRY_ASSIGN(const auto format, RecogniseOrExplain(text.bytes(), name));
  if (format == nullptr) return std::optional<LogKind>();
  return std::optional(format->parse == nullptr ? LogKind::kGcpList : LogKind::kFlight);
}

Result<FlightLog> ParseLog(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed) {
  if (bytes.empty()) {
    return Because(ErrorCode::kCorrupt, {RemarkCode::kFileEmpty, {{"file", name}}});
  }
  SKYQUILT_TRY_ASSIGN(const auto text, LogText::Of(name, bytes));
  const LogBytes head = text.bytes().first(std::min(text.bytes().size(), kRecogniseBytes));
  SKYQUILT_TRY_ASSIGN(const auto format, RecogniseOrExplain(head, name));
  if (format == nullptr) {
    return Because(ErrorCode::kUnsupportedFormat, {RemarkCode::kFileIsNoLog, {{"file", name}}});
  }
  if (format->parse == nullptr) {
    return Because(ErrorCode::kUnsupportedFormat, {RemarkCode::kFileIsPointList, {{"file", name}}});
  }
  // Offsets into decoded text are none into the file.
  return format->parse(name, text.bytes(), text.is_decoded() ? ConsumedUpTo() : consumed);
}

Result<FlightLog> ReadLog(const InputFile& file) {
  SKYQUILT_TRY_ASSIGN(const auto mapped, MappedFile::Open(file.path));
  return ParseLog(file.name, mapped.bytes(), [&](std::size_t offset) { mapped.ReleaseBefore(offset); });
}

}  // namespace skyquilt::flight
