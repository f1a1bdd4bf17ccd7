// StartSession: serves one connection (server/connection) until it closes: takes a request head,
// finds its route, streams bodies in slices, answers, and goes on (keep-alive, pipelining). Handlers that
// wait for the disk run on the pool, quick ones where the socket is served. Never throws into the io_context.
#pragma once

#include "api/router.h"
#include "api/service.h"
#include "server/http_settings.h"
#include "server/session_set.h"

namespace boost::asio {
class io_context;
class thread_pool;
}  // namespace boost::asio

namespace skyquilt::server {

// What every connection works with; outlives them all.
struct SessionContext {
  const api::Router& router;
  api::Service& service;
  const HttpSettings& settings;
  boost::asio::thread_pool& disk_pool;
  SessionSet& sessions;
};

// Takes over the accepted socket `fd`. The io_context is run by one thread.
void StartSession(boost::asio::io_context& io, int fd, SessionContext& context);

}  // namespace skyquilt::server
