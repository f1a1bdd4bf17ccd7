// The small picture of a map, over a real data folder.
#include <fstream>

#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "tests/api/sample_service.h"

namespace skyquilt::api {
namespace {

class SmallPictureTest : public testing::Test {
 protected:
  SmallPictureTest() : flight_(sample_.NewFlight()) {
    const auto tile =
        image::EncodePicture(image::RgbaImage::Transparent(256, 256), image::PictureFormat::kPng);
    revision_ = sample_.Publish(flight_, {{2, 1, 2, {tile.begin(), tile.end()}}});
    image::RgbaImage map = image::RgbaImage::Transparent(512, 256);
    for (int y = 0; y < 256; ++y) {
      for (int x = 256; x < 512; ++x) map.Pixel(x, y)[0] = map.Pixel(x, y)[3] = 255;
    }
    const auto png = image::EncodePicture(std::move(map), image::PictureFormat::kPng);
    WriteThumbnail({png.begin(), png.end()});
  }
  void WriteThumbnail(const std::string& bytes) {
    std::ofstream(sample_.dir().Flights() / flight_ / ("r" + std::to_string(revision_)) / "thumbnail.png",
                  std::ios::binary)
        << bytes;
  }
  Response Get(const std::string& query, Headers headers = {}) {
    return sample_.Get("/api/v1/flights/" + flight_ + "/thumbnail.webp" + query, std::move(headers));
  }

  SampleService sample_;
  std::string flight_;
  std::int64_t revision_ = 0;
};

TEST_F(SmallPictureTest, IsTheWholeMapInTheSizeAskedFor) {
  for (const auto& [query, width_px] : {std::pair{"", 320}, {"?size=160", 160}, {"?rev=1&size=512", 512}}) {
    const Response response = Get(query);
    ASSERT_EQ(response.status, 200) << query;
    EXPECT_EQ(response.headers.Find("Content-Type"), "image/webp");
    EXPECT_EQ(response.headers.Find("Cache-Control"), "no-cache");
    const auto picture = test::ValueOf(image::DecodePicture(response.body));
    EXPECT_EQ(picture.width_px, width_px);
    EXPECT_EQ(picture.height_px, width_px / 2);
    EXPECT_EQ(picture.Pixel(2, 2)[3], 0);
    EXPECT_EQ(picture.Pixel(width_px - 3, 2)[3], 255);
    EXPECT_GT(picture.Pixel(width_px - 3, 2)[0], 240);
  }
}

TEST_F(SmallPictureTest, IsMadeOnceAndKnownByItsTag) {
  const Response first = Get("");
  const std::string etag(first.headers.Find("ETag"));
  EXPECT_NE(etag, Get("?size=160").headers.Find("ETag"));
  WriteThumbnail("no picture any more");
  EXPECT_EQ(Get("").body, first.body);
  const Response again = Get("", {{"If-None-Match", etag}});
  EXPECT_EQ(again.status, 304);
  EXPECT_TRUE(again.body.empty());
}

// Green at its corner in the north-west, red elsewhere, and blue around it, which belongs to no map.
std::string TileWithFrame(int left_px, int top_px, int right_px, int bottom_px) {
  constexpr int kSidePx = 256;
  image::RgbaImage tile = image::RgbaImage::Transparent(kSidePx, kSidePx);
  for (int y = 0; y < kSidePx; ++y) {
    for (int x = 0; x < kSidePx; ++x) {
      const bool is_within = x >= left_px && x < right_px && y >= top_px && y < bottom_px;
      const bool is_corner = x < left_px + 16 && y < top_px + 16;
      tile.Pixel(x, y)[!is_within ? 2 : is_corner ? 1 : 0] = 255;
      tile.Pixel(x, y)[3] = 255;
    }
  }
  const auto png = image::EncodePicture(std::move(tile), image::PictureFormat::kPng);
  return {png.begin(), png.end()};
}

TEST_F(SmallPictureTest, AsAPosterReachesExactlyAsFarAsTheBoundsOfTheMap) {
  const geo::Bounds2 tile = geo::TileId::Make(2, 1, 1)->BoundsInMerc();
  const double pixel_m = tile.Width() / 256;
  geo::Bounds2 bounds;
  bounds.Include({tile.min.x() + 64 * pixel_m, tile.max.y() - 224 * pixel_m});
  bounds.Include({tile.min.x() + 192 * pixel_m, tile.max.y() - 32 * pixel_m});
  const std::string flight = sample_.NewFlight();
  sample_.PublishAt(geo::LatLonBoundsFromMerc(bounds), flight, {{2, 1, 2, TileWithFrame(64, 32, 192, 224)}});
  const Response response = sample_.Get("/api/v1/flights/" + flight + "/thumbnail.webp?size=1024");
  ASSERT_EQ(response.status, 200) << response.body;
  EXPECT_LT(response.body.size(), 110'000u);
  const auto picture = test::ValueOf(image::DecodePicture(response.body));
  EXPECT_EQ(picture.width_px, 128) << "not enlarged";
  EXPECT_EQ(picture.height_px, 192);
  for (const auto& [x, y] : {std::pair{0, 191}, {127, 0}, {127, 191}, {64, 96}}) {
    EXPECT_GT(picture.Pixel(x, y)[0], 200) << x << " " << y;
    EXPECT_LT(picture.Pixel(x, y)[2], 60) << x << " " << y;
  }
  EXPECT_GT(picture.Pixel(0, 0)[1], 200);
  EXPECT_LT(picture.Pixel(0, 0)[2], 60);
  EXPECT_LT(picture.Pixel(24, 8)[1], 60);
}

TEST_F(SmallPictureTest, RefusesSizesThatThereAreNotAndSaysWhichThereAre) {
  for (const char* query : {"?size=0", "?size=321", "?size=-1", "?size=", "?size=99999999999999999999"}) {
    const Response response = Get(query);
    EXPECT_EQ(response.status, 400) << query;
    EXPECT_NE(response.body.find("160, 320, 512 or 1024"), std::string::npos) << query;
  }
}

TEST_F(SmallPictureTest, IsNotThereWithoutAThumbnailOrAMapAndSaysSoOfADamagedOne) {
  WriteThumbnail("no picture");
  EXPECT_EQ(Get("").status, 422);
  std::filesystem::remove(sample_.dir().Flights() / flight_ / ("r" + std::to_string(revision_)) /
                          "thumbnail.png");
  EXPECT_EQ(Get("").status, 404);
  EXPECT_EQ(sample_.Get("/api/v1/flights/" + sample_.NewFlight() + "/thumbnail.webp").status, 404);
}

}  // namespace
}  // namespace skyquilt::api
