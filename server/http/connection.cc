#include "server/http/connection.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/buffer_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <exception>
#include <optional>
#include <vector>

#include "server/routing/request_log.h"

namespace skyquilt::server {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using SystemError = boost::system::error_code;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kDeadlineBytes = 128 * 1024;
constexpr std::size_t kLingerSliceBytes = 128 * 1024;
constexpr std::uint64_t kLingerBytes = 64 << 20;
constexpr std::chrono::seconds kLingerTime{2};

class SocketConnection : public Connection, public std::enable_shared_from_this<SocketConnection> {
 public:
  SocketConnection(net::io_context& io, net::ip::tcp::socket socket, std::string peer,
                   const HttpSettings& settings)
      : io_(io), socket_(std::move(socket)), settings_(settings), clock_(io), rest_(io) {
    peer_ = std::move(peer);
  }

  Awaitable<Head> ReadHead() override {
    is_idle_ = true;
    head_ = RequestHead();
    bool has_begun = buffer_.size() > 0;
    const bool is_due = has_begun || is_first_;
    SetDeadline(is_due ? settings_.header_deadline : settings_.idle_deadline);
    HeadParser reading(settings_);
    HeadState state = reading.Examine(Buffered());
    while (state == HeadState::kNeedsMore) {
      SystemError error;
      const std::size_t got = co_await socket_.async_read_some(
          buffer_.prepare(4096), net::redirect_error(net::use_awaitable, error));
      if (error && is_late_ && has_begun) co_return Refuse({408, "The request head came too slowly."});
      if (error) co_return Head::kClosed;
      buffer_.commit(got);
      state = reading.Examine(Buffered());
      if (state == HeadState::kNeedsMore && !has_begun && !is_first_) SetDeadline(settings_.header_deadline);
      has_begun = true;
    }
    // What is known of a refused head still shapes the answer to it.
    head_ = std::move(reading.head());
    if (state == HeadState::kRefused) co_return Refuse(reading.refusal());
    EndHeadDeadline();
    buffer_.consume(reading.size());
    parser_ = reading.TakeParser();
    since_deadline_ = kDeadlineBytes;
    co_return Head::kRead;
  }

  bool KeepsAlive() const override { return parser_->get().keep_alive(); }
  bool IsBodyRead() const override { return parser_->is_done(); }

  Awaitable<BodySlice> ReadBody(std::span<std::uint8_t> into) override {
    parser_->get().body().data = into.data();
    parser_->get().body().size = into.size();
    // One deadline for so many bytes, however many pieces they come in: dripping does not help. One that rang
    // while nothing was read was the disk's time, not the client's.
    if (since_deadline_ >= kDeadlineBytes || is_late_) {
      SetDeadline(settings_.slice_deadline);
      since_deadline_ = 0;
    }
    SystemError error;
    co_await http::async_read_some(socket_, buffer_, *parser_,
                                   net::redirect_error(net::use_awaitable, error));
    const std::size_t size = into.size() - parser_->get().body().size;
    since_deadline_ += size;
    const bool is_read = !error || error == http::error::need_buffer;
    if (!is_read || parser_->is_done()) EndDeadline();
    if (is_read) co_return BodySlice{.size = size};
    if (error == http::error::body_limit) co_return BodySlice{.fault = BodySlice::Fault::kTooLarge};
    const bool is_bad_http = error.category() == http::make_error_code(http::error::bad_chunk).category() &&
                             error != http::error::partial_message && error != http::error::end_of_stream;
    if (is_bad_http) co_return BodySlice{.fault = BodySlice::Fault::kNotHttp, .reason = error.message()};
    if (is_late_ && error == net::error::operation_aborted) {
      co_return BodySlice{.fault = BodySlice::Fault::kTooSlow,
                          .reason = fmt::format("less than {} KiB of it in {} s", kDeadlineBytes / 1024,
                                                settings_.slice_deadline.count())};
    }
    has_failed_ = true;  // the client is gone
    co_return BodySlice{.fault = BodySlice::Fault::kConnection};
  }

  Awaitable<void> Write(std::string_view head, std::span<const std::uint8_t> body) override {
    std::array<net::const_buffer, 2> buffers = {net::buffer(head.data(), head.size()),
                                                net::buffer(body.data(), body.size())};
    // What the system takes at once needs no turn of the loop, but for who sent several requests together:
    // others have their turns between his answers. What fails here fails again below.
    SystemError error, untaken;
    const std::size_t sent = buffer_.size() == 0 ? socket_.write_some(buffers, untaken) : 0;
    if (sent < head.size() + body.size()) {
      const std::size_t sent_of_head = std::min(sent, head.size());
      buffers[0] += sent_of_head;
      buffers[1] += sent - sent_of_head;
      SetDeadline(settings_.slice_deadline);  // also where a body is answered before it was read
      co_await net::async_write(socket_, buffers, net::redirect_error(net::use_awaitable, error));
    }
    EndDeadline();
    if (error) has_failed_ = true;
  }

  Awaitable<RequestPool::Answer> RunOnPool(RequestPool& pool, const std::string& client,
                                           std::function<void()> work) override {
    co_return co_await Run(work, [&](auto run) { return pool.Submit(client, std::move(run)); });
  }

  Awaitable<void> OnPool(RequestPool& pool, std::function<void()> work) override {
    co_await Run(work, [&](auto run) {
      pool.Continue([run = std::move(run)] { run(false); });
      return RequestPool::Answer::kTaken;
    });
  }

  Awaitable<void> Rest(std::chrono::milliseconds time) override {
    if (!is_woken_) {
      rest_.expires_after(time);
      SystemError error;
      co_await rest_.async_wait(net::redirect_error(net::use_awaitable, error));
    }
    is_woken_ = false;
  }

  std::function<void()> Waker() override {
    return [weak = weak_from_this(), &io = io_] {
      net::post(io, [weak] {
        if (const auto self = weak.lock()) self->Wake();
      });
    };
  }

  void WatchForEnd() override {
    socket_.async_wait(net::ip::tcp::socket::wait_read, [weak = weak_from_this()](const SystemError& error) {
      const auto self = weak.lock();
      if (self == nullptr || error == net::error::operation_aborted) return;
      SystemError unknown;
      const bool has_ended = self->socket_.available(unknown) == 0;
      if (error || unknown || has_ended) self->has_failed_ = true;
      self->Wake();
    });
  }

  Awaitable<void> EndGently() override {
    SystemError error;
    socket_.shutdown(net::ip::tcp::socket::shutdown_send, error);
    SetDeadline(kLingerTime);
    std::vector<std::uint8_t> slice(kLingerSliceBytes);
    std::uint64_t dropped = 0;
    while (!error && dropped < kLingerBytes) {
      dropped += co_await socket_.async_read_some(net::buffer(slice),
                                                  net::redirect_error(net::use_awaitable, error));
    }
  }

  void CloseIfIdle() override {
    SystemError unknown;
    if (is_idle_) socket_.close(unknown);
    Wake();
  }

 private:
  void Wake() {
    is_woken_ = true;
    rest_.cancel();
  }

  std::string_view Buffered() const {
    const auto bytes = buffer_.data();
    return {static_cast<const char*>(bytes.data()), bytes.size()};
  }

  // `hand_over` gives a pool what is to be run there, and says whether it was taken.
  template <typename HandOver>
  Awaitable<RequestPool::Answer> Run(const std::function<void()>& work, HandOver hand_over) {
    using Answer = RequestPool::Answer;
    co_return co_await net::async_initiate<const net::use_awaitable_t<>&, void(std::exception_ptr, Answer)>(
        [this, &work, &hand_over](auto handler) {
          auto shared = std::make_shared<decltype(handler)>(std::move(handler));
          const Answer answer = hand_over([this, &work, shared](bool is_late) {
            std::exception_ptr failure;
            try {
              if (!is_late) work();
            } catch (...) {
              failure = std::current_exception();  // carried to the coroutine, which ends the connection
            }
            net::post(io_, [shared, failure, is_late] {
              (*shared)(failure, is_late ? Answer::kFull : Answer::kTaken);
            });
          });
          if (answer != Answer::kTaken) net::post(io_, [shared, answer] { (*shared)(nullptr, answer); });
        },
        net::use_awaitable);
  }

  // At the deadline what is read or written is given up, but the socket stays: who sent a part of a request
  // is told. A clock that rings too early looks again at the time; setting it for each request costs more.
  void SetDeadline(std::chrono::seconds time) {
    is_late_ = false;
    due_ = Clock::now() + time;
    if (!rings_ || *due_ < *rings_) SetClock();
  }

  void SetClock() {
    rings_ = due_;
    clock_.expires_at(*rings_);
    clock_.async_wait([weak = weak_from_this(), rings = *rings_](const SystemError& error) {
      const std::shared_ptr<SocketConnection> self = weak.lock();
      if (error || self == nullptr || self->rings_ != rings) return;  // set anew meanwhile
      self->rings_.reset();
      if (!self->due_) return;
      if (*self->due_ > Clock::now()) return self->SetClock();
      self->due_.reset();
      self->is_late_ = true;
      SystemError unknown;
      self->socket_.cancel(unknown);
    });
  }

  void EndDeadline() { due_.reset(); }

  void EndHeadDeadline() {
    EndDeadline();
    is_idle_ = false;
    is_first_ = false;
  }

  Head Refuse(Refusal refusal) {
    EndHeadDeadline();
    refusal_ = std::move(refusal);
    return Head::kRefused;
  }

  net::io_context& io_;
  net::ip::tcp::socket socket_;
  const HttpSettings& settings_;
  beast::flat_buffer buffer_;
  std::unique_ptr<RequestParser> parser_;
  net::steady_timer clock_;
  std::optional<Clock::time_point> rings_;  // when the clock does
  std::optional<Clock::time_point> due_;    // the deadline; none while nobody waits for the client
  net::steady_timer rest_;
  bool is_woken_ = false;
  std::size_t since_deadline_ = 0;
  bool is_late_ = false;
  bool is_idle_ = true;
  bool is_first_ = true;
};

}  // namespace

std::shared_ptr<Connection> TakeConnection(net::io_context& io, int fd, std::string peer,
                                           const HttpSettings& settings) {
  net::ip::tcp::socket socket(io);
  SystemError error;
  socket.assign(net::ip::tcp::v4(), fd, error);
  if (!error) socket.non_blocking(true, error);  // Write tries before it waits
  if (error) {
    LogFailure("-", "accept", error.message());
    return nullptr;
  }
  socket.set_option(net::ip::tcp::no_delay(true), error);
  return std::make_shared<SocketConnection>(io, std::move(socket), std::move(peer), settings);
}

}  // namespace skyquilt::server
