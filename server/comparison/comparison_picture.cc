#include "server/comparison/comparison_picture.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "api/tiles/map_window.h"
#include "api/tiles/transcode_tile.h"
#include "core/base/try.h"
#include "core/geo/bounds.h"
#include "core/geo/web_mercator.h"
#include "core/pyramid/picture_sheet.h"
#include "storage/tilesets/mbtiles_reader.h"

namespace skyquilt::server {
namespace {

constexpr int kPanelPx = 480;

struct View {
  Eigen::Vector2d middle_in_merc;
  double pixel_m = 1.0;  // in merc
};

Result<image::RgbaImage> Draw(const storage::Tileset& tileset, const View& view) {
  api::MapWindow window;
  window.width_px = window.height_px = kPanelPx;
  window.pixel_m = view.pixel_m;
  window.x_in_merc = [&](int column) {
    return view.middle_in_merc.x() + (column + 0.5 - 0.5 * kPanelPx) * view.pixel_m;
  };
  window.y_in_merc = [&](int row) {
    return view.middle_in_merc.y() - (row + 0.5 - 0.5 * kPanelPx) * view.pixel_m;
  };
  SKYQUILT_TRY_ASSIGN(image::RgbaImage image, api::RenderWindow(tileset, window));
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    for (std::size_t c = 0; c < 3; ++c) {
      image.rgba[i + c] = static_cast<std::uint8_t>(image.rgba[i + c] * image.rgba[i + 3] / 255);
    }
  }
  return image;
}

}  // namespace

Result<std::string> ComparisonPng(const std::vector<MethodOutcome>& outcomes) {
  std::vector<const MethodOutcome*> drawn;
  std::vector<storage::Tileset> tilesets;
  geo::Bounds2 all;
  for (const MethodOutcome& outcome : outcomes) {
    if (!outcome.failure.empty() || !outcome.note.empty()) continue;
    SKYQUILT_TRY_ASSIGN(auto reader, storage::MbtilesReader::Open(outcome.folder / "mosaic.mbtiles"));
    storage::Tileset tileset;
    tileset.reader = std::move(reader);
    tileset.revision.min_zoom = outcome.min_zoom;
    tileset.revision.max_zoom = outcome.max_zoom;
    tilesets.push_back(std::move(tileset));
    drawn.push_back(&outcome);
    all.Include(geo::MercFromLatLonBounds(outcome.bounds));
  }
  if (drawn.empty())
    return Error{ErrorCode::kUnprocessable, "No method made a map, so there is nothing to compare.", ""};
  // The last method is the product's own: the middle of its map surely shows ground.
  const MethodOutcome& best = *drawn.back();
  const geo::Bounds2 of_best = geo::MercFromLatLonBounds(best.bounds);
  const double lat_deg = best.bounds.Middle().lat_deg;
  const View whole{0.5 * (all.min + all.max), std::max(all.Width(), all.Height()) / kPanelPx};
  const View detail{0.5 * (of_best.min + of_best.max), best.gsd_m / geo::GroundMetresPerMercMetre(lat_deg)};
  std::vector<pyramid::SheetPicture> pictures;
  for (const View& view : {whole, detail}) {
    for (std::size_t k = 0; k < drawn.size(); ++k) {
      SKYQUILT_TRY_ASSIGN(image::RgbaImage image, Draw(tilesets[k], view));
      const MethodOutcome& outcome = *drawn[k];
      std::string caption =
          fmt::format("{}: {} of {} photos", outcome.method, outcome.placed, outcome.photos);
      if (outcome.truth) caption += fmt::format(", CE90 {:.2f} m", outcome.truth->relative_ce90_m);
      if (pictures.size() >= drawn.size()) {
        caption = fmt::format("{}: the middle, {:.1f} cm a pixel", outcome.method, 100.0 * best.gsd_m);
      }
      pictures.push_back({std::move(caption), std::move(image)});
    }
  }
  return api::EncodeTile(pyramid::PictureSheet(pictures, static_cast<int>(drawn.size())),
                         image::PictureFormat::kPng);
}

}  // namespace skyquilt::server
