#include "api/http/accept.h"

#include "api/tiles/recode_tile.h"
#include "tests/api/sample_service.h"

namespace skyquilt::api {
namespace {

TEST(AcceptedQuality, GoesByTheClosestRange) {
  EXPECT_EQ(AcceptedQuality("", "image/png"), 1000);
  EXPECT_EQ(AcceptedQuality("*/*", "image/png"), 1000);
  EXPECT_EQ(AcceptedQuality("image/*;q=0.5, IMAGE/PNG;q=0.25", "image/png"), 250);
  EXPECT_EQ(AcceptedQuality("image/*;q=0.5, IMAGE/PNG;q=0.25", "image/jpeg"), 500);
  EXPECT_EQ(AcceptedQuality("text/html, */*;q=0.8", "application/json"), 800);
  EXPECT_EQ(AcceptedQuality("image/png;q=0, */*", "image/png"), 0);
  EXPECT_EQ(AcceptedQuality("text/html", "application/json"), 0);
  EXPECT_EQ(AcceptedQuality("image/png ; v=1 ; Q=0.1", "image/png"), 100);
}

TEST(AcceptedQuality, TakesNonsenseForNothingSaid) {
  for (const char* accept :
       {"image/png;q=", "image/png;q=x", "image/png;q=7", "image/png;q=nan", "image/png;;", ",image/png,"})
    EXPECT_EQ(AcceptedQuality(accept, "image/png"), 1000) << accept;
  for (const char* accept : {",", ";", "/", "image", "=;,", "/*"})
    EXPECT_EQ(AcceptedQuality(accept, "image/png"), 0) << accept;
}

class OgcFormats : public testing::Test {
 protected:
  OgcFormats() : flight_(sample_.NewFlight()) {
    const std::string jpeg = EncodeTile(image::RgbaImage::Transparent(512, 512), image::PictureFormat::kJpeg);
    sample_.Publish(flight_, {{2, 1, 2, jpeg}}, 512);
    tiles_ = "/ogc/collections/" + flight_ + "/map/tiles";
  }
  Response Get(const std::string& path, const std::string& accept) {
    return sample_.Get(path, {{"Accept", accept}});
  }
  SampleService sample_;
  std::string flight_;
  std::string tiles_;
};

TEST_F(OgcFormats, OfDocumentsAreJson) {
  for (const std::string& path : {std::string("/ogc"), std::string("/ogc/collections"),
                                  "/ogc/collections/" + flight_, tiles_, tiles_ + "/WebMercatorQuad"}) {
    EXPECT_EQ(Get(path, "text/html,*/*;q=0.1").status, 200) << path;
    EXPECT_EQ(Get(path + "?f=json", "text/html").status, 200) << path;
    EXPECT_EQ(Get(path, "text/html").status, 406) << path;
    EXPECT_EQ(Get(path + "?f=html", "*/*").status, 406) << path;
  }
}

TEST_F(OgcFormats, OfTilesAreWhatTheClientTakes) {
  const std::string tile = tiles_ + "/WebMercatorQuad/3/2/2";
  for (const auto& [query, accept, type] :
       {std::tuple("", "*/*", "image/jpeg"), std::tuple("", "image/webp,image/*;q=0.8", "image/jpeg"),
        std::tuple("", "image/png", "image/png"),
        std::tuple("", "image/webp;q=0.2,image/png;q=0.1", "image/webp"),
        std::tuple("?f=png", "image/webp", "image/png"), std::tuple("?f=image/webp", "", "image/webp"),
        std::tuple(".png", "image/webp", "image/png")}) {
    const Response answer = Get(tile + query, accept);
    EXPECT_EQ(answer.status, 200);
    EXPECT_EQ(answer.headers.Find("Content-Type"), type) << query << " " << accept;
    EXPECT_EQ(image::DecodePicture(answer.body)->width_px, 256);
  }
  EXPECT_EQ(Get(tile, "text/html").status, 406);
  EXPECT_EQ(Get(tile + "?f=tiff", "*/*").status, 406);
  EXPECT_EQ(image::DecodePicture(Get(tiles_ + "/WebMercatorQuad512/2/1/1", "*/*").body)->width_px, 512);
  EXPECT_EQ(Get(tiles_ + "/WebMercatorQuad1024/2/1/1", "*/*").status, 404);
}

}  // namespace
}  // namespace skyquilt::api
