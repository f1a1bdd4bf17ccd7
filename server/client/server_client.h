// ServerClient: single requests to a running Skyquilt, over one connection that is kept (libcurl). A server
// that does not answer, or says that it is busy, is asked again for as long as was said; what is waited for
// is told. Blocking; one thread at a time. Errors: kUnavailable (no answer for that long), kCancelled,
// kInvalidArgument (no address), kUnauthorized, kForbidden and kNotFound as the server has them, with its own
// words, kUnprocessable for its other refusals.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"

namespace skyquilt::server {

struct ClientSettings {
  std::string url;    // "http://host:port", no slash at the end
  std::string token;  // empty: none
  std::chrono::seconds patience{600};
};

struct ClientRequest {
  const char* method = "GET";
  std::string path;  // from the server's root, encoded; or a whole address below it
  std::vector<std::pair<std::string, std::string>> headers;
  std::string body;
  // Instead of a body: a part of a file.
  std::filesystem::path file;
  std::uint64_t from = 0, length = 0;
  std::function<void(std::uint64_t sent)> on_sent;
};

struct ClientAnswer {
  long status = 0;
  std::string body;
  std::vector<std::pair<std::string, std::string>> headers;

  std::string Header(const std::string& name) const;  // empty where it is absent
};

class ServerClient {
 public:
  // `waits`: told, in words, whenever the server is waited for.
  ServerClient(ClientSettings settings, Progress& progress, std::function<void(const std::string&)> waits);
  ~ServerClient();
  ServerClient(const ServerClient&) = delete;
  ServerClient& operator=(const ServerClient&) = delete;

  // Asked again where the server does not answer: for what may be sent twice. An answer has a status below
  // 400.
  Result<ClientAnswer> Send(const ClientRequest& request);
  // Once. kUnavailable: it may or may not have arrived.
  Result<ClientAnswer> SendOnce(const ClientRequest& request);
  // Sleeps a little longer each time, from the first failure after `Succeeded`; an error when patience ends.
  Result<void> WaitAfter(const Error& failure);
  void Succeeded();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace skyquilt::server
