// The formats that OGC documents and tiles are asked for in: by "f", or else by Accept. Any thread.
// Errors: kNotAcceptable, with what there is.
#pragma once

#include <optional>

#include "api/http/http_message.h"
#include "core/image/picture_format.h"
#include "storage/caches/tileset_cache.h"

namespace skyquilt::api {

// Documents are there as JSON alone.
Result<void> CheckTakesJson(const Request& request);
// Lists of features as GeoJSON.
Result<void> CheckTakesGeoJson(const Request& request);
// Of a picture that is made for the request: PNG where the client does not care.
Result<image::PictureFormat> PictureFormatFor(const Request& request);
// Absent: as stored, which the client takes.
Result<std::optional<image::PictureFormat>> TileFormatFor(const Request& request,
                                                          const storage::Tileset& tileset);

}  // namespace skyquilt::api
