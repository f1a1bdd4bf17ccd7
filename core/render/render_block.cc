#include "core/render/render_block.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "core/geo/web_mercator.h"
#include "core/render/block_geometry.h"
#include "core/render/block_weights.h"

namespace skyquilt::render {
namespace {

// Where each pixel of the share's rectangle lies in the decoded (possibly smaller) image: bilinear between
// nodes.
struct PixelMaps {
  cv::Mat1f x, y;
};

// A part of a share: whole cells of nodes, so low that its maps stay in the processor's cache.
constexpr int kStripRows = 2 * kNodeStepPx;

// The columns of the share that some pixel of the strip is weighed in, out to whole cells of nodes; empty if
// none.
cv::Rect StripAt(const PhotoShare& share, int y) {
  const int height = std::min(kStripRows, share.height - y);
  int first = share.width, last = -1;
  for (int row = y; row < y + height; ++row) {
    const float* weight = share.weight.data() + static_cast<std::size_t>(row) * share.width;
    int from = 0, to = share.width - 1;
    while (from < first && weight[from] <= 0.0f) ++from;
    while (to > last && weight[to] <= 0.0f) --to;
    first = std::min(first, from), last = std::max(last, to);
  }
  if (last < first) return {};
  first = first / kNodeStepPx * kNodeStepPx;
  last = (last / kNodeStepPx + 1) * kNodeStepPx;
  return {first, y, last - first, height};
}

void FillMaps(const PhotoShare& share, const cv::Rect& strip, const PhotoView& view, int nodes_per_side,
              int denominator, PixelMaps& maps) {
  const float scale = 1.0f / static_cast<float>(denominator);
  const float shift = 0.5f * scale - 0.5f;  // pixel corners scale, centres carry the half pixel
  constexpr float kStep = 1.0f / kNodeStepPx;
  for (int cell_y = 0; cell_y < strip.height; cell_y += kNodeStepPx) {
    for (int cell_x = 0; cell_x < strip.width; cell_x += kNodeStepPx) {
      const std::size_t k =
          static_cast<std::size_t>((share.y + strip.y + cell_y) / kNodeStepPx) * nodes_per_side +
          static_cast<std::size_t>((share.x + strip.x + cell_x) / kNodeStepPx);
      const Eigen::Vector2f nw = view.pixel_in_image[k];
      const Eigen::Vector2f ne = view.pixel_in_image[k + 1];
      const Eigen::Vector2f sw = view.pixel_in_image[k + nodes_per_side];
      const Eigen::Vector2f se = view.pixel_in_image[k + nodes_per_side + 1];
      for (int dy = 0; dy < kNodeStepPx; ++dy) {
        const float v = dy * kStep;
        const Eigen::Vector2f west = (1.0f - v) * nw + v * sw;
        const Eigen::Vector2f east = (1.0f - v) * ne + v * se;
        const Eigen::Vector2f step = (east - west) * kStep;
        float* out_x = maps.x[cell_y + dy] + cell_x;
        float* out_y = maps.y[cell_y + dy] + cell_x;
        for (int dx = 0; dx < kNodeStepPx; ++dx) {
          // NaN (the photo does not see this cell) compares false and leaves a pixel nobody weighs.
          const float x = west.x() + dx * step.x();
          const float y = west.y() + dx * step.y();
          out_x[dx] = x > -1e4f && x < 1e5f ? x * scale + shift : -1e4f;
          out_y[dx] = y > -1e4f && y < 1e5f ? y * scale + shift : -1e4f;
        }
      }
    }
  }
}

// What the seam map adds to the photo, in grey levels: bilinear between the centres of the cells.
class SeamLight {
 public:
  SeamLight(const PhotoShare& share, const BlockCells& cells)
      : levels_(cells.seams.levels[share.photo]),
        cells_(cells),
        share_(share),
        row_(static_cast<std::size_t>(share.width)) {}
  bool IsEmpty() const { return levels_.eighths.empty(); }

  // Of one row of the share, from a column on.
  const std::vector<std::array<float, 3>>& Row(int y, int first, int width) {
    const float cell_px = static_cast<float>(cells_.seams.grid.cell_px);
    const float v = (static_cast<float>(share_.y + y) + 0.5f) / cell_px - 0.5f;
    const int row = static_cast<int>(std::floor(v));
    const float fv = v - static_cast<float>(row);
    int column = std::numeric_limits<int>::min();
    std::array<float, 3> west{}, east{};
    const auto column_at = [&](int at) {
      const auto upper = levels_.At(cells_.corner.x() + at, cells_.corner.y() + row);
      const auto lower = levels_.At(cells_.corner.x() + at, cells_.corner.y() + row + 1);
      std::array<float, 3> mixed{};
      for (std::size_t c = 0; c < 3; ++c) mixed[c] = upper[c] + fv * (lower[c] - upper[c]);
      return mixed;
    };
    for (int x = first; x < first + width; ++x) {
      const float u = (static_cast<float>(share_.x + x) + 0.5f) / cell_px - 0.5f;
      const int at = static_cast<int>(std::floor(u));
      if (at != column) {
        column = at;
        west = column_at(at);
        east = column_at(at + 1);
      }
      const float fu = u - static_cast<float>(at);
      for (std::size_t c = 0; c < 3; ++c)
        row_[static_cast<std::size_t>(x - first)][c] = west[c] + fu * (east[c] - west[c]);
    }
    return row_;
  }

 private:
  const PhotoLevels& levels_;
  const BlockCells& cells_;
  const PhotoShare& share_;
  std::vector<std::array<float, 3>> row_;
};

// How a photo's values become the map's.
struct Tone {
  float center_x, center_y, radius_scale;
  std::array<float, 3> gain, vignetting;

  Tone(const PhotoTone& tone, const camera::Intrinsics& lens, int denominator)
      : center_x(static_cast<float>((lens.center_x_px + 0.5) / denominator - 0.5)),
        center_y(static_cast<float>((lens.center_y_px + 0.5) / denominator - 0.5)) {
    const double half_diagonal_px = 0.5 * std::hypot(lens.width_px, lens.height_px) / denominator;
    radius_scale = static_cast<float>(1.0 / (half_diagonal_px * half_diagonal_px));
    for (std::size_t i = 0; i < 3; ++i) {
      gain[i] = static_cast<float>(tone.gain[i]);
      vignetting[i] = static_cast<float>(tone.vignetting.a[i]);
    }
  }
  float Brighten(float x, float y) const {
    const float dx = x - center_x, dy = y - center_y;
    const float r2 = (dx * dx + dy * dy) * radius_scale;
    return 1.0f / (1.0f + r2 * (vignetting[0] + r2 * (vignetting[1] + r2 * vignetting[2])));
  }
};

// The block while photos are added: weighted sums, and whether anything was added.
struct Sums {
  int size_px;
  std::vector<float> rgb;
  std::vector<std::uint8_t> covered;
};

void Accumulate(const PhotoShare& share, const cv::Rect& strip, const cv::Mat3b& warped,
                const PixelMaps& maps, const Tone& tone, SeamLight& light, Sums& sums) {
  const std::vector<std::array<float, 3>> no_light(static_cast<std::size_t>(strip.width));
  for (int y = 0; y < strip.height; ++y) {
    const std::size_t row = static_cast<std::size_t>(strip.y + y);
    const float* weight = share.weight.data() + row * static_cast<std::size_t>(share.width) + strip.x;
    const std::uint8_t* rgb = warped.ptr<std::uint8_t>(y);
    const float* map_x = maps.x[y];
    const float* map_y = maps.y[y];
    const std::array<float, 3>* added =
        light.IsEmpty() ? no_light.data() : light.Row(strip.y + y, strip.x, strip.width).data();
    const std::size_t base = (static_cast<std::size_t>(share.y) + row) * sums.size_px + share.x + strip.x;
    float* out = sums.rgb.data() + base * 3;
    for (int x = 0; x < strip.width; ++x, out += 3) {
      if (weight[x] <= 0.0f) continue;
      const float brighten = tone.Brighten(map_x[x], map_y[x]);
      for (int c = 0; c < 3; ++c) {
        const auto channel = static_cast<std::size_t>(c);
        const float value =
            static_cast<float>(rgb[3 * x + c]) * tone.gain[channel] * brighten + added[x][channel];
        out[c] += weight[x] * std::clamp(value, 0.0f, 255.0f);
      }
      sums.covered[base + x] = 255;
    }
  }
}

}  // namespace

int DenominatorFor(const alignment::AlignedPhoto& photo, double output_pixel_m) {
  const double photo_pixel_m = std::max(1.0, photo.height_above_ground_m) / photo.intrinsics.MeanFocalPx();
  const double minification = output_pixel_m / photo_pixel_m;
  int denominator = 1;
  while (denominator < 8 && minification / denominator > 1.45) denominator *= 2;
  return denominator;
}

Result<pyramid::RgbaImage> RenderBlockPixels(const RenderContext& context, const RenderBlock& block) {
  const int size_px = context.plan.BlockSizePx();
  const BlockGeometry geometry = MakeBlockGeometry(block.tile, size_px, context.flight.frame, context.ground);
  const BlockCells cells(context.seams, block.tile, context.plan.block_levels);
  // At the map's edge a pixel may be seen by a photo that has no cell here.
  const std::vector<std::uint32_t> photos = cells.IsInner() ? cells.Photos() : block.photos;
  std::vector<PhotoView> views;
  views.reserve(photos.size());
  for (const std::uint32_t photo : photos) views.push_back(ViewBlock(context.flight.photos[photo], geometry));
  const std::vector<PhotoShare> shares =
      WeighPhotos(context.flight, photos, views, geometry, cells, context.plan.feather_m);

  pyramid::RgbaImage image = pyramid::RgbaImage::Transparent(size_px, size_px);
  if (shares.empty()) return image;
  const auto pixels = static_cast<std::size_t>(size_px) * size_px;
  Sums sums{size_px, std::vector<float>(pixels * 3, 0.0f), std::vector<std::uint8_t>(pixels, 0)};
  PixelMaps whole_maps{cv::Mat1f(kStripRows, size_px), cv::Mat1f(kStripRows, size_px)};
  cv::Mat3b whole_warped(kStripRows, size_px);
  const double pixel_m = geo::PixelSizeInMercM(block.tile.z(), size_px) *
                         geo::GroundMetresPerMercMetre(context.flight.frame.origin().lat_deg);
  for (const PhotoShare& share : shares) {
    if (std::none_of(share.weight.begin(), share.weight.end(), [](float w) { return w > 0.0f; })) continue;
    const alignment::AlignedPhoto& photo = context.flight.photos[share.photo];
    const auto at = std::lower_bound(photos.begin(), photos.end(), share.photo) - photos.begin();
    const int denominator = DenominatorFor(photo, pixel_m);
    const Result<DecodedPhoto> decoded = context.cache.Get(share.photo, photo.photo, denominator);
    if (!decoded) return decoded.error();
    const pipeline::DecodedImage& source = **decoded;
    const cv::Mat3b source_rgb(source.height_px, source.width_px,
                               reinterpret_cast<cv::Vec3b*>(const_cast<std::uint8_t*>(source.rgb.data())));
    const Tone tone(context.exposure.photos[share.photo], photo.intrinsics, denominator);
    SeamLight light(share, cells);
    for (int y = 0; y < share.height; y += kStripRows) {
      const cv::Rect strip = StripAt(share, y);
      if (strip.empty()) continue;
      const cv::Rect room(0, 0, strip.width, strip.height);
      PixelMaps maps{whole_maps.x(room), whole_maps.y(room)};
      FillMaps(share, strip, views[static_cast<std::size_t>(at)], geometry.nodes_per_side, denominator, maps);
      cv::Mat3b warped = whole_warped(room);
      cv::remap(source_rgb, warped, maps.x, maps.y, cv::INTER_CUBIC, cv::BORDER_REPLICATE);
      Accumulate(share, strip, warped, maps, tone, light, sums);
    }
  }
  for (std::size_t i = 0; i < pixels; ++i) {
    if (sums.covered[i] == 0) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      image.rgba[4 * i + c] = static_cast<std::uint8_t>(std::min(255.0f, sums.rgb[3 * i + c] + 0.5f));
    }
    image.rgba[4 * i + 3] = 255;
  }
  return image;
}

}  // namespace skyquilt::render
