// StartSession: serves one connection (server/http/connection) until it closes: takes a request head,
// finds its route, streams bodies in slices, answers, and goes on (keep-alive, pipelining). Handlers that
// compute or wait run on a pool of their kind, bounded, and only quick ones where the socket is served. Never
// throws into the io_context.
#pragma once

#include <string>

#include "api/http/router.h"
#include "api/service.h"
#include "server/http/request_pool.h"
#include "server/http/session_set.h"
#include "server/routing/http_settings.h"

namespace boost::asio {
class io_context;
}  // namespace boost::asio

namespace skyquilt::server {

// Where requests are carried out that are not quick.
struct RequestPools {
  explicit RequestPools(const HttpSettings& settings);
  RequestPool& Of(api::Work work);
  RequestPool read;
  RequestPool write;
  RequestPool compute;
};

// What every connection works with; outlives them all.
struct SessionContext {
  const api::Router& router;
  api::Service& service;
  const HttpSettings& settings;
  RequestPools& pools;
  SessionSet& sessions;
};

// Takes over the accepted socket `fd`, whose other end is `peer`, and keeps `place` while it is open. The
// io_context is run by one thread. `by_network`: see RouteRequest.
void StartSession(boost::asio::io_context& io, int fd, std::string peer, SessionSet::Place place,
                  SessionContext& context, bool by_network);

}  // namespace skyquilt::server
