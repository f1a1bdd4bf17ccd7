#include "core/render/render_tiles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include "core/geo/tile_id.h"
#include "core/render/blocks/block_digest.h"
#include "core/render/blocks/block_geometry.h"
#include "tests/support/map_truth.h"
#include "tests/support/memory_sink.h"
#include "tests/support/simulated_map.h"
#include "tests/support/value_of.h"

namespace skyquilt::render {
namespace {

test::SimulatedMap SmallMap(const PlanOptions& plan = {}) {
  simulate::SimulateOptions options = test::SmallPhotos(9);
  options.intrinsics.k1 = -0.1;
  options.trajectory.yaw_rule = simulate::YawRule::kAnywhere;
  options.vignetting = 0.2;
  options.exposure_jitter = 0.08;
  return test::MakeSimulatedMap(options, plan);
}

// The same map cut into blocks of another size.
MosaicPlan WithBlockLevels(const MosaicPlan& plan, int block_levels) {
  MosaicPlan other = plan;
  other.block_levels = block_levels;
  const int block_zoom = plan.base_zoom - block_levels;
  std::map<std::uint64_t, RenderBlock> blocks;
  for (const RenderBlock& block : plan.blocks) {
    const int finer = block_zoom - block.tile.z();
    const int across = finer > 0 ? 1 << finer : 1;
    for (int y = 0; y < across; ++y) {
      for (int x = 0; x < across; ++x) {
        const std::int64_t column =
            finer > 0 ? (std::int64_t{block.tile.x()} << finer) + x : block.tile.x() >> -finer;
        const std::int64_t row =
            finer > 0 ? (std::int64_t{block.tile.y()} << finer) + y : block.tile.y() >> -finer;
        RenderBlock& made = blocks[geo::HilbertIndex(block_zoom, static_cast<std::uint32_t>(column),
                                                     static_cast<std::uint32_t>(row))];
        made.tile = *geo::TileId::Make(block_zoom, column, row);
        std::vector<std::uint32_t> photos;
        std::set_union(made.photos.begin(), made.photos.end(), block.photos.begin(), block.photos.end(),
                       std::back_inserter(photos));
        made.photos = photos;
      }
    }
  }
  other.blocks.clear();
  for (auto& [index, block] : blocks) other.blocks.push_back(block);
  return other;
}

TEST(RenderTiles, DoesNotDependOnBlockSizeOrThreads) {
  test::SimulatedMap map = SmallMap();
  const SeamMap seams = map.Seams({});
  const MosaicPlan planned = map.plan;
  ASSERT_EQ(planned.block_levels, 2);
  test::MemorySink expected;
  RenderMap(map, seams, 1, expected);
  EXPECT_GT(expected.tiles.size(), 30u);
  // Above a block its topmost tile as it is stored is what parents are made from: which zoom that is, is the
  // plan's. Up to there the same pixels come from blocks of all sizes.
  const auto up_to = [&](const test::MemorySink& sink, int levels) {
    auto tiles = sink.tiles;
    std::erase_if(tiles, [&](const auto& tile) { return tile.first.z() < planned.base_zoom - levels; });
    return tiles;
  };
  for (const int block_levels : {0, 1, 2}) {
    for (const int threads : {1, 2}) {
      map.plan = WithBlockLevels(planned, block_levels);
      test::MemorySink tiles;
      RenderMap(map, seams, threads, tiles);
      EXPECT_EQ(tiles.tiles.size(), expected.tiles.size());
      EXPECT_TRUE(up_to(tiles, block_levels) == up_to(expected, block_levels))
          << block_levels << " block levels, " << threads << " threads";
      if (block_levels == 2) {
        EXPECT_TRUE(tiles.tiles == expected.tiles) << threads << " threads";
      }
    }
  }
}

TEST(RenderTiles, ShowsTheWorldWhereItIs) {
  const test::SimulatedMap map = SmallMap();
  test::MemorySink tiles;
  RenderMap(map, map.Seams({}), 2, tiles);
  const test::MapError error = test::MeasureMapError(tiles, map.truth.world, map.flight.frame);
  EXPECT_GT(error.patches, 20);
  EXPECT_LT(error.shift_rmse_px, 0.25);
}

// Whatever is covered is as bright in an overview as in the tiles below it: no dark fringe at the map's edge.
TEST(RenderTiles, OverviewsHaveNoFringe) {
  const test::SimulatedMap map = SmallMap();
  test::MemorySink tiles;
  RenderMap(map, map.Seams({}), 2, tiles);
  double darkest = 255.0;
  int fringe_pixels = 0;
  for (const auto& [tile, stored] : tiles.tiles) {
    if (tile.z() == map.plan.base_zoom || stored.format != image::PictureFormat::kPng) continue;
    const cv::Mat image = cv::imdecode(stored.bytes, cv::IMREAD_UNCHANGED);
    for (int y = 1; y + 1 < image.rows; ++y) {
      for (int x = 1; x + 1 < image.cols; ++x) {
        const auto pixel = image.at<cv::Vec4b>(y, x);
        if (pixel[3] == 0 || pixel[3] == 255) continue;
        // Against the brightest fully covered neighbour.
        for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
          const auto inner = image.at<cv::Vec4b>(y + dy, x + dx);
          if (inner[3] != 255) continue;
          ++fringe_pixels;
          darkest = std::min(darkest, (pixel[0] + pixel[1] + pixel[2] + 1.0) /
                                          (inner[0] + inner[1] + inner[2] + 1.0) * 255.0);
          break;
        }
      }
    }
  }
  EXPECT_GT(fringe_pixels, 100);
  // A fringe would be black mixed in: half of what lies beside it or less.
  EXPECT_GT(darkest, 90.0);
}

// A photo of rings that grow finer outwards, rendered at a quarter of its resolution: what cannot be shown
// must turn to grey, not to other rings.
TEST(RenderTiles, DoesNotAlias) {
  class ZonePlate final : public flight::PhotoSource {
   public:
    Result<image::DecodedImage> Decode(const flight::Photo& photo, int denominator) const override {
      image::DecodedImage image{photo.intrinsics.width_px, photo.intrinsics.height_px, {}};
      image.rgb.resize(static_cast<std::size_t>(image.width_px) * image.height_px * 3);
      cv::Mat whole(image.height_px, image.width_px, CV_8UC3, image.rgb.data());
      for (int y = 0; y < whole.rows; ++y) {
        for (int x = 0; x < whole.cols; ++x) {
          const double r2 = std::pow(x - 0.5 * whole.cols, 2) + std::pow(y - 0.5 * whole.rows, 2);
          // Reaches a period of two pixels at the image's upper edge.
          const auto value =
              static_cast<uchar>(std::lround(127.5 + 110.0 * std::cos(3.14159265 * r2 / whole.rows)));
          whole.at<cv::Vec3b>(y, x) = {value, value, value};
        }
      }
      return test::AtSize(image, denominator);
    }
  };
  simulate::SimulateOptions options;
  options.intrinsics = camera::Intrinsics::Centered(1200, 1200, 900.0);
  options.trajectory.photos = 1;
  for (const double times_coarser : {1.3, 2.0, 2.8, 4.0, 6.0}) {
    test::SimulatedMap map = test::MakeSimulatedMap(options);
    map.plan = *PlanMosaic(map.flight, map.ground, {.gsd_m = times_coarser * map.plan.gsd_m});
    const ZonePlate zone_plate;
    map.thumbnails = {*MakeThumbnail(zone_plate, map.flight.photos[0].photo)};
    PhotoCache cache(zone_plate, std::int64_t{1} << 28);
    const SeamMap seams = map.Seams({});
    double worst = 0.0;
    int looked_at = 0;
    for (const RenderBlock& block : map.plan.blocks) {
      const auto image = test::ValueOf(
          RenderBlockPixels({map.flight, map.ground, map.exposure, seams, map.plan, cache}, block));
      const BlockGeometry geometry =
          MakeBlockGeometry(block.tile, map.plan.BlockSizePx(), map.flight.frame, map.ground);
      const PhotoView view = ViewBlock(map.flight.photos[0], geometry);
      const double shrink = (view.pixel_in_image[1] - view.pixel_in_image[0]).norm() / kNodeStepPx;
      for (int node = 0; node + geometry.nodes_per_side + 1 < static_cast<int>(view.pixel_in_image.size());
           ++node) {
        const int column = node % geometry.nodes_per_side, row = node / geometry.nodes_per_side;
        if (column + 1 == geometry.nodes_per_side || row + 1 == geometry.nodes_per_side) continue;
        const Eigen::Vector2f at = view.pixel_in_image[static_cast<std::size_t>(node)];
        const double r = std::hypot(at.x() - 600.0, at.y() - 600.0);
        // Frequency there, cycles a map pixel: well beyond what the map can hold, and inside the photo.
        const double cycles = r / 1200.0 * shrink;
        if (!(cycles > 0.85) || r > 560.0 || std::isnan(at.x())) continue;
        double sum = 0.0, squares = 0.0;
        for (int y = 0; y < kNodeStepPx; ++y) {
          for (int x = 0; x < kNodeStepPx; ++x) {
            const double value = image.Pixel(column * kNodeStepPx + x, row * kNodeStepPx + y)[0];
            sum += value, squares += value * value;
          }
        }
        const double pixels = kNodeStepPx * kNodeStepPx;
        worst = std::max(worst, std::sqrt(std::max(0.0, squares / pixels - std::pow(sum / pixels, 2))));
        ++looked_at;
      }
    }
    if (times_coarser >= 4.0) {
      EXPECT_GT(looked_at, 5) << times_coarser;
    }
    // Aliased rings would have the full contrast: a deviation of 78.
    EXPECT_LT(worst, 25.0) << "coarser by " << times_coarser;
  }
}

// A triangle over the middle of the map, its corners given in the local frame.
geo::Boundary TriangleOver(const test::SimulatedMap& map, double aside_m) {
  geo::Boundary::Ring ring;
  for (const Eigen::Vector2d& corner :
       {Eigen::Vector2d(-20.0, -15.0), Eigen::Vector2d(22.0, -9.0), Eigen::Vector2d(1.0, 18.0)}) {
    const geo::Wgs84 at = map.flight.frame.Wgs84FromEnu({corner.x() + aside_m, corner.y(), 0.0});
    ring.push_back({at.lat_deg, at.lon_deg});
  }
  ring.push_back(ring.front());
  return {{{ring}}};
}

TEST(RenderTiles, ABoundaryCutsPixelsAndChangesNoneOfTheRest) {
  const test::SimulatedMap whole = SmallMap();
  const geo::Boundary triangle = TriangleOver(whole, 0.0);
  PlanOptions options;
  options.boundary = &triangle;
  const test::SimulatedMap cut = SmallMap(options);
  ASSERT_LT(cut.plan.blocks.size(), whole.plan.blocks.size());
  ASSERT_EQ(cut.plan.base_zoom, whole.plan.base_zoom);
  const SeamMap whole_seams = whole.Seams({}), cut_seams = cut.Seams({});
  PhotoCache whole_cache(*whole.photos, 1 << 28), cut_cache(*cut.photos, 1 << 28);
  const geo::BoundaryOnZoom on_blocks(triangle, whole.plan.base_zoom - whole.plan.block_levels,
                                      whole.plan.BlockSizePx());
  std::int64_t inside_pixels = 0, outside_pixels = 0;
  for (const RenderBlock& block : whole.plan.blocks) {
    std::vector<std::uint8_t> inside;
    const bool is_beyond = on_blocks.Mask(block.tile, inside) == geo::Cover::kNone;
    const auto kept = std::find_if(cut.plan.blocks.begin(), cut.plan.blocks.end(),
                                   [&](const RenderBlock& one) { return one.tile == block.tile; });
    ASSERT_EQ(kept == cut.plan.blocks.end(), is_beyond);
    if (is_beyond) continue;
    const auto before = RenderBlockPixels(
        {whole.flight, whole.ground, whole.exposure, whole_seams, whole.plan, whole_cache}, block);
    const auto after =
        RenderBlockPixels({cut.flight, cut.ground, cut.exposure, cut_seams, cut.plan, cut_cache}, *kept);
    ASSERT_TRUE(before.ok() && after.ok());
    for (std::size_t i = 0; i < inside.size(); ++i) {
      for (std::size_t channel = 0; channel < 4; ++channel) {
        const std::uint8_t expected = inside[i] != 0 ? before->rgba[4 * i + channel] : std::uint8_t{0};
        ASSERT_EQ(after->rgba[4 * i + channel], expected);
      }
      ++(inside[i] != 0 ? inside_pixels : outside_pixels);
    }
  }
  EXPECT_GT(inside_pixels, 1000);
  EXPECT_GT(outside_pixels, 1000);
}

// By the equator a metre of Mercator is 0.7 % less ground from north to south than from east to west.
TEST(RenderTiles, TellsHowMuchGroundTheMapShows) {
  simulate::SimulateOptions options = test::SmallPhotos(9);
  options.origin = {0.3, 7.1};
  test::SimulatedMap map = test::MakeSimulatedMap(options);
  const geo::Boundary triangle = TriangleOver(map, 0.0);
  PlanOptions plan;
  plan.boundary = &triangle;
  map.plan = *PlanMosaic(map.flight, map.ground, plan);
  const SeamMap seams = map.Seams({});
  PhotoCache cache(*map.photos, 1 << 28);
  test::MemorySink tiles;
  SilentProgress progress;
  const RenderContext context{map.flight, map.ground, map.exposure, seams, map.plan, cache};
  const auto report = RenderTiles(context, {2, {image::TileEncoding::kJpegPng, 95}}, tiles, progress);
  ASSERT_TRUE(report.ok());
  EXPECT_NEAR(report->covered_m2 / geo::AreaM2(triangle), 1.0, 0.002);
}

// Of samples that are more than bytes: the same file in another range is another picture.
TEST(RenderTiles, ABlockIsAnotherWhereItsPhotosAreDrawnInAnotherRange) {
  test::SimulatedMap map = SmallMap();
  const SeamMap seams = map.Seams({});
  PhotoCache cache(*map.photos, 1 << 28);
  const RenderContext context{map.flight, map.ground, map.exposure, seams, map.plan, cache};
  const std::vector<Digest> files(map.flight.photos.size());
  const auto digests = [&] {
    std::vector<Digest> of_blocks;
    for (const RenderBlock& block : map.plan.blocks) {
      of_blocks.push_back(DigestBlock(context, pyramid::EncodeOptions{image::TileEncoding::kJpegPng, 95},
                                      files, block, GeometryOf(context, block)));
    }
    return of_blocks;
  };
  const std::vector<Digest> drawn_as_bytes = digests();
  const auto draw_in = [&](double high) {
    for (alignment::AlignedPhoto& photo : map.flight.photos)
      photo.photo.sample_range = flight::SampleRange{1000.0, high};
  };
  draw_in(5000.0);
  const std::vector<Digest> dark = digests();
  draw_in(4000.0);
  EXPECT_NE(dark, drawn_as_bytes);
  EXPECT_NE(digests(), dark);
  draw_in(5000.0);
  EXPECT_EQ(digests(), dark);
}

TEST(RenderTiles, ABoundaryElsewhereIsRefusedWithTheFlightsPlace) {
  const test::SimulatedMap map = SmallMap();
  const geo::Boundary far = TriangleOver(map, 20'000.0);
  PlanOptions options;
  options.boundary = &far;
  const Error plan = test::ErrorOf(PlanMosaic(map.flight, map.ground, options));
  EXPECT_EQ(plan.code, ErrorCode::kUnprocessable);
  EXPECT_NE(plan.message.find("46.80000, 7.10000"), std::string::npos) << plan.message;
}

}  // namespace
}  // namespace skyquilt::render
