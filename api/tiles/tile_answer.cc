#include "api/tiles/tile_answer.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <utility>

#include "api/http/conditional.h"
#include "api/http/responses.h"
#include "core/base/try.h"
#include "core/image/picture_codec.h"

namespace skyquilt::api {
namespace {

constexpr const char* kRevalidated = "public, max-age=60, must-revalidate";
constexpr const char* kImmutable = "public, max-age=31536000, immutable";

Result<EmptyTile> ParseEmptyTile(const Request& request, EmptyTile otherwise) {
  const auto wanted = request.Query("empty");
  if (!wanted) return otherwise;
  if (*wanted == "blank") return EmptyTile::kBlank;
  if (*wanted == "204") return EmptyTile::kNoContent;
  if (*wanted == "404") return EmptyTile::kNotFound;
  return Error{ErrorCode::kInvalidArgument, "The parameter \"empty\" must be blank, 204 or 404."};
}

// Made once for each size that occurs (256 and 512 as a rule). Null: it is still to be made, but not here.
const std::string* BlankTile(int side_px, Work work) {
  static std::mutex mutex;
  static std::map<int, std::string> made;
  {
    const std::lock_guard lock(mutex);
    const auto found = made.find(side_px);
    if (found != made.end()) return &found->second;
  }
  if (work < Work::kCompute) return nullptr;
  std::string png = TransparentPng(side_px);
  const std::lock_guard lock(mutex);
  return &made.try_emplace(side_px, std::move(png)).first->second;
}

}  // namespace

Response DeferTo(Work work) {
  Response response;
  response.wants = work;
  return response;
}

Result<std::shared_ptr<const storage::Tileset>> MapFor(Service& service, const Request& request,
                                                       const std::string& flight_id) {
  if (request.work < Work::kRead) return service.tilesets.AtHand(flight_id);
  return service.tilesets.Get(flight_id);
}

const char* CacheControl(const Request& request, const storage::Tileset& tileset) {
  const auto revision = request.Query("rev");
  return revision && *revision == std::to_string(tileset.revision.revision) ? kImmutable : kRevalidated;
}

Response TaggedHead(const Request& request, const char* cache_control, std::string etag) {
  Response response;
  if (EtagListMatches(request.headers.Find("If-None-Match"), etag)) response.status = 304;
  response.headers.Add("Cache-Control", cache_control);
  response.headers.Add("ETag", std::move(etag));
  return response;
}

Result<Response> BlankAnswer(const Request& request, EmptyTile otherwise, int side_px,
                             const char* cache_control) {
  SKYQUILT_TRY_ASSIGN(const EmptyTile empty, ParseEmptyTile(request, otherwise));
  if (empty == EmptyTile::kNotFound) return Error{ErrorCode::kNotFound, "The map has nothing here."};
  if (empty == EmptyTile::kNoContent) {
    Response response = NoContent();
    response.headers.Add("Cache-Control", cache_control);
    return response;
  }
  Response response = TaggedHead(request, cache_control, "\"blank-" + std::to_string(side_px) + "\"");
  if (response.status == 304) return response;
  const std::string* png = BlankTile(std::min(side_px, image::kMaxPictureSidePx), request.work);
  if (png == nullptr) return DeferTo(Work::kCompute);
  response.headers.Add("Content-Type", "image/png");
  response.body = *png;
  return response;
}

Result<std::shared_ptr<const storage::MadeTile>> Made(Service& service, const Request& request,
                                                      const storage::MadeTileKey& key,
                                                      const std::function<Result<std::string>()>& make) {
  if (request.work < Work::kCompute) return service.made_tiles.Find(key);
  return service.made_tiles.Get(key, make);
}

Result<Response> AnswerMade(Service& service, const Request& request, const storage::Tileset& tileset,
                            const storage::MadeTileKey& key, std::string_view variant,
                            const std::function<Result<std::string>()>& make, EmptyTile empty, int side_px) {
  SKYQUILT_TRY_ASSIGN(const auto made, Made(service, request, key, make));
  if (made == nullptr) return DeferTo(Work::kCompute);
  const char* const cache_control = CacheControl(request, tileset);
  if (made->bytes.empty()) return BlankAnswer(request, empty, side_px, cache_control);
  Response response = TaggedHead(request, cache_control, StrongEtag(made->digest, variant));
  if (response.status == 304) return response;
  const auto format = image::PictureFormatOf(made->bytes).value_or(image::PictureFormat::kPng);
  response.headers.Add("Content-Type", image::ContentTypeOf(format));
  response.body = made->bytes;
  return response;
}

}  // namespace skyquilt::api
