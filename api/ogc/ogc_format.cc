#include "api/ogc/ogc_format.h"

#include <algorithm>
#include <initializer_list>
#include <nlohmann/json.hpp>

#include "api/http/accept.h"
#include "api/http/links.h"
#include "api/http/responses.h"
#include "core/base/check.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

using image::PictureFormat;

std::optional<PictureFormat> FormatAsked(std::string_view word) {
  for (const image::PictureFormatRow& row : image::kPictureFormats) {
    for (const char* known : {row.name, row.extension, row.content_type}) {
      if (EqualsIgnoringCase(word, known)) return row.format;
    }
  }
  return std::nullopt;
}

// `names`: what "f" may say, and among them the types that Accept may.
Result<void> CheckTakes(const Request& request, std::initializer_list<std::string_view> names,
                        const char* refusal) {
  const auto wanted = request.Query("f");
  const std::string_view accept = request.headers.Find("Accept");
  for (const std::string_view name : names) {
    const bool is_type = name.find('/') != std::string_view::npos;
    if (wanted ? EqualsIgnoringCase(*wanted, name) : is_type && AcceptedQuality(accept, name) > 0) return {};
  }
  return Error{ErrorCode::kNotAcceptable, refusal};
}

// Maps hold JPEG within and WebP or PNG at their edge, or WebP throughout.
bool TakesAsStored(std::string_view accept, const storage::Tileset& tileset) {
  const bool takes_webp = AcceptedQuality(accept, "image/webp") > 0,
             takes_png = AcceptedQuality(accept, "image/png") > 0,
             takes_jpeg = AcceptedQuality(accept, "image/jpeg") > 0;
  switch (storage::EncodingOf(tileset.reader->metadata())) {
    case image::TileEncoding::kWebp:
      return takes_webp;
    case image::TileEncoding::kJpegWebp:
      // Who does not name WebP gets PNG at the edge.
      return takes_jpeg && (takes_png || NamesType(accept, "image/webp"));
    case image::TileEncoding::kJpegPng:
      return takes_jpeg && takes_png;
  }
  SKYQUILT_CHECK(false, "an encoding outside the list");
}

}  // namespace

nlohmann::ordered_json OgcLink(const Request& request, std::string_view path, const std::string& rel,
                               const char* type, const char* title) {
  return {{"href", LinkTo(request, path)}, {"rel", rel}, {"type", type}, {"title", title}};
}

Result<void> CheckTakesJson(const Request& request) {
  return CheckTakes(request, {"json", "application/json"},
                    "This document is there as JSON: ask for f=json or with \"Accept: application/json\".");
}

Result<void> CheckTakesGeoJson(const Request& request) {
  return CheckTakes(
      request, {"geojson", "json", "application/geo+json", "application/json"},
      "Features are there as GeoJSON: ask for f=json or with \"Accept: application/geo+json\".");
}

Result<PictureFormat> PictureFormatFor(const Request& request) {
  if (const auto wanted = request.Query("f")) {
    const std::optional<PictureFormat> format = FormatAsked(*wanted);
    if (format) return *format;
    return Error{
        ErrorCode::kNotAcceptable,
        "Pictures are there with " + image::ListedFormats(&image::PictureFormatRow::name, "f=") + "."};
  }
  const std::string_view accept = request.headers.Find("Accept");
  std::optional<PictureFormat> best;
  int most = 0;
  for (const image::PictureFormatRow& row : image::kPictureFormats) {
    const int quality = AcceptedQuality(accept, row.content_type);
    if (quality > most) best = row.format;
    most = std::max(most, quality);
  }
  if (best) return *best;
  return Error{ErrorCode::kNotAcceptable,
               "Pictures are there as " + image::ListedFormats(&image::PictureFormatRow::content_type) + "."};
}

Result<std::optional<PictureFormat>> TileFormatFor(const Request& request, const storage::Tileset& tileset) {
  if (!request.Query("f") && TakesAsStored(request.headers.Find("Accept"), tileset))
    return std::optional<PictureFormat>();
  SKYQUILT_TRY_ASSIGN(const PictureFormat format, PictureFormatFor(request));
  return std::optional(format);
}

}  // namespace skyquilt::api
