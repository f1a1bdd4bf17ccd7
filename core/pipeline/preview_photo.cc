#include "core/pipeline/preview_photo.h"

#include <algorithm>

#include "core/base/check.h"
#include "core/base/try.h"
#include "core/geo/web_mercator.h"
#include "core/ground/ground_surface.h"
#include "core/render/plan_mosaic.h"
#include "core/render/render_tiles.h"

namespace skyquilt::pipeline {

Result<PhotoPreview> PreviewPhoto(const alignment::AlignedFlight& placed, std::size_t photo,
                                  const flight::PhotoSource& source, const PreviewOptions& options,
                                  pyramid::TileSink& sink) {
  SKYQUILT_CHECK(photo < placed.photos.size(), "a preview of a photo that is not in the flight");
  alignment::AlignedFlight one;
  one.frame = placed.frame;
  one.ground_z_in_enu_m = placed.ground_z_in_enu_m;
  one.photos = {placed.photos[photo]};
  const camera::Intrinsics& lens = one.photos[0].intrinsics;
  const ground::GroundSurface ground = ground::GroundSurface::Plane(one.ground_z_in_enu_m);
  const double shrink =
      std::max(1.0, static_cast<double>(std::max(lens.width_px, lens.height_px)) / options.longer_side_px);
  const double photo_pixel_m = std::max(1.0, one.photos[0].height_above_ground_m) / lens.MeanFocalPx();
  SKYQUILT_TRY_ASSIGN(
      const auto plan,
      render::PlanMosaic(one, ground, {.gsd_m = options.gsd_m.value_or(shrink * photo_pixel_m)}));
  SKYQUILT_TRY_ASSIGN(const render::Thumbnail thumbnail, render::MakeThumbnail(source, one.photos[0].photo));
  const render::ExposureModel exposure = render::ExposureModel::Even(1);
  const render::SeamMap seams = render::BuildSeamMap(
      one, ground, plan, exposure, {thumbnail}, {.moves_seams = false, .evens_light = false, .threads = 1});
  render::PhotoCache cache(source, 0);  // the one photo is held while it is used
  SilentProgress progress;
  SKYQUILT_TRY_ASSIGN(
      const auto rendered,
      render::RenderTiles({one, ground, exposure, seams, plan, cache},
                          {1, {image::TileEncoding::kJpegPng, options.jpeg_quality}}, sink, progress));
  if (rendered.base_tiles == 0) {
    return Error{ErrorCode::kUnprocessable, one.photos[0].photo.name + " shows no ground.", ""};
  }
  return PhotoPreview{geo::LatLonBoundsFromMerc(rendered.covered_in_merc), plan.min_zoom, plan.base_zoom,
                      plan.tile_size_px, rendered.tiles};
}

}  // namespace skyquilt::pipeline
