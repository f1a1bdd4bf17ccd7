#include "core/render/blocks/render_block.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include "core/base/try.h"
#include "core/geo/web_mercator.h"
#include "core/render/blocks/block_weights.h"
#include "core/render/blocks/cubic_sampler.h"
#include "core/render/blocks/weigh_block.h"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace skyquilt::render {
namespace {

// Four numbers side by side: red, green, blue and one that means nothing.
using Four = float __attribute__((vector_size(16)));

Four FourOf(const std::array<double, 3>& values) {
  return Four{static_cast<float>(values[0]), static_cast<float>(values[1]), static_cast<float>(values[2]),
              0.0f};
}

Four Between(const Four& a, const Four& b, float share) { return a + share * (b - a); }

// A quantity at a square's four corners; its rows' ends and steps.
template <typename T>
struct Ends {
  T first, step;
};
template <typename T>
Ends<T> RowOf(const std::array<T, 4>& corners, int row, int side) {
  const float v = static_cast<float>(row) / static_cast<float>(side);
  const T west = corners[0] + v * (corners[2] - corners[0]);
  const T east = corners[1] + v * (corners[3] - corners[1]);
  return {west, (east - west) * (1.0f / static_cast<float>(side))};
}

// How one photo's pixels come onto the block.
class PhotoOnBlock {
 public:
  PhotoOnBlock(const alignment::AlignedPhoto& photo, const PhotoTone& tone, const PhotoView& view,
               const BlockGeometry& geometry, int denominator, const PhotoLevels& levels,
               const BlockCells& cells)
      : view_(view),
        nodes_per_side_(geometry.nodes_per_side),
        step_px_(geometry.node_step_px),
        scale_(1.0f / static_cast<float>(denominator)),
        levels_(levels),
        cells_(cells),
        gain_(FourOf(tone.gain)),
        shade_(tone.shade, photo.intrinsics) {}

  int NodeStepPx() const { return step_px_; }
  // Light at the corners of a square of the block: north-west, north-east, south-west, south-east.
  struct Tone {
    std::array<Four, 4> gain;
    std::array<Four, 4> light;  // what the seam map adds, grey levels
  };
  // Nothing where the photo does not see one of them.
  std::optional<Tone> ToneOf(int block_x, int block_y, int side) const {
    Tone tone;
    for (int corner = 0; corner < 4; ++corner) {
      const auto k = static_cast<std::size_t>(corner);
      const int x = block_x + (corner % 2) * side, y = block_y + (corner / 2) * side;
      const Eigen::Vector2f in_photo = InPhoto(x, y, block_x, block_y, std::max(side, step_px_));
      if (std::isnan(in_photo.x())) return std::nullopt;
      const auto shade = shade_.At(in_photo.x(), in_photo.y());
      tone.gain[k] = gain_ * Four{shade[0], shade[1], shade[2], 1.0f};
      tone.light[k] = LightAt(x, y, block_x, block_y);
    }
    return tone;
  }

  // Where in the decoded image its pixels lie, row by row.
  void PlacesOf(int block_x, int block_y, int side, float* x, float* y) const {
    const int part = std::min(side, step_px_);
    for (int top = 0; top < side; top += part) {
      for (int left = 0; left < side; left += part) {
        std::array<float, 4> corner_x, corner_y;
        for (int corner = 0; corner < 4; ++corner) {
          const auto k = static_cast<std::size_t>(corner);
          const Eigen::Vector2f in_photo =
              InPhoto(block_x + left + (corner % 2) * part, block_y + top + (corner / 2) * part,
                      block_x + left, block_y + top, step_px_);
          // Pixel corners scale, centres carry the half pixel.
          corner_x[k] = (in_photo.x() + 0.5f) * scale_ - 0.5f;
          corner_y[k] = (in_photo.y() + 0.5f) * scale_ - 0.5f;
        }
        for (int row = 0; row < part; ++row) {
          const auto along_x = RowOf(corner_x, row, part), along_y = RowOf(corner_y, row, part);
          const int first = (top + row) * side + left;
          for (int i = 0; i < part; ++i) {
            x[first + i] = along_x.first + static_cast<float>(i) * along_x.step;
            y[first + i] = along_y.first + static_cast<float>(i) * along_y.step;
          }
        }
      }
    }
  }

 private:
  // Bilinear between the nodes around the square that starts at (block_x, block_y), `apart_px` from each
  // other.
  Eigen::Vector2f InPhoto(int x, int y, int block_x, int block_y, int apart_px) const {
    const int column = block_x / step_px_, row = block_y / step_px_;
    const auto per_px = 1.0f / static_cast<float>(apart_px);
    const float u = static_cast<float>(x - column * step_px_) * per_px;
    const float v = static_cast<float>(y - row * step_px_) * per_px;
    const std::ptrdiff_t apart = apart_px / step_px_, below = apart * nodes_per_side_;
    const Eigen::Vector2f* nw =
        view_.pixel_in_image.data() + static_cast<std::ptrdiff_t>(row) * nodes_per_side_ + column;
    const Eigen::Vector2f north = nw[0] + u * (nw[apart] - nw[0]);
    const Eigen::Vector2f south = nw[below] + u * (nw[below + apart] - nw[below]);
    return north + v * (south - north);
  }

  // Bilinear between the centres of the seam map's cells, of which the square lies between four.
  Four LightAt(int x, int y, int block_x, int block_y) const {
    if (levels_.eighths.empty()) return Four{};
    const int cell_px = cells_.seams.grid.cell_px;
    // Of the centre that lies north-west of the whole square.
    const int column = (block_x + cell_px / 2) / cell_px - 1, row = (block_y + cell_px / 2) / cell_px - 1;
    const auto part = [&](int pixel, int cell) {
      return (static_cast<float>(pixel - cell * cell_px) + 0.5f) / static_cast<float>(cell_px) - 0.5f;
    };
    const auto level = [&](int dx, int dy) {
      const auto rgb = levels_.At(cells_.corner.x() + column + dx, cells_.corner.y() + row + dy);
      return Four{rgb[0], rgb[1], rgb[2], 0.0f};
    };
    const float u = part(x, column), v = part(y, row);
    return Between(Between(level(0, 0), level(1, 0), u), Between(level(0, 1), level(1, 1), u), v);
  }

  const PhotoView& view_;
  const int nodes_per_side_, step_px_;
  const float scale_;
  const PhotoLevels& levels_;
  const BlockCells& cells_;
  const Four gain_;
  const ShadeGrid shade_;
};

Four Clamped(Four value) {
  const Four black{}, white = black + 255.0f;
  value = value > black ? value : black;
  return value < white ? value : white;
}

// Of numbers from 0 to 255.
void Write(const Four& value, std::uint8_t* rgba) {
#if defined(__SSE2__)
  const __m128i whole = _mm_cvttps_epi32(value + 0.5f);
  const __m128i halves = _mm_packs_epi32(whole, whole);
  const auto pixel =
      static_cast<std::uint32_t>(_mm_cvtsi128_si32(_mm_packus_epi16(halves, halves))) | 0xff000000U;
  std::memcpy(rgba, &pixel, 4);
#else
  using FourInts = std::int32_t __attribute__((vector_size(16)));
  using FourBytes = std::uint8_t __attribute__((vector_size(4)));
  const FourBytes bytes = __builtin_convertvector(__builtin_convertvector(value + 0.5f, FourInts), FourBytes);
  std::memcpy(rgba, &bytes, 4);
  rgba[3] = 255;
#endif
}

// Squares in which photos mix: their weighted sums until all have been added.
class Mixture {
 public:
  Mixture(int block_px, int square_px)
      : across_(block_px / square_px),
        square_px_(square_px),
        first_(static_cast<std::size_t>(across_) * across_, kNone) {}

  // The sums of the square's pixels, row by row; the fourth number is not 0 where something was added.
  Four* Sums(int x, int y) {
    std::int32_t& first = first_[static_cast<std::size_t>(y / square_px_) * across_ + x / square_px_];
    if (first == kNone) {
      first = static_cast<std::int32_t>(sums_.size());
      sums_.resize(sums_.size() + static_cast<std::size_t>(square_px_) * square_px_, Four{});
    }
    return sums_.data() + first;
  }

  void WriteTo(image::RgbaImage& image) const {
    for (std::size_t square = 0; square < first_.size(); ++square) {
      if (first_[square] == kNone) continue;
      const Four* sum = sums_.data() + first_[square];
      const int x = static_cast<int>(square) % across_ * square_px_,
                y = static_cast<int>(square) / across_ * square_px_;
      for (int dy = 0; dy < square_px_; ++dy) {
        for (int dx = 0; dx < square_px_; ++dx, ++sum) {
          if ((*sum)[3] > 0.0f) Write(Clamped(*sum), image.Pixel(x + dx, y + dy));
        }
      }
    }
  }

 private:
  static constexpr std::int32_t kNone = -1;
  const int across_, square_px_;
  std::vector<std::int32_t> first_;  // by square, in sums_
  std::vector<Four> sums_;
};

// What a photo has of a square's pixels.
class Painter {
 public:
  Painter(const PhotoShare& share, const PhotoOnBlock& photo, const CubicSampler& sampler, int square_px,
          image::RgbaImage& image, Mixture& mixture)
      : share_(share),
        photo_(photo),
        sampler_(sampler),
        square_px_(square_px),
        image_(image),
        mixture_(mixture) {}

  void Paint() {
    for (const SquareShare& square : share_.squares) {
      if (const auto tone = photo_.ToneOf(square.x, square.y, square_px_)) {
        PaintPart(square, square.x, square.y, square_px_, *tone);
        continue;
      }
      // Some of it lies where the photo sees nothing.
      const int part_px = std::min(square_px_, photo_.NodeStepPx());
      for (int y = square.y; y < square.y + square_px_; y += part_px) {
        for (int x = square.x; x < square.x + square_px_; x += part_px)
          if (const auto tone = photo_.ToneOf(x, y, part_px)) PaintPart(square, x, y, part_px, *tone);
      }
    }
  }

 private:
  static constexpr std::size_t kMaxPixels = std::size_t{kNodeStepPx} * kNodeStepPx;

  void PaintPart(const SquareShare& square, int left, int top, int side, const PhotoOnBlock::Tone& tone) {
    const bool is_alone = square.first_weight == SquareShare::kAlone;
    photo_.PlacesOf(left, top, side, x_.data(), y_.data());
    sampler_.At(x_.data(), y_.data(), side * side, sampled_.data());
    for (int row = 0; row < side; ++row) {
      const auto gain = RowOf(tone.gain, row, side), light = RowOf(tone.light, row, side);
      const SampledPixel* sampled = sampled_.data() + static_cast<std::ptrdiff_t>(row) * side;
      std::uint8_t* out = image_.Pixel(left, top + row);
      const int in_square = (top + row - square.y) * square_px_ + left - square.x;
      const float* weights = is_alone ? nullptr : share_.weights.data() + square.first_weight + in_square;
      Four* sums = is_alone ? nullptr : mixture_.Sums(square.x, square.y) + in_square;
      for (int i = 0; i < side; ++i) {
        Four value;
        std::memcpy(&value, sampled[i].data(), sizeof(value));
        const auto along = static_cast<float>(i);
        value = Clamped(value * (gain.first + along * gain.step) + (light.first + along * light.step));
        if (is_alone) {
          Write(value, out + 4 * i);
        } else if (weights[i] > 0.0f) {
          value[3] = 1.0f;
          sums[i] += weights[i] * value;
        }
      }
    }
  }

  const PhotoShare& share_;
  const PhotoOnBlock& photo_;
  const CubicSampler& sampler_;
  const int square_px_;
  image::RgbaImage& image_;
  Mixture& mixture_;
  std::array<float, kMaxPixels> x_, y_;
  std::array<SampledPixel, kMaxPixels> sampled_;
};

}  // namespace

double OutputPixelM(const MosaicPlan& plan, const alignment::AlignedFlight& flight) {
  return geo::PixelSizeInMercM(plan.base_zoom, plan.tile_size_px) *
         geo::GroundMetresPerMercMetre(flight.frame.origin().lat_deg);
}

int DenominatorFor(const alignment::AlignedPhoto& photo, double output_pixel_m) {
  const double photo_pixel_m = std::max(1.0, photo.height_above_ground_m) / photo.intrinsics.MeanFocalPx();
  const double minification = output_pixel_m / photo_pixel_m;
  int denominator = 1;
  while (denominator < 8 && minification / denominator > 1.45) denominator *= 2;
  return denominator;
}

BlockGeometry GeometryOf(const RenderContext& context, const RenderBlock& block) {
  return MakeBlockGeometry(block.tile, context.plan.BlockSizePx(), context.flight.frame, context.ground);
}

Result<image::RgbaImage> RenderBlockPixels(const RenderContext& context, const RenderBlock& block) {
  return RenderBlockPixels(context, block, GeometryOf(context, block));
}

Result<image::RgbaImage> RenderBlockPixels(const RenderContext& context, const RenderBlock& block,
                                           BlockGeometry ground_below) {
  const int size_px = context.plan.BlockSizePx();
  const auto [cells, geometry, photos, views, shares] =
      WeighBlock(context.flight, context.ground, context.seams, context.plan, block, std::move(ground_below));

  image::RgbaImage image = image::RgbaImage::Transparent(size_px, size_px);
  Mixture mixture(size_px, shares.square_px);
  const double pixel_m = OutputPixelM(context.plan, context.flight);
  for (const PhotoShare& share : shares.photos) {
    const alignment::AlignedPhoto& photo = context.flight.photos[share.photo];
    const auto at = std::lower_bound(photos.begin(), photos.end(), share.photo) - photos.begin();
    const int denominator = DenominatorFor(photo, pixel_m);
    const PhotoView& view = views[static_cast<std::size_t>(at)];
    const image::PixelBox box =
        ShownBy(share, shares.square_px, view, geometry).Grown(denominator * CubicSampler::kReachPx);
    SKYQUILT_TRY_ASSIGN(const DecodedPhoto decoded,
                        context.cache.Get(share.photo, photo.photo, denominator, box));
    const PhotoOnBlock on_block(photo, context.exposure.tones[share.photo], view, geometry, denominator,
                                context.seams.levels[share.photo], cells);
    const image::DecodedPart& part = *decoded;
    const CubicSampler sampler(part.image, part.left_px, part.top_px);
    Painter(share, on_block, sampler, shares.square_px, image, mixture).Paint();
  }
  mixture.WriteTo(image);
  BlockBoundary(context.plan, block.tile).Cut(image);
  return image;
}

}  // namespace skyquilt::render
