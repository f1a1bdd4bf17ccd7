#include "api/tiles/recode_tile.h"

#include <gtest/gtest.h>

#include "api/tiles/map_window.h"
#include "core/image/picture_codec.h"
#include "tests/api/sample_service.h"

namespace skyquilt::api {
namespace {

// Red grows to the east, green to the south; nothing in the last quarter where alpha is wanted.
image::RgbaImage Slopes(int side_px, bool has_hole) {
  image::RgbaImage picture = image::RgbaImage::Transparent(side_px, side_px);
  for (int y = 0; y < side_px; ++y) {
    for (int x = 0; x < side_px; ++x) {
      if (has_hole && x >= side_px / 2 && y >= side_px / 2) continue;
      std::uint8_t* const pixel = picture.Pixel(x, y);
      pixel[0] = static_cast<std::uint8_t>(255 * x / side_px);
      pixel[1] = static_cast<std::uint8_t>(255 * y / side_px);
      pixel[3] = 255;
    }
  }
  return picture;
}

// A picture of all of a map of one zoom is made of each of its tiles.
TEST(RenderWindow, DecodesNoMoreThanItsBudget) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  const std::string tile = EncodeTile(Slopes(256, false), image::PictureFormat::kPng);
  sample.Publish(flight, {{1, 0, 0, tile}, {1, 1, 0, tile}, {1, 0, 1, tile}, {1, 1, 1, tile}});
  const auto tileset = test::ValueOf(sample.service().tilesets.Get(flight));
  const MapWindow window = WindowOfTile(*geo::TileId::Make(0, 0, 0), 256);
  constexpr std::int64_t kTilePx = 256 * 256;
  const image::RgbaImage whole = test::ValueOf(RenderWindow(*tileset, window));
  EXPECT_EQ(test::ValueOf(RenderWindow(*tileset, window, {.decoded_px = 4 * kTilePx})).rgba, whole.rgba);
  EXPECT_EQ(test::ErrorOf(RenderWindow(*tileset, window, {.decoded_px = 4 * kTilePx - 1})).code,
            ErrorCode::kTooLarge);
}

TEST(CutDepth, IsHowOftenTheSideIsHalved) {
  EXPECT_EQ(CutDepth(256, 256), 0);
  EXPECT_EQ(CutDepth(256, 512), 1);
  EXPECT_EQ(CutDepth(256, 1024), 2);
  EXPECT_FALSE(CutDepth(256, 128));
  EXPECT_FALSE(CutDepth(256, 768));
}

TEST(CutOf, FindsTheStoredTileAndThePlaceInIt) {
  const TileCut cut = CutOf(*geo::TileId::Make(5, 7, 13), 2, 1024);
  EXPECT_EQ(cut.stored, *geo::TileId::Make(3, 1, 3));
  EXPECT_EQ(cut.left_px, 3 * 256);
  EXPECT_EQ(cut.top_px, 256);
  EXPECT_EQ(cut.side_px, 256);
  EXPECT_EQ(CutOf(*geo::TileId::Make(3, 1, 3), 0, 512).stored, *geo::TileId::Make(3, 1, 3));
}

TEST(CutTile, KeepsThePixels) {
  const image::RgbaImage whole = Slopes(512, false);
  for (const auto stored : {image::PictureFormat::kPng, image::PictureFormat::kJpeg}) {
    const std::string bytes = EncodeTile(whole, stored);
    const auto cut = test::ValueOf(CutTile(bytes, CutOf(*geo::TileId::Make(1, 1, 0), 1, 512), stored));
    EXPECT_EQ(image::PictureFormatOf(cut), stored);
    const auto piece = image::DecodePicture(cut);
    const auto want = image::DecodePicture(bytes);
    ASSERT_TRUE(piece);
    ASSERT_EQ(std::pair(piece->width_px, piece->height_px), std::pair(256, 256));
    // Within, where a JPEG's coarser colours do not look beyond the edge: the same to the bit.
    for (int y = 2; y < 254; ++y) {
      for (int x = 2; x < 254; ++x) {
        ASSERT_TRUE(std::equal(piece->Pixel(x, y), piece->Pixel(x, y) + 4, want->Pixel(256 + x, y)));
      }
    }
  }
}

TEST(CutTile, IsEmptyWhereNothingCanBeSeen) {
  const std::string bytes = EncodeTile(Slopes(512, true), image::PictureFormat::kPng);
  EXPECT_EQ(*CutTile(bytes, CutOf(*geo::TileId::Make(1, 1, 1), 1, 512), image::PictureFormat::kPng), "");
}

TEST(CutTile, RefusesDamagedTilesAndOthersThanTheMapsOwn) {
  const TileCut cut = CutOf(*geo::TileId::Make(1, 1, 0), 1, 512);
  for (const auto format : {image::PictureFormat::kPng, image::PictureFormat::kJpeg}) {
    EXPECT_FALSE(CutTile(EncodeTile(Slopes(512, false), format).substr(0, 60), cut, format));
    EXPECT_FALSE(CutTile(EncodeTile(Slopes(256, false), format), cut, format));
    EXPECT_FALSE(CutTile("", cut, format));
  }
}

class CutTiles : public testing::TestWithParam<int> {
 protected:
  CutTiles() : side_px_(GetParam()), depth_(*CutDepth(256, side_px_)), flight_(sample_.NewFlight()) {
    const std::string jpeg = EncodeTile(Slopes(side_px_, false), image::PictureFormat::kJpeg);
    const std::string png = EncodeTile(Slopes(side_px_, true), image::PictureFormat::kPng);
    sample_.Publish(flight_, {{2, 1, 2, jpeg}, {2, 2, 2, png}}, side_px_);
  }
  std::string At(int z, int x, int y, const std::string& rest = "") const {
    return "/tiles/" + flight_ + "/256/" + std::to_string(z) + "/" + std::to_string(x) + "/" +
           std::to_string(y) + rest;
  }

  int side_px_;
  int depth_;
  SampleService sample_;
  std::string flight_;
};

TEST_P(CutTiles, AreServedAtTheZoomsOfTheirSize) {
  const int z = 2 + depth_, first = 1 << depth_;
  for (const auto& [rest, type] :
       {std::pair("", "image/jpeg"), std::pair(".png", "image/png"), std::pair(".webp", "image/webp")}) {
    const Response tile = sample_.Get(At(z, first + 1, first, rest));
    ASSERT_EQ(tile.status, 200);
    EXPECT_EQ(tile.headers.Find("Content-Type"), type);
    const auto picture = test::ValueOf(image::DecodePicture(tile.body));
    EXPECT_EQ(picture.width_px, 256);
    EXPECT_NEAR(picture.Pixel(128, 128)[0], 255 * 384 / side_px_, 4);
    EXPECT_NEAR(picture.Pixel(128, 128)[1], 255 * 128 / side_px_, 4);
    const Headers knows{{"If-None-Match", std::string(tile.headers.Find("ETag"))}};
    EXPECT_EQ(sample_.Get(At(z, first + 1, first, rest), knows).status, 304);
  }
  EXPECT_EQ(image::DecodePicture(sample_.Get(At(z - 1, first / 2, first / 2, "@2x")).body)->width_px, 512);
}

TEST_P(CutTiles, AreNotThereBeyondTheirZooms) {
  EXPECT_EQ(sample_.Get(At(2 + depth_ - 1, 1, 1)).status, 404);
  EXPECT_EQ(sample_.Get(At(2 + depth_ + 1, 8, 8)).status, 404);
  EXPECT_EQ(sample_.Get(At(0, 0, 0)).status, 404);
}

TEST_P(CutTiles, AreBlankWhereTheStoredTileHasNothing) {
  const int z = 2 + depth_, last = (3 << depth_) - 1;
  const Response blank = sample_.Get(At(z, last, (2 << depth_) - 1));
  EXPECT_EQ(blank.status, 200);
  EXPECT_EQ(blank.headers.Find("ETag"), "\"blank-256\"");
  EXPECT_EQ(sample_.Get(At(z, last, (2 << depth_) - 1, "?empty=204")).status, 204);
  EXPECT_EQ(sample_.Get(At(z, 0, 0, "?empty=404")).status, 404);
}

INSTANTIATE_TEST_SUITE_P(OfAllSizes, CutTiles, testing::Values(512, 1024));

TEST(CutTile, OfUsualMapsAreTheStoredOnes) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  sample.Publish(flight, {{2, 1, 2, TransparentPng(256)}});
  EXPECT_EQ(sample.Get("/tiles/" + flight + "/256/2/1/1").body, TransparentPng(256));
  EXPECT_EQ(image::DecodePicture(sample.Get("/tiles/" + flight + "/256/2/1/1@2x").body)->width_px, 512);
}

}  // namespace
}  // namespace skyquilt::api
