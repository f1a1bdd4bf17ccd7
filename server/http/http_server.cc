#include "server/http/http_server.h"

#include <utility>
// <utility> first: Boost 1.74's awaitable uses std::exchange without including it.
#include <fmt/format.h>

#include <atomic>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <future>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/base/try.h"
#include "server/http/http_session.h"
#include "server/http/session_set.h"
#include "server/routing/client_address.h"
#include "server/routing/network_addresses.h"
#include "server/routing/request_log.h"

namespace skyquilt::server {
namespace {

namespace net = boost::asio;
using net::ip::tcp;

constexpr int kBacklog = 1024;
constexpr std::chrono::seconds kOpenTime{3};
constexpr std::chrono::milliseconds kAcceptPause{50};  // after an accept that failed (out of descriptors)

// A thread with its io_context; a connection stays with one of them, so that its parts need no locks.
struct Lane {
  net::io_context io{1};
  net::executor_work_guard<net::io_context::executor_type> work = net::make_work_guard(io);
  std::thread thread;
};

skyquilt::Error BindError(const tcp::endpoint& end, const boost::system::error_code& error) {
  const std::string where = fmt::format("{}:{}", end.address().to_string(), end.port());
  if (error == net::error::address_in_use) {
    return {ErrorCode::kConflict, where + " is in use. Stop the other server, or choose another --listen."};
  }
  if (error == net::error::access_denied) {
    return {ErrorCode::kForbidden, "Listening at " + where + " is not permitted. Choose a port above 1023."};
  }
  return {ErrorCode::kIo, "Listening at " + where + " failed: " + error.message() + "."};
}

struct Listener {
  explicit Listener(net::io_context& io) : acceptor(io), pause(io) {}
  Result<void> ListenAt(const tcp::endpoint& end) {
    boost::system::error_code error, ignored;
    acceptor.close(ignored);
    acceptor.open(end.protocol(), error);
    if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor.bind(end, error);
    if (!error) acceptor.listen(kBacklog, error);
    return error ? Result<void>(BindError(end, error)) : Result<void>();
  }
  tcp::acceptor acceptor;
  net::steady_timer pause;
  bool is_by_network = false;
};

}  // namespace

struct HttpServer::State {
  State(const HttpSettings& given, const api::Router& router, api::Service& service)
      : settings(given), pools(given), context{router, service, settings, pools, sessions} {
    for (int i = 0; i < settings.threads; ++i) lanes.push_back(std::make_unique<Lane>());
    listeners.push_back(std::make_unique<Listener>(lanes.front()->io));
  }

  void Accept(Listener& at) {
    Lane& lane = *lanes[next++ % lanes.size()];
    at.acceptor.async_accept(lane.io,
                             [this, &at, &lane](const boost::system::error_code& error, tcp::socket socket) {
                               if (error == net::error::operation_aborted || !at.acceptor.is_open()) return;
                               if (error) {
                                 at.pause.expires_after(kAcceptPause);
                                 at.pause.async_wait([this, &at](const boost::system::error_code&) {
                                   if (at.acceptor.is_open()) Accept(at);
                                 });
                                 return;
                               }
                               HandOver(lane, std::move(socket), at.is_by_network);
                               Accept(at);
                             });
  }

  // On the first lane, as all that touches listeners once it runs.
  Result<void> OpenNetwork() {
    if (context.service.is_draining) return skyquilt::Error{ErrorCode::kUnavailable, "The server is ending."};
    bool is_open = false;
    Result<void> failed = skyquilt::Error{
        ErrorCode::kConflict, "This computer is in no network. Connect it to one, and try again."};
    for (const std::string& host : NetworkHosts()) {
      const Result<void> listens = PortAt(host) ? Result<void>() : ListenBesides(host);
      is_open = is_open || listens;
      if (listens) continue;
      failed = listens.error();
      LogFailure("-", "listening at " + host, listens.error().message);
    }
    return is_open ? Result<void>() : failed;
  }

  Result<void> ListenBesides(const std::string& host) {
    const net::ip::address address = net::ip::make_address(host);
    auto listener = std::make_unique<Listener>(lanes.front()->io);
    listener->is_by_network = true;
    if (!listener->ListenAt({address, port})) SKYQUILT_TRY(listener->ListenAt({address, 0}));
    const int listens_at = listener->acceptor.local_endpoint().port();
    {
      const std::lock_guard lock(network_mutex);
      network[host] = listens_at;
    }
    context.service.is_network_open = true;
    LogEvent(fmt::format("listening at {}:{} besides, for who has a link or a token", host, listens_at));
    listeners.push_back(std::move(listener));
    Accept(*listeners.back());
    return {};
  }

  std::optional<int> PortAt(const std::string& host) const {
    const std::lock_guard lock(network_mutex);
    const auto found = network.find(host);
    return found == network.end() ? std::nullopt : std::optional(found->second);
  }

  // Above a bound the newcomer is closed at once; those that are served are not disturbed.
  void HandOver(Lane& lane, tcp::socket socket, bool by_network) {
    boost::system::error_code gone;
    const tcp::endpoint end = socket.remote_endpoint(gone);
    if (gone) return;
    std::string peer = end.address().to_string();
    SessionSet::Place place = sessions.Admit(ClientAddress(peer, {}, settings), settings.max_connections,
                                             settings.connections_of_client);
    if (place == nullptr) return;
    const int fd = socket.release();
    net::post(lane.io,
              [this, &lane, fd, by_network, peer = std::move(peer), place = std::move(place)]() mutable {
                StartSession(lane.io, fd, std::move(peer), std::move(place), context, by_network);
              });
  }

  HttpSettings settings;
  SessionSet sessions;
  // Lanes outlive the pools: work there posts its answer to a lane. The pools are stopped first.
  std::vector<std::unique_ptr<Lane>> lanes;
  RequestPools pools;
  SessionContext context;
  std::vector<std::unique_ptr<Listener>> listeners;  // the first: what was asked for at the start
  std::uint16_t port = 0;                            // of the first
  mutable std::mutex network_mutex;
  std::map<std::string, int> network;  // ports, by the addresses of this machine that were opened
  std::size_t next = 0;
};

HttpServer::HttpServer(std::unique_ptr<State> state) : state_(std::move(state)) {}

Result<std::unique_ptr<HttpServer>> HttpServer::Listen(const HttpSettings& settings,
                                                       const api::Router& router, api::Service& service) {
  boost::system::error_code error;
  const net::ip::address address = net::ip::make_address(settings.address, error);
  if (error) {
    return skyquilt::Error{ErrorCode::kInvalidArgument,
                           fmt::format("\"{}\" is not an IP address to listen at.", settings.address)};
  }
  auto state = std::make_unique<State>(settings, router, service);
  const tcp::endpoint endpoint(address, settings.port);
  SKYQUILT_TRY(state->listeners.front()->ListenAt(endpoint));
  state->port = state->listeners.front()->acceptor.local_endpoint().port();
  return std::unique_ptr<HttpServer>(new HttpServer(std::move(state)));
}

int HttpServer::port() const { return state_->port; }

Result<void> HttpServer::OpenNetwork() {
  // Whoever waits may be gone when the lane gets to it, or the lane when it was to. Who was told that it was
  // not opened finds it closed.
  struct Asked {
    std::promise<Result<void>> answer;
    std::atomic<bool> is_taken = false;  // by the lane, or given up
  };
  const auto asked = std::make_shared<Asked>();
  std::future<Result<void>> answer = asked->answer.get_future();
  net::post(state_->lanes.front()->io, [this, asked] {
    if (!asked->is_taken.exchange(true)) asked->answer.set_value(state_->OpenNetwork());
  });
  if (answer.wait_for(kOpenTime) != std::future_status::ready && !asked->is_taken.exchange(true))
    return skyquilt::Error{ErrorCode::kUnavailable, "The server is ending, or too busy."};
  return answer.get();
}

std::vector<std::string> HttpServer::NetworkAddresses() const {
  std::vector<std::string> addresses;
  for (const std::string& host : NetworkHosts()) {
    if (const std::optional<int> port = state_->PortAt(host))
      addresses.push_back(fmt::format("http://{}:{}{}", host, *port, state_->settings.base_path));
  }
  return addresses;
}

void HttpServer::Start() {
  for (const auto& lane : state_->lanes) {
    lane->thread = std::thread([&io = lane->io] { io.run(); });
  }
  net::post(state_->lanes.front()->io, [this] { state_->Accept(*state_->listeners.front()); });
}

bool HttpServer::Drain(std::chrono::milliseconds timeout) {
  state_->context.service.is_draining = true;
  std::promise<void> closed;
  net::post(state_->lanes.front()->io, [&] {
    boost::system::error_code ignored;  // a listening socket that will not close is closed by the exit
    for (const auto& listener : state_->listeners) {
      listener->acceptor.close(ignored);
      listener->pause.cancel();
    }
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
  state_->listeners.clear();
  state_->lanes.clear();
}

}  // namespace skyquilt::server
