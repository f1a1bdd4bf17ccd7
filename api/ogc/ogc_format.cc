#include "api/ogc/ogc_format.h"

#include <algorithm>

#include "api/ogc/accept.h"

namespace skyquilt::api {
namespace {

using image::PictureFormat;

constexpr PictureFormat kTileFormats[] = {PictureFormat::kPng, PictureFormat::kJpeg, PictureFormat::kWebp};

std::optional<PictureFormat> TileFormatNamed(std::string_view name) {
  if (EqualsIgnoringCase(name, "jpeg")) return PictureFormat::kJpeg;
  for (const PictureFormat format : kTileFormats) {
    if (EqualsIgnoringCase(name, image::ExtensionOf(format)) ||
        EqualsIgnoringCase(name, image::ContentTypeOf(format))) {
      return format;
    }
  }
  return std::nullopt;
}

// Maps hold JPEG within and PNG at their edge, or WebP throughout.
bool TakesAsStored(std::string_view accept, const storage::Tileset& tileset) {
  const auto& metadata = tileset.reader->metadata();
  const auto stored = metadata.find("format");
  if (stored != metadata.end() && stored->second == "webp") return AcceptedQuality(accept, "image/webp") > 0;
  return AcceptedQuality(accept, "image/png") > 0 && AcceptedQuality(accept, "image/jpeg") > 0;
}

}  // namespace

Result<void> CheckTakesJson(const Request& request) {
  constexpr const char* kJson = "application/json";
  if (const auto wanted = request.Query("f")) {
    if (EqualsIgnoringCase(*wanted, "json") || EqualsIgnoringCase(*wanted, kJson)) return {};
  } else if (AcceptedQuality(request.headers.Find("Accept"), kJson) > 0) {
    return {};
  }
  return Error{ErrorCode::kNotAcceptable,
               "This document is there as JSON: ask for f=json or with \"Accept: application/json\".", ""};
}

Result<void> CheckTakesGeoJson(const Request& request) {
  constexpr const char* kTypes[] = {"application/geo+json", "application/json"};
  if (const auto wanted = request.Query("f")) {
    for (const char* name : {"geojson", "json", kTypes[0], kTypes[1]}) {
      if (EqualsIgnoringCase(*wanted, name)) return {};
    }
  } else {
    const std::string_view accept = request.headers.Find("Accept");
    for (const char* type : kTypes) {
      if (AcceptedQuality(accept, type) > 0) return {};
    }
  }
  return Error{ErrorCode::kNotAcceptable,
               "Features are there as GeoJSON: ask for f=json or with \"Accept: application/geo+json\".", ""};
}

Result<std::optional<PictureFormat>> TileFormatFor(const Request& request, const storage::Tileset& tileset) {
  if (const auto wanted = request.Query("f")) {
    const std::optional<PictureFormat> format = TileFormatNamed(*wanted);
    if (format) return format;
    return Error{ErrorCode::kNotAcceptable, "Tiles are there with f=png, f=jpeg and f=webp.", ""};
  }
  const std::string_view accept = request.headers.Find("Accept");
  if (TakesAsStored(accept, tileset)) return std::optional<PictureFormat>();
  std::optional<PictureFormat> best;
  int most = 0;
  for (const PictureFormat format : kTileFormats) {
    const int quality = AcceptedQuality(accept, image::ContentTypeOf(format));
    if (quality > most) best = format;
    most = std::max(most, quality);
  }
  if (best) return best;
  return Error{ErrorCode::kNotAcceptable, "Tiles are there as image/png, image/jpeg and image/webp.", ""};
}

}  // namespace skyquilt::api
