// Verdicts of maps across the antimeridian, which have tiles at both ends of the web map's square. Damage of
// all kinds: tests/e2e/command_line/validate_test.py.
#include "storage/validation/validate_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string_view>

#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "core/image/rgba_image.h"
#include "core/pyramid/encode_tile.h"
#include "storage/exports/cog_writer.h"
#include "storage/exports/pmtiles_writer.h"
#include "storage/files/publish_file.h"
#include "storage/tilesets/mbtiles_writer.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

constexpr int kSeamZoom = 8, kSeamRow = 100;
constexpr double kTileDeg = 360.0 / 256;

// A tile on either side of it; the bounds begin at `west_deg`.
void WriteAcross(const std::filesystem::path& path, double west_deg) {
  auto writer = *MbtilesWriter::Create(path);
  image::RgbaImage white = image::RgbaImage::Transparent(256, 256);
  for (std::uint8_t& value : white.rgba) value = 255;
  const auto encoded = test::ValueOf(pyramid::EncodeTile(white, {}));
  for (const int column : {255, 0})
    ASSERT_TRUE(writer->Put(*geo::TileId::Make(kSeamZoom, column, kSeamRow), encoded.format, encoded.bytes));
  TilesetMetadata metadata;
  metadata.name = "across";
  metadata.min_zoom = metadata.max_zoom = kSeamZoom;
  metadata.bounds = geo::LatLonBoundsFromMerc(geo::TileId::Make(kSeamZoom, 255, kSeamRow)->BoundsInMerc());
  metadata.bounds.west_deg = west_deg;
  metadata.bounds.east_deg = west_deg + 2 * kTileDeg;
  ASSERT_TRUE(writer->Publish(metadata));
}

std::string ErrorsOf(const FileVerdict& verdict) {
  std::string errors;
  for (const Finding& finding : verdict.findings) {
    if (finding.severity != Severity::kNote) errors += finding.what + "\n";
  }
  return errors;
}

TEST(ValidateMap, FindsNothingWrongWithOneAcrossTheAntimeridian) {
  const test::TemporaryFolder folder;
  SilentProgress progress;
  const auto mbtiles = folder.path() / "map.mbtiles", pmtiles = folder.path() / "map.pmtiles",
             tif = folder.path() / "map.tif";
  WriteAcross(mbtiles, 180.0 - kTileDeg);
  ASSERT_TRUE(WritePmtiles(mbtiles, pmtiles, progress));
  ASSERT_TRUE(WriteCog(mbtiles, tif, {}, progress));
  for (const auto& path : {mbtiles, pmtiles, tif}) {
    const auto verdicts = test::ValueOf(ValidateMap(path, false, progress));
    const FileVerdict& verdict = verdicts.front();
    EXPECT_EQ(ErrorsOf(verdict), "") << path;
    ASSERT_TRUE(verdict.bounds);
    EXPECT_NEAR(verdict.bounds->west_deg, 180.0 - kTileDeg, 1e-6) << path;
    EXPECT_NEAR(verdict.bounds->east_deg, 180.0 + kTileDeg, 1e-6) << path;
  }
}

TEST(ValidateMap, StillFindsTilesBeyondTheBoundsThere) {
  const test::TemporaryFolder folder;
  SilentProgress progress;
  WriteAcross(folder.path() / "map.mbtiles", 180.0 - 3 * kTileDeg);
  EXPECT_NE(ErrorsOf(test::ValueOf(ValidateMap(folder.path() / "map.mbtiles", false, progress)).front()), "");
}

// What is not shown of a map would be shown, and the other way round.
TEST(ValidateMap, FindsADamagedMask) {
  const test::TemporaryFolder folder;
  SilentProgress progress;
  WriteAcross(folder / "map.mbtiles", 180.0 - kTileDeg);
  ASSERT_TRUE(WriteCog(folder / "map.mbtiles", folder / "map.tif", {}, progress));
  std::string bytes = test::ValueOf(ReadWholeFile(folder / "map.tif"));
  constexpr std::string_view kDeflated = "\x78\x9c";  // of the last mask, which ends the file
  const std::size_t mask = bytes.rfind(kDeflated);
  ASSERT_NE(mask, std::string::npos);
  bytes.replace(mask, 4, 4, '\xff');
  const auto damaged = folder.Write("damaged.tif", bytes);
  const auto verdicts = test::ValueOf(ValidateMap(damaged, false, progress));
  EXPECT_NE(ErrorsOf(verdicts.front()).find("1 blocks of the mask are damaged"), std::string::npos)
      << ErrorsOf(verdicts.front());
}

TEST(ValidateMap, LooksAtTheRastersBesideAMap) {
  const test::TemporaryFolder folder;
  SilentProgress progress;
  WriteAcross(folder / "mosaic.mbtiles", 180.0 - kTileDeg);
  folder.Write("dsm.tif", std::string_view("no heights"));
  const auto verdicts = test::ValueOf(ValidateMap(folder.path(), false, progress));
  const auto heights = std::find_if(verdicts.begin(), verdicts.end(),
                                    [](const FileVerdict& verdict) { return verdict.file == "dsm.tif"; });
  ASSERT_NE(heights, verdicts.end());
  EXPECT_NE(ErrorsOf(*heights).find("cannot be opened"), std::string::npos);
}

}  // namespace
}  // namespace skyquilt::storage
