#include "storage/exports/pmtiles_writer.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>
#include <optional>

#include "storage/pmtiles/pmtiles_archive.h"
#include "storage/tilesets/mbtiles_reader.h"
#include "storage/tilesets/mbtiles_writer.h"
#include "tests/storage/painted_tileset.h"
#include "tests/support/bytes_of.h"
#include "tests/support/temporary_folder.h"

namespace skyquilt::storage {
namespace {

std::string Gunzip(std::string_view bytes) {
  z_stream stream{};
  EXPECT_EQ(inflateInit2(&stream, 15 + 16), Z_OK);
  std::string out(std::size_t{1} << 24, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(stream.total_out);
  inflateEnd(&stream);
  return out;
}

std::vector<PmtilesEntry> ParseDirectory(const std::string& bytes) {
  std::size_t at = 0;
  const auto varint = [&] {
    std::uint64_t value = 0;
    for (int shift = 0;; shift += 7) {
      const auto byte = static_cast<std::uint8_t>(bytes.at(at++));
      value |= std::uint64_t{byte & 0x7fu} << shift;
      if (byte < 0x80) return value;
    }
  };
  std::vector<PmtilesEntry> entries(varint());
  std::uint64_t tile = 0;
  for (auto& entry : entries) entry.tile = tile += varint();
  for (auto& entry : entries) entry.run = static_cast<std::uint32_t>(varint());
  for (auto& entry : entries) entry.length = static_cast<std::uint32_t>(varint());
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const std::uint64_t offset = varint();
    entries[i].offset = offset > 0 ? offset - 1 : entries[i - 1].offset + entries[i - 1].length;
  }
  return entries;
}

std::optional<PmtilesEntry> Holding(const std::vector<PmtilesEntry>& entries, std::uint64_t tile) {
  std::optional<PmtilesEntry> last;
  for (const auto& entry : entries) {
    if (entry.tile <= tile) last = entry;
  }
  if (last && last->run > 0 && tile >= last->tile + last->run) return std::nullopt;
  return last;
}

// A reader after the specification's words, independent of the writer.
struct Archive {
  std::string bytes;
  std::uint64_t Number(std::size_t at) const {
    std::uint64_t value = 0;
    std::memcpy(&value, bytes.data() + at, 8);
    return value;
  }
  std::string Section(std::size_t place_at) const {
    return bytes.substr(Number(place_at), Number(place_at + 8));
  }
  std::optional<std::string> Tile(std::uint64_t number) const {
    auto entry = Holding(ParseDirectory(Gunzip(Section(8))), number);
    if (entry && entry->run == 0) {
      entry = Holding(ParseDirectory(Gunzip(Section(40).substr(entry->offset, entry->length))), number);
    }
    if (!entry) return std::nullopt;
    return bytes.substr(Number(56) + entry->offset, entry->length);
  }
};

TEST(PmtilesNumber, CountsAsTheSpecificationsTable) {
  // The examples of the specification, chapter 3.3.
  EXPECT_EQ(PmtilesNumber(*geo::TileId::Make(0, 0, 0)), 0u);
  EXPECT_EQ(PmtilesNumber(*geo::TileId::Make(1, 0, 0)), 1u);
  EXPECT_EQ(PmtilesNumber(*geo::TileId::Make(1, 0, 1)), 2u);
  EXPECT_EQ(PmtilesNumber(*geo::TileId::Make(1, 1, 1)), 3u);
  EXPECT_EQ(PmtilesNumber(*geo::TileId::Make(1, 1, 0)), 4u);
  EXPECT_EQ(PmtilesNumber(*geo::TileId::Make(2, 0, 0)), 5u);
  EXPECT_EQ(PmtilesNumber(*geo::TileId::Make(12, 3423, 1763)), 19078479u);
}

TEST(WritePmtiles, HoldsExactlyTheTilesOfTheTileset) {
  test::TemporaryFolder folder;
  const test::PaintedTileset tileset{18, 256, 1001, 2002, 7, 6};
  WritePaintedTileset(folder.path() / "map.mbtiles", tileset);
  SilentProgress progress;
  ASSERT_TRUE(WritePmtiles(folder.path() / "map.mbtiles", folder.path() / "map.pmtiles", progress));
  const Archive archive{test::BytesOf(folder.path() / "map.pmtiles")};
  EXPECT_EQ(archive.bytes.substr(0, 8), std::string("PMTiles\x03", 8));
  EXPECT_EQ(Gunzip(archive.Section(24)).find("\"name\":\"painted \\\"map\\\"\""), 1u);
  auto tiles = *MbtilesReader::Open(folder.path() / "map.mbtiles");
  std::uint64_t held = 0;
  for (int zoom = 14; zoom <= 18; ++zoom) {
    const int up = 18 - zoom;
    for (int y = (2000 >> up) - 1; y <= (2010 >> up) + 1; ++y) {
      for (int x = (1000 >> up) - 1; x <= (1010 >> up) + 1; ++x) {
        const auto id = *geo::TileId::Make(zoom, x, y);
        const auto found = *tiles->Find(id);
        const auto packed = archive.Tile(PmtilesNumber(id));
        ASSERT_EQ(packed.has_value(), found.has_value()) << zoom << "/" << x << "/" << y;
        if (!found) continue;
        ++held;
        EXPECT_EQ(*packed, *tiles->Load(*found));
      }
    }
  }
  EXPECT_GT(held, 30u);
}

TEST(WritePmtiles, StoresEqualTilesOnceAndEqualNeighboursAsARun) {
  test::TemporaryFolder folder;
  auto writer = *MbtilesWriter::Create(folder.path() / "map.mbtiles");
  const std::vector<std::uint8_t> sea{0xff, 0xd8, 0xff, 1, 2, 3};
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 8; ++y)
      ASSERT_TRUE(writer->Put(*geo::TileId::Make(3, x, y), image::PictureFormat::kJpeg, sea));
  }
  TilesetMetadata metadata;
  metadata.min_zoom = metadata.max_zoom = 3;
  ASSERT_TRUE(writer->Publish(metadata));
  SilentProgress progress;
  ASSERT_TRUE(WritePmtiles(folder.path() / "map.mbtiles", folder.path() / "map.pmtiles", progress));
  const Archive archive{test::BytesOf(folder.path() / "map.pmtiles")};
  EXPECT_EQ(archive.Number(64), sea.size());
  EXPECT_EQ(archive.Number(72), 64u);
  EXPECT_EQ(archive.Number(80), 1u);
  EXPECT_EQ(archive.Number(88), 1u);
}

TEST(WritePmtiles, TakesATileSizeThatIsNoNumberForTheUsualOne) {
  test::TemporaryFolder folder;
  test::WritePaintedTileset(folder / "map.mbtiles", {18, 256, 1001, 2002, 7, 6});
  ASSERT_TRUE(SqliteDb::Open(folder / "map.mbtiles", OpenMode::kReadWrite)
                  ->Exec("UPDATE metadata SET value='wide' WHERE name='tile_size'"));
  SilentProgress progress;
  ASSERT_TRUE(WritePmtiles(folder / "map.mbtiles", folder / "map.pmtiles", progress));
  const Archive archive{test::BytesOf(folder / "map.pmtiles")};
  EXPECT_NE(Gunzip(archive.Section(24)).find("\"tile_size\":256"), std::string::npos);
}

TEST(PmtilesDirectories, SplitIntoLeavesWhenTheRootGrowsTooLarge) {
  std::vector<PmtilesEntry> entries;
  std::uint64_t offset = 0, tile = 0;
  for (std::uint32_t i = 0; i < 100'000; ++i) {
    const std::uint32_t length = 1000 + (i * 2654435761u) % 30'000;
    tile += 1 + (i * 40503u) % 7;
    entries.push_back({tile, offset, length, 1});
    offset += length;
  }
  const PmtilesDirectories made = MakePmtilesDirectories(entries);
  EXPECT_LE(made.root.size(), kPmtilesRootBytes);
  std::vector<PmtilesEntry> read;
  for (const PmtilesEntry& leaf : ParseDirectory(Gunzip(made.root))) {
    ASSERT_EQ(leaf.run, 0u);
    const auto part = ParseDirectory(Gunzip(made.leaves.substr(leaf.offset, leaf.length)));
    ASSERT_EQ(part.front().tile, leaf.tile);
    read.insert(read.end(), part.begin(), part.end());
  }
  ASSERT_EQ(read.size(), entries.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    ASSERT_EQ(read[i].tile, entries[i].tile);
    ASSERT_EQ(read[i].offset, entries[i].offset);
    ASSERT_EQ(read[i].length, entries[i].length);
  }
}

}  // namespace
}  // namespace skyquilt::storage
