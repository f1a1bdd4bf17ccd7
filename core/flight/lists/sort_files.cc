#include "core/flight/lists/sort_files.h"

#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/digest.h"
#include "core/base/try.h"
#include "core/flight/aside/aside.h"
#include "core/flight/bytes/byte_source.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/lists/file_kinds.h"
#include "core/flight/lists/reflectance_list.h"
#include "core/flight/logs/explain_unknown.h"
#include "core/flight/logs/read_log.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::flight {
namespace {

// Pictures outnumber logs by far and need no further look.
bool IsPicture(const std::vector<std::uint8_t>& head) {
  constexpr std::array<std::string_view, 5> kMagic = {"\xFF\xD8\xFF", std::string_view("II*\0", 4),
                                                      std::string_view("MM\0*", 4), "\x89PNG", "RIFF"};
  const std::string_view text = TextOf(head);
  return text.substr(std::min<std::size_t>(4, text.size())).starts_with("ftyp") ||
         !RawFormatOf(head).empty() || std::any_of(kMagic.begin(), kMagic.end(), [&](std::string_view magic) {
           return text.starts_with(magic);
         });
}

// Endings of the logs that are read here, of the formats that nothing else uses them for.
constexpr std::array<std::string_view, 6> kLogEndings = {".bin", ".ulg", ".tlog", ".mrk", ".srt", ".ass"};

// Endings of pictures and films, whatever the file holds.
constexpr std::array<std::string_view, 24> kPictureEndings = {
    ".jpg", ".jpeg", ".jpe", ".tif", ".tiff", ".png", ".dng", ".heic", ".heif", ".webp", ".avif", ".gif",
    ".bmp", ".raw",  ".arw", ".cr2", ".cr3",  ".nef", ".orf", ".raf",  ".rw2",  ".mp4",  ".mov",  ".seq"};

// Endings of what else lies in a flight's folder and is nobody's fault: side files, notes.
constexpr std::array<std::string_view, 32> kSideEndings = {
    ".log", ".csv", ".tsv", ".txt", ".nav", ".obs", ".pos", ".dat",     ".json",      ".kml", ".kmz",
    ".gpx", ".xml", ".p4d", ".rtk", ".ubx", ".rnx", ".md",  ".rtcm3",   ".pdf",       ".ini", ".db",
    ".prj", ".xmp", ".rtb", ".rpt", ".bbx", ".bb3", ".sbf", ".geojson", ".waypoints", ".nmea"};

bool EndsWithOneOf(std::string_view name, std::span<const std::string_view> endings) {
  const std::string lower = LowerCase(name);
  return std::any_of(endings.begin(), endings.end(),
                     [&](std::string_view ending) { return lower.ends_with(ending); });
}

// Where a file goes; null: it is not used.
using Place = std::vector<InputFile> SortedFiles::*;

Result<Place> PlaceOf(const InputFile& file) {
  const bool is_log_by_name = EndsWithOneOf(file.name, kLogEndings);
  const Place unknown =
      is_log_by_name || EndsWithOneOf(file.name, kSideEndings) ? nullptr : &SortedFiles::photos;
  const auto source = OpenFileBytes(file.path);
  if (!source) return unknown;  // reading it as a photo tells why
  constexpr std::size_t kEnoughForMagic = 16;
  std::vector<std::uint8_t> head = (*source)->ReadUpTo(0, kEnoughForMagic);
  if (head.empty() && unknown == nullptr) {
    return Because(ErrorCode::kCorrupt, {RemarkCode::kFileEmpty, {{"file", file.name}}});
  }
  if (head.empty()) return unknown;
  if (IsElevationModel(**source)) return &SortedFiles::elevation_models;
  if (LooksLikeFilm(TextOf(head))) return &SortedFiles::films;
  if (IsPicture(head)) return &SortedFiles::photos;
  head = (*source)->ReadUpTo(0, kRecogniseBytes);
  SKYQUILT_TRY_ASSIGN(const auto format, RecogniseLog(head, file.name));
  SKYQUILT_TRY_ASSIGN(const auto text, LogText::Of(file.name, head));
  if (!format) {
    if (auto why = ExplainUnknownTrack(text.bytes(), file.name))
      return Because(ErrorCode::kUnsupportedFormat, *std::move(why));
  }
  if (!format && is_log_by_name) {
    return Because(ErrorCode::kUnsupportedFormat, {RemarkCode::kFileNamedAsLog, {{"file", file.name}}});
  }
  // A licence, a note, a list without an ending: nobody meant it to be a photo, so that none is missing.
  const bool is_note = LooksLikeText(TextOf(text.bytes())) && !EndsWithOneOf(file.name, kPictureEndings);
  if (!format && (unknown == nullptr || is_note)) {
    if (auto why = ExplainUnknownTable(text.bytes(), file.name))
      return Because(ErrorCode::kUnsupportedFormat, *std::move(why));
    if (auto why = ExplainUnknownList(text.bytes(), file.name))
      return Because(ErrorCode::kUnsupportedFormat, *std::move(why));
  }
  if (!format) return is_note ? nullptr : unknown;
  return *format == LogKind::kGcpList ? &SortedFiles::gcp_lists : &SortedFiles::logs;
}

// XMP in a file of its own.
bool IsSidecar(const InputFile& file) {
  if (!LowerCase(file.name).ends_with(".xmp")) return false;
  const auto source = OpenFileBytes(file.path);
  if (!source) return false;
  constexpr std::size_t kStart = 4096;
  const std::vector<std::uint8_t> start = (*source)->ReadUpTo(0, kStart);
  return HoldsOneOf(TextOf(start), {"<x:xmpmeta", "<rdf:RDF"});
}

Remark NotUsed(const std::vector<std::string>& names) {
  constexpr std::size_t kMaxNamed = 10;
  std::string files = names.front();
  for (std::size_t i = 1; i < std::min(names.size(), kMaxNamed); ++i) files += ", " + names[i];
  if (names.size() <= kMaxNamed) return {RemarkCode::kFilesUnknown, {{"files", files}}};
  return {RemarkCode::kFilesUnknownAndMore, {{"files", files}, {"more", names.size() - kMaxNamed}}};
}

}  // namespace

SortedFiles SortFiles(const std::vector<InputFile>& files) {
  SortedFiles sorted;
  std::vector<std::string> unused;
  std::size_t unread_tables = 0;
  constexpr std::size_t kMaxTablesExplained = 10;
  for (const InputFile& file : files) {
    if (LowerCase(file.name).ends_with(kMapNotesName)) continue;  // for who looks at the map
    if (IsReflectanceList(file.name)) {
      sorted.reflectance_lists.push_back(file);
      continue;
    }
    if (IsSidecar(file)) {
      sorted.sidecars.push_back(file);
      continue;
    }
    const auto place = PlaceOf(file);
    if (!place && place.error().code == ErrorCode::kUnsupportedFormat &&
        ++unread_tables > kMaxTablesExplained) {
      unused.push_back(file.name);
    } else if (!place) {
      sorted.refused.push_back({RemarkCode::kFileNotRead, {{"why", WhyOf(place.error())}}});
    } else if (*place != nullptr) {
      (sorted.*(*place)).push_back(file);
    } else {
      unused.push_back(file.name);
    }
  }
  if (!unused.empty()) sorted.unused = NotUsed(unused);
  return sorted;
}

namespace {

using Fingerprint = std::pair<std::uint64_t, std::uint64_t>;  // size, hash of the start

std::optional<Fingerprint> FingerprintOf(const std::filesystem::path& path) {
  constexpr std::size_t kStart = 1 << 16;  // holds the time of capture and the position
  auto source = OpenFileBytes(path);
  if (!source) return std::nullopt;
  const auto start = (*source)->ReadUpTo(0, kStart);
  if (start.empty()) return std::nullopt;
  return Fingerprint{(*source)->size(), XXH3_64bits(start.data(), start.size())};
}

bool HaveSameBytes(const std::filesystem::path& first, const std::filesystem::path& second) {
  auto a = OpenFileBytes(first);
  auto b = OpenFileBytes(second);
  if (!a || !b || (*a)->size() != (*b)->size()) return false;
  constexpr std::size_t kBlock = 1 << 20;
  for (std::uint64_t offset = 0; offset < (*a)->size(); offset += kBlock) {
    const auto block = (*a)->ReadUpTo(offset, kBlock);
    if (block.empty() || block != (*b)->ReadUpTo(offset, kBlock)) return false;
  }
  return true;
}

}  // namespace

std::vector<std::optional<std::size_t>> FindDuplicates(const std::vector<InputFile>& files) {
  std::vector<std::optional<std::size_t>> duplicate_of(files.size());
  std::map<std::uint64_t, std::vector<std::size_t>> by_size;
  for (std::size_t i = 0; i < files.size(); ++i) {
    std::error_code error;
    const auto size = std::filesystem::file_size(files[i].path, error);
    if (!error) by_size[size].push_back(i);
  }
  for (const auto& [size, same_size] : by_size) {
    if (same_size.size() < 2) continue;
    std::map<Fingerprint, std::vector<std::size_t>> alike;
    for (const std::size_t i : same_size) {
      if (const auto fingerprint = FingerprintOf(files[i].path)) alike[*fingerprint].push_back(i);
    }
    for (const auto& [fingerprint, candidates] : alike) {
      if (candidates.size() < 2) continue;
      // Each is read once for its digest, and once more beside the first that has the same.
      std::map<Digest, std::size_t> firsts;
      for (const std::size_t i : candidates) {
        const Result<Digest> digest = DigestOfFile(files[i].path);
        if (!digest) continue;
        const auto [first, is_new] = firsts.try_emplace(*digest, i);
        if (!is_new && HaveSameBytes(files[first->second].path, files[i].path))
          duplicate_of[i] = first->second;
      }
    }
  }
  return duplicate_of;
}

}  // namespace skyquilt::flight
