#include "server/http/http_server.h"

#include <utility>
// <utility> first: Boost 1.74's awaitable uses std::exchange without including it.
#include <fmt/format.h>

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <future>
#include <thread>
#include <vector>

#include "server/http/http_session.h"
#include "server/http/session_set.h"
#include "server/routing/client_address.h"
#include "server/routing/request_log.h"

namespace skyquilt::server {
namespace {

namespace net = boost::asio;
using net::ip::tcp;

constexpr int kBacklog = 1024;
constexpr std::chrono::milliseconds kAcceptPause{50};  // after an accept that failed (out of descriptors)

// A thread with its io_context; a connection stays with one of them, so that its parts need no locks.
struct Lane {
  net::io_context io{1};
  net::executor_work_guard<net::io_context::executor_type> work = net::make_work_guard(io);
  std::thread thread;
};

skyquilt::Error BindError(const HttpSettings& settings, const boost::system::error_code& error) {
  const std::string where = fmt::format("{}:{}", settings.address, settings.port);
  if (error == net::error::address_in_use) {
    return {ErrorCode::kConflict, where + " is in use. Stop the other server, or choose another --listen.",
            ""};
  }
  if (error == net::error::access_denied) {
    return {ErrorCode::kForbidden, "Listening at " + where + " is not permitted. Choose a port above 1023.",
            ""};
  }
  return {ErrorCode::kIo, "Listening at " + where + " failed: " + error.message() + ".", ""};
}

}  // namespace

struct HttpServer::State {
  State(const HttpSettings& given, const api::Router& router, api::Service& service)
      : settings(given), pools(given), context{router, service, settings, pools, sessions} {
    for (int i = 0; i < settings.threads; ++i) lanes.push_back(std::make_unique<Lane>());
    acceptor.emplace(lanes.front()->io);
    pause.emplace(lanes.front()->io);
  }

  void Accept() {
    Lane& lane = *lanes[next++ % lanes.size()];
    acceptor->async_accept(lane.io,
                           [this, &lane](const boost::system::error_code& error, tcp::socket socket) {
                             if (error == net::error::operation_aborted || !acceptor->is_open()) return;
                             if (error) {
                               pause->expires_after(kAcceptPause);
                               pause->async_wait([this](const boost::system::error_code&) {
                                 if (acceptor->is_open()) Accept();
                               });
                               return;
                             }
                             HandOver(lane, std::move(socket));
                             Accept();
                           });
  }

  // Above a bound the newcomer is closed at once; those that are served are not disturbed.
  void HandOver(Lane& lane, tcp::socket socket) {
    boost::system::error_code gone;
    const tcp::endpoint end = socket.remote_endpoint(gone);
    if (gone) return;
    std::string peer = end.address().to_string();
    SessionSet::Place place = sessions.Admit(ClientAddress(peer, {}, settings), settings.max_connections,
                                             settings.connections_of_client);
    if (place == nullptr) return;
    const int fd = socket.release();
    net::post(lane.io, [this, &lane, fd, peer = std::move(peer), place = std::move(place)]() mutable {
      StartSession(lane.io, fd, std::move(peer), std::move(place), context);
    });
  }

  HttpSettings settings;
  SessionSet sessions;
  // Lanes outlive the pools: work there posts its answer to a lane. The pools are stopped first.
  std::vector<std::unique_ptr<Lane>> lanes;
  RequestPools pools;
  SessionContext context;
  std::optional<tcp::acceptor> acceptor;
  std::optional<net::steady_timer> pause;
  std::size_t next = 0;
};

HttpServer::HttpServer(std::unique_ptr<State> state) : state_(std::move(state)) {}

Result<std::unique_ptr<HttpServer>> HttpServer::Listen(const HttpSettings& settings,
                                                       const api::Router& router, api::Service& service) {
  boost::system::error_code error;
  const net::ip::address address = net::ip::make_address(settings.address, error);
  if (error) {
    return skyquilt::Error{ErrorCode::kInvalidArgument,
                           fmt::format("\"{}\" is not an IP address to listen at.", settings.address), ""};
  }
  auto state = std::make_unique<State>(settings, router, service);
  const tcp::endpoint endpoint(address, settings.port);
  tcp::acceptor& acceptor = *state->acceptor;
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(kBacklog, error);
  if (error) return BindError(settings, error);
  return std::unique_ptr<HttpServer>(new HttpServer(std::move(state)));
}

int HttpServer::port() const { return state_->acceptor->local_endpoint().port(); }

void HttpServer::Start() {
  for (const auto& lane : state_->lanes) {
    lane->thread = std::thread([&io = lane->io] { io.run(); });
  }
  net::post(state_->lanes.front()->io, [this] { state_->Accept(); });
}

bool HttpServer::Drain(std::chrono::milliseconds timeout) {
  state_->context.service.is_draining = true;
  std::promise<void> closed;
  net::post(state_->lanes.front()->io, [&] {
    boost::system::error_code ignored;  // a listening socket that will not close is closed by the exit
    state_->acceptor->close(ignored);
    state_->pause->cancel();
    closed.set_value();
  });
  closed.get_future().wait();
  // A connection may become idle after the first check, so the check is repeated.
  const auto end = std::chrono::steady_clock::now() + timeout;
  while (true) {
    state_->sessions.CloseIdle();
    if (state_->sessions.WaitForNone(std::chrono::milliseconds(50))) return true;
    if (std::chrono::steady_clock::now() >= end) return false;
  }
}

bool HttpServer::End(std::chrono::steady_clock::time_point until) {
  state_->context.service.event_hub.Stop();
  for (const auto& lane : state_->lanes) lane->io.stop();
  for (const auto& lane : state_->lanes) {
    if (lane->thread.joinable()) lane->thread.join();
  }
  bool has_ended = true;
  for (RequestPool* pool : {&state_->pools.read, &state_->pools.write, &state_->pools.compute}) {
    has_ended = pool->Stop(until) && has_ended;
  }
  return has_ended;
}

HttpServer::~HttpServer() {
  End(std::chrono::steady_clock::now() + std::chrono::hours(24));
  // What is left of the coroutines is destroyed with its lane, while everything that it refers to is still
  // there.
  state_->acceptor.reset();
  state_->pause.reset();
  state_->lanes.clear();
}

}  // namespace skyquilt::server
