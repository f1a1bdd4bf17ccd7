// StreamedProduct: the GeoTIFF or the PMTiles archive of a map that has none on the disk, laid out over its
// tiles (storage/exports/streamed) and made as it is read: with a length, exact ranges and an entity tag like
// any file. Where maps lie elsewhere, the tileset is fetched first. Any thread. Errors: kNotFound (no such
// map any more, or a name that is none of the two), kCorrupt, those of the store.
#pragma once

#include <memory>
#include <string>

#include "api/http/http_message.h"
#include "api/service.h"
#include "storage/exports/streamed/streamed_maps.h"

namespace skyquilt::api {

inline constexpr const char* kStreamedProducts[] = {"mosaic.pmtiles", "mosaic.tif"};

// `name`: of the file that it would be in the map's folder, below `prefix`.
Result<storage::OpenStreamed> OpenStreamedProduct(Service& service, const std::string& prefix,
                                                  const std::string& name);

Result<std::unique_ptr<BodySource>> ReadStreamed(const storage::OpenStreamed& streamed, std::uint64_t offset,
                                                 std::uint64_t length);
Result<Response> SendStreamed(const Request& request, const storage::OpenStreamed& streamed,
                              const std::string& content_type);

}  // namespace skyquilt::api
