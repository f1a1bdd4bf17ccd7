#include "server/http_session.h"

#include <utility>
// <utility> first: Boost 1.74's awaitable uses std::exchange without including it.
#include <fmt/format.h>

#include <array>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/buffer_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <exception>
#include <functional>
#include <memory>
#include <vector>

#include "api/problem.h"
#include "server/head_parser.h"
#include "server/request_head.h"
#include "server/request_log.h"
#include "server/response_head.h"
#include "server/route_request.h"

namespace skyquilt::server {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using SystemError = boost::system::error_code;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kReceiveSliceBytes = 128 * 1024;
constexpr std::size_t kSendSliceBytes = 256 * 1024;
constexpr std::uint64_t kLingerBytes = 64 << 20;
constexpr std::chrono::seconds kLingerTime{2};
constexpr std::chrono::milliseconds kLivePause{200};  // between two looks for what is new

class Session : public std::enable_shared_from_this<Session> {
 public:
  Session(net::io_context& io, net::ip::tcp::socket socket, SessionContext& context)
      : io_(io), stream_(std::move(socket)), context_(context), head_deadline_(io) {}

  ~Session() {
    context_.sessions.Remove(key_);
    context_.service.metrics.ConnectionClosed();
  }

  void Start() {
    context_.service.metrics.ConnectionOpened();
    key_ = context_.sessions.Add([weak = weak_from_this(), &io = io_] {
      net::post(io, [weak] {
        const std::shared_ptr<Session> self = weak.lock();
        if (self != nullptr && self->is_idle_) self->stream_.close();
      });
    });
    net::co_spawn(
        io_, [self = shared_from_this()]() -> net::awaitable<void> { return self->Serve(); },
        [](const std::exception_ptr& failure) { LogUncaught(failure); });
  }

 private:
  enum class Head { kRead, kRefused, kClosed };

  net::awaitable<void> Serve() {
    // A copy here keeps the session alive for as long as its coroutine runs.
    const std::shared_ptr<Session> self = shared_from_this();
    bool goes_on = true;
    while (goes_on) {
      const Head got = co_await ReadHead();
      if (got == Head::kClosed) co_return;
      started_ = Clock::now();
      request_id_ = NextRequestId();
      keep_alive_ = got == Head::kRead && !context_.service.is_draining;
      if (got == Head::kRead) {
        co_await Answer();
      } else {
        api::Response response = api::ProblemWithStatus(refusal_.status, refusal_.reason, "", request_id_);
        co_await Send(std::move(response), false);
      }
      goes_on = keep_alive_ && !failed_;
      is_first_ = false;
    }
    if (!failed_) co_await Linger();
  }

  // Fills head_ from the next request, or refusal_.
  net::awaitable<Head> ReadHead() {
    is_idle_ = true;
    is_head_ = false;
    head_ = RequestHead();
    bool has_begun = buffer_.size() > 0;
    const bool is_due = has_begun || is_first_;
    SetHeadDeadline(is_due ? context_.settings.header_deadline : context_.settings.idle_deadline);
    HeadParser reading(context_.settings);
    HeadState state = reading.Look(Buffered());
    while (state == HeadState::kNeedsMore) {
      SystemError error;
      const std::size_t got = co_await stream_.async_read_some(
          buffer_.prepare(4096), net::redirect_error(net::use_awaitable, error));
      if (error && is_late_ && has_begun) co_return Refuse({408, "The request head came too slowly."});
      if (error) co_return Head::kClosed;
      buffer_.commit(got);
      state = reading.Look(Buffered());
      // Most heads come whole, and setting a timer that is sooner than all others costs a system call.
      if (state == HeadState::kNeedsMore && !has_begun && !is_first_)
        SetHeadDeadline(context_.settings.header_deadline);
      has_begun = true;
    }
    // What is known of a refused head still shapes the answer to it.
    head_ = std::move(reading.head());
    if (state == HeadState::kRefused) co_return Refuse(reading.refusal());
    EndHeadDeadline();
    is_idle_ = false;
    buffer_.consume(reading.size());
    parser_ = reading.TakeParser();
    co_return Head::kRead;
  }

  std::string_view Buffered() const {
    const auto bytes = buffer_.data();
    return {static_cast<const char*>(bytes.data()), bytes.size()};
  }

  // At the deadline the read is given up, but the socket stays: who sent a part of a head is told.
  void SetHeadDeadline(std::chrono::seconds time) {
    stream_.expires_never();
    is_late_ = false;
    head_deadline_.expires_after(time);
    head_deadline_.async_wait([weak = weak_from_this(), round = ++deadline_round_](const SystemError& error) {
      const std::shared_ptr<Session> self = weak.lock();
      if (error || self == nullptr || round != self->deadline_round_) return;
      self->is_late_ = true;
      self->stream_.cancel();
    });
  }

  void EndHeadDeadline() {
    ++deadline_round_;  // one that has rung already, but was not heard, is too late
    head_deadline_.cancel();
  }

  Head Refuse(Refusal refusal) {
    EndHeadDeadline();
    is_idle_ = false;
    refusal_ = std::move(refusal);
    return Head::kRefused;
  }

  net::awaitable<void> Answer() {
    keep_alive_ = keep_alive_ && parser_->get().keep_alive();
    is_head_ = head_.method == "HEAD";
    const bool has_body = head_.is_chunked || head_.content_length.value_or(0) > 0;
    Routed routed = RouteRequest(head_, context_.router, context_.settings, context_.service, request_id_);
    if (routed.route != nullptr && routed.route->upload) {
      co_await Receive(*routed.route, std::move(routed.request), has_body);
      co_return;
    }
    // A body that nobody asked for is not read: the answer, then the end of the connection.
    if (has_body) keep_alive_ = false;
    api::Response response = std::move(routed.response);
    if (routed.route != nullptr) {
      if (routed.route->is_quick) {
        response = Guarded(routed.request, [&] { return routed.route->handler(routed.request); });
      } else {
        co_await OnPool([&] {
          response = Guarded(routed.request, [&] { return routed.route->handler(routed.request); });
        });
      }
    }
    co_await Send(std::move(response), routed.route != nullptr && routed.route->is_quick);
  }

  // What a handler throws (the machine is out of something) becomes a 500 of this one request.
  template <typename Call>
  static api::Response Guarded(const api::Request& request, Call call) {
    try {
      return call();
    } catch (const std::exception& failure) {
      LogFailure(request.request_id, request.path, failure.what());
      return api::Problem({ErrorCode::kInternal, "The server failed at this request. Its log says more.", ""},
                          request);
    }
  }

  // Runs `work` where waiting for the disk is fine, and comes back to this connection's own thread.
  net::awaitable<void> OnPool(std::function<void()> work) {
    co_await net::async_initiate<const net::use_awaitable_t<>&, void(std::exception_ptr)>(
        [this, &work](auto handler) {
          auto shared = std::make_shared<decltype(handler)>(std::move(handler));
          net::post(context_.disk_pool, [this, &work, shared] {
            std::exception_ptr failure;
            try {
              work();
            } catch (...) {
              failure = std::current_exception();  // carried to the coroutine, which ends the connection
            }
            net::post(io_, [shared, failure] { (*shared)(failure); });
          });
        },
        net::use_awaitable);
  }

  // An upload: begun, fed slice by slice, finished.
  net::awaitable<void> Receive(const api::Route& route, api::Request request, bool has_body) {
    std::unique_ptr<api::BodySink> sink;
    api::Response response;
    is_upload_ = true;
    co_await OnPool([&] {
      response = Guarded(request, [&] {
        auto begun = route.upload(request);
        if (auto* refused = std::get_if<api::Response>(&begun)) return std::move(*refused);
        sink = std::move(std::get<std::unique_ptr<api::BodySink>>(begun));
        return api::Response();
      });
    });
    if (sink == nullptr) {
      if (has_body) keep_alive_ = false;
      co_await Send(std::move(response), false);
      co_return;
    }
    const bool arrived = !has_body || co_await ReceiveBody(*sink, request, &response);
    co_await OnPool([&] {
      if (arrived) response = Guarded(request, [&] { return sink->Finish(); });
      sink.reset();  // an upload that broke is undone here, before anyone hears of it
    });
    if (failed_) co_return;
    if (!arrived) keep_alive_ = false;
    co_await Send(std::move(response), false);
  }

  // False: the body did not arrive whole or was refused; *response says why, unless the connection failed.
  net::awaitable<bool> ReceiveBody(api::BodySink& sink, const api::Request& request,
                                   api::Response* response) {
    if (head_.wants_continue) {
      static constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";
      SystemError error;
      co_await net::async_write(stream_, net::buffer(kContinue.data(), kContinue.size()),
                                net::redirect_error(net::use_awaitable, error));
      if (error) failed_ = true;
      if (error) co_return false;
    }
    std::vector<std::uint8_t> slice(kReceiveSliceBytes);
    std::size_t since_deadline = kReceiveSliceBytes;
    while (!parser_->is_done()) {
      parser_->get().body().data = slice.data();
      parser_->get().body().size = slice.size();
      // One deadline a slice, however many pieces it comes in: dripping does not help.
      if (since_deadline >= kReceiveSliceBytes) {
        stream_.expires_after(context_.settings.slice_deadline);
        since_deadline = 0;
      }
      SystemError error;
      co_await http::async_read_some(stream_, buffer_, *parser_,
                                     net::redirect_error(net::use_awaitable, error));
      if (error == http::error::need_buffer) error = {};
      if (error == http::error::body_limit) {
        *response =
            api::Problem({ErrorCode::kTooLarge, "The body is larger than the server takes.", ""}, request);
        co_return false;
      }
      const bool is_bad_http = error.category() == http::make_error_code(http::error::bad_chunk).category() &&
                               error != http::error::partial_message && error != http::error::end_of_stream;
      if (error && !is_bad_http) {
        failed_ = true;  // the client is gone, or too slow
        co_return false;
      }
      if (error) {
        *response = api::ProblemWithStatus(400, "The body is not HTTP: " + error.message() + ".",
                                           request.path, request_id_);
        co_return false;
      }
      const std::size_t size = slice.size() - parser_->get().body().size;
      if (size == 0) continue;
      since_deadline += size;
      context_.service.metrics.CountBytesIn(size);
      bool is_taken = false;
      co_await OnPool([&] {
        *response = Guarded(request, [&] {
          const Result<void> written = sink.Write({slice.data(), size});
          is_taken = written.ok();
          return is_taken ? api::Response() : api::Problem(written.error(), request);
        });
      });
      if (!is_taken) co_return false;
    }
    co_return true;
  }

  net::awaitable<void> Send(api::Response response, bool is_quick) {
    const bool is_live = response.live != nullptr;
    const bool has_length = response.status != 204 && response.status != 304 && !is_live;
    if (is_live) keep_alive_ = false;  // the end of the connection is the only end it has
    const std::uint64_t length =
        response.source != nullptr ? response.source->length() : response.body.size();
    if (head_.version < 11) keep_alive_ = false;
    const std::string head = ResponseHead(
        response, has_length ? std::optional<std::uint64_t>(length) : std::nullopt, keep_alive_, request_id_);
    const bool has_body = has_length && !is_head_;
    const std::array<net::const_buffer, 2> buffers = {
        net::buffer(head),
        has_body && response.source == nullptr ? net::buffer(response.body) : net::const_buffer()};
    stream_.expires_after(context_.settings.slice_deadline);
    SystemError error;
    co_await net::async_write(stream_, buffers, net::redirect_error(net::use_awaitable, error));
    if (error) failed_ = true;
    if (!failed_ && has_body && response.source != nullptr) co_await SendSource(*response.source);
    if (!failed_ && is_live && !is_head_) co_await SendLive(std::move(response.live));
    const auto route_class = is_quick                            ? api::RouteClass::kTile
                             : is_upload_                        ? api::RouteClass::kUpload
                             : head_.target.starts_with("/api/") ? api::RouteClass::kApi
                                                                 : api::RouteClass::kPage;
    context_.service.metrics.CountRequest(route_class, response.status, Clock::now() - started_,
                                          has_body ? length : 0);
    if (response.status >= 500) LogResponse(request_id_, head_.method, PathOf(head_.target), response.status);
    is_upload_ = false;
  }

  net::awaitable<void> SendSource(api::BodySource& source) {
    std::vector<std::uint8_t> slice(static_cast<std::size_t>(
        std::min<std::uint64_t>(kSendSliceBytes, std::max<std::uint64_t>(1, source.length()))));
    std::uint64_t left = source.length();
    while (left > 0) {
      std::size_t got = 0;
      co_await OnPool([&] {
        const Result<std::size_t> read = source.Read(slice);
        got = read ? *read : 0;
      });
      if (got == 0) failed_ = true;  // less than promised: only the end of the connection can say so
      if (failed_) co_return;
      stream_.expires_after(context_.settings.slice_deadline);
      SystemError error;
      co_await net::async_write(stream_, net::buffer(slice.data(), got),
                                net::redirect_error(net::use_awaitable, error));
      if (error) failed_ = true;
      if (failed_) co_return;
      left -= got;
    }
  }

  // Until the client goes or the server stops.
  net::awaitable<void> SendLive(std::unique_ptr<api::LiveSource> live) {
    net::steady_timer pause(io_);
    while (!failed_ && !context_.service.is_draining) {
      std::string text;
      co_await OnPool([&] {
        Result<std::string> next = live->Next();
        if (next) text = *std::move(next);
        failed_ = !next;
      });
      SystemError error;
      if (!text.empty()) {
        stream_.expires_after(context_.settings.slice_deadline);
        co_await net::async_write(stream_, net::buffer(text), net::redirect_error(net::use_awaitable, error));
        if (error) failed_ = true;
      }
      if (failed_) co_return;
      pause.expires_after(kLivePause);
      co_await pause.async_wait(net::redirect_error(net::use_awaitable, error));
    }
  }

  // Closing with unread bytes would reset the connection under the answer, so these are read and dropped for
  // a while.
  net::awaitable<void> Linger() {
    SystemError error;
    stream_.socket().shutdown(net::ip::tcp::socket::shutdown_send, error);
    stream_.expires_after(kLingerTime);
    std::vector<std::uint8_t> slice(kReceiveSliceBytes);
    std::uint64_t dropped = 0;
    while (!error && dropped < kLingerBytes) {
      dropped += co_await stream_.async_read_some(net::buffer(slice),
                                                  net::redirect_error(net::use_awaitable, error));
    }
  }

  net::io_context& io_;
  beast::tcp_stream stream_;
  SessionContext& context_;
  std::uint64_t key_ = 0;
  beast::flat_buffer buffer_;
  std::unique_ptr<RequestParser> parser_;
  RequestHead head_;
  Refusal refusal_;
  std::string request_id_;
  Clock::time_point started_;
  net::steady_timer head_deadline_;
  int deadline_round_ = 0;
  bool is_late_ = false;
  bool is_idle_ = true;
  bool is_first_ = true;
  bool is_head_ = false;
  bool is_upload_ = false;
  bool keep_alive_ = true;
  bool failed_ = false;  // the connection is of no more use
};

}  // namespace

void StartSession(net::io_context& io, int fd, SessionContext& context) {
  net::ip::tcp::socket socket(io);
  SystemError error;
  socket.assign(net::ip::tcp::v4(), fd, error);
  if (error) {
    LogFailure("-", "accept", error.message());
    return;
  }
  socket.set_option(net::ip::tcp::no_delay(true), error);
  std::make_shared<Session>(io, std::move(socket), context)->Start();
}

}  // namespace skyquilt::server
