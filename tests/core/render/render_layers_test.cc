#include "core/render/blocks/render_layers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "core/geo/web_mercator.h"
#include "tests/support/memory_sink.h"
#include "tests/support/simulated_map.h"
#include "tests/support/value_of.h"

namespace skyquilt::render {
namespace {

struct Layers {
  test::MemorySink photo, error, height;
};

test::SimulatedMap HillyMap() {
  test::SimulatedMap map = test::MakeSimulatedMap(test::SmallPhotos(9));
  for (std::size_t i = 0; i < map.flight.photos.size(); ++i) {
    map.flight.photos[i].error_radius_m = i % 2 == 0 ? 0.01 : 10.0;
  }
  return map;
}

void Render(const test::SimulatedMap& map, const SeamMap& seams, int threads, Layers& layers) {
  SilentProgress progress;
  const auto rendered = RenderLayers(map.flight, map.ground, seams, map.plan,
                                     {{MapLayer::kPhoto, layers.photo},
                                      {MapLayer::kError, layers.error},
                                      {MapLayer::kHeight, layers.height}},
                                     threads, progress);
  ASSERT_TRUE(rendered.ok()) << rendered.error().message;
}

// The colour of a layer at a point of the ground, at a zoom; nothing where it is empty.
std::optional<Rgb> ColourAt(const test::MemorySink& layer, int zoom, const Eigen::Vector2d& in_merc) {
  const geo::TileId tile = geo::TileId::AtMerc(zoom, in_merc);
  const auto found = layer.tiles.find(tile);
  if (found == layer.tiles.end()) return std::nullopt;
  EXPECT_EQ(found->second.format, image::PictureFormat::kPng);
  const cv::Mat image = cv::imdecode(found->second.bytes, cv::IMREAD_UNCHANGED);
  EXPECT_EQ(image.size(), cv::Size(kLayerTilePx, kLayerTilePx));
  const geo::Bounds2 bounds = tile.BoundsInMerc();
  const double pixel_m = geo::PixelSizeInMercM(zoom, kLayerTilePx);
  const auto pixel = image.at<cv::Vec4b>(static_cast<int>((bounds.max.y() - in_merc.y()) / pixel_m),
                                         static_cast<int>((in_merc.x() - bounds.min.x()) / pixel_m));
  if (pixel[3] == 0) return std::nullopt;
  EXPECT_EQ(pixel[3], 255);
  return Rgb{pixel[2], pixel[1], pixel[0]};
}

geo::Wgs84 GroundBelow(const test::SimulatedMap& map, std::size_t photo) {
  const Eigen::Vector3d below = map.flight.photos[photo].cam_from_enu.TargetOriginInSource();
  return map.flight.frame.Wgs84FromEnu({below.x(), below.y(), map.ground.HeightAt(below.head<2>())});
}

TEST(RenderLayers, NamesThePhotoItsErrorAndTheGroundsHeightAtEveryZoom) {
  const test::SimulatedMap map = HillyMap();
  SeamOptions as_seen;
  as_seen.moves_seams = false;
  const SeamMap seams = map.Seams(as_seen);
  Layers layers;
  Render(map, seams, 2, layers);
  const std::vector<Rgb> colours = PhotoColours(map.flight.photos.size());
  const LayerZooms zooms = ZoomsOfLayers(map.plan);
  EXPECT_LT(zooms.min_zoom, zooms.max_zoom);
  int seen = 0;
  for (std::size_t i = 0; i < map.flight.photos.size(); ++i) {
    // Straight below a camera nobody sees better than that camera.
    const geo::Wgs84 place = GroundBelow(map, i);
    const Eigen::Vector2d in_merc = geo::MercFromLatLon({place.lat_deg, place.lon_deg});
    const auto photo = test::ValueOf(ColourAt(layers.photo, zooms.max_zoom, in_merc));
    if (photo == colours[i])
      ++seen;
    else
      continue;
    EXPECT_EQ(ColourAt(layers.error, zooms.max_zoom, in_merc),
              ErrorColour(map.flight.photos[i].error_radius_m));
    const auto height = test::ValueOf(ColourAt(layers.height, zooms.max_zoom, in_merc));
    const double height_m = height[0] * 256.0 + height[1] + height[2] / 256.0 - 32768.0;
    EXPECT_NEAR(height_m, place.height_ellipsoid_m, 0.05);
    // Coarser tiles hold codes too, never mixtures of them.
    const auto coarse = test::ValueOf(ColourAt(layers.photo, zooms.min_zoom, in_merc));
    EXPECT_NE(std::find(colours.begin(), colours.end(), coarse), colours.end());
  }
  EXPECT_GE(seen, 8);
}

TEST(RenderLayers, AreTheSameWithOneThreadAndWithTwo) {
  const test::SimulatedMap map = HillyMap();
  const SeamMap seams = map.Seams({});
  Layers one, two;
  Render(map, seams, 1, one);
  Render(map, seams, 2, two);
  EXPECT_EQ(one.photo.order, two.photo.order);
  EXPECT_TRUE(one.photo.tiles == two.photo.tiles);
  EXPECT_TRUE(one.error.tiles == two.error.tiles);
  EXPECT_TRUE(one.height.tiles == two.height.tiles);
}

TEST(RenderLayers, CountHeightsFromWhereTheyAreToldTo) {
  const test::SimulatedMap map = HillyMap();
  const SeamMap seams = map.Seams({});
  test::MemorySink recorded, surveyed;
  SilentProgress progress;
  const auto low = RenderLayers(map.flight, map.ground, seams, map.plan, {{MapLayer::kHeight, surveyed}}, 2,
                                progress, -47.25);
  const auto high =
      RenderLayers(map.flight, map.ground, seams, map.plan, {{MapLayer::kHeight, recorded}}, 2, progress);
  ASSERT_TRUE(low.ok() && high.ok());
  EXPECT_NEAR(low->min_m, high->min_m - 47.25, 0.001);
  EXPECT_NEAR(low->max_m, high->max_m - 47.25, 0.001);
  EXPECT_FALSE(recorded.tiles == surveyed.tiles);
}

TEST(RenderLayers, ColourNoErrorOfAlignedPhotosThatNothingSupports) {
  test::SimulatedMap map = HillyMap();
  SeamOptions as_seen;
  as_seen.moves_seams = false;
  const SeamMap seams = map.Seams(as_seen);
  map.flight.photos[4].placement = alignment::Placement::kPoseOnly;  // its record says how far off it is
  test::MemorySink photos, errors;
  SilentProgress progress;
  const auto rendered = RenderLayers(map.flight, map.ground, seams, map.plan,
                                     {{MapLayer::kPhoto, photos}, {MapLayer::kError, errors}}, 2, progress,
                                     0.0, alignment::ErrorsKnown::kOfPoseOnly);
  ASSERT_TRUE(rendered.ok()) << rendered.error().message;
  const std::vector<Rgb> colours = PhotoColours(map.flight.photos.size());
  const int zoom = ZoomsOfLayers(map.plan).max_zoom;
  int seen = 0;
  for (std::size_t i = 0; i < map.flight.photos.size(); ++i) {
    const geo::Wgs84 place = GroundBelow(map, i);
    const Eigen::Vector2d in_merc = geo::MercFromLatLon({place.lat_deg, place.lon_deg});
    if (ColourAt(photos, zoom, in_merc) != colours[i]) continue;
    ++seen;
    EXPECT_EQ(ColourAt(errors, zoom, in_merc), ErrorColour(i == 4 ? 0.01 : std::nan(""))) << i;
  }
  EXPECT_GE(seen, 8);
}

TEST(RenderLayers, StopWhereTheSinkRefuses) {
  class FullDisk final : public pyramid::TileSink {
   public:
    Result<void> Put(const geo::TileId&, image::PictureFormat, std::span<const std::uint8_t>) override {
      return Error{ErrorCode::kOutOfSpace, "no space left", ""};
    }
  } full;
  const test::SimulatedMap map = HillyMap();
  SilentProgress progress;
  const auto rendered =
      RenderLayers(map.flight, map.ground, map.Seams({}), map.plan, {{MapLayer::kPhoto, full}}, 2, progress);
  ASSERT_FALSE(rendered.ok());
  EXPECT_EQ(rendered.error().code, ErrorCode::kOutOfSpace);
}

TEST(MapLayer, GivesEveryPhotoAColourOfItsOwn) {
  const std::vector<Rgb> colours = PhotoColours(20'000);
  EXPECT_EQ(std::set<Rgb>(colours.begin(), colours.end()).size(), colours.size());
}

TEST(MapLayer, ScalesErrorsByTheirLogarithm) {
  EXPECT_EQ(ErrorColour(0.0), ErrorColour(0.01));
  EXPECT_EQ(ErrorColour(1e9), ErrorColour(10.0));
  EXPECT_EQ(ErrorColour(std::nan("")), ErrorColour(10.0));
  EXPECT_NE(ErrorColour(0.1), ErrorColour(0.15));
  EXPECT_NE(ErrorColour(1.0), ErrorColour(1.5));
}

TEST(MapLayer, CodesHeightsToAQuarterOfACentimetre) {
  for (const double height_m : {-430.0, 0.0, 0.004, 123.456, 8848.86}) {
    const Rgb colour = HeightColour(height_m);
    EXPECT_NEAR(colour[0] * 256.0 + colour[1] + colour[2] / 256.0 - 32768.0, height_m, 0.002);
  }
}

}  // namespace
}  // namespace skyquilt::render
