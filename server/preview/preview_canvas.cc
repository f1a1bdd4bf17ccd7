#include "server/preview/preview_canvas.h"

#include <set>
#include <utility>

#include "core/base/try.h"
#include "core/image/picture_codec.h"
#include "core/pyramid/encode_tile.h"
#include "core/pyramid/tile_image.h"

namespace skyquilt::server {
namespace {

using image::RgbaImage;

constexpr int kJpegQuality = 75;
constexpr int kSidePx = PreviewCanvas::kTileSizePx;

Result<RgbaImage> Decode(std::string_view bytes) {
  SKYQUILT_TRY_ASSIGN(RgbaImage pixels, image::DecodePicture(bytes));
  if (pixels.width_px != kSidePx || pixels.height_px != kSidePx) {
    return Error{ErrorCode::kCorrupt, "A tile of the preview has another size than the rest.", ""};
  }
  for (std::size_t i = 0; i < pixels.rgba.size(); i += 4) {
    const int alpha = pixels.rgba[i + 3];
    for (std::size_t c = i; c < i + 3; ++c) {
      pixels.rgba[c] = static_cast<std::uint8_t>((pixels.rgba[c] * alpha + 127) / 255);
    }
  }
  return pixels;
}

void LayOver(const RgbaImage& above, RgbaImage& below) {
  for (std::size_t i = 0; i < below.rgba.size(); i += 4) {
    const int shows_through = 255 - above.rgba[i + 3];
    for (std::size_t c = i; c < i + 4; ++c) {
      below.rgba[c] = static_cast<std::uint8_t>(above.rgba[c] + (below.rgba[c] * shows_through + 127) / 255);
    }
  }
}

}  // namespace

Result<RgbaImage> PreviewCanvas::Load(const geo::TileId& tile) {
  const auto found = changed_.find(tile);
  if (found != changed_.end()) return found->second;
  SKYQUILT_TRY_ASSIGN(const std::optional<storage::FoundTile> stored, stored_.Find(tile));
  if (!stored) return RgbaImage::Transparent(kSidePx, kSidePx);
  return Decode(*stored->bytes);
}

Result<void> PreviewCanvas::Lay(const geo::TileId& tile, std::string_view bytes) {
  if (tile.z() != max_zoom_) return {};
  SKYQUILT_TRY_ASSIGN(const RgbaImage above, Decode(bytes));
  SKYQUILT_TRY_ASSIGN(RgbaImage below, Load(tile));
  LayOver(above, below);
  changed_[tile] = std::move(below);
  return {};
}

Result<void> PreviewCanvas::DrawParents(int zoom) {
  std::set<geo::TileId> parents;
  for (const auto& [tile, image] : changed_) {
    if (tile.z() == zoom + 1) parents.insert(tile.Parent());
  }
  for (const geo::TileId& parent : parents) {
    RgbaImage image = RgbaImage::Transparent(kSidePx, kSidePx);
    const auto children = parent.Children();
    for (int i = 0; i < 4; ++i) {
      SKYQUILT_TRY_ASSIGN(const RgbaImage child, Load(children[static_cast<std::size_t>(i)]));
      pyramid::Paste(pyramid::Halve(child), (i % 2) * kSidePx / 2, (i / 2) * kSidePx / 2, image);
    }
    changed_[parent] = std::move(image);
  }
  return {};
}

Result<storage::PreviewTiles::Tiles> PreviewCanvas::Finish() {
  for (int zoom = max_zoom_ - 1; zoom >= min_zoom_; --zoom) {
    SKYQUILT_TRY(DrawParents(zoom));
  }
  storage::PreviewTiles::Tiles tiles;
  for (const auto& [tile, image] : changed_) {
    const auto encoded = pyramid::EncodeTile(image, {image::TileEncoding::kJpegPng, kJpegQuality});
    if (encoded) tiles[tile] = std::string(encoded->bytes.begin(), encoded->bytes.end());
  }
  return tiles;
}

}  // namespace skyquilt::server
