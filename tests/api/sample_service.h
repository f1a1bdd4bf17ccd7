// A service over an empty data folder, with the real routes: what handler tests talk to, without a socket.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <utility>
#include <variant>

#include "api/auth/access.h"
#include "api/build_api.h"
#include "api/http/target.h"
#include "core/image/picture_codec.h"
#include "tests/storage/small_tileset.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::api {

class SampleService {
 public:
  SampleService()
      : dir_(*storage::DataDir::Open(scratch_.path())),
        db_(*storage::CatalogueDb::Open(dir_.Catalogue())),
        catalogue(*db_),
        queue(*db_),
        store_(dir_),
        tilesets_(dir_, catalogue),
        service_{catalogue, queue, store_, tilesets_, metrics_, *db_, "1.2.3"},
        router_(BuildApi(service_)) {}

  // One request with its whole body, as a session would make it.
  Response Send(Method method, const std::string& target, const std::string& body = "", Headers headers = {},
                bool says_length = true) {
    const auto parsed = ParseTarget(target);
    EXPECT_TRUE(parsed) << target;
    auto match = router_.Find(method, parsed->segments);
    if (match.route == nullptr) return Status(match.allow.empty() ? 404 : 405);
    Request request;
    request.method = method;
    request.path = target.substr(0, target.find('?'));
    request.parameters = match.parameters;
    request.query = parsed->query;
    request.headers = std::move(headers);
    if (says_length) request.content_length = body.size();
    request.base_url = "http://127.0.0.1:1";
    if (auto refused = CheckAccess(service_, request, *match.route)) return *std::move(refused);
    if (match.route->handler) {
      Response answer = match.route->handler(request);
      KeepToAsker(service_, request, answer);
      return answer;
    }
    auto begun = match.route->upload(request);
    if (auto* refused = std::get_if<Response>(&begun)) return std::move(*refused);
    auto& sink = std::get<std::unique_ptr<BodySink>>(begun);
    const auto written = sink->Write({reinterpret_cast<const std::uint8_t*>(body.data()), body.size()});
    if (!written) return Status(-static_cast<int>(written.error().code));
    return sink->Finish();
  }
  Response Get(const std::string& target, Headers headers = {}) {
    return Send(Method::kGet, target, "", std::move(headers));
  }

  // What must be there, as text, document or picture.
  std::string Body(const std::string& target, Headers headers = {}) {
    const Response response = Get(target, std::move(headers));
    EXPECT_EQ(response.status, 200) << target << " " << response.body;
    return response.body;
  }
  nlohmann::json Json(const std::string& target, Headers headers = {}) {
    return nlohmann::json::parse(Body(target, std::move(headers)), nullptr, false);
  }
  image::RgbaImage Picture(const std::string& target) {
    return test::ValueOf(image::DecodePicture(Body(target)));
  }

  // A new token, as the header that shows it. Its id is its name.
  Headers MakeToken(const std::string& name, storage::Scope scope, std::optional<std::int64_t> max_bytes = {},
                    const std::string& flight_id = "") {
    const std::string text = NewTokenText();
    storage::Token token{name, name, HashToken(text), scope, storage::Now()};
    token.max_bytes = max_bytes;
    token.flight_id = flight_id;
    EXPECT_TRUE(service_.tokens.Add(token));
    return {{"Authorization", "Bearer " + text}};
  }

  std::string NewFlight() { return catalogue.AddFlight("field", "{}", storage::Now())->id; }
  std::int64_t Publish(const std::string& flight, const std::vector<storage::SmallTile>& tiles,
                       int tile_size_px = 256, const std::optional<storage::Revision>& facts = {}) {
    return storage::PublishSmallTileset(dir_, *db_, flight, tiles, tile_size_px, facts);
  }
  std::int64_t PublishAt(const geo::LatLonBounds& bounds, const std::string& flight,
                         const std::vector<storage::SmallTile>& tiles, int tile_size_px = 256) {
    storage::Revision facts;
    facts.bounds = bounds;
    return Publish(flight, tiles, tile_size_px, facts);
  }
  const storage::DataDir& dir() const { return dir_; }
  const Router& router() const { return router_; }
  Service& service() { return service_; }

 private:
  static Response Status(int status) {
    Response response;
    response.status = status;
    return response;
  }

  test::TemporaryFolder scratch_;
  storage::DataDir dir_;
  std::unique_ptr<storage::CatalogueDb> db_;

 public:
  storage::Catalogue catalogue;
  storage::JobQueue queue;

 private:
  storage::PhotoStore store_;
  storage::TilesetCache tilesets_;
  Metrics metrics_;
  Service service_;
  Router router_;
};

inline std::string BodyOf(Response& response) {
  if (response.source == nullptr) return response.body;
  std::string body;
  std::vector<std::uint8_t> slice(7);
  while (true) {
    const auto got = response.source->Read(slice);
    EXPECT_TRUE(got);
    if (!got || *got == 0) return body;
    body.append(slice.begin(), slice.begin() + static_cast<std::ptrdiff_t>(*got));
  }
}

}  // namespace skyquilt::api
