// OGC API Maps: a map as one picture, by box, size, scale, coordinate system and background; what a request
// leaves out; headers; and what is refused. Every pixel is held against the place at which it lies.
#include <fmt/format.h>

#include <charconv>
#include <nlohmann/json.hpp>

#include "api/common/background.h"
#include "api/maps/map_request.h"
#include "api/tiles/map_crs.h"
#include "tests/api/maps/textured_map.h"

namespace skyquilt::api {
namespace {

using nlohmann::json;

constexpr geo::LatLon kAlps{.lat_deg = 47.1, .lon_deg = 8.3};

std::vector<double> Numbers(std::string_view text) {
  std::vector<double> numbers;
  while (true) {
    double number = 0.0;
    const auto parsed = std::from_chars(text.data(), text.data() + text.size(), number);
    EXPECT_EQ(parsed.ec, std::errc()) << text;
    numbers.push_back(number);
    text.remove_prefix(static_cast<std::size_t>(parsed.ptr - text.data()));
    if (text.empty()) return numbers;
    EXPECT_EQ(text.front(), ',');
    text.remove_prefix(1);
  }
}

class OgcMaps : public testing::Test {
 protected:
  Response Map(const std::string& query, Headers headers = {}) {
    return sample_.Get(at_ + (query.empty() ? "" : "?" + query), std::move(headers));
  }
  struct Drawn {
    image::RgbaImage picture = image::RgbaImage::Transparent(1, 1);
    std::vector<double> box;  // Content-Bbox
    std::string crs;          // Content-Crs
    std::array<int, 2> size() const { return {picture.width_px, picture.height_px}; }
  };
  Drawn Draw(const std::string& query) {
    const Response response = Map(query);
    EXPECT_EQ(response.status, 200) << query << response.body;
    if (response.status != 200) return {image::RgbaImage::Transparent(1, 1), {0, 0, 1, 1}, ""};
    const Result<image::RgbaImage> picture = image::DecodePicture(response.body);
    EXPECT_TRUE(picture) << query;
    Drawn drawn;
    if (picture) drawn.picture = *picture;
    drawn.box = Numbers(response.headers.Find("Content-Bbox"));
    drawn.crs = response.headers.Find("Content-Crs");
    EXPECT_EQ(drawn.box.size(), 4u);
    return drawn;
  }
  // Each pixel against the place that Content-Bbox and the system say; `position` of x and y of the system.
  int Compare(const Drawn& drawn, const std::function<geo::LatLon(double x, double y)>& position,
              bool is_north_first = false) {
    std::vector<double> box = drawn.box;
    if (is_north_first) box = {box[1], box[0], box[3], box[2]};
    const double width = (box[2] - box[0]) / drawn.picture.width_px;
    const double height = (box[3] - box[1]) / drawn.picture.height_px;
    const auto at = [&](double x, double y) { return position(box[0] + x * width, box[3] - y * height); };
    // Small pictures are read from the coarser zoom, between whose pixels waves are half as long.
    return map_.Compare(drawn.picture, at, drawn.picture.width_px < 800 ? 2.5 : 1.5);
  }
  void Refused(const std::string& query, int status, const std::string& word) {
    const Response response = Map(query);
    EXPECT_EQ(response.status, status) << query;
    EXPECT_NE(response.body.find(word), std::string::npos) << query << response.body;
    EXPECT_EQ(response.headers.Find("Content-Type"), "application/problem+json") << query;
  }
  static geo::LatLon OfDegrees(double x, double y) { return {.lat_deg = y, .lon_deg = x}; }
  static geo::LatLon OfMerc(double x, double y) { return geo::LatLonFromMerc({x, y}); }

  SampleService sample_;
  TexturedMap map_{sample_, kAlps};
  std::string at_ = "/ogc/collections/" + map_.flight() + "/map";
};

TEST_F(OgcMaps, NothingSaidIsTheWholeMapInItsOwnSystem) {
  const Drawn drawn = Draw("");
  EXPECT_EQ(drawn.crs, "http://www.opengis.net/def/crs/EPSG/0/3857");
  const geo::Bounds2& bounds = map_.bounds_in_merc();
  EXPECT_NEAR(drawn.box[0], bounds.min.x(), 1e-6);
  EXPECT_NEAR(drawn.box[3], bounds.max.y(), 1e-6);
  // As large as the map's own pixels, which are no more than 1,024.
  EXPECT_NEAR(drawn.picture.width_px, 1024, 4);
  EXPECT_NEAR(drawn.picture.height_px, 1024, 8);  // on the ellipsoid a degree of latitude is a little longer
  EXPECT_GT(Compare(drawn, OfMerc), 900'000);
}

TEST_F(OgcMaps, EverySystemShowsEveryPlaceWhereItLies) {
  const Drawn degrees = Draw("crs=[OGC:CRS84]");
  EXPECT_EQ(degrees.crs, "");  // by the standard, of CRS84 nothing is said
  EXPECT_NEAR(degrees.box[0], map_.bounds().west_deg, 1e-12);
  EXPECT_GT(Compare(degrees, OfDegrees), 500'000);
  const Drawn latlon = Draw("crs=http://www.opengis.net/def/crs/EPSG/0/4326");
  EXPECT_EQ(latlon.crs, "http://www.opengis.net/def/crs/EPSG/0/4326");
  EXPECT_NEAR(latlon.box[0], map_.bounds().south_deg, 1e-12);  // latitude comes first
  EXPECT_GT(Compare(latlon, OfDegrees, true), 500'000);
  EXPECT_EQ(latlon.picture.rgba, degrees.picture.rgba);
  const Drawn utm = Draw("crs=[EPSG:32632]");
  EXPECT_EQ(utm.crs, "http://www.opengis.net/def/crs/EPSG/0/32632");
  EXPECT_GT(Compare(utm, [](double x, double y) { return LatLonOfUtm(32, x, y); }), 900'000);
  // Systems of the region, by PROJ itself; one turned against north by ten degrees.
  for (const int code : {2056, 31467, 3035, 4258, 25833, 32631}) {
    const Result<geo::MapProjection> system = geo::MapProjection::OfEpsg(code);
    ASSERT_TRUE(system);
    const Drawn drawn = Draw("crs=[EPSG:" + std::to_string(code) + "]");
    EXPECT_GT(Compare(
                  drawn,
                  [&](double x, double y) {
                    return *system->LatLonOf({x, y});
                  },
                  system->is_north_first()),
              500'000)
        << code;
  }
}

TEST_F(OgcMaps, ABoxIsShownInTheSystemAskedFor) {
  const auto& [west, south, east, north] = map_.bounds();
  const double dx = (east - west) / 5, dy = (north - south) / 7;
  const std::string box = fmt::format("{},{},{},{}", west + dx, south + dy, east - dx, north - dy);
  const Drawn degrees = Draw("bbox=" + box + "&crs=[OGC:CRS84]&width=300&height=200");
  EXPECT_EQ(degrees.size(), (std::array{300, 200}));
  EXPECT_NEAR(degrees.box[0], west + dx, 1e-12);
  EXPECT_NEAR(degrees.box[3], north - dy, 1e-12);
  EXPECT_EQ(Compare(degrees, OfDegrees), 300 * 200);
  // The same with latitude first, in both systems.
  const std::string turned = fmt::format("{},{},{},{}", south + dy, west + dx, north - dy, east - dx);
  const Drawn latlon = Draw("bbox=" + turned + "&bbox-crs=[EPSG:4326]&crs=[EPSG:4326]&width=300&height=200");
  EXPECT_EQ(latlon.picture.rgba, degrees.picture.rgba);
  EXPECT_EQ(
      Draw("bbox=" + turned + "&bbox-crs=[EPSG:4326]&crs=[OGC:CRS84]&width=300&height=200").picture.rgba,
      degrees.picture.rgba);
  // As WMS draws it, and as the six numbers of a box with heights.
  const std::string same_box = "bbox=" + box + "&crs=[OGC:CRS84]&width=300&height=200";
  const Response wms =
      sample_.Get("/wms/" + map_.flight() +
                  "?service=WMS&version=1.3.0&request=GetMap&layers=map&styles=&crs=CRS:84&bbox=" + box +
                  "&width=300&height=200&format=image/png&transparent=true");
  EXPECT_EQ(wms.body, Map(same_box).body);
  const std::string high = fmt::format("{},{},0,{},{},900", west + dx, south + dy, east - dx, north - dy);
  EXPECT_EQ(Map("bbox=" + high + "&bbox-crs=[OGC:CRS84h]&crs=[OGC:CRS84]&width=300&height=200").body,
            wms.body);
  // A box of degrees in UTM is what holds it.
  const Drawn utm = Draw("bbox=" + box + "&crs=[EPSG:32632]&width=300&height=300");
  EXPECT_GT(Compare(utm, [](double x, double y) { return LatLonOfUtm(32, x, y); }), 80'000);
  const geo::LatLon corner = LatLonOfUtm(32, utm.box[0], utm.box[1]);
  EXPECT_LE(corner.lat_deg, south + dy + 1e-6);
  EXPECT_NEAR(corner.lon_deg, west + dx, 2e-4);
  // One in metres of UTM, in Web Mercator.
  const std::string metres = fmt::format("{},{},{},{}", utm.box[0], utm.box[1], utm.box[2], utm.box[3]);
  EXPECT_GT(
      Compare(Draw("bbox=" + metres + "&bbox-crs=http://www.opengis.net/def/crs/EPSG/0/32632&width=256"),
              OfMerc),
      10'000);
}

TEST_F(OgcMaps, SubsetsAreBoxes) {
  const auto& [west, south, east, north] = map_.bounds();
  const double dx = (east - west) / 5, dy = (north - south) / 7;
  const std::string rest = "&crs=[OGC:CRS84]&width=200&height=100";
  const std::string want =
      Map(fmt::format("bbox={},{},{},{}", west + dx, south + dy, east, north - dy) + rest).body;
  const std::string lon = fmt::format("Lon({}:{})", west + dx, east),
                    lat = fmt::format("Lat({}:{})", south + dy, north - dy);
  EXPECT_EQ(Map("subset=" + lon + "," + lat + rest).body, want);
  EXPECT_EQ(Map("subset=" + lat + "&subset=" + lon + rest).body, want);
  EXPECT_EQ(Map("subset=" + lat + fmt::format(",lon({}:*)", west + dx) + rest).body, want);
  EXPECT_EQ(Map("subset=" + lat + "," + lon + "&subset-crs=[EPSG:4326]" + rest).body, want);
  const geo::Bounds2& bounds = map_.bounds_in_merc();
  const Drawn half = Draw(fmt::format("subset=x({}:{})&subset-crs=[EPSG:3857]", bounds.min.x(),
                                      bounds.min.x() + bounds.Width() / 2));
  EXPECT_NEAR(half.box[2] - half.box[0], bounds.Width() / 2, 1e-6);
  EXPECT_NEAR(half.box[3], bounds.max.y(), 1e-6);
  for (const char* bad : {"time(1:2)", "Lat(a:2)", "Lat", ")(,", "Lat(48:47)"})
    Refused(std::string("subset=") + bad, 400, "subset");
}

TEST_F(OgcMaps, SizesFollowFromWhatIsSaid) {
  // One side: the other from the shape on the ground.
  EXPECT_EQ(Draw("width=512").size()[0], 512);
  EXPECT_NEAR(Draw("width=512").size()[1], 512, 4);
  EXPECT_EQ(Draw("height=100&crs=[OGC:CRS84]").size()[1], 100);
  EXPECT_NEAR(Draw("height=100&crs=[OGC:CRS84]").size()[0], 100, 1);
  // Both without a box: the whole map lies within, undistorted.
  const Drawn wide = Draw("width=600&height=200");
  EXPECT_EQ(wide.size(), (std::array{600, 200}));
  EXPECT_NEAR((wide.box[2] - wide.box[0]) / (wide.box[3] - wide.box[1]), 3.0, 0.03);
  EXPECT_LE(wide.box[1], map_.bounds_in_merc().min.y() + 1.0);
  EXPECT_GE(wide.box[3], map_.bounds_in_merc().max.y() - 1.0);
  EXPECT_GT(Compare(wide, OfMerc), 30'000);
  // A scale: of 0.28 millimetres a pixel on the ground, or as said.
  const double ground_m = 416.0;  // the map is about so wide
  EXPECT_NEAR(Draw("scale-denominator=5000").picture.width_px * 0.00028 * 5000, ground_m, 4.0);
  EXPECT_NEAR(Draw("scale-denominator=5000&mm-per-pixel=0.56").picture.width_px * 0.00056 * 5000, ground_m,
              4.0);
  const auto& [west, south, east, north] = map_.bounds();
  const std::string box = fmt::format("bbox={},{},{},{}", west, south, east, north);
  EXPECT_NEAR(Draw(box + "&scale-denominator=2500&crs=[EPSG:32632]").picture.width_px * 0.00028 * 2500,
              ground_m, 8.0);
  // Around a place, in metres of the ground whatever the system.
  for (const char* crs : {"[OGC:CRS84]", "[EPSG:3857]", "[EPSG:32632]", "[EPSG:3035]"}) {
    const Drawn around =
        Draw(fmt::format("center=8.301,47.1&width=300&height=200&scale-denominator=1000&crs={}", crs));
    EXPECT_EQ(around.size(), (std::array{300, 200}));
    const MapCrs system = *MapCrs::Named(crs);
    std::vector<double> corners = around.box;
    if (system.is_north_first()) corners = {corners[1], corners[0], corners[3], corners[2]};
    const auto middle = system.LatLonOf({(corners[0] + corners[2]) / 2, (corners[1] + corners[3]) / 2});
    ASSERT_TRUE(middle) << crs;
    EXPECT_NEAR(middle->lon_deg, 8.301, 1e-7) << crs;
    EXPECT_NEAR(middle->lat_deg, 47.1, 1e-7) << crs;
    const Eigen::Vector2d metres =
        *system.MetresPerUnit({(corners[0] + corners[2]) / 2, (corners[1] + corners[3]) / 2});
    EXPECT_NEAR((corners[2] - corners[0]) * metres.x(), 300 * 0.28, 0.01) << crs;
    EXPECT_NEAR((corners[3] - corners[1]) * metres.y(), 200 * 0.28, 0.01) << crs;
  }
  EXPECT_EQ(Draw("center=47.1,8.301&center-crs=[EPSG:4326]").size(), (std::array{1024, 1024}));
  EXPECT_EQ(Draw("center=8.301,47.1&width=77").size(), (std::array{77, 77}));
}

TEST_F(OgcMaps, SizesBeyondTheLimitsAreTooLarge) {
  Refused("width=4097", 413, "4096");
  Refused("width=1&height=100000", 413, "4096");
  Refused("width=4096&height=4096", 413, "million");
  Refused("scale-denominator=0.01&bbox=8,47,9,48", 413, "million");
  Refused("width=4096&bbox=8.3,0,8.3001,47", 413, "million");  // the other side would be far longer
  Refused("width=1e300", 413, "4096");
  EXPECT_EQ(Map("width=4096&height=8").status, 200);
}

TEST_F(OgcMaps, FormatsAreByParameterOrAccept) {
  const auto type = [&](const std::string& query, const std::string& accept) {
    Headers headers;
    if (!accept.empty()) headers.Add("Accept", accept);
    const Response response = Map("width=32" + query, headers);
    const auto format = image::PictureFormatOf(response.body);
    if (response.status != 200) return std::to_string(response.status);
    EXPECT_EQ(response.headers.Find("Content-Type"), image::ContentTypeOf(format.value()));
    EXPECT_EQ(response.headers.Find("Vary").empty(), query.find("f=") != std::string::npos);
    return std::string(response.headers.Find("Content-Type"));
  };
  EXPECT_EQ(type("", ""), "image/png");
  EXPECT_EQ(type("", "*/*"), "image/png");
  EXPECT_EQ(type("", "image/jpeg"), "image/jpeg");
  EXPECT_EQ(type("", "image/avif,image/webp,image/apng,image/*,*/*;q=0.8"), "image/png");
  EXPECT_EQ(type("", "text/html,image/webp;q=0.5"), "image/webp");
  EXPECT_EQ(type("", "text/html"), "406");
  EXPECT_EQ(type("&f=webp", "image/png"), "image/webp");
  EXPECT_EQ(type("&f=image/jpeg", ""), "image/jpeg");
  EXPECT_EQ(type("&f=jpg", ""), "image/jpeg");
  EXPECT_EQ(type("&f=html", ""), "406");
}

// What the first pixel, beside the map, is in all combinations.
TEST_F(OgcMaps, BackgroundsAreAsTheStandardHasThem) {
  const auto& [west, south, east, north] = map_.bounds();
  const std::string box = fmt::format("bbox={},{},{},{}&width=64&height=64", west - 0.01, south - 0.01,
                                      east + 0.01, north + 0.01);
  const auto corner = [&](const std::string& query) {
    const Drawn drawn = Draw(box + query);
    EXPECT_EQ(drawn.picture.Pixel(32, 32)[3], 255) << query;  // the map itself
    const std::uint8_t* const pixel = drawn.picture.Pixel(0, 0);
    return std::array<int, 4>{pixel[0], pixel[1], pixel[2], pixel[3]};
  };
  EXPECT_EQ(corner("")[3], 0);
  EXPECT_EQ(corner("&transparent=true")[3], 0);
  EXPECT_EQ(corner("&transparent=false"), (std::array{255, 255, 255, 255}));
  EXPECT_EQ(corner("&bgcolor=0xCC00CC"), (std::array{0xCC, 0, 0xCC, 255}));
  EXPECT_EQ(corner("&bgcolor=CC00CC&transparent=FALSE"), (std::array{0xCC, 0, 0xCC, 255}));
  EXPECT_EQ(corner("&bgcolor=%23cc00cc"), (std::array{0xCC, 0, 0xCC, 255}));
  EXPECT_EQ(corner("&bgcolor=NaVy"), (std::array{0, 0, 128, 255}));
  EXPECT_EQ(corner("&bgcolor=DarkSlateGrey"), (std::array{0x2F, 0x4F, 0x4F, 255}));
  EXPECT_EQ(corner("&bgcolor=CC00CC&transparent=true"), (std::array{0xCC, 0, 0xCC, 0}));
  EXPECT_EQ(corner("&f=webp&bgcolor=NaVy")[3], 255);
  // A format without transparency has the colour, or white.
  const auto jpeg = [&](const std::string& query) { return corner("&f=jpeg" + query); };
  EXPECT_NEAR(jpeg("")[0], 255, 3);
  EXPECT_NEAR(jpeg("&bgcolor=CC00CC&transparent=true")[0], 0xCC, 3);
  EXPECT_NEAR(jpeg("&bgcolor=CC00CC&transparent=true")[1], 0, 3);
  for (const char* bad : {"nocolour", "0xCC00", ""}) Refused(std::string("bgcolor=") + bad, 400, "bgcolor");
  Refused("transparent=maybe", 400, "transparent");
  Refused("void-transparent=1", 400, "void-transparent");
}

TEST_F(OgcMaps, BeyondTheWorldIsVoid) {
  // Of latitudes beyond the poles there is nothing, between them and the map the background.
  const std::string world = "bbox=-180,-120,180,120&crs=[OGC:CRS84]&width=60&height=60";
  const auto pixel = [&](const std::string& query, int row) {
    const Drawn drawn = Draw(world + query);
    const std::uint8_t* const at = drawn.picture.Pixel(3, row);
    return std::array<int, 4>{at[0], at[1], at[2], at[3]};
  };
  const std::string both = "&bgcolor=00FF00&void-color=red";
  EXPECT_EQ(pixel(both, 0), (std::array{255, 0, 0, 255}));
  EXPECT_EQ(pixel(both, 20), (std::array{0, 255, 0, 255}));
  EXPECT_EQ(pixel("&bgcolor=00FF00", 0), (std::array{0, 255, 0, 255}));
  EXPECT_EQ(pixel(both + "&void-transparent=true", 0)[3], 0);
  EXPECT_EQ(pixel(both + "&void-transparent=true", 20)[3], 255);
  EXPECT_EQ(pixel("&void-transparent=false&void-color=0x0000FF", 0), (std::array{0, 0, 255, 255}));
  EXPECT_EQ(pixel("&void-transparent=false&void-color=0x0000FF", 20)[3], 0);
}

TEST_F(OgcMaps, WhatContradictsItselfIsRefused) {
  const std::string box = "bbox=8.2,47.0,8.4,47.2";
  Refused(box + "&center=8.3,47.1", 400, "center");
  Refused(box + "&subset=Lat(47:48)", 400, "subset");
  Refused("subset=Lat(47:48)&center=8.3,47.1", 400, "center");
  Refused(box + "&scale-denominator=1000&width=100", 400, "scale-denominator");
  for (const char* bad : {"bbox=1,2,3", "bbox=", "bbox=1,2,3,4,5", "bbox=1,2,nan,4", "bbox=1,2,inf,4",
                          "bbox=8.3,47.2,8.4,47.1", "bbox=8.3,47.1,8.3,47.2", "bbox=1,2,3,4,5,6,7",
                          "bbox=1,2,3,", "bbox=-1000,0,1000,10", "bbox=a,b,c,d"}) {
    Refused(bad, 400, "bbox");
  }
  for (const char* bad :
       {"width=0", "width=-5", "width=1.5", "width=many", "width=", "height=0", "scale-denominator=0",
        "scale-denominator=-3", "mm-per-pixel=0", "center=1", "center=1,2,3", "center=x,y"}) {
    const std::string name = std::string(bad).substr(0, std::string(bad).find('='));
    Refused(bad, 400, name);
  }
  for (const char* bad :
       {"crs=EPSG", "crs=[EPSG:1]", "crs=[EPSG:-4]", "crs=[EPSG:4979]", "crs=", "crs=[EPSG:99999999999]",
        "crs=[OGC:CRS85]", "crs=http://www.opengis.net/def/crs/EPSG/0/", "crs=%2Bproj%3Dutm",
        "bbox-crs=nowhere&bbox=1,2,3,4", "center-crs=[EPSG:0]&center=1,2", "crs=PROJ:x", "crs=[EPSG:4326",
        "crs=[]"}) {
    const Response response = Map(bad);
    EXPECT_EQ(response.status, 400) << bad << response.body;
  }
  // Systems of which the map is no part.
  Refused("crs=[EPSG:3031]&center=0,91", 400, "center");
  EXPECT_EQ(Map("bbox-crs=nonsense&width=8").status, 200);  // without a box it is not read
  const std::string other = "/ogc/collections/" + sample_.NewFlight() + "/map";
  EXPECT_EQ(sample_.Get(other).status, 404);
  EXPECT_EQ(sample_.Get("/ogc/collections/nobody/map").status, 404);
  EXPECT_EQ(sample_.Get("/ogc/collections/" + map_.flight() + ".photos/map").status, 404);
}

TEST_F(OgcMaps, BoxesFarAwayAreEmptyAndQuick) {
  const Drawn away = Draw("bbox=100,10,101,11&crs=[EPSG:32648]&width=2000&height=2000");
  for (std::size_t i = 3; i < away.picture.rgba.size(); i += 4) ASSERT_EQ(away.picture.rgba[i], 0);
  // The whole world, in a few systems, of which some have no place for all of it.
  for (const char* crs :
       {"[OGC:CRS84]", "[EPSG:3857]", "[EPSG:3035]", "[EPSG:32632]", "[EPSG:3413]", "[EPSG:8857]"}) {
    const Response response = Map(std::string("bbox=-180,-85,180,85&width=1500&height=1500&crs=") + crs);
    EXPECT_EQ(response.status, 200) << crs << response.body;
  }
}

TEST_F(OgcMaps, TheCollectionLeadsToTheMapAndSaysItsSystems) {
  const json collection = json::parse(sample_.Get("/ogc/collections/" + map_.flight() + "?token=abc").body);
  std::vector<std::string> types;
  for (const json& link : collection["links"]) {
    if (link["rel"] != "http://www.opengis.net/def/rel/ogc/1.0/map") continue;
    const std::string href = link["href"];
    const Response response = sample_.Get(href.substr(href.find("/ogc")));
    EXPECT_EQ(response.status, 200) << href;
    EXPECT_EQ(response.headers.Find("Content-Type"), link["type"].get<std::string>());
    EXPECT_NE(href.find("token=abc"), std::string::npos);
    types.push_back(link["type"]);
  }
  EXPECT_EQ(types, (std::vector<std::string>{"image/png", "image/jpeg", "image/webp"}));
  EXPECT_EQ(collection["storageCrs"], "http://www.opengis.net/def/crs/EPSG/0/3857");
  EXPECT_EQ(collection["crs"][0], collection["storageCrs"]);
  for (const json& crs : collection["crs"]) {
    EXPECT_EQ(Map("width=8&crs=" + crs.get<std::string>()).status, 200) << crs;
  }
  EXPECT_EQ(collection["crs"].back(), "http://www.opengis.net/def/crs/EPSG/0/32632");
  const json& box = collection["extent"]["spatial"]["storageCrsBbox"][0];
  EXPECT_NEAR(box[0].get<double>(), map_.bounds_in_merc().min.x(), 1e-6);
  EXPECT_NEAR(box[3].get<double>(), map_.bounds_in_merc().max.y(), 1e-6);
  const json classes = json::parse(sample_.Get("/ogc/conformance").body)["conformsTo"];
  for (const char* name : {"core", "collection-map", "crs", "background", "scaling", "spatial-subsetting",
                           "display-resolution", "png", "jpeg"}) {
    const std::string uri = std::string("https://www.opengis.net/spec/ogcapi-maps-1/1.0/conf/") + name;
    EXPECT_NE(std::find(classes.begin(), classes.end(), uri), classes.end()) << uri;
  }
}

TEST(MapCrs, IsNamedInEveryWay) {
  for (const char* text :
       {"[EPSG:32632]", "EPSG:32632", "epsg:32632", "http://www.opengis.net/def/crs/EPSG/0/32632",
        "https://www.opengis.net/def/crs/EPSG/9.9.1/32632", "urn:ogc:def:crs:EPSG::32632"}) {
    const Result<MapCrs> crs = MapCrs::Named(text);
    ASSERT_TRUE(crs) << text;
    EXPECT_EQ(crs->uri(), "http://www.opengis.net/def/crs/EPSG/0/32632") << text;
  }
  for (const char* text :
       {"[OGC:CRS84]", "OGC:CRS84", "CRS84", "CRS:84", "http://www.opengis.net/def/crs/OGC/1.3/CRS84",
        "https://www.opengis.net/def/crs/OGC/0/CRS84h", "urn:ogc:def:crs:OGC:1.3:CRS84"}) {
    const Result<MapCrs> crs = MapCrs::Named(text);
    ASSERT_TRUE(crs) << text;
    EXPECT_TRUE(crs->is_crs84()) << text;
  }
  EXPECT_EQ(MapCrs::Named("EPSG:900913")->uri(), MapCrs::Mercator().uri());
}

TEST(ParseColour, TakesDigitsAndNames) {
  EXPECT_EQ(*ParseColour("0x0102FF", "c"), (Rgb{1, 2, 255}));
  EXPECT_EQ(*ParseColour("rebeccaPurple", "c"), (Rgb{0x66, 0x33, 0x99}));
  EXPECT_EQ(*ParseColour("aqua", "c"), *ParseColour("cyan", "c"));
  EXPECT_EQ(*ParseColour("lightgoldenrodyellow", "c"), (Rgb{0xFA, 0xFA, 0xD2}));
  for (const char* bad :
       {"", "0x", "12345", "1234567", "0xGG0000", "-12345", "+12345", "0x 1234", "reddish", "#"}) {
    EXPECT_FALSE(ParseColour(bad, "c")) << bad;
  }
}

}  // namespace
}  // namespace skyquilt::api
