#include "storage/pmtiles/pmtiles_directory.h"

#include <algorithm>
#include <span>

#include "core/geo/tile_id.h"
#include "storage/pmtiles/gzip.h"

namespace skyquilt::storage {
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

}  // namespace skyquilt::storage
