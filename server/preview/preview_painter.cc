#include "server/preview/preview_painter.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "core/alignment/baselines/align_by_pose.h"
#include "core/base/try.h"
#include "core/flight/photos/photo_decoder.h"
#include "core/flight/read_flight.h"
#include "core/geo/web_mercator.h"
#include "core/pipeline/preview_photo.h"
#include "core/poses/estimate_poses.h"
#include "server/preview/preview_canvas.h"
#include "server/routing/request_log.h"

namespace skyquilt::server {
namespace {

using storage::Preview;

// A flight of some kilometres still shows as a few pixels.
constexpr int kOverviewLevels = 9;

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
  return kBetweenZooms * geo::PixelSizeInMercM(zoom, PreviewCanvas::kTileSizePx) *
         geo::GroundMetresPerMercMetre(lat_deg);
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
  return posed.photos[photo].attitude_origin != poses::AttitudeOrigin::kCourse || posed.photos.size() > 1;
}

}  // namespace

void PreviewPainter::Remember(const std::vector<storage::StoredFile>& tried) {
  // The catalogue is right: a file that is gone is no part of the flight any more.
  std::map<std::string, flight::Photo> before = std::exchange(photos_, {});
  std::set<std::string> waiting;
  for (const storage::StoredFile& file : tried) {
    const auto found = before.find(file.stored_name);
    if (found != before.end()) {
      photos_.insert(before.extract(found));
      if (waiting_.contains(file.stored_name)) waiting.insert(file.stored_name);
      continue;
    }
    begin_photo_(file.stored_name);
    Result<flight::Photo> photo = flight::ReadPhoto({file.name, files_dir_ / file.stored_name});
    if (photo && photo->position) photos_.emplace(file.stored_name, *std::move(photo));
  }
  waiting_ = std::move(waiting);
}

Result<PreviewDrawn> PreviewPainter::Draw(const PreviewRequest& request) {
  Remember(request.tried);
  PreviewDrawn drawn;
  for (const storage::StoredFile& file : request.fresh) {
    begin_photo_(file.stored_name);
    Result<flight::Photo> photo = flight::ReadPhoto({file.name, files_dir_ / file.stored_name});
    if (photo && photo->position) {
      photos_.insert_or_assign(file.stored_name, *std::move(photo));
      waiting_.insert(file.stored_name);
    } else {
      drawn.forgone.push_back(file.stored_name);
    }
  }
  if (waiting_.empty()) return drawn;
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
      LogEvent(placed.photos[i].photo.name + " is not in the preview: " + drawn.error().message);
      continue;
    }
    if (drawn->tile_size_px != PreviewCanvas::kTileSizePx) continue;  // a flight at arm's length
    if (!preview) {
      preview.emplace();
      preview->bounds = drawn->bounds;
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
    if (!changed) changed = drawn->bounds;
    changed->Include(drawn->bounds);
    preview->bounds.Include(drawn->bounds);
    ++preview->photos;
  }
  if (!changed) return std::optional<Preview>();
  SKYQUILT_TRY_ASSIGN(const storage::PreviewTiles::Tiles made, canvas->Finish());
  SKYQUILT_TRY(tiles->Put(made));
  preview->changed = *changed;
  return preview;
}

}  // namespace skyquilt::server
