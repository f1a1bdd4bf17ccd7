#include "core/pyramid/build_overviews.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <utility>

#include "core/base/check.h"

namespace skyquilt::pyramid {
namespace {

// Smaller ones are not worth trimming.
constexpr int kTrimmedTilePx = 1024;

// The rectangle that holds all covered pixels; where it begins goes to x and y.
image::RgbaImage Trimmed(const image::RgbaImage& image, int& x, int& y) {
  int left = image.width_px, right = 0, top = image.height_px, bottom = 0;
  for (int row = 0; row < image.height_px; ++row) {
    const std::uint8_t* alpha = image.Pixel(0, row) + 3;
    int first = 0, last = image.width_px;
    while (first < last && alpha[std::ptrdiff_t{4} * first] == 0) ++first;
    if (first == last) continue;
    while (alpha[std::ptrdiff_t{4} * (last - 1)] == 0) --last;
    left = std::min(left, first), right = std::max(right, last);
    top = std::min(top, row), bottom = row + 1;
  }
  image::RgbaImage trimmed =
      image::RgbaImage::Transparent(std::max(0, right - left), std::max(0, bottom - top));
  if (trimmed.width_px == 0) return trimmed;
  x += left, y += top;
  for (int row = 0; row < trimmed.height_px; ++row) {
    std::memcpy(trimmed.Pixel(0, row), image.Pixel(left, top + row),
                4 * static_cast<std::size_t>(trimmed.width_px));
  }
  return trimmed;
}

}  // namespace

OverviewBuilder::OverviewBuilder(int first_zoom, int min_zoom, int tile_size_px, Emit emit, Reduce reduce)
    : first_zoom_(first_zoom),
      min_zoom_(min_zoom),
      tile_size_px_(tile_size_px),
      emit_(std::move(emit)),
      reduce_(std::move(reduce)),
      open_(static_cast<std::size_t>(first_zoom) + 1) {}

void OverviewBuilder::AddHalf(const geo::TileId& tile, const image::RgbaImage& half) {
  SKYQUILT_CHECK(tile.z() == first_zoom_, "overviews start from one zoom");
  if (first_zoom_ > min_zoom_) AddTo(first_zoom_ - 1, tile, half);
}

void OverviewBuilder::AddTo(int parent_zoom, const geo::TileId& child, const image::RgbaImage& child_half) {
  OpenParent& parent = open_[static_cast<std::size_t>(parent_zoom)];
  if (parent.is_open && parent.tile != child.Parent()) Close(parent_zoom);
  if (!parent.is_open) {
    parent.is_open = true;
    parent.tile = child.Parent();
  }
  const int half_px = tile_size_px_ / 2;
  Quarter quarter{static_cast<int>(child.x() & 1u) * half_px, static_cast<int>(child.y() & 1u) * half_px, {}};
  quarter.image = tile_size_px_ < kTrimmedTilePx ? child_half : Trimmed(child_half, quarter.x, quarter.y);
  parent.quarters.push_back(std::move(quarter));
}

void OverviewBuilder::Close(int zoom) {
  OpenParent closed = std::exchange(open_[static_cast<std::size_t>(zoom)], {});
  image::RgbaImage image = image::RgbaImage::Transparent(tile_size_px_, tile_size_px_);
  for (const Quarter& quarter : closed.quarters) Paste(quarter.image, quarter.x, quarter.y, image);
  closed.quarters.clear();
  emit_(closed.tile, image);
  if (zoom > min_zoom_) AddTo(zoom - 1, closed.tile, reduce_(image));
}

void OverviewBuilder::Finish() {
  for (int zoom = first_zoom_ - 1; zoom >= min_zoom_; --zoom) {
    if (open_[static_cast<std::size_t>(zoom)].is_open) Close(zoom);
  }
}

}  // namespace skyquilt::pyramid
