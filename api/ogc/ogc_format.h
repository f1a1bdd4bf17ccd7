// The formats that OGC documents and tiles are asked for in: by "f", or else by Accept; and what the
// documents share. Any thread. Errors: kNotAcceptable, with what there is.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "api/http/http_message.h"
#include "core/image/picture_format.h"
#include "storage/caches/tileset_cache.h"

namespace skyquilt::api {

// What OGC's own link relations begin with.
inline const std::string kOgcRel = "http://www.opengis.net/def/rel/ogc/1.0/";
inline constexpr const char* kMercatorUri = "http://www.opengis.net/def/crs/EPSG/0/3857";
inline constexpr const char* kCrs84Uri = "http://www.opengis.net/def/crs/OGC/1.3/CRS84";

// A link of a document to `path` of this server.
nlohmann::ordered_json OgcLink(const Request& request, std::string_view path, const std::string& rel,
                               const char* type, const char* title);

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
