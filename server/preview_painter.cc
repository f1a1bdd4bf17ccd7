#include "server/preview_painter.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "core/alignment/align_by_pose.h"
#include "core/flight/photo_decoder.h"
#include "core/flight/read_flight.h"
#include "core/geo/web_mercator.h"
#include "core/pipeline/preview_photo.h"
#include "core/poses/estimate_poses.h"
#include "server/preview_canvas.h"
#include "server/request_log.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;
using storage::Preview;

constexpr int kPhotosAtOnce = 3;
constexpr std::size_t kMostTracks = 8;
// A flight of some kilometres still shows as a few pixels.
constexpr int kOverviewLevels = 9;

class Collected final : public pipeline::TileSink {
 public:
  Result<void> Put(const geo::TileId& tile, pipeline::TileFormat,
                   std::span<const std::uint8_t> bytes) override {
    tiles.emplace_back(tile, std::string(bytes.begin(), bytes.end()));
    return {};
  }
  std::vector<std::pair<geo::TileId, std::string>> tiles;
};

void Include(const std::array<double, 4>& more, std::array<double, 4>& bounds) {
  bounds = {std::min(bounds[0], more[0]), std::min(bounds[1], more[1]), std::max(bounds[2], more[2]),
            std::max(bounds[3], more[3])};
}

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

PreviewPainter::Track& PreviewPainter::TrackOf(const storage::PreviewWork& work) {
  if (!tracks_.contains(work.flight_id) && tracks_.size() >= kMostTracks) tracks_.clear();
  Track& track = tracks_[work.flight_id];
  // The catalogue is right: a file that is gone is no part of the flight any more.
  std::map<std::string, flight::Photo> before = std::exchange(track.photos, {});
  std::set<std::string> waiting;
  for (const storage::StoredFile& file : work.tried) {
    const auto found = before.find(file.stored_name);
    if (found != before.end()) {
      track.photos.insert(before.extract(found));
      if (track.waiting.contains(file.stored_name)) waiting.insert(file.stored_name);
      continue;
    }
    Result<flight::Photo> photo =
        flight::ReadPhoto({file.name, store_.PathOf(work.flight_id, file.stored_name)});
    if (photo && photo->position) track.photos.emplace(file.stored_name, *std::move(photo));
  }
  track.waiting = std::move(waiting);
  return track;
}

Result<bool> PreviewPainter::Step() {
  const Result<std::optional<storage::PreviewWork>> work = previews_.Claim(kPhotosAtOnce);
  if (!work) return work.error();
  if (!*work) return false;
  Track& track = TrackOf(**work);
  std::vector<storage::StoredFile> without_part;
  for (const storage::StoredFile& file : (*work)->fresh) {
    Result<flight::Photo> photo =
        flight::ReadPhoto({file.name, store_.PathOf((*work)->flight_id, file.stored_name)});
    if (photo && photo->position) {
      track.photos.emplace(file.stored_name, *std::move(photo));
      track.waiting.insert(file.stored_name);
    } else {
      without_part.push_back(file);
    }
  }
  if (!without_part.empty()) {
    const Result<void> forgone = previews_.Forgo(without_part);
    if (!forgone) return forgone.error();
  }
  if (!track.waiting.empty()) {
    const Result<void> drawn = Draw((*work)->flight_id, track);
    if (!drawn) return drawn.error();
  }
  return true;
}

Result<Preview> PreviewPainter::Begin(const std::string& flight_id) const {
  Preview preview;
  preview.flight_id = flight_id;
  preview.folder = storage::NewPreviewFolder();
  std::error_code error;
  fs::create_directory(dir_.Flight(flight_id) / preview.folder, error);
  if (error) return Error{ErrorCode::kIo, "The folder of a preview cannot be made.", error.message()};
  return preview;
}

Result<void> PreviewPainter::Draw(const std::string& flight_id, Track& track) {
  const poses::PosedFlight posed = PoseOf(track.photos);
  if (posed.photos.empty()) return {};
  const alignment::AlignedFlight placed = alignment::AlignByPoseOnly(posed);
  const Result<std::optional<Preview>> found = previews_.Find(flight_id);
  if (!found) return found.error();
  std::optional<Preview> preview = *found;
  const flight::FilePhotoSource source;
  std::optional<PreviewCanvas> canvas;
  std::shared_ptr<storage::PreviewTiles> tiles;
  std::optional<std::array<double, 4>> changed;
  for (std::size_t i = 0; i < placed.photos.size(); ++i) {
    const std::string stored_name = placed.photos[i].photo.path.filename().string();
    if (!track.waiting.contains(stored_name) || !IsTurned(posed, i)) continue;
    track.waiting.erase(stored_name);
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
      Result<Preview> begun = Begin(flight_id);
      if (!begun) return begun.error();
      preview = *std::move(begun);
      preview->bounds = drawn->bounds;
      preview->max_zoom = drawn->max_zoom;
      preview->min_zoom = std::max(0, drawn->max_zoom - kOverviewLevels);
    }
    if (!tiles) {
      Result<std::shared_ptr<storage::PreviewTiles>> opened =
          storage::PreviewTiles::Open(dir_.Flight(flight_id) / preview->folder);
      if (!opened) return opened.error();
      tiles = *std::move(opened);
      canvas.emplace(*tiles, preview->min_zoom, preview->max_zoom);
    }
    for (const auto& [tile, bytes] : collected.tiles) {
      const Result<void> laid = canvas->Lay(tile, bytes);
      if (!laid) return laid.error();
    }
    if (!changed) changed = drawn->bounds;
    Include(drawn->bounds, *changed);
    Include(drawn->bounds, preview->bounds);
    ++preview->photos;
  }
  if (!changed) return {};
  const Result<storage::PreviewTiles::Tiles> made = canvas->Finish();
  if (!made) return made.error();
  const Result<void> put = tiles->Put(*made);
  if (!put) return put.error();
  ++preview->edition;
  preview->changed = *changed;
  const Result<bool> shown = previews_.Show(*preview);
  if (!shown) return shown.error();
  if (!*shown) {
    // The map came first, or a photo was taken out: what was drawn is nobody's now.
    std::error_code ignored;  // what stays is swept at the next start
    fs::remove_all(dir_.Flight(flight_id) / preview->folder, ignored);
    tracks_.erase(flight_id);
  }
  return {};
}

}  // namespace skyquilt::server
