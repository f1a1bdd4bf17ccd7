#include "storage/pmtiles/pmtiles_reader.h"

#include <xxhash.h>

#include "core/base/try.h"

namespace skyquilt::storage {
namespace {

// Our archives have one level of leaves; the specification advises against more than two.
constexpr int kMaxDepth = 4;

}  // namespace

Result<std::shared_ptr<PmtilesReader>> PmtilesReader::Open(std::shared_ptr<BlobStore> blobs,
                                                           const std::string& key,
                                                           std::shared_ptr<PmtilesMemory> memory) {
  std::shared_ptr<PmtilesReader> reader(new PmtilesReader(std::move(blobs), key, std::move(memory)));
  SKYQUILT_TRY_ASSIGN(const std::string head,
                      reader->blobs_->ReadNear(key, 0, static_cast<std::int64_t>(kPmtilesHeadBytes)));
  const auto understand = [&]() -> Result<void> {
    SKYQUILT_TRY_ASSIGN(reader->header_, ParsePmtilesHeader(head));
    const PmtilesHeader& header = reader->header_;
    if (header.root.offset + header.root.bytes > head.size())
      return Error{ErrorCode::kCorrupt, "The map's file mosaic.pmtiles is cut off. Stitch the flight again.",
                   key};
    SKYQUILT_TRY_ASSIGN(reader->root_, ParsePmtilesDirectory(std::string_view(head).substr(
                                           header.root.offset, header.root.bytes)));
    SKYQUILT_TRY_ASSIGN(const std::string metadata, reader->Read(header.metadata, 0, header.metadata.bytes));
    SKYQUILT_TRY_ASSIGN(reader->metadata_, ParsePmtilesMetadata(metadata, header));
    return {};
  };
  const Result<void> understood = understand();
  if (!understood) return reader->Doubted(understood.error());
  return reader;
}

Result<std::string> PmtilesReader::Read(const PmtilesSection& section, std::uint64_t offset,
                                        std::uint64_t length) const {
  const Error outside{ErrorCode::kCorrupt,
                      "The map's file mosaic.pmtiles is damaged. Stitch the flight again.", key_};
  if (offset > section.bytes || length > section.bytes - offset) return outside;
  SKYQUILT_TRY_ASSIGN(std::string bytes,
                      blobs_->ReadNear(key_, static_cast<std::int64_t>(section.offset + offset),
                                       static_cast<std::int64_t>(length)));
  if (bytes.size() != length) return Doubted(outside);
  return bytes;
}

Error PmtilesReader::Doubted(const Error& error) const {
  if (blobs_->IsFolder() || error.code != ErrorCode::kCorrupt) return error;
  blobs_->DoubtNear(key_);
  return {
      ErrorCode::kUnavailable,
      "A part of the map came damaged from the store of photos and maps. Try again later; if it stays so, "
      "stitch the flight again.",
      key_ + ": " + error.message};
}

Result<PmtilesReader::Directory> PmtilesReader::Leaf(const PmtilesEntry& entry) const {
  const std::string name = NameOf('/', entry.offset);
  if (Directory kept = memory_->leaves.Find(name)) return kept;
  SKYQUILT_TRY_ASSIGN(const std::string packed, Read(header_.leaves, entry.offset, entry.length));
  Result<std::vector<PmtilesEntry>> entries = ParsePmtilesDirectory(packed);
  if (!entries) return Doubted(entries.error());
  const std::size_t bytes = sizeof(PmtilesEntry) * entries->size();
  const auto leaf = std::make_shared<const std::vector<PmtilesEntry>>(*std::move(entries));
  memory_->leaves.Keep(name, leaf, bytes);
  return Directory(leaf);
}

Result<std::optional<FoundTile>> PmtilesReader::Find(const geo::TileId& tile) {
  const std::uint64_t number = PmtilesNumber(tile);
  const std::string name = NameOf('@', number);
  if (const std::shared_ptr<const FoundTile> kept = memory_->tiles.Find(name)) return std::optional(*kept);
  std::optional<PmtilesEntry> entry = FindPmtilesEntry(root_, number);
  for (int depth = 0; entry && entry->run == 0; ++depth) {
    if (depth == kMaxDepth)
      return Error{ErrorCode::kCorrupt, "The map's file mosaic.pmtiles leads in circles. Stitch again.",
                   key_};
    SKYQUILT_TRY_ASSIGN(const Directory leaf, Leaf(*entry));
    entry = FindPmtilesEntry(*leaf, number);
  }
  if (!entry) return std::optional<FoundTile>();
  SKYQUILT_TRY_ASSIGN(std::string bytes, Read(header_.tiles, entry->offset, entry->length));
  FoundTile found;
  // As MBTiles of ours name them, so that the tags of tiles do not tell where they came from.
  found.content_id = XXH3_64bits(bytes.data(), bytes.size()) >> 1;
  found.bytes = std::move(bytes);
  const std::size_t size = found.bytes->size();
  memory_->tiles.Keep(name, std::make_shared<const FoundTile>(found), size + sizeof(FoundTile));
  return std::optional<FoundTile>(std::move(found));
}

bool PmtilesReader::IsAtHand(const geo::TileId& tile) const {
  const std::uint64_t number = PmtilesNumber(tile);
  if (memory_->tiles.Has(NameOf('@', number))) return true;
  std::optional<PmtilesEntry> entry = FindPmtilesEntry(root_, number);
  for (int depth = 0; entry && entry->run == 0 && depth < kMaxDepth; ++depth) {
    const Directory leaf = memory_->leaves.Find(NameOf('/', entry->offset));
    if (leaf == nullptr) return false;
    entry = FindPmtilesEntry(*leaf, number);
  }
  return !entry;  // that there is none, is known
}

}  // namespace skyquilt::storage
