#include "storage/exports/streamed/streamed_file.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdlib>
#include <random>

#include "core/image/picture_codec.h"
#include "storage/exports/cog_writer.h"
#include "storage/exports/pmtiles_writer.h"
#include "storage/exports/stored_tiles.h"
#include "storage/exports/streamed/cog_cells.h"
#include "storage/exports/streamed/streamed_maps.h"
#include "storage/files/publish_file.h"
#include "storage/tilesets/mbtiles_reader.h"
#include "storage/tilesets/mbtiles_writer.h"
#include "tests/storage/painted_tileset.h"
#include "tests/storage/rasters/raster_by_gdal.h"
#include "tests/support/bytes_of.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

using test::PaintedTileset;

std::string ReadAll(const OpenStreamed& streamed, std::uint64_t offset, std::uint64_t length,
                    std::size_t slice) {
  StreamedReader reader(streamed.file, streamed.tiles, offset, length);
  EXPECT_EQ(reader.length(), length);
  std::string all;
  std::vector<std::uint8_t> buffer(slice);
  while (true) {
    const Result<std::size_t> got = reader.Read(buffer);
    EXPECT_TRUE(got.ok()) << (got ? "" : got.error().message);
    if (!got || *got == 0) return all;
    all.append(reinterpret_cast<const char*>(buffer.data()), *got);
  }
}

class StreamedFileTest : public testing::Test {
 protected:
  std::filesystem::path Painted(const PaintedTileset& tileset) const {
    const std::filesystem::path path = folder_.path() / "map.mbtiles";
    std::filesystem::remove(path);
    WritePaintedTileset(path, tileset);
    return path;
  }

  test::TemporaryFolder folder_;
  StreamedMaps maps_;
};

constexpr PaintedTileset kPainted{18, 256, 1001, 2002, 9, 7};

TEST_F(StreamedFileTest, EveryRangeIsThatOfTheWhole) {
  const auto mbtiles = Painted(kPainted);
  for (const StreamedFormat format : {StreamedFormat::kPmtiles, StreamedFormat::kGeotiff}) {
    const auto streamed = test::ValueOf(maps_.Open(mbtiles, "a", format));
    const std::uint64_t length = streamed.file->length();
    const std::string whole = ReadAll(streamed, 0, length, 1 << 20);
    ASSERT_EQ(whole.size(), length);
    EXPECT_TRUE(ReadAll(streamed, 0, length, 777) == whole);
    std::mt19937_64 random(7);
    for (int i = 0; i < 200; ++i) {
      const std::uint64_t offset = random() % length;
      const std::uint64_t wanted = std::min<std::uint64_t>(1 + random() % 30000, length - offset);
      ASSERT_TRUE(ReadAll(streamed, offset, wanted, 4096) == whole.substr(offset, wanted)) << offset;
    }
    // The borders of pieces, where one begins and the one before ends.
    for (std::size_t i = 0; i < streamed.file->PieceCount(); ++i) {
      const std::uint64_t begins = streamed.file->Piece(i).offset;
      ASSERT_TRUE(ReadAll(streamed, begins - 1, 2, 2) == whole.substr(begins - 1, 2)) << i;
    }
    EXPECT_EQ(ReadAll(streamed, length, 0, 10), "");
  }
}

TEST_F(StreamedFileTest, PmtilesAreWhatTheWriterWrites) {
  const auto mbtiles = Painted(kPainted);
  SilentProgress progress;
  ASSERT_TRUE(WritePmtiles(mbtiles, folder_.path() / "map.pmtiles", progress));
  const auto streamed = test::ValueOf(maps_.Open(mbtiles, "a", StreamedFormat::kPmtiles));
  EXPECT_TRUE(ReadAll(streamed, 0, streamed.file->length(), 5000) ==
              test::BytesOf(folder_.path() / "map.pmtiles"));
}

std::vector<std::uint8_t> Pixels(GDALRasterBand* band) { return test::PixelsOf(*band); }

double MeanDifference(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
  EXPECT_EQ(a.size(), b.size());
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(int{a[i]} - int{b[i]});
  return sum / static_cast<double>(a.size());
}

// As GDAL reads it: the picture and its mask at every level. Colours of tiles whose room is small are
// coarser.
TEST_F(StreamedFileTest, GeotiffShowsWhatTheWritersShows) {
  GDALAllRegister();
  for (const image::TileEncoding encoding :
       {image::TileEncoding::kJpegWebp, image::TileEncoding::kJpegPng, image::TileEncoding::kWebp}) {
    PaintedTileset painted = kPainted;
    painted.encoding = encoding;
    const auto mbtiles = Painted(painted);
    SilentProgress progress;
    ASSERT_TRUE(WriteCog(mbtiles, folder_.path() / "written.tif", {}, progress));
    const auto opened =
        maps_.Open(mbtiles, std::to_string(static_cast<int>(encoding)), StreamedFormat::kGeotiff);
    ASSERT_TRUE(opened);
    ASSERT_TRUE(WriteFileAtomically(folder_.path() / "streamed.tif",
                                    ReadAll(*opened, 0, opened->file->length(), 1 << 16)));
    const auto written = test::OpenByGdal(folder_ / "written.tif"),
               streamed = test::OpenByGdal(folder_ / "streamed.tif");
    ASSERT_EQ(streamed->GetRasterCount(), written->GetRasterCount());
    for (int band = 1; band <= streamed->GetRasterCount(); ++band) {
      GDALRasterBand* ours = streamed->GetRasterBand(band);
      GDALRasterBand* theirs = written->GetRasterBand(band);
      ASSERT_EQ(ours->GetOverviewCount(), theirs->GetOverviewCount());
      EXPECT_LT(MeanDifference(Pixels(ours), Pixels(theirs)), 4.0);
      EXPECT_TRUE(Pixels(ours->GetMaskBand()) == Pixels(theirs->GetMaskBand()));
      for (int level = 0; level < ours->GetOverviewCount(); ++level) {
        EXPECT_LT(MeanDifference(Pixels(ours->GetOverview(level)), Pixels(theirs->GetOverview(level))), 4.0);
        EXPECT_TRUE(Pixels(ours->GetOverview(level)->GetMaskBand()) ==
                    Pixels(theirs->GetOverview(level)->GetMaskBand()))
            << level;
      }
    }
  }
}

TEST_F(StreamedFileTest, LaysOutTilesetsThatDoNotSayHowLargeTheirTilesAre) {
  const auto mbtiles = Painted(kPainted);
  const auto stated = test::ValueOf(maps_.Open(mbtiles, "stated", StreamedFormat::kGeotiff));
  const std::string whole = ReadAll(stated, 0, stated.file->length(), 9999);
  auto db = *SqliteDb::Open(mbtiles, OpenMode::kReadWriteCreate);
  ASSERT_TRUE(db.Exec(
      "CREATE TABLE earlier (zoom_level INTEGER NOT NULL, tile_column INTEGER NOT NULL, tile_row INTEGER NOT "
      "NULL, tile_data_id INTEGER NOT NULL, PRIMARY KEY (zoom_level, tile_column, tile_row)) WITHOUT ROWID;"
      "INSERT INTO earlier SELECT zoom_level, tile_column, tile_row, tile_data_id FROM tiles_shallow;"
      "DROP VIEW tiles; DROP TABLE tiles_shallow; ALTER TABLE earlier RENAME TO tiles_shallow;"
      "CREATE VIEW tiles AS SELECT zoom_level, tile_column, tile_row, tile_data FROM tiles_shallow "
      "JOIN tiles_data USING (tile_data_id);"));
  ASSERT_TRUE(db.Close());
  const auto measured = test::ValueOf(maps_.Open(mbtiles, "measured", StreamedFormat::kGeotiff));
  ASSERT_EQ(measured.file->digest(), stated.file->digest());
  EXPECT_TRUE(ReadAll(measured, 0, measured.file->length(), 9999) == whole);
}

// Noise in colour and in alpha: as WebP of low quality small, as JPEG larger than any room for it.
image::RgbaImage Noise(int side_px) {
  image::RgbaImage noise = image::RgbaImage::Transparent(side_px, side_px);
  std::mt19937 random(3);
  for (std::uint8_t& value : noise.rgba) value = static_cast<std::uint8_t>(random());
  return noise;
}

TEST_F(StreamedFileTest, WhatHasNoRoomIsMadeCoarserAndStaysReadable) {
  constexpr int kSidePx = 256;
  const auto mbtiles = folder_.path() / "noise.mbtiles";
  const geo::TileId id = *geo::TileId::Make(10, 500, 300);
  {
    auto writer = *MbtilesWriter::Create(mbtiles);
    const auto webp = image::EncodeWebp(image::RowsOf(Noise(kSidePx)), 0.0F);
    ASSERT_TRUE(writer->Put(id, image::PictureFormat::kWebp, webp));
    const auto jpeg = image::EncodeJpeg(image::RowsOf(Noise(kSidePx)), 50);
    ASSERT_TRUE(writer->Put(*geo::TileId::Make(10, 501, 300), image::PictureFormat::kJpeg, jpeg));
    TilesetMetadata metadata;
    metadata.min_zoom = metadata.max_zoom = 10;
    metadata.tile_size_px = kSidePx;
    ASSERT_TRUE(writer->Publish(metadata));
  }
  const auto tiles = *MbtilesReader::Open(mbtiles);
  GridLevel level;
  level.zoom = 10;
  level.first_column = 500, level.first_row = 300;
  level.columns = level.rows = 1;
  level.width_px = level.height_px = kSidePx;
  const CogCells cells(TiffTiles::kJpeg, kSidePx, 100);
  const CogRoom least = cells.LeastRoom();
  for (const std::uint64_t more : {0, 1, 2, 3, 4, 5, 1000, 70000, 200001}) {
    const auto cell = test::ValueOf(cells.MakeWithin(level, 0, least.Sum() + more, *tiles));
    EXPECT_EQ(cell.image.size(), least.image + more);
    EXPECT_EQ(cell.mask.size(), least.mask);
    const auto picture = image::DecodePicture(cell.image);
    ASSERT_TRUE(picture) << more;
    EXPECT_EQ(picture->width_px, kSidePx);
  }
  EXPECT_EQ(cells.MakeWithin(level, 0, least.Sum() - 1, *tiles).error().code, ErrorCode::kCorrupt);
}

TEST_F(StreamedFileTest, SaysThatATileIsNotWhatTheTilesetSays) {
  const auto mbtiles = Painted(kPainted);
  {
    auto db = *SqliteDb::Open(mbtiles, OpenMode::kReadWriteCreate);
    ASSERT_TRUE(db.Exec("UPDATE tiles_shallow SET tile_bytes = tile_bytes + 1 WHERE tile_format = 0"));
  }
  const auto streamed = test::ValueOf(maps_.Open(mbtiles, "a", StreamedFormat::kPmtiles));
  StreamedReader reader(streamed.file, streamed.tiles, 0, streamed.file->length());
  std::vector<std::uint8_t> buffer(1 << 20);
  Result<std::size_t> got = std::size_t{1};
  while (got && *got > 0) got = reader.Read(buffer);
  ASSERT_FALSE(got);
  EXPECT_EQ(got.error().code, ErrorCode::kCorrupt);
}

TEST_F(StreamedFileTest, RefusesWhatIsNoMap) {
  EXPECT_EQ(maps_.Open(folder_.path() / "none.mbtiles", "a", StreamedFormat::kPmtiles).error().code,
            ErrorCode::kNotFound);
  const auto mbtiles = Painted(kPainted);
  {
    auto db = *SqliteDb::Open(mbtiles, OpenMode::kReadWriteCreate);
    ASSERT_TRUE(db.Exec("DELETE FROM tiles_shallow"));
  }
  for (const StreamedFormat format : {StreamedFormat::kPmtiles, StreamedFormat::kGeotiff})
    EXPECT_EQ(maps_.Open(mbtiles, "b", format).error().code, ErrorCode::kCorrupt);
}

// As that of an export is, which may take no more than the disk has room for.
TEST(StreamFile, TellsALimitOfItsSizeAsADiskWithoutRoom) {
  const test::TemporaryFolder folder;
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit limited{rlim_t{1} << 20, before.rlim_max};
  const auto handler = signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limited), 0);
  auto file = *StreamFile::Create(folder / "large");
  file->Write(std::string(std::size_t{2} << 20, 'x'));
  const Result<void> published = file->Publish();
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  signal(SIGXFSZ, handler);
  ASSERT_FALSE(published.ok());
  EXPECT_EQ(published.error().code, ErrorCode::kOutOfSpace) << published.error().message;
}

}  // namespace
}  // namespace skyquilt::storage
