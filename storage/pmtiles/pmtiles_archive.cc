#include "storage/pmtiles/pmtiles_archive.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <limits>
#include <new>
#include <nlohmann/json.hpp>
#include <span>

#include "core/base/check.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "core/image/picture_format.h"
#include "storage/tilesets/tile_source.h"

namespace skyquilt::storage {
namespace {

constexpr int kGzipWindow = 15 + 16;  // zlib's largest, with gzip's head and end

}  // namespace

std::string Gzip(std::string_view bytes, int level) {
  constexpr int kMemoryLevel = 8;
  z_stream stream{};
  if (deflateInit2(&stream, level, Z_DEFLATED, kGzipWindow, kMemoryLevel, Z_DEFAULT_STRATEGY) != Z_OK) {
    throw std::bad_alloc();
  }
  std::string out(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int code = deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  SKYQUILT_CHECK(code == Z_STREAM_END, "a buffer of the asked size did not hold the gzip stream");
  return out;
}

namespace {

constexpr std::size_t kFirstLeafEntries = 4096;

void AppendVarint(std::string& out, std::uint64_t value) {
  while (value >= 0x80) {
    out += static_cast<char>((value & 0x7f) | 0x80);
    value >>= 7;
  }
  out += static_cast<char>(value);
}

std::string Compressed(std::span<const PmtilesEntry> entries) {
  std::string plain;
  AppendVarint(plain, entries.size());
  std::uint64_t last = 0;
  for (const PmtilesEntry& entry : entries) {
    AppendVarint(plain, entry.tile - last);
    last = entry.tile;
  }
  for (const PmtilesEntry& entry : entries) AppendVarint(plain, entry.run);
  for (const PmtilesEntry& entry : entries) AppendVarint(plain, entry.length);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const bool follows = i > 0 && entries[i].offset == entries[i - 1].offset + entries[i - 1].length;
    AppendVarint(plain, follows ? 0 : entries[i].offset + 1);
  }
  return Gzip(plain);
}

}  // namespace

std::uint64_t PmtilesNumber(const geo::TileId& tile) {
  const std::uint64_t coarser = ((std::uint64_t{1} << (2 * tile.z())) - 1) / 3;
  return coarser + geo::HilbertIndex(tile.z(), tile.x(), tile.y());
}

PmtilesDirectories MakePmtilesDirectories(const std::vector<PmtilesEntry>& entries) {
  PmtilesDirectories made;
  made.root = Compressed(entries);
  for (std::size_t leaf_entries = kFirstLeafEntries; made.root.size() > kPmtilesRootBytes;
       leaf_entries *= 2) {
    made.leaves.clear();
    std::vector<PmtilesEntry> root;
    for (std::size_t begin = 0; begin < entries.size(); begin += leaf_entries) {
      const std::size_t count = std::min(leaf_entries, entries.size() - begin);
      const std::string leaf = Compressed(std::span(entries).subspan(begin, count));
      // A run of zero tiles says: the bytes are a leaf directory.
      root.push_back({entries[begin].tile, made.leaves.size(), static_cast<std::uint32_t>(leaf.size()), 0});
      made.leaves += leaf;
    }
    made.root = Compressed(root);
  }
  return made;
}

namespace {

// A leaf of our own has four thousand entries as a rule; one of any writer that is read has up to a million.
constexpr std::size_t kMaxUnpackedBytes = std::size_t{16} << 20;
constexpr std::uint64_t kMaxEntries = 1'000'000;
constexpr std::uint64_t kMaxLeafBytes = std::uint64_t{4} << 20;
constexpr std::uint64_t kMaxArchiveBytes = std::uint64_t{1} << 50;

Error Damaged(const std::string& what) {
  return {ErrorCode::kCorrupt, "The map's file mosaic.pmtiles is damaged. Stitch the flight again.", what};
}

Result<std::string> Unpacked(std::string_view packed) {
  z_stream stream{};
  if (inflateInit2(&stream, kGzipWindow) != Z_OK) throw std::bad_alloc();
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  std::string bytes;
  int code = Z_OK;
  while (code == Z_OK && bytes.size() < kMaxUnpackedBytes) {
    const std::size_t have = bytes.size();
    bytes.resize(std::min(kMaxUnpackedBytes, std::max<std::size_t>(4096, 2 * have)));
    stream.next_out = reinterpret_cast<Bytef*>(bytes.data() + have);
    stream.avail_out = static_cast<uInt>(bytes.size() - have);
    code = inflate(&stream, Z_NO_FLUSH);
    bytes.erase(bytes.size() - stream.avail_out);
  }
  inflateEnd(&stream);
  if (code != Z_STREAM_END) return Damaged("what cannot be unpacked");
  return bytes;
}

// Numbers of seven bits a byte; once something is wrong, it stays wrong.
class Varints {
 public:
  explicit Varints(std::string_view bytes) : bytes_(bytes) {}
  std::uint64_t Next() {
    std::uint64_t value = 0;
    for (int shift = 0; shift < 64; shift += 7) {
      if (at_ >= bytes_.size()) break;
      const auto byte = static_cast<unsigned char>(bytes_[at_++]);
      value |= std::uint64_t{byte & 0x7fu} << shift;
      if (byte < 0x80) return value;
    }
    is_good_ = false;
    return 0;
  }
  bool is_good() const { return is_good_; }
  std::size_t left() const { return bytes_.size() - at_; }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
  bool is_good_ = true;
};

}  // namespace

Result<PmtilesHeader> ParsePmtilesHeader(std::string_view archive) {
  constexpr int kVersion = 3, kGzip = 2, kUncompressed = 1;
  if (archive.size() < kPmtilesHeaderBytes || !archive.starts_with("PMTiles")) return Damaged("no header");
  const PmtilesFields fields(archive);
  if (fields.ByteAt(7) != kVersion || fields.ByteAt(97) != kGzip || fields.ByteAt(98) > kUncompressed) {
    return Error{ErrorCode::kUnsupportedFormat,
                 "The map's file mosaic.pmtiles is of another version, or packed in another way.", ""};
  }
  PmtilesHeader header;
  header.root = fields.SectionAt(8);
  header.metadata = fields.SectionAt(24);
  header.leaves = fields.SectionAt(40);
  header.tiles = fields.SectionAt(56);
  for (const PmtilesSection& section : {header.root, header.metadata, header.leaves, header.tiles}) {
    if (section.offset > kMaxArchiveBytes || section.bytes > kMaxArchiveBytes) return Damaged("a section");
  }
  if (header.root.offset < kPmtilesHeaderBytes || header.root.offset > kPmtilesHeadBytes ||
      header.root.bytes > kPmtilesHeadBytes - header.root.offset || header.root.bytes == 0)
    return Damaged("the root");
  if (header.metadata.bytes > kMaxLeafBytes) return Damaged("the metadata");
  const std::optional<image::PictureFormat> format = image::PictureFormatOfPmtiles(fields.ByteAt(99));
  if (!format)
    return Error{ErrorCode::kUnsupportedFormat, "The tiles of mosaic.pmtiles are no pictures.", ""};
  header.format = image::ExtensionOf(*format);
  header.min_zoom = fields.ByteAt(100);
  header.max_zoom = fields.ByteAt(101);
  if (header.max_zoom > geo::kMaxZoom || header.min_zoom > header.max_zoom) return Damaged("zooms");
  header.west_deg = fields.DegreesAt(102);
  header.south_deg = fields.DegreesAt(106);
  header.east_deg = fields.DegreesAt(110);
  header.north_deg = fields.DegreesAt(114);
  return header;
}

Result<std::vector<PmtilesEntry>> ParsePmtilesDirectory(std::string_view packed) {
  SKYQUILT_TRY_ASSIGN(const std::string bytes, Unpacked(packed));
  Varints numbers(bytes);
  const std::uint64_t count = numbers.Next();
  // Four numbers of at least a byte each.
  if (!numbers.is_good() || count == 0 || count > kMaxEntries || count > numbers.left() / 4)
    return Damaged("a directory");
  std::vector<PmtilesEntry> entries(static_cast<std::size_t>(count));
  constexpr std::uint64_t kLargest = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t tile = 0;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const std::uint64_t step = numbers.Next();
    if ((i > 0 && step == 0) || step > kLargest - tile) return Damaged("tiles out of order");
    tile += step;
    entries[i].tile = tile;
  }
  for (PmtilesEntry& entry : entries) {
    const std::uint64_t run = numbers.Next();
    if (run > std::numeric_limits<std::uint32_t>::max() || run > kLargest - entry.tile)
      return Damaged("a run");
    entry.run = static_cast<std::uint32_t>(run);
  }
  for (PmtilesEntry& entry : entries) {
    const std::uint64_t length = numbers.Next();
    if (length == 0 || length > (entry.run == 0 ? kMaxLeafBytes : kMaxTileBytes)) return Damaged("a length");
    entry.length = static_cast<std::uint32_t>(length);
  }
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const std::uint64_t offset = numbers.Next();
    if ((offset == 0 && i == 0) || offset > kMaxArchiveBytes) return Damaged("an offset");
    entries[i].offset = offset > 0 ? offset - 1 : entries[i - 1].offset + entries[i - 1].length;
  }
  if (!numbers.is_good()) return Damaged("a directory that ends too early");
  return entries;
}

Result<std::map<std::string, std::string>> ParsePmtilesMetadata(std::string_view packed,
                                                                const PmtilesHeader& header) {
  SKYQUILT_TRY_ASSIGN(const std::string text, Unpacked(packed));
  const nlohmann::json json = ParseJson(text);
  if (!json.is_object()) return Damaged("metadata that are no JSON object");
  std::map<std::string, std::string> metadata;
  for (const auto& [name, value] : json.items()) {
    if (value.is_string()) metadata[name] = value.get<std::string>();
    if (value.is_number_integer()) metadata[name] = std::to_string(value.get<std::int64_t>());
  }
  metadata["format"] = header.format;
  metadata["minzoom"] = std::to_string(header.min_zoom);
  metadata["maxzoom"] = std::to_string(header.max_zoom);
  metadata["bounds"] = fmt::format("{:.7f},{:.7f},{:.7f},{:.7f}", header.west_deg, header.south_deg,
                                   header.east_deg, header.north_deg);
  return metadata;
}

std::optional<PmtilesEntry> FindPmtilesEntry(const std::vector<PmtilesEntry>& entries, std::uint64_t tile) {
  auto after =
      std::upper_bound(entries.begin(), entries.end(), tile,
                       [](std::uint64_t value, const PmtilesEntry& entry) { return value < entry.tile; });
  if (after == entries.begin()) return std::nullopt;
  const PmtilesEntry& entry = *std::prev(after);
  if (entry.run != 0 && tile - entry.tile >= entry.run) return std::nullopt;
  return entry;
}

}  // namespace skyquilt::storage
