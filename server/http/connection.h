// Connection: one TCP connection with HTTP's framing: request heads under a deadline, bodies in and out in
// slices, and a request's work on other threads. Knows no routes and no answers (server/http/http_session
// does). Run by the one thread of its io_context; throws only what work on the pool threw. After a failed
// read or write has_failed() is true and the connection must be closed.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
// <utility> first: Boost 1.74's awaitable uses std::exchange without including it.
#include <boost/asio/awaitable.hpp>

#include "server/http/request_pool.h"
#include "server/routing/http_settings.h"
#include "server/routing/request_head.h"

namespace boost::asio {
class io_context;
}  // namespace boost::asio

namespace skyquilt::server {

template <typename T>
using Awaitable = boost::asio::awaitable<T>;

// What became of a slice of a request's body.
struct BodySlice {
  enum class Fault { kNone, kTooLarge, kNotHttp, kTooSlow, kConnection };
  std::size_t size = 0;
  Fault fault = Fault::kNone;
  std::string reason = {};  // of kNotHttp and kTooSlow
};

class Connection {
 public:
  enum class Head { kRead, kRefused, kClosed };

  virtual ~Connection() = default;

  // The next request: head() after kRead, refusal() (and what is known of head()) after kRefused.
  virtual Awaitable<Head> ReadHead() = 0;
  RequestHead& head() { return head_; }
  const Refusal& refusal() const { return refusal_; }

  // After kRead: whether the client wants to go on with this connection, and the body that follows the head.
  virtual bool KeepsAlive() const = 0;
  virtual bool IsBodyRead() const = 0;
  virtual Awaitable<BodySlice> ReadBody(std::span<std::uint8_t> into) = 0;

  // Both with one deadline.
  virtual Awaitable<void> Write(std::string_view head, std::span<const std::uint8_t> body) = 0;
  // Runs `work` on the pool, and comes back to this connection's own thread. Not kTaken: it was not run.
  virtual Awaitable<RequestPool::Answer> RunOnPool(RequestPool& pool, const std::string& client,
                                                   std::function<void()> work) = 0;
  // The same for a piece of what is under way already, which is never refused.
  virtual Awaitable<void> OnPool(RequestPool& pool, std::function<void()> work) = 0;
  // Until `time` has passed or the waker, which may be called from any thread, was called since the last
  // rest.
  virtual Awaitable<void> Rest(std::chrono::milliseconds time) = 0;
  virtual std::function<void()> Waker() = 0;
  // From now on the client's end of the connection fails it and ends a rest, though nothing is read or
  // written.
  virtual void WatchForEnd() = 0;
  // Says that nothing more comes, and lets what the client still sends run out for a while: closing over
  // unread bytes would reset the connection under the last answer.
  virtual Awaitable<void> EndGently() = 0;
  // Closes it where no request is under way, and ends a rest.
  virtual void CloseIfIdle() = 0;

  // The other end, as the system says; behind a proxy that is the proxy.
  const std::string& peer() const { return peer_; }
  bool has_failed() const { return has_failed_; }
  void GiveUp() { has_failed_ = true; }

 protected:
  std::string peer_;
  RequestHead head_;
  Refusal refusal_;
  bool has_failed_ = false;
};

// Takes over the accepted socket `fd`; null, and a line in the log, where the system refuses.
std::shared_ptr<Connection> TakeConnection(boost::asio::io_context& io, int fd, std::string peer,
                                           const HttpSettings& settings);

}  // namespace skyquilt::server
