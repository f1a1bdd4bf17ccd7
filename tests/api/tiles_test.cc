

#include "api/tiles/recode_tile.h"
#include "api/tiles/tile_path.h"
#include "tests/api/sample_service.h"

namespace skyquilt::api {
namespace {

using nlohmann::json;

class TilesTest : public testing::Test {
 protected:
  TilesTest()
      : flight_(sample_.NewFlight()),
        png_(TransparentPng(256)),
        jpeg_(*TranscodeTile(png_, image::PictureFormat::kJpeg)) {
    sample_.Publish(flight_, {{2, 1, 2, jpeg_}, {3, 2, 5, png_}});
  }
  std::string Path(const std::string& rest) const { return "/tiles/" + flight_ + "/" + rest; }

  SampleService sample_;
  std::string flight_;
  std::string png_;
  std::string jpeg_;
};

TEST_F(TilesTest, AreServedWithTheTypeOfTheirBytes) {
  const Response jpeg = sample_.Get(Path("2/1/1"));
  EXPECT_EQ(jpeg.status, 200);
  EXPECT_EQ(jpeg.body, jpeg_);
  EXPECT_EQ(jpeg.headers.Find("Content-Type"), "image/jpeg");
  EXPECT_EQ(sample_.Get(Path("2/1/1.jpg")).body, jpeg_);
  EXPECT_EQ(sample_.Get(Path("3/2/2.png")).body, png_);
}

TEST_F(TilesTest, AnswerWithNothingWhenTheClientHasThem) {
  for (const char* path : {"2/1/1", "2/1/1.png", "2/2/2"}) {
    const Response first = sample_.Get(Path(path));
    const std::string etag(first.headers.Find("ETag"));
    ASSERT_FALSE(etag.empty());
    const Response second = sample_.Get(Path(path), {{"If-None-Match", etag}});
    EXPECT_EQ(second.status, 304);
    EXPECT_EQ(second.headers.Find("ETag"), etag);
    EXPECT_TRUE(second.body.empty());
  }
  EXPECT_NE(sample_.Get(Path("2/1/1")).headers.Find("ETag"),
            sample_.Get(Path("2/1/1.png")).headers.Find("ETag"));
}

TEST_F(TilesTest, AreConvertedToTheFormatAskedFor) {
  for (const char* extension : {"jpg", "png", "webp"}) {
    for (const char* tile : {"2/1/1.", "3/2/2."}) {
      const Response response = sample_.Get(Path(std::string(tile) + extension));
      ASSERT_EQ(response.status, 200);
      const auto format = test::ValueOf(image::PictureFormatOf(response.body));
      EXPECT_STREQ(image::ExtensionOf(format), extension);
      EXPECT_EQ(response.headers.Find("Content-Type"), image::ContentTypeOf(format));
      EXPECT_EQ(image::DecodePicture(response.body)->width_px, 256);
    }
  }
}

class WebpFringe : public testing::Test {
 protected:
  WebpFringe() : flight_(sample_.NewFlight()), path_("/tiles/" + flight_) {
    auto fringe = image::RgbaImage::Transparent(512, 512);
    std::fill_n(fringe.Pixel(0, 7), 4 * 256, std::uint8_t{255});
    webp_ = EncodeTile(fringe, image::PictureFormat::kWebp);
    jpeg_ = EncodeTile(fringe, image::PictureFormat::kJpeg);
    sample_.Publish(flight_, {{2, 1, 2, jpeg_}, {3, 2, 5, webp_}}, 512);
  }
  Response Get(const std::string& rest, const std::string& accept, const std::string& known = "") {
    Headers headers;
    if (!accept.empty()) headers.Add("Accept", accept);
    if (!known.empty()) headers.Add("If-None-Match", known);
    return sample_.Get(path_ + rest, std::move(headers));
  }

  SampleService sample_;
  std::string flight_, path_, webp_, jpeg_;
};

TEST_F(WebpFringe, IsPngForWhoDoesNotNameWebp) {
  for (const char* accept : {"image/webp,*/*", "text/html, image/WebP;q=0.5, image/png"}) {
    const Response stored = Get("/3/2/2", accept);
    EXPECT_EQ(stored.body, webp_) << accept;
    EXPECT_EQ(stored.headers.Find("Content-Type"), "image/webp");
    EXPECT_EQ(stored.headers.Find("Vary"), "Accept");
  }
  for (const char* accept : {"", "*/*", "image/*", "image/png, image/jpeg, */*", "image/webp;q=0, */*"}) {
    const Response made = Get("/3/2/2", accept);
    EXPECT_EQ(image::PictureFormatOf(made.body), image::PictureFormat::kPng) << accept;
    EXPECT_EQ(made.headers.Find("Content-Type"), "image/png");
    EXPECT_EQ(made.headers.Find("Vary"), "Accept");
    EXPECT_EQ(image::DecodePicture(made.body)->rgba, image::DecodePicture(webp_)->rgba);
    EXPECT_EQ(Get("/2/1/1", accept).body, jpeg_);
  }
}

TEST_F(WebpFringe, HasATagOfItsOwnAsPng) {
  const std::string webp(Get("/3/2/2", "image/webp,*/*").headers.Find("ETag"));
  const std::string png(Get("/3/2/2", "*/*").headers.Find("ETag"));
  EXPECT_NE(webp, png);
  EXPECT_EQ(Get("/3/2/2", "*/*", png).status, 304);
  EXPECT_EQ(Get("/3/2/2", "*/*", webp).status, 200);
  EXPECT_EQ(Get("/3/2/2", "image/webp,*/*", webp).status, 304);
  EXPECT_EQ(Get("/3/2/2", "image/webp,*/*", png).status, 200);
}

TEST_F(WebpFringe, IsPngAtOtherAddressesToo) {
  const std::string arcgis = "/arcgis/rest/services/" + flight_ + "/MapServer/tile/4/4/4";
  const Response piece = sample_.Get(arcgis);
  ASSERT_EQ(piece.status, 200);
  EXPECT_EQ(piece.headers.Find("Content-Type"), "image/png");
  EXPECT_EQ(piece.headers.Find("Vary"), "Accept");
  for (const auto& [accept, type] :
       {std::pair("", "image/png"), std::pair("image/webp, image/jpeg", "image/webp")}) {
    EXPECT_EQ(Get("/256/4/4/4", accept).headers.Find("Content-Type"), type);
    const Response ogc = sample_.Get("/ogc/collections/" + flight_ + "/map/tiles/WebMercatorQuad512/3/2/2",
                                     {{"Accept", accept}});
    EXPECT_EQ(ogc.headers.Find("Content-Type"), type);
  }
}

TEST_F(TilesTest, AreTransparentWhereTheMapHasNothing) {
  const Response blank = sample_.Get(Path("2/2/2.jpg"));
  EXPECT_EQ(blank.status, 200);
  EXPECT_EQ(blank.headers.Find("Content-Type"), "image/png");
  EXPECT_EQ(image::DecodePicture(blank.body)->width_px, 256);
  EXPECT_EQ(sample_.Get(Path("2/2/2?empty=204")).status, 204);
  EXPECT_EQ(sample_.Get(Path("2/2/2?empty=404")).status, 404);
  EXPECT_EQ(sample_.Get(Path("2/2/2?empty=1")).status, 400);
}

TEST_F(TilesTest, AreMissingOutsideTheZooms) {
  EXPECT_EQ(sample_.Get(Path("1/0/0")).status, 404);
  EXPECT_EQ(sample_.Get(Path("4/0/0")).status, 404);
  EXPECT_EQ(sample_.Get("/tiles/" + sample_.NewFlight() + "/2/1/1").status, 404);
  EXPECT_EQ(sample_.Get("/tiles/nothing/2/1/1").status, 404);
}

TEST_F(TilesTest, MayBeKeptForEverUnderTheirRevision) {
  EXPECT_NE(sample_.Get(Path("2/1/1?rev=1")).headers.Find("Cache-Control").find("immutable"),
            std::string::npos);
  EXPECT_EQ(sample_.Get(Path("2/1/1?rev=2")).headers.Find("Cache-Control").find("immutable"),
            std::string::npos);
  EXPECT_EQ(sample_.Get(Path("2/1/1")).headers.Find("Cache-Control").find("immutable"), std::string::npos);
}

TEST_F(TilesTest, AreForTheirTokenAloneWhereOneIsNeeded) {
  const std::string paths[] = {Path("2/1/1?rev=1"), Path("2/1/1"), Path("2/2/2?rev=1"),
                               "/tiles/" + flight_ + ".json", "/wmts"};
  for (const std::string& path : {paths[0], paths[1], paths[2]}) {
    const Response open = sample_.Get(path);
    EXPECT_TRUE(open.headers.Find("Cache-Control").starts_with("public")) << path;
    EXPECT_EQ(open.headers.Find("Vary").find("Authorization"), std::string::npos) << path;
  }
  const Headers token = sample_.MakeToken("one", storage::Scope::kRead);
  for (const std::string& path : paths) {
    const Response guarded = sample_.Get(path, token);
    ASSERT_EQ(guarded.status, 200) << path;
    EXPECT_TRUE(guarded.headers.Find("Cache-Control").starts_with("private")) << path;
    EXPECT_NE(guarded.headers.Find("Vary").find("Authorization"), std::string::npos) << path;
    Headers again = token;
    again.Add("If-None-Match", std::string(guarded.headers.Find("ETag")));
    EXPECT_TRUE(sample_.Get(path, again).headers.Find("Cache-Control").starts_with("private")) << path;
  }
  EXPECT_EQ(sample_.Get(paths[0], token).headers.Find("Cache-Control"),
            "private, max-age=31536000, immutable");
  // A cache that keeps them apart by token is told that it may.
  sample_.service().has_keyed_cache = true;
  const Response kept = sample_.Get(paths[0], token);
  EXPECT_EQ(kept.headers.Find("Cache-Control"), "public, max-age=31536000, immutable");
  EXPECT_EQ(kept.headers.Find("Vary"), "Accept, Authorization");
  EXPECT_TRUE(sample_.Get(paths[3], token).headers.Find("Cache-Control").starts_with("private"));
}

TEST_F(TilesTest, AreDescribedAsTileJson) {
  const Response response = sample_.Get("/tiles/" + flight_ + ".json");
  ASSERT_EQ(response.status, 200);
  const json document = json::parse(response.body);
  EXPECT_EQ(document["tilejson"], "3.0.0");
  EXPECT_EQ(document["minzoom"], 2);
  EXPECT_EQ(document["maxzoom"], 3);
  EXPECT_EQ(document["bounds"].size(), 4u);
  EXPECT_EQ(document["tiles"][0], "http://127.0.0.1:1/tiles/" + flight_ + "/{z}/{x}/{y}?rev=1");
  EXPECT_EQ(sample_.Get("/tiles/" + flight_).status, 404);
  EXPECT_EQ(sample_.Get("/tiles/x.json").status, 404);
  const Headers knows{{"If-None-Match", std::string(response.headers.Find("ETag"))}};
  EXPECT_EQ(sample_.Get("/tiles/" + flight_ + ".json", knows).status, 304);
}

class BadTilePaths : public testing::TestWithParam<const char*> {};

TEST_P(BadTilePaths, AreRefused) {
  const std::string path = GetParam();
  const std::size_t first = path.find('/');
  const std::size_t second = path.find('/', first + 1);
  const auto parsed = ParseTilePath(path.substr(0, first), path.substr(first + 1, second - first - 1),
                                    path.substr(second + 1));
  ASSERT_FALSE(parsed) << path;
  EXPECT_EQ(parsed.error().code, ErrorCode::kInvalidArgument);
}

INSTANTIATE_TEST_SUITE_P(
    ParseTilePath, BadTilePaths,
    testing::Values("-1/0/0", "31/0/0", "99999999999/0/0", "2/4/0", "2/0/4", "2/1/1e3", "2/1/ 1", "2/1/+1",
                    "2/1/0x1", "2/1/1.5", "2/1/", "//", "2/1/1.", "2/1/1.exe", "2/1/1@3x", "2/1/1@9x.png",
                    "2/1/1.png.jpg", "2/1/.png", "2/1/\xd9\xa1", "2/1/1.PNG", "30/1073741824/0",
                    "2/1/11111111111111111111111111111111111111111111111111111111111111111111"));

TEST(ParseTilePath, TakesPlainNumbers) {
  const auto path = test::ValueOf(ParseTilePath("30", "1073741823", "0.jpeg"));
  EXPECT_EQ(path.tile, *geo::TileId::Make(30, 1073741823, 0));
  EXPECT_EQ(path.format, image::PictureFormat::kJpeg);
  EXPECT_FALSE(ParseTilePath("0", "0", "0")->format);
}

TEST(TranscodeTile, LaysTransparencyOnWhiteForJpeg) {
  const std::string jpeg = *TranscodeTile(TransparentPng(64), image::PictureFormat::kJpeg);
  // Back to PNG: one colour of full white compresses to almost nothing, and differs from the transparent one.
  const std::string png = *TranscodeTile(jpeg, image::PictureFormat::kPng);
  EXPECT_LT(png.size(), 1000u);
  EXPECT_NE(png, TransparentPng(64));
}

TEST(TranscodeTile, RefusesDamagedTiles) {
  const std::string good = *TranscodeTile(TransparentPng(64), image::PictureFormat::kWebp);
  EXPECT_FALSE(TranscodeTile("not an image", image::PictureFormat::kPng));
  EXPECT_FALSE(TranscodeTile("", image::PictureFormat::kPng));
  EXPECT_FALSE(TranscodeTile(good.substr(0, 20), image::PictureFormat::kPng));
  EXPECT_FALSE(TranscodeTile(TransparentPng(64).substr(0, 50), image::PictureFormat::kJpeg));
}

}  // namespace
}  // namespace skyquilt::api
