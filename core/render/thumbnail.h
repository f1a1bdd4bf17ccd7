// Thumbnail: a photo averaged down to at most kThumbnailSidePx, for what needs colour but no detail. Kept as
// JPEG: a flight of thousands holds all of them. A value.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/flight/photo.h"
#include "core/flight/photos/photo_source.h"
#include "core/image/decoded_image.h"

namespace skyquilt::render {

inline constexpr int kThumbnailSidePx = 384;

struct Thumbnail {
  std::string photo_name;
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint8_t> jpeg;
};

// What a photo is shrunk by when it is decoded for its thumbnail.
int ThumbnailDenominator(const flight::Photo& photo);
// Of a photo decoded so, or larger.
Thumbnail MakeThumbnail(const flight::Photo& photo, const image::DecodedImage& decoded);
// Decodes it too. Errors: those of decoding.
Result<Thumbnail> MakeThumbnail(const flight::PhotoSource& source, const flight::Photo& photo);

image::DecodedImage Decode(const Thumbnail& thumbnail);

}  // namespace skyquilt::render
