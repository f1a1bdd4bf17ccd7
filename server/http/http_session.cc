#include "server/http/http_session.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <cstdint>
#include <ctime>
#include <exception>
#include <iterator>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "api/auth/access.h"
#include "api/http/compress.h"
#include "api/http/http_message.h"
#include "api/http/responses.h"
#include "core/base/check.h"
#include "server/http/connection.h"
#include "server/routing/client_address.h"
#include "server/routing/public_address.h"
#include "server/routing/request_log.h"
#include "server/routing/route_request.h"

namespace skyquilt::server {
namespace {

namespace net = boost::asio;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kReceiveSliceBytes = 128 * 1024;
constexpr std::size_t kSendSliceBytes = 256 * 1024;
constexpr std::chrono::seconds kLiveRest{5};      // between two polls of a live response that nobody wakes
constexpr std::chrono::seconds kComputeWait{30};  // after which who waits for a picture has gone
constexpr int kComputeNiceness = 5;               // as the workers that stitch

std::span<const std::uint8_t> BytesOf(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

// Formatted once a second and thread.
const std::string& DateNow() {
  thread_local std::time_t made_at = 0;
  thread_local std::string date;
  const std::time_t now = std::time(nullptr);
  if (now != made_at) {
    date = fmt::format("{:%a, %d %b %Y %H:%M:%S} GMT", fmt::gmtime(now));
    made_at = now;
  }
  return date;
}

std::string ResponseHead(const api::Response& response, std::optional<std::uint64_t> content_length,
                         bool keep_alive, std::string_view request_id) {
  std::string head;
  head.reserve(512);
  const auto out = std::back_inserter(head);
  fmt::format_to(out, "HTTP/1.1 {} {}\r\nDate: {}\r\nX-Request-Id: {}\r\n", response.status,
                 api::ReasonOf(response.status), DateNow(), request_id);
  for (const auto& [name, value] : response.headers.list()) {
    head += name;
    head += ": ";
    head += value;
    head += "\r\n";
  }
  head += "X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n";
  if (content_length) fmt::format_to(out, "Content-Length: {}\r\n", *content_length);
  head += keep_alive ? "\r\n" : "Connection: close\r\n\r\n";
  return head;
}

class Session : public std::enable_shared_from_this<Session> {
 public:
  Session(std::shared_ptr<Connection> connection, SessionSet::Place place, SessionContext& context,
          bool by_network)
      : connection_(std::move(connection)),
        place_(std::move(place)),
        context_(context),
        by_network_(by_network) {}

  ~Session() {
    context_.sessions.Remove(key_);
    context_.service.metrics.ConnectionClosed();
  }

  void Start(net::io_context& io) {
    context_.service.metrics.ConnectionOpened();
    key_ = context_.sessions.Add([weak = std::weak_ptr(connection_), &io] {
      net::post(io, [weak] {
        if (const std::shared_ptr<Connection> connection = weak.lock()) connection->CloseIfIdle();
      });
    });
    net::co_spawn(
        io, [self = shared_from_this()]() -> Awaitable<void> { return self->Serve(); },
        [](const std::exception_ptr& failure) { LogUncaught(failure); });
  }

 private:
  Awaitable<void> Serve() {
    // A copy here keeps the session alive for as long as its coroutine runs.
    const std::shared_ptr<Session> self = shared_from_this();
    bool goes_on = true;
    while (goes_on) {
      is_head_ = false;
      cors_ = {};
      base_path_.clear();
      work_.reset();
      const Connection::Head got = co_await connection_->ReadHead();
      if (got == Connection::Head::kClosed) co_return;
      started_ = Clock::now();
      request_id_ = NextRequestId();
      keep_alive_ = got == Connection::Head::kRead && !context_.service.is_draining;
      if (got == Connection::Head::kRead) {
        co_await Answer();
      } else {
        const Refusal& refusal = connection_->refusal();
        api::Response response = api::ProblemWithStatus(refusal.status, refusal.reason, "", request_id_);
        co_await Send(std::move(response), false);
      }
      goes_on = keep_alive_ && !connection_->has_failed();
    }
    if (!connection_->has_failed()) co_await connection_->EndGently();
  }

  Awaitable<void> Answer() {
    RequestHead& head = connection_->head();
    keep_alive_ = keep_alive_ && connection_->KeepsAlive();
    is_head_ = head.method == "HEAD";
    const bool has_body = head.is_chunked || head.content_length.value_or(0) > 0;
    Routed routed = RouteRequest(head, context_.router, context_.settings, context_.service, request_id_,
                                 connection_->peer(), by_network_);
    base_path_ = routed.request.base_path;
    routed.request.client = ClientAddress(connection_->peer(), routed.request.headers, context_.settings);
    cors_ = std::move(routed.cors);
    if (routed.route != nullptr && routed.route->upload) {
      co_await Receive(*routed.route, std::move(routed.request), has_body);
      co_return;
    }
    // An unexpected body is not read: the response is sent and the connection closed.
    if (has_body) keep_alive_ = false;
    api::Response response = std::move(routed.response);
    if (routed.route != nullptr) response = co_await CarryOut(*routed.route, routed.request);
    co_await Send(std::move(response), routed.route != nullptr && routed.route->work == api::Work::kQuick);
  }

  // First where the route begins, then wherever its answer asks to be made.
  Awaitable<api::Response> CarryOut(const api::Route& route, api::Request& request) {
    bool is_checked = false;
    const auto call = [&] {
      const Clock::time_point begun = Clock::now();
      api::Response made = Guarded(request, [&] {
        if (!is_checked) {
          if (auto refused = Refused(request, route)) return *std::move(refused);
          is_checked = true;
        }
        api::Response answer = route.handler(request);
        api::KeepToAsker(context_.service, request, answer);
        if (request.work != api::Work::kQuick) {
          if (auto packed = api::CompressAnswer(request, answer); !packed)
            return api::Problem(packed.error(), request);
        }
        return answer;
      });
      work_ = work_.value_or(Clock::duration::zero()) + (Clock::now() - begun);
      return made;
    };
    api::Response response;
    response.wants = route.work;
    while (response.wants) {
      request.work = *response.wants;
      if (request.work == api::Work::kQuick) {
        response = call();
        continue;
      }
      RequestPool& pool = context_.pools.Of(request.work);
      const RequestPool::Answer taken =
          co_await connection_->RunOnPool(pool, request.client, [&] { response = call(); });
      if (taken != RequestPool::Answer::kTaken) co_return TooMany(taken, pool, request);
      SKYQUILT_CHECK(!response.wants || *response.wants > request.work, "work that comes back for the same");
    }
    co_return response;
  }

  static api::Response TooMany(RequestPool::Answer why, const RequestPool& pool,
                               const api::Request& request) {
    const std::string message =
        why == RequestPool::Answer::kClientFull
            ? fmt::format(
                  "{} requests from your address are being worked on already. Wait for their answers.",
                  pool.settings().max_of_client)
            : "The server has more such requests than it can work on. Try again in a moment.";
    return api::Problem({ErrorCode::kRateLimited, message}, request);
  }

  // Whoever may not, and whatever would change what can no longer be stored.
  std::optional<api::Response> Refused(api::Request& request, const api::Route& route) {
    if (auto refused = api::CheckAccess(context_.service, request, route)) return refused;
    return RefusedUnlessStored(request);
  }

  std::optional<api::Response> RefusedUnlessStored(const api::Request& request) {
    if (request.method == api::Method::kGet || request.method == api::Method::kOptions) return std::nullopt;
    const Result<void> in_place = context_.service.storage_in_place();
    if (in_place) return std::nullopt;
    return api::Problem(in_place.error(), request);
  }

  // What a handler throws (the machine is out of something) becomes a 500 of this one request.
  template <typename Call>
  static api::Response Guarded(const api::Request& request, Call call) {
    try {
      return call();
    } catch (const std::exception& failure) {
      LogFailure(request.request_id, request.path, failure.what());
      return api::Problem({ErrorCode::kInternal, "The server failed at this request. Its log says more."},
                          request);
    }
  }

  // An upload: begun, fed slice by slice, finished.
  Awaitable<void> Receive(const api::Route& route, api::Request request, bool has_body) {
    std::unique_ptr<api::BodySink> sink;
    api::Response response;
    is_upload_ = true;
    request.work = api::Work::kWrite;
    RequestPool& pool = context_.pools.Of(request.work);
    const RequestPool::Answer taken = co_await connection_->RunOnPool(pool, request.client, [&] {
      response = Guarded(request, [&] {
        if (auto refused = Refused(request, route)) return *std::move(refused);
        auto begun = route.upload(request);
        if (auto* refused = std::get_if<api::Response>(&begun)) return std::move(*refused);
        sink = std::move(std::get<std::unique_ptr<api::BodySink>>(begun));
        return api::Response();
      });
    });
    if (taken != RequestPool::Answer::kTaken) response = TooMany(taken, pool, request);
    if (sink == nullptr) {
      if (has_body) keep_alive_ = false;
      co_await Send(std::move(response), false);
      co_return;
    }
    const bool arrived = !has_body || co_await ReceiveBody(*sink, request, &response);
    const auto finish = [&] {
      response = Guarded(request, [&] {
        auto refused = RefusedUnlessStored(request);  // the folder may have gone while the body came
        return refused ? *std::move(refused) : sink->Finish();
      });
    };
    const bool is_computed = arrived && route.work == api::Work::kCompute;
    if (is_computed) {
      RequestPool& compute = context_.pools.compute;
      const RequestPool::Answer computed = co_await connection_->RunOnPool(compute, request.client, finish);
      if (computed != RequestPool::Answer::kTaken) response = TooMany(computed, compute, request);
    }
    co_await connection_->OnPool(pool, [&] {
      if (arrived && !is_computed) finish();
      sink.reset();  // an upload that broke is undone here, before anyone hears of it
    });
    if (connection_->has_failed()) co_return;
    if (!arrived) keep_alive_ = false;
    co_await Send(std::move(response), false);
  }

  // False: the body did not arrive whole or was refused; *response says why, unless the connection failed.
  Awaitable<bool> ReceiveBody(api::BodySink& sink, const api::Request& request, api::Response* response) {
    if (connection_->head().wants_continue) {
      co_await connection_->Write("HTTP/1.1 100 Continue\r\n\r\n", {});
      if (connection_->has_failed()) co_return false;
    }
    std::vector<std::uint8_t> room(kReceiveSliceBytes);
    while (!connection_->IsBodyRead()) {
      const BodySlice slice = co_await connection_->ReadBody(room);
      if (slice.fault == BodySlice::Fault::kTooLarge) {
        *response =
            api::Problem({ErrorCode::kTooLarge, "The body is larger than the server takes."}, request);
      } else if (slice.fault == BodySlice::Fault::kNotHttp) {
        *response = api::ProblemWithStatus(400, "The body is not HTTP: " + slice.reason + ".", request.path,
                                           request_id_);
      } else if (slice.fault == BodySlice::Fault::kTooSlow) {
        *response = api::ProblemWithStatus(
            408,
            fmt::format("The body came too slowly: {}. Send it again; what is sent in parts (tus, at "
                        "/api/v1/uploads, as \"skyquilt upload\" and the page do) goes on where it was.",
                        slice.reason),
            request.path, request_id_);
      }
      if (slice.fault != BodySlice::Fault::kNone) co_return false;
      if (slice.size == 0) continue;
      context_.service.metrics.CountBytesIn(slice.size);
      bool is_taken = false;
      co_await connection_->OnPool(context_.pools.write, [&] {
        *response = Guarded(request, [&] {
          const Result<void> written = sink.Write({room.data(), slice.size});
          is_taken = written.ok();
          return is_taken ? api::Response() : api::Problem(written.error(), request);
        });
      });
      if (!is_taken) co_return false;
    }
    co_return true;
  }

  // For whoever asks where the time goes: that of the handler, and of all from the request's head on, which
  // waiting for a thread is a part of (https://www.w3.org/TR/server-timing/).
  void AddTiming(api::Headers& headers) const {
    if (!work_) return;
    const auto milliseconds = [](Clock::duration time) {
      return std::chrono::duration<double, std::milli>(time).count();
    };
    headers.Add("Server-Timing", fmt::format("work;dur={:.2f}, total;dur={:.2f}", milliseconds(*work_),
                                             milliseconds(Clock::now() - started_)));
  }

  Awaitable<void> Send(api::Response response, bool is_quick) {
    const RequestHead& request_head = connection_->head();
    for (const auto& [name, value] : cors_.list()) {
      if (name == "Vary") {
        response.headers.AddVary(value);
      } else {
        response.headers.Add(name, value);
      }
    }
    PutBasePath(response.headers, base_path_);
    AddTiming(response.headers);
    const bool is_live = response.live != nullptr;
    const bool has_length = response.status != 204 && response.status != 304 && !is_live;
    if (is_live) keep_alive_ = false;  // the end of the connection is the only end it has
    const std::uint64_t length =
        response.source != nullptr ? response.source->length() : response.body.size();
    if (request_head.version < 11) keep_alive_ = false;
    const std::string head = ResponseHead(
        response, has_length ? std::optional<std::uint64_t>(length) : std::nullopt, keep_alive_, request_id_);
    const bool has_body = has_length && !is_head_;
    co_await connection_->Write(
        head, has_body && response.source == nullptr ? BytesOf(response.body) : BytesOf({}));
    if (!connection_->has_failed() && has_body && response.source != nullptr)
      co_await SendSource(*response.source);
    if (!connection_->has_failed() && is_live && !is_head_) co_await SendLive(std::move(response.live));
    const auto route_class = is_quick                                   ? api::RouteClass::kTile
                             : is_upload_                               ? api::RouteClass::kUpload
                             : request_head.target.starts_with("/api/") ? api::RouteClass::kApi
                                                                        : api::RouteClass::kPage;
    context_.service.metrics.CountRequest(route_class, response.status, Clock::now() - started_,
                                          has_body ? length : 0);
    if (response.status >= 500)
      LogResponse(request_id_, request_head.method, PathOf(request_head.target), response.status,
                  response.for_log);
    is_upload_ = false;
  }

  Awaitable<void> SendSource(api::BodySource& source) {
    std::vector<std::uint8_t> slice(static_cast<std::size_t>(
        std::min<std::uint64_t>(kSendSliceBytes, std::max<std::uint64_t>(1, source.length()))));
    std::uint64_t left = source.length();
    while (left > 0 && !connection_->has_failed()) {
      std::size_t got = 0;
      co_await connection_->OnPool(context_.pools.read, [&] {
        const Result<std::size_t> read = source.Read(slice);
        got = read ? *read : 0;
        if (!read) LogFailure(request_id_, PathOf(connection_->head().target), read.error());
      });
      if (got == 0) connection_->GiveUp();  // less than promised: only the end of the connection can say so
      if (got > 0) co_await connection_->Write({}, std::span(slice).first(got));
      left -= got;
    }
  }

  // Until the client goes or the server stops.
  Awaitable<void> SendLive(std::unique_ptr<api::LiveSource> live) {
    connection_->WatchForEnd();
    live->OnNews(connection_->Waker());
    while (!connection_->has_failed() && !context_.service.is_draining) {
      std::string text;
      const auto look = [&] {
        Result<std::string> next = live->Next();
        if (!next) return connection_->GiveUp();
        text = *std::move(next);
      };
      const bool was_behind = live->WaitsForDisk();
      if (was_behind) {
        co_await connection_->OnPool(context_.pools.read, look);
      } else {
        look();
      }
      if (!text.empty()) co_await connection_->Write(text, {});
      if (!was_behind && !connection_->has_failed()) co_await connection_->Rest(kLiveRest);
    }
  }

  std::shared_ptr<Connection> connection_;
  SessionSet::Place place_;
  SessionContext& context_;
  const bool by_network_;
  std::uint64_t key_ = 0;
  std::string request_id_;
  api::Headers cors_;
  std::string base_path_;  // of the request that is answered
  Clock::time_point started_;
  std::optional<Clock::duration> work_;  // of the handler; absent: none was asked
  bool is_head_ = false;
  bool is_upload_ = false;
  bool keep_alive_ = true;
};

}  // namespace

RequestPools::RequestPools(const HttpSettings& settings)
    : read({"read", settings.read_threads, settings.max_waiting, settings.max_of_client}),
      write({"write", settings.write_threads, settings.max_waiting, settings.max_of_client}),
      compute({"compute", settings.compute_threads, settings.max_waiting, settings.max_of_client,
               kComputeWait, kComputeNiceness}) {}

RequestPool& RequestPools::Of(api::Work work) {
  SKYQUILT_CHECK(work != api::Work::kQuick, "quick work has no pool");
  return work == api::Work::kRead ? read : work == api::Work::kWrite ? write : compute;
}

void StartSession(net::io_context& io, int fd, std::string peer, SessionSet::Place place,
                  SessionContext& context, bool by_network) {
  std::shared_ptr<Connection> connection = TakeConnection(io, fd, std::move(peer), context.settings);
  if (connection != nullptr) {
    std::make_shared<Session>(std::move(connection), std::move(place), context, by_network)->Start(io);
  }
}

}  // namespace skyquilt::server
