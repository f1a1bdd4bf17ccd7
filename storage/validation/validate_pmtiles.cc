// PMTiles specification version 3, chapters 3 (header), 4 (directories) and 5 (metadata).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <optional>
#include <system_error>
#include <unordered_set>

#include "core/base/try.h"
#include "core/geo/tile_id.h"
#include "core/image/picture_format.h"
#include "storage/pmtiles/pmtiles_archive.h"
#include "storage/validation/tile_judge.h"
#include "storage/validation/validate_map.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxLeafDepth = 4;
constexpr std::uint64_t kMaxMetadataBytes = std::uint64_t{4} << 20;

// The tile of a number along the Hilbert curves; nothing beyond the finest zoom.
std::optional<geo::TileId> TileOfNumber(std::uint64_t number) {
  int zoom = 0;
  std::uint64_t rest = number;
  for (; zoom <= geo::kMaxZoom && rest >= std::uint64_t{1} << 2 * zoom; ++zoom)
    rest -= std::uint64_t{1} << 2 * zoom;
  if (zoom > geo::kMaxZoom) return std::nullopt;
  std::uint32_t x = 0, y = 0;
  for (int order = 1; order <= zoom; ++order) {
    const std::uint64_t wanted = rest >> 2 * (zoom - order);
    for (std::uint32_t child = 0; child < 4; ++child) {
      const std::uint32_t cx = 2 * x + (child & 1u), cy = 2 * y + (child >> 1);
      if (geo::HilbertIndex(order, cx, cy) != wanted) continue;
      x = cx;
      y = cy;
      break;
    }
  }
  return *geo::TileId::Make(zoom, x, y);
}

class PmtilesCheck {
 public:
  PmtilesCheck(const fs::path& path, bool quick, FileVerdict& verdict, Progress& progress)
      : file_(path, std::ios::binary), verdict_(verdict), judge_(quick), progress_(progress) {
    std::error_code gone;
    const std::uintmax_t bytes = fs::file_size(path, gone);
    bytes_ = gone ? 0 : bytes;
  }

  Result<void> Run() {
    const std::string head = ReadAt(0, kPmtilesHeadBytes);
    if (head.size() < kPmtilesHeaderBytes || !head.starts_with("PMTiles")) {
      verdict_.Add(Severity::kError, "it has no PMTiles header");
      return {};
    }
    const PmtilesFields fields(head);
    if (fields.ByteAt(7) != 3) {
      verdict_.Add(Severity::kError,
                   fmt::format("it is of version {} of PMTiles; version 3 is read", fields.ByteAt(7)));
      return {};
    }
    if (!CheckSections(fields)) return {};
    const TilesetClaims claims = ReadClaims(fields);
    constexpr int kGzipped = 2;
    if (fields.ByteAt(97) != kGzipped) {
      verdict_.Add(Severity::kNote, "its directories are not packed by gzip; they are not looked at");
      return {};
    }
    CheckMetadata();
    SKYQUILT_TRY(Walk(ReadAt(root_.offset, root_.bytes), "the root directory", 0));
    CompareCounts(fields);
    judge_.Finish(claims, verdict_);
    return {};
  }

 private:
  std::string ReadAt(std::uint64_t offset, std::uint64_t bytes) {
    std::string read(static_cast<std::size_t>(bytes), '\0');
    file_.clear();
    file_.seekg(static_cast<std::streamoff>(offset));
    file_.read(read.data(), static_cast<std::streamsize>(read.size()));
    read.resize(static_cast<std::size_t>(std::max<std::streamsize>(file_.gcount(), 0)));
    return read;
  }

  bool CheckSections(const PmtilesFields& fields) {
    struct Named {
      const char* name;
      PmtilesSection section;
    };
    root_ = fields.SectionAt(8);
    metadata_ = fields.SectionAt(24);
    leaves_ = fields.SectionAt(40);
    tiles_ = fields.SectionAt(56);
    std::array<Named, 4> sections{Named{"the root directory", root_}, Named{"the metadata", metadata_},
                                  Named{"the leaf directories", leaves_}, Named{"the tiles", tiles_}};
    bool is_sound = true;
    const auto wrong = [&](std::string what) {
      verdict_.Add(Severity::kError, std::move(what));
      is_sound = false;
    };
    for (const auto& [name, section] : sections) {
      if (section.bytes > bytes_ || section.offset > bytes_ - section.bytes)
        wrong(fmt::format("it is cut off: {} should end at byte {}, and the file has {}", name,
                          section.offset + section.bytes, bytes_));
    }
    if (root_.offset + root_.bytes > kPmtilesHeadBytes)
      wrong("the root directory does not end within the first 16384 bytes");
    std::sort(sections.begin(), sections.end(),
              [](const Named& a, const Named& b) { return a.section.offset < b.section.offset; });
    std::uint64_t end = kPmtilesHeaderBytes;
    const char* before = "the header";
    for (const auto& [name, section] : sections) {
      if (section.bytes == 0) continue;
      if (section.offset < end) wrong(fmt::format("{} and {} lie upon each other", before, name));
      end = section.offset + section.bytes;
      before = name;
    }
    if (metadata_.bytes > kMaxMetadataBytes) wrong("its metadata are larger than 4 MiB");
    return is_sound;
  }

  TilesetClaims ReadClaims(const PmtilesFields& fields) {
    TilesetClaims claims;
    const int type = fields.ByteAt(99);
    const std::optional<image::PictureFormat> format = image::PictureFormatOfPmtiles(type);
    are_pictures_ = format && fields.ByteAt(98) <= 1;
    if (are_pictures_) {
      claims.format = image::ExtensionOf(*format);
    } else {
      verdict_.Add(Severity::kNote,
                   fmt::format("its tiles are {}; what is in them is not looked at",
                               type == 1   ? "vector tiles"
                               : type == 5 ? "AVIF pictures"
                                           : fmt::format("of type {}, packing {}", type, fields.ByteAt(98))));
    }
    claims.min_zoom = fields.ByteAt(100);
    claims.max_zoom = fields.ByteAt(101);
    claims.bounds = geo::LatLonBounds{fields.DegreesAt(102), fields.DegreesAt(106), fields.DegreesAt(110),
                                      fields.DegreesAt(114)};
    const double lon = fields.DegreesAt(119), lat = fields.DegreesAt(123);
    constexpr double kSlackDeg = 1e-6;
    const geo::LatLonBounds& b = *claims.bounds;
    if (lon < b.west_deg - kSlackDeg || lon > b.east_deg + kSlackDeg || lat < b.south_deg - kSlackDeg ||
        lat > b.north_deg + kSlackDeg)
      verdict_.Add(Severity::kWarning, "its centre lies outside of its bounds");
    is_clustered_ = fields.ByteAt(96) == 1;
    return claims;
  }

  void CheckMetadata() {
    PmtilesHeader header;
    header.format = "jpg";
    if (!ParsePmtilesMetadata(ReadAt(metadata_.offset, metadata_.bytes), header))
      verdict_.Add(Severity::kError, "its metadata are no JSON object packed by gzip");
  }

  Result<void> Walk(const std::string& packed, const std::string& name, int depth) {
    const auto entries = ParsePmtilesDirectory(packed);
    if (!entries) {
      verdict_.Add(Severity::kError, name + " is damaged: " + entries.error().detail);
      return {};
    }
    for (std::size_t i = 0; i < entries->size(); ++i) {
      if (progress_.IsCancelled()) return Error{ErrorCode::kCancelled, "Cancelled.", ""};
      const PmtilesEntry& entry = (*entries)[i];
      if (entry.run == 0) {
        SKYQUILT_TRY(WalkLeaf(entry, depth));
        continue;
      }
      if (++entries_ > kMaxEntries) {
        verdict_.Add(Severity::kError,
                     "its directories have more entries than any map: they lead in circles");
        return Error{ErrorCode::kCorrupt, "", ""};
      }
      if (entry.tile < next_tile_)
        judge_.counted().Add(Severity::kError, "entries are out of order, or overlap the one before",
                             fmt::format("tile number {}", entry.tile));
      next_tile_ = entry.tile + entry.run;
      Take(entry);
      progress_.Report(std::min(1.0, static_cast<double>(seen_bytes_) /
                                         static_cast<double>(std::max<std::uint64_t>(tiles_.bytes, 1))),
                       "looking at tiles");
    }
    return {};
  }

  Result<void> WalkLeaf(const PmtilesEntry& entry, int depth) {
    const std::string name = fmt::format("the leaf directory from tile number {} on", entry.tile);
    if (depth >= kMaxLeafDepth || ++leaf_count_ > kMaxLeaves) {
      verdict_.Add(Severity::kError, name + " lies too deep; directories lead in circles");
      return Error{ErrorCode::kCorrupt, "", ""};
    }
    if (entry.length > leaves_.bytes || entry.offset > leaves_.bytes - entry.length) {
      verdict_.Add(Severity::kError, name + " lies beyond the leaf directories");
      return {};
    }
    return Walk(ReadAt(leaves_.offset + entry.offset, entry.length), name, depth + 1);
  }

  void Take(const PmtilesEntry& entry) {
    const auto first = TileOfNumber(entry.tile);
    if (!first) {
      judge_.counted().Add(Severity::kError, "tiles lie nowhere: their number is beyond zoom 30",
                           fmt::format("tile number {}", entry.tile));
      return;
    }
    for (std::uint64_t k = 0; k < entry.run && addressed_ < kMaxAddressed && !progress_.IsCancelled();
         ++k, ++addressed_) {
      if (const auto tile = TileOfNumber(entry.tile + k)) judge_.Cover(*tile);
    }
    if (entry.length > tiles_.bytes || entry.offset > tiles_.bytes - entry.length) {
      judge_.counted().Add(Severity::kError, "tiles lie beyond the end of the tiles' section",
                           TileJudge::NameOf(*first));
      return;
    }
    if (!contents_.insert(entry.offset).second) return;
    if (is_clustered_ && entry.offset != seen_bytes_)
      judge_.counted().Add(Severity::kWarning,
                           "tiles are not in the order that the header promises (clustered)",
                           TileJudge::NameOf(*first));
    seen_bytes_ = entry.offset + entry.length;
    if (are_pictures_) judge_.LookAt(*first, ReadAt(tiles_.offset + entry.offset, entry.length));
  }

  void CompareCounts(const PmtilesFields& fields) {
    const auto compare = [&](std::size_t at, std::uint64_t is, const char* name) {
      const auto said = fields.At<std::uint64_t>(at);
      if (said != 0 && said != is)  // zero: unknown
        verdict_.Add(Severity::kError,
                     fmt::format("the header counts {} {}, and there are {}", said, name, is));
    };
    if (addressed_ >= kMaxAddressed) return;
    compare(72, addressed_, "tiles");
    compare(80, entries_, "entries");
    compare(88, contents_.size(), "pictures");
  }

  static constexpr std::uint64_t kMaxAddressed = 20'000'000, kMaxEntries = 50'000'000, kMaxLeaves = 1'000'000;

  std::ifstream file_;
  std::uint64_t bytes_ = 0;
  FileVerdict& verdict_;
  TileJudge judge_;
  Progress& progress_;
  PmtilesSection root_, metadata_, leaves_, tiles_;
  bool are_pictures_ = false, is_clustered_ = false;
  std::uint64_t next_tile_ = 0, seen_bytes_ = 0, addressed_ = 0, entries_ = 0, leaf_count_ = 0;
  std::unordered_set<std::uint64_t> contents_;
};

}  // namespace

Result<FileVerdict> ValidatePmtiles(const fs::path& path, bool quick, Progress& progress) {
  FileVerdict verdict;
  verdict.file = path.filename().string();
  verdict.kind = "PMTiles";
  const Result<void> run = PmtilesCheck(path, quick, verdict, progress).Run();
  if (!run && run.error().code == ErrorCode::kCancelled) return run.error();
  return verdict;
}

}  // namespace skyquilt::storage
