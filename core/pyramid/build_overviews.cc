#include "core/pyramid/build_overviews.h"

#include <utility>

#include "core/base/check.h"

namespace skyquilt::pyramid {

OverviewBuilder::OverviewBuilder(int first_zoom, int min_zoom, int tile_size_px, Emit emit, Reduce reduce)
    : first_zoom_(first_zoom),
      min_zoom_(min_zoom),
      tile_size_px_(tile_size_px),
      emit_(std::move(emit)),
      reduce_(std::move(reduce)),
      open_(static_cast<std::size_t>(first_zoom) + 1) {}

void OverviewBuilder::AddHalf(const geo::TileId& tile, const RgbaImage& half) {
  SKYQUILT_CHECK(tile.z() == first_zoom_, "overviews start from one zoom");
  if (first_zoom_ > min_zoom_) AddTo(first_zoom_ - 1, tile, half);
}

void OverviewBuilder::AddTo(int parent_zoom, const geo::TileId& child, const RgbaImage& child_half) {
  OpenParent& parent = open_[static_cast<std::size_t>(parent_zoom)];
  if (parent.is_open && parent.tile != child.Parent()) Close(parent_zoom);
  if (!parent.is_open) {
    parent.is_open = true;
    parent.tile = child.Parent();
    parent.image = RgbaImage::Transparent(tile_size_px_, tile_size_px_);
  }
  const int half_px = tile_size_px_ / 2;
  Paste(child_half, static_cast<int>(child.x() & 1u) * half_px, static_cast<int>(child.y() & 1u) * half_px,
        parent.image);
}

void OverviewBuilder::Close(int zoom) {
  OpenParent closed = std::exchange(open_[static_cast<std::size_t>(zoom)], {});
  emit_(closed.tile, closed.image);
  if (zoom > min_zoom_) AddTo(zoom - 1, closed.tile, reduce_(closed.image));
}

void OverviewBuilder::Finish() {
  for (int zoom = first_zoom_ - 1; zoom >= min_zoom_; --zoom) {
    if (open_[static_cast<std::size_t>(zoom)].is_open) Close(zoom);
  }
}

}  // namespace skyquilt::pyramid
