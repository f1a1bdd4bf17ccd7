#include "server/preview/preview_painter.h"

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "core/alignment/align_by_pose.h"
#include "core/base/try.h"
#include "core/flight/photos/photo_decoder.h"
#include "core/flight/read_flight.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "core/image/picture_codec.h"
#include "core/image/rgba_image.h"
#include "core/pipeline/preview_photo.h"
#include "core/poses/estimate_poses.h"
#include "core/pyramid/encode_tile.h"
#include "core/pyramid/tile_image.h"
#include "server/routing/request_log.h"
#include "storage/catalogue/previews.h"

namespace skyquilt::server {
namespace {

using image::RgbaImage;
using storage::Preview;

constexpr int kSidePx = 256;  // of a tile
constexpr int kJpegQuality = 75;
// A flight of some kilometres still shows as a few pixels.
constexpr int kOverviewLevels = 9;

Result<RgbaImage> Decode(std::string_view bytes) {
  SKYQUILT_TRY_ASSIGN(RgbaImage pixels, image::DecodePicture(bytes));
  if (pixels.width_px != kSidePx || pixels.height_px != kSidePx) {
    return Error{ErrorCode::kCorrupt, "A tile of the preview has another size than the rest."};
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

// Composes photos onto the tiles of a growing preview and updates the overviews above changed
// tiles. Reads the tiles it needs and writes nothing: Finish returns what the next edition changes. Memory:
// the changed tiles, decoded. Errors: kCorrupt (a stored tile), kIo.
class PreviewCanvas {
 public:
  PreviewCanvas(storage::PreviewTiles& stored, int min_zoom, int max_zoom)
      : stored_(stored), min_zoom_(min_zoom), max_zoom_(max_zoom) {}

  // Lays one encoded tile of a photo over what is there. Tiles of other zooms than the finest are passed
  // over: the overviews are of all photos.
  Result<void> Lay(const geo::TileId& tile, std::string_view bytes);
  Result<storage::PreviewTiles::Tiles> Finish();

 private:
  Result<RgbaImage> Load(const geo::TileId& tile);
  Result<void> DrawParents(int zoom);

  storage::PreviewTiles& stored_;
  const int min_zoom_;
  const int max_zoom_;
  std::map<geo::TileId, RgbaImage> changed_;
};

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

class Collected final : public pyramid::TileSink {
 public:
  Result<void> Put(const geo::TileId& tile, image::PictureFormat,
                   std::span<const std::uint8_t> bytes) override {
    tiles.emplace_back(tile, std::string(bytes.begin(), bytes.end()));
    return {};
  }
  std::vector<std::pair<geo::TileId, std::string>> tiles;
};

// Pixels of this size make just this zoom.
double GsdOfZoom(int zoom, double lat_deg) {
  constexpr double kBetweenZooms = 1.4;
  return kBetweenZooms * geo::PixelSizeInMercM(zoom, kSidePx) * geo::GroundMetresPerMercMetre(lat_deg);
}

poses::PosedFlight PoseOf(const std::map<std::string, flight::Photo>& photos) {
  flight::Flight flight;
  for (const auto& [name, photo] : photos) flight.photos.push_back(photo);
  std::sort(flight.photos.begin(), flight.photos.end(), flight::ComesBefore);
  Result<poses::PosedFlight> posed = poses::EstimatePoses(flight, {});
  return posed && posed->is_placed ? *std::move(posed) : poses::PosedFlight();
}

// A photo that flies where its neighbours say has to wait for one.
bool IsTurned(const poses::PosedFlight& posed, std::size_t photo) {
  const poses::AttitudeOrigin origin = posed.photos[photo].attitude_origin;
  return (origin != poses::AttitudeOrigin::kCourse && origin != poses::AttitudeOrigin::kDirection) ||
         posed.photos.size() > 1;
}

// The disk did not give a photo, which may be a sound one.
template <typename Value>
bool IsOfDisk(const Result<Value>& read) {
  return !read && read.error().code == ErrorCode::kIo;
}

}  // namespace

void PreviewPainter::Remember(const PreviewRequest& request) {
  // Without a preview the process before was not kept: what waited in it waits in this one. More of them are
  // of a flight that cannot be drawn.
  constexpr std::size_t kMaxUndrawn = 3;
  const bool is_undrawn = !request.preview && request.tried.size() <= kMaxUndrawn;
  // The catalogue is right: a file that is gone is no part of the flight any more.
  std::map<std::string, flight::Photo> before = std::exchange(photos_, {});
  std::set<std::string> waiting;
  for (const storage::StoredFile& file : request.tried) {
    const auto found = before.find(file.stored_name);
    if (waiting_.contains(file.stored_name)) waiting.insert(file.stored_name);
    if (found != before.end()) {
      photos_.insert(before.extract(found));
      continue;
    }
    Result<flight::Photo> photo = Read(file);
    const bool may_be_drawn = photo ? photo->position.has_value() : IsOfDisk(photo);
    if (is_undrawn && may_be_drawn) waiting.insert(file.stored_name);
    if (photo && photo->position) photos_.emplace(file.stored_name, *std::move(photo));
  }
  waiting_ = std::move(waiting);
}

Result<flight::Photo> PreviewPainter::Read(const storage::StoredFile& file) const {
  begin_photo_(file.stored_name);
  return flight::ReadPhoto({file.name, files_dir_ / file.stored_name});
}

Result<PreviewDrawn> PreviewPainter::Draw(const PreviewRequest& request) {
  Remember(request);
  PreviewDrawn drawn;
  for (const storage::StoredFile& file : request.fresh) {
    Result<flight::Photo> photo = Read(file);
    const bool is_unread = IsOfDisk(photo);
    if (photo && photo->position) photos_.insert_or_assign(file.stored_name, *std::move(photo));
    if (is_unread || photos_.contains(file.stored_name)) {
      waiting_.insert(file.stored_name);
    } else {
      drawn.forgone.push_back(file.stored_name);
    }
  }
  if (waiting_.empty() || photos_.empty()) return drawn;
  SKYQUILT_TRY_ASSIGN(std::optional<Preview> preview, DrawWaiting(request.preview));
  drawn.preview = std::move(preview);
  return drawn;
}

Result<std::optional<Preview>> PreviewPainter::DrawWaiting(std::optional<Preview> preview) {
  const poses::PosedFlight posed = PoseOf(photos_);
  if (posed.photos.empty()) return std::optional<Preview>();
  const alignment::AlignedFlight placed = alignment::AlignByPoseOnly(posed);
  const flight::FilePhotoSource source;
  std::optional<PreviewCanvas> canvas;
  std::shared_ptr<storage::PreviewTiles> tiles;
  std::optional<geo::LatLonBounds> changed;
  for (std::size_t i = 0; i < placed.photos.size(); ++i) {
    const std::string stored_name = placed.photos[i].photo.path.filename().string();
    if (!waiting_.contains(stored_name) || !IsTurned(posed, i)) continue;
    waiting_.erase(stored_name);
    begin_photo_(stored_name);
    pipeline::PreviewOptions options;
    if (preview) options.gsd_m = GsdOfZoom(preview->max_zoom, placed.frame.origin().lat_deg);
    Collected collected;
    const Result<pipeline::PhotoPreview> drawn =
        pipeline::PreviewPhoto(placed, i, source, options, collected);
    if (!drawn) {
      if (IsOfDisk(drawn)) waiting_.insert(stored_name);
      LogEvent(placed.photos[i].photo.name + " is not in the preview: " + drawn.error().message);
      continue;
    }
    if (drawn->tile_size_px != kSidePx) continue;  // a flight at arm's length
    if (!preview) {
      preview.emplace();
      preview->bounds = drawn->bounds.OnEarth();
      preview->max_zoom = drawn->max_zoom;
      preview->min_zoom = std::max(0, drawn->max_zoom - kOverviewLevels);
    }
    if (!tiles) {
      SKYQUILT_TRY_ASSIGN(std::shared_ptr<storage::PreviewTiles> opened,
                          storage::PreviewTiles::Open(folder_));
      tiles = std::move(opened);
      canvas.emplace(*tiles, preview->min_zoom, preview->max_zoom);
    }
    for (const auto& [tile, bytes] : collected.tiles) {
      SKYQUILT_TRY(canvas->Lay(tile, bytes));
    }
    const geo::LatLonBounds seen = drawn->bounds.Beside(preview->bounds);
    if (!changed) changed = seen;
    changed->Include(seen);
    preview->bounds.Include(seen);
    ++preview->photos;
  }
  if (!changed) return std::optional<Preview>();
  SKYQUILT_TRY_ASSIGN(const storage::PreviewTiles::Tiles made, canvas->Finish());
  SKYQUILT_TRY(tiles->Put(made));
  preview->bounds = preview->bounds.OnEarth();
  preview->changed = changed->OnEarth();
  return preview;
}

}  // namespace skyquilt::server
