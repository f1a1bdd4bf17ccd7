// HttpServer: listens, distributes accepted connections over a few threads, and shuts down in order: stops
// accepting, closes idle connections, lets requests in progress finish. One caller; the router and service
// outlive it. Errors: kInvalidArgument (no such address), kConflict (the port is taken), kForbidden, kIo.
#pragma once

#include <chrono>
#include <memory>

#include "api/http/router.h"
#include "api/service.h"
#include "core/base/result.h"
#include "server/routing/http_settings.h"

namespace skyquilt::server {

class HttpServer {
 public:
  // Bound and listening, so that port() is known; serves from Start on.
  static Result<std::unique_ptr<HttpServer>> Listen(const HttpSettings& settings, const api::Router& router,
                                                    api::Service& service);
  ~HttpServer();

  int port() const;
  // Listens at the addresses by which the network knows this machine besides, until the end: at the same
  // port, or, where that is taken, at a free one. Asked again, it takes what the machine has come by since.
  // Who comes there needs a token. After Start. Errors: kConflict (no network), kUnavailable (it is ending),
  // kIo.
  Result<void> OpenNetwork();
  // "http://192.168.1.20:8080/skyquilt", those of now, the likeliest first; none before.
  std::vector<std::string> NetworkAddresses() const;
  void Start();
  // False: some connection did not finish in time and was cut.
  bool Drain(std::chrono::milliseconds timeout);
  // After Drain: nothing is answered any more, and what requests still do is waited for. False: something
  // goes on at `until`; then the process is to end at once, with this and all that handlers use undestroyed.
  bool End(std::chrono::steady_clock::time_point until);

 private:
  struct State;
  explicit HttpServer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace skyquilt::server
