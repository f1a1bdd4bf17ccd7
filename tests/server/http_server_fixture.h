// HttpServerTest: a server at a free port over an empty data folder, spoken to in raw bytes.
#pragma once

#include <filesystem>
#include <iterator>
#include <thread>

#include "api/build_api.h"
#include "server/http/http_server.h"
#include "tests/server/raw_client.h"
#include "tests/server/served_folder.h"

namespace skyquilt::server {

class HttpServerTest : public ServedFolder {
 protected:
  HttpServerTest() : router_(api::BuildApi(service_)) {
    settings_.port = 0;
    settings_.header_deadline = std::chrono::seconds(1);
  }

  void Start() {
    auto server = HttpServer::Listen(settings_, router_, service_);
    ASSERT_TRUE(server) << server.error().message;
    server_ = *std::move(server);
    server_->Start();
  }
  int port() const { return server_->port(); }
  RawAnswer Ask(const std::string& bytes) { return RawClient(port()).Ask(bytes); }
  int CountIncoming() const {
    return static_cast<int>(std::distance(std::filesystem::directory_iterator(dir_.Incoming()), {}));
  }
  bool WaitForIncoming(int count) const {
    for (int i = 0; i < 1000 && CountIncoming() != count; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(25));
    return CountIncoming() == count;
  }

  api::Router router_;
  HttpSettings settings_;
  std::unique_ptr<HttpServer> server_;
};

inline const std::string kHost = "Host: localhost\r\n";

}  // namespace skyquilt::server
