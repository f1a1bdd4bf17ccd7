#include "storage/exports/kmz_writer.h"

#include <cpl_vsi.h>
#include <gdal_priv.h>
#include <gtest/gtest.h>

#include <set>
#include <tuple>

#include "core/image/picture_codec.h"
#include "storage/tilesets/mbtiles_reader.h"
#include "storage/tilesets/mbtiles_writer.h"
#include "tests/storage/painted_tileset.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

std::string Read(const std::string& name) {
  std::string text;
  VSILFILE* file = VSIFOpenL(name.c_str(), "rb");
  if (file == nullptr) return text;
  char part[4096];
  for (std::size_t got = 0; (got = VSIFReadL(part, 1, sizeof(part), file)) > 0;) text.append(part, got);
  VSIFCloseL(file);
  return text;
}

// What the KML's links name, seen from its folder.
std::set<std::string> LinksOf(const std::string& kml) {
  std::set<std::string> links;
  for (std::size_t at = 0; (at = kml.find("<href>", at)) != std::string::npos;) {
    at += 6;
    links.insert(kml.substr(at, kml.find('<', at) - at));
  }
  return links;
}

// The stored bytes, but WebP, which KML viewers do not show: another picture of the same.
void ExpectShows(const std::string& shown, const std::string& stored) {
  if (image::PictureFormatOf(stored) != image::PictureFormat::kWebp) {
    EXPECT_EQ(shown, stored);
    return;
  }
  const bool has_alpha = image::IsWebpWithAlpha(stored);
  EXPECT_EQ(image::PictureFormatOf(shown),
            has_alpha ? image::PictureFormat::kPng : image::PictureFormat::kJpeg);
  const auto is = image::DecodePicture(shown), was = image::DecodePicture(stored);
  ASSERT_TRUE(is && was);
  ASSERT_EQ(is->rgba.size(), was->rgba.size());
  for (std::size_t i = 0; i < is->rgba.size(); ++i)
    ASSERT_NEAR(is->rgba[i], was->rgba[i], has_alpha ? 0 : 12);
}

TEST(WriteKmz, LeadsFromTheFirstFileToEveryTileWithItsPicture) {
  const test::TemporaryFolder dir;
  const std::filesystem::path mbtiles = dir.path() / "map.mbtiles", kmz = dir.path() / "map.kmz";
  test::WritePaintedTileset(mbtiles, {.first_column = 134'000, .first_row = 92'000, .columns = 7, .rows = 5});
  SilentProgress progress;
  const auto written = WriteKmz(mbtiles, kmz, progress);
  ASSERT_TRUE(written) << written.error().message;
  auto tiles = *MbtilesReader::Open(mbtiles);
  const std::string zip = "/vsizip/" + kmz.string() + "/";
  std::vector<std::string> open{"doc.kml"};
  std::set<std::string> pictures;
  while (!open.empty()) {
    const std::string name = open.back();
    open.pop_back();
    const std::string kml = Read(zip + name);
    ASSERT_NE(kml.find("</kml>"), std::string::npos) << name;
    const std::string folder = name.substr(0, name.rfind('/') + 1);
    for (std::string link : LinksOf(kml)) {
      if (link.ends_with(".kml")) {
        open.push_back(link.starts_with("../../") ? link.substr(6) : folder + link);
        continue;
      }
      int z = 0, x = 0, y = 0;
      ASSERT_EQ(std::sscanf((folder + link).c_str(), "%d/%d/%d", &z, &x, &y), 3) << link;
      auto found = tiles->Find(*geo::TileId::Make(z, x, y));
      ASSERT_TRUE(found && *found) << folder + link;
      ExpectShows(Read(zip + folder + link), *tiles->Load(**found));
      pictures.insert(folder + link);
    }
  }
  std::size_t count = 0;
  for (int z = 0; z <= 18; ++z) {
    for (int x = 134'000 >> (18 - z); x <= 134'006 >> (18 - z); ++x) {
      for (int y = 92'000 >> (18 - z); y <= 92'004 >> (18 - z); ++y) {
        const auto found = tiles->Find(*geo::TileId::Make(z, x, y));
        count += found && *found ? 1 : 0;
      }
    }
  }
  EXPECT_EQ(pictures.size(), count);
  EXPECT_GT(count, 20u);
}

TEST(WriteKmz, ShowsMapsOfWebpAsPngAndJpeg) {
  const test::TemporaryFolder dir;
  test::WritePaintedTileset(
      dir.path() / "map.mbtiles",
      {.first_column = 4, .columns = 5, .rows = 5, .encoding = image::TileEncoding::kWebp, .quality = 80});
  SilentProgress progress;
  ASSERT_TRUE(WriteKmz(dir.path() / "map.mbtiles", dir.path() / "map.kmz", progress));
  auto tiles = *MbtilesReader::Open(dir.path() / "map.mbtiles");
  const std::string zip = "/vsizip/" + (dir.path() / "map.kmz").string() + "/18/";
  for (const auto& [name, x, y] : {std::tuple{"6/2.jpg", 6, 2}, std::tuple{"4/2.png", 4, 2}}) {
    auto found = *tiles->Find(*geo::TileId::Make(18, x, y));
    ASSERT_TRUE(found) << name;
    ExpectShows(Read(zip + name), *tiles->Load(*found));
  }
}

TEST(WriteKmz, SaysThatATileIsDamaged) {
  const test::TemporaryFolder dir;
  auto writer = *MbtilesWriter::Create(dir.path() / "map.mbtiles");
  constexpr std::string_view kCutOff("RIFF\x08\0\0\0WEBPVP8X", 16);
  ASSERT_TRUE(writer->Put(*geo::TileId::Make(3, 1, 1), image::PictureFormat::kWebp,
                          {reinterpret_cast<const std::uint8_t*>(kCutOff.data()), kCutOff.size()}));
  TilesetMetadata metadata;
  metadata.min_zoom = metadata.max_zoom = 3;
  ASSERT_TRUE(writer->Publish(metadata));
  SilentProgress progress;
  EXPECT_EQ(test::ErrorOf(WriteKmz(dir.path() / "map.mbtiles", dir.path() / "map.kmz", progress)).code,
            ErrorCode::kCorrupt);
  EXPECT_FALSE(std::filesystem::exists(dir.path() / "map.kmz"));
}

}  // namespace
}  // namespace skyquilt::storage
