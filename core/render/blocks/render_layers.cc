#include "core/render/blocks/render_layers.h"

#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <memory>
#include <optional>

#include "core/base/bilinear_grid.h"
#include "core/base/parallel_for.h"
#include "core/image/png_encoder.h"
#include "core/pyramid/build_overviews.h"
#include "core/render/blocks/block_geometry.h"
#include "core/render/blocks/weigh_block.h"

namespace skyquilt::render {
namespace {

constexpr HeightRange kNoHeights{std::numeric_limits<double>::infinity(),
                                 -std::numeric_limits<double>::infinity()};
constexpr std::size_t kPixels = static_cast<std::size_t>(kLayerTilePx) * kLayerTilePx;

// By pixel of the layers' tile: the photo that shows most of it; kNoPhoto where less than half of it is
// shown.
std::vector<std::int32_t> OwnersOf(const WeighedBlock& block, const BlockBoundary& boundary) {
  const int step = block.geometry.size_px / kLayerTilePx;
  std::vector<float> total(kPixels, 0.0f), most(kPixels, 0.0f), own(kPixels, 0.0f);
  std::vector<std::int32_t> owners(kPixels, kNoPhoto);
  const int side = block.shares.square_px;
  for (const PhotoShare& share : block.shares.photos) {
    std::fill(own.begin(), own.end(), 0.0f);
    for (const SquareShare& square : share.squares) {
      const bool is_alone = square.first_weight == SquareShare::kAlone;
      const float* weight = is_alone ? nullptr : share.weights.data() + square.first_weight;
      for (int y = square.y; y < square.y + side; ++y) {
        for (int x = square.x; x < square.x + side; ++x) {
          const float of_pixel = is_alone ? 1.0f : *weight++;
          if (!boundary.Holds(x, y)) continue;
          own[static_cast<std::size_t>(y / step) * kLayerTilePx + static_cast<std::size_t>(x / step)] +=
              of_pixel;
        }
      }
    }
    for (std::size_t i = 0; i < kPixels; ++i) {
      total[i] += own[i];
      if (own[i] > most[i]) most[i] = own[i], owners[i] = static_cast<std::int32_t>(share.photo);
    }
  }
  const float half = 0.5f * static_cast<float>(step) * static_cast<float>(step);
  for (std::size_t i = 0; i < kPixels; ++i) {
    if (total[i] < half) owners[i] = kNoPhoto;
  }
  return owners;
}

// Heights of the ground at the middles of the layers' pixels, `raised_m` higher.
std::vector<double> HeightsOf(const BlockGeometry& geometry, const geo::LocalFrame& frame, double raised_m) {
  std::vector<float> at_nodes;
  at_nodes.reserve(geometry.ground_in_enu.size());
  for (const Eigen::Vector3d& ground : geometry.ground_in_enu) {
    at_nodes.push_back(static_cast<float>(frame.Wgs84FromEnu(ground).height_ellipsoid_m + raised_m));
  }
  const double step = static_cast<double>(geometry.size_px) / kLayerTilePx;
  std::vector<double> heights(kPixels);
  const auto node = [&](int pixel) { return ((pixel + 0.5) * step - 0.5) / geometry.node_step_px; };
  const int side = geometry.nodes_per_side;
  for (int y = 0; y < kLayerTilePx; ++y) {
    for (int x = 0; x < kLayerTilePx; ++x) {
      heights[static_cast<std::size_t>(y) * kLayerTilePx + static_cast<std::size_t>(x)] =
          BilinearAt(at_nodes, side, side, node(x), node(y));
    }
  }
  return heights;
}

template <typename ColourOf>
image::RgbaImage Draw(const std::vector<std::int32_t>& owners, const ColourOf& colour_of) {
  image::RgbaImage image = image::RgbaImage::Transparent(kLayerTilePx, kLayerTilePx);
  for (std::size_t i = 0; i < kPixels; ++i) {
    if (owners[i] == kNoPhoto) continue;
    const Rgb colour = colour_of(i, static_cast<std::size_t>(owners[i]));
    std::copy(colour.begin(), colour.end(), image.rgba.begin() + static_cast<std::ptrdiff_t>(4 * i));
    image.rgba[4 * i + 3] = 255;
  }
  return image;
}

// A block in every layer.
struct DrawnBlock {
  std::vector<image::RgbaImage> images;  // by layer; none where nothing is covered
  HeightRange heights = kNoHeights;
};

// One layer's pyramid while its blocks arrive.
class LayerPyramid {
 public:
  LayerPyramid(pyramid::TileSink& sink, const LayerZooms& zooms)
      : sink_(sink),
        overviews_(
            zooms.max_zoom, zooms.min_zoom, kLayerTilePx,
            [this](const geo::TileId& tile, const image::RgbaImage& image) { Put(tile, image); },
            pyramid::EveryOther) {}

  void Add(const geo::TileId& tile, const image::RgbaImage& image) {
    Put(tile, image);
    overviews_.AddHalf(tile, pyramid::EveryOther(image));
  }
  void Finish() { overviews_.Finish(); }
  const std::optional<Error>& failure() const { return failure_; }

 private:
  void Put(const geo::TileId& tile, const image::RgbaImage& image) {
    if (failure_) return;
    const std::vector<std::uint8_t> png = image::EncodePng(image, 0, 0, kLayerTilePx);
    if (auto put = sink_.Put(tile, image::PictureFormat::kPng, png); !put) failure_ = put.error();
  }

  pyramid::TileSink& sink_;
  pyramid::OverviewBuilder overviews_;
  std::optional<Error> failure_;
};

}  // namespace

LayerZooms ZoomsOfLayers(const MosaicPlan& plan) {
  const int block_zoom = plan.base_zoom - plan.block_levels;
  return {std::min(plan.min_zoom, block_zoom), block_zoom};
}

Result<HeightRange> RenderLayers(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                                 const SeamMap& seams, const MosaicPlan& plan,
                                 const std::vector<LayerSink>& layers, int threads, Progress& progress,
                                 double raised_m, alignment::ErrorsKnown known) {
  const std::vector<Rgb> photo_colours = PhotoColours(flight.photos.size());
  const auto error_colour = [&](const alignment::AlignedPhoto& photo) {
    constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();
    return ErrorColour(alignment::KnownErrorM(photo, known).value_or(kNotKnown));
  };
  const auto draw = [&](const RenderBlock& block) {
    DrawnBlock drawn;
    const WeighedBlock weighed =
        WeighBlock(flight, ground, seams, plan, block,
                   MakeBlockGeometry(block.tile, plan.BlockSizePx(), flight.frame, ground));
    const std::vector<std::int32_t> owners = OwnersOf(weighed, BlockBoundary(plan, block.tile));
    if (std::all_of(owners.begin(), owners.end(), [](std::int32_t owner) { return owner == kNoPhoto; })) {
      return drawn;
    }
    for (const LayerSink& layer : layers) {
      switch (layer.layer) {
        case MapLayer::kPhoto:
          drawn.images.push_back(
              Draw(owners, [&](std::size_t, std::size_t photo) { return photo_colours[photo]; }));
          break;
        case MapLayer::kError:
          drawn.images.push_back(Draw(
              owners, [&](std::size_t, std::size_t photo) { return error_colour(flight.photos[photo]); }));
          break;
        case MapLayer::kHeight: {
          const std::vector<double> heights = HeightsOf(weighed.geometry, flight.frame, raised_m);
          drawn.images.push_back(Draw(owners, [&](std::size_t pixel, std::size_t) {
            drawn.heights.min_m = std::min(drawn.heights.min_m, heights[pixel]);
            drawn.heights.max_m = std::max(drawn.heights.max_m, heights[pixel]);
            return HeightColour(heights[pixel]);
          }));
          break;
        }
      }
    }
    return drawn;
  };

  std::vector<std::unique_ptr<LayerPyramid>> pyramids;
  pyramids.reserve(layers.size());
  for (const LayerSink& layer : layers) {
    pyramids.push_back(std::make_unique<LayerPyramid>(layer.sink, ZoomsOfLayers(plan)));
  }
  std::atomic<bool> stop{false};
  const std::size_t count = plan.blocks.size();
  const std::size_t window = 2 * static_cast<std::size_t>(ThreadCount(threads)) + 2;
  HeightRange heights = kNoHeights;
  ParallelOrdered<DrawnBlock>(
      count, threads, window,
      [&](std::size_t i) { return stop || progress.IsCancelled() ? DrawnBlock() : draw(plan.blocks[i]); },
      [&](std::size_t i, DrawnBlock&& drawn) {
        heights.min_m = std::min(heights.min_m, drawn.heights.min_m);
        heights.max_m = std::max(heights.max_m, drawn.heights.max_m);
        for (std::size_t k = 0; k < drawn.images.size(); ++k) {
          pyramids[k]->Add(plan.blocks[i].tile, drawn.images[k]);
          if (pyramids[k]->failure()) stop = true;
        }
        progress.Report(static_cast<double>(i + 1) / static_cast<double>(count),
                        fmt::format("block {} of {}", i + 1, count));
      });
  if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "The job was cancelled.", ""};
  for (const auto& pyramid : pyramids) {
    pyramid->Finish();
    if (pyramid->failure()) return *pyramid->failure();
  }
  return heights.min_m <= heights.max_m ? heights : HeightRange{};
}

}  // namespace skyquilt::render
