#include "server/webhooks/post_message.h"

#include <utility>
// <utility> first: Boost 1.74's awaitable uses std::exchange without including it.
#include <fmt/format.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/host_name_verification.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <exception>
#include <optional>

#include "core/base/try.h"

namespace skyquilt::server {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using Tcp = net::ip::tcp;

constexpr std::chrono::seconds kPatience{10};
constexpr std::uint64_t kMaxAnswerBytes = 64 * 1024;

struct Place {
  bool is_tls = false;
  std::string host;  // without brackets
  std::string port;
  std::string target;
};

Result<Place> PlaceOf(const std::string& url) {
  Place place;
  place.is_tls = url.starts_with("https://");
  const std::size_t begin = url.find("://") + 3;
  const std::size_t slash = url.find_first_of("/?", begin);
  std::string authority = url.substr(begin, slash == std::string::npos ? slash : slash - begin);
  place.target = slash == std::string::npos ? "/" : url.substr(slash);
  if (place.target.front() == '?') place.target.insert(0, "/");
  const std::size_t bracket = authority.rfind(']');
  const std::size_t colon = authority.find(':', bracket == std::string::npos ? 0 : bracket);
  place.port = colon == std::string::npos ? (place.is_tls ? "443" : "80") : authority.substr(colon + 1);
  place.host = authority.substr(0, colon);
  if (place.host.starts_with('[') && place.host.ends_with(']'))
    place.host = place.host.substr(1, place.host.size() - 2);
  if (place.host.empty()) return Error{ErrorCode::kInvalidArgument, "The address has no host.", url};
  return place;
}

bool IsPublic(const net::ip::address_v4& address) {
  const std::uint32_t bits = address.to_uint();
  const auto within = [&](std::uint32_t network, int prefix) {
    return (bits ^ network) >> (32 - prefix) == 0;
  };
  constexpr std::pair<std::uint32_t, int> kNotPublic[] = {
      {0x00000000, 8},  {0x0a000000, 8},  {0x64400000, 10}, {0x7f000000, 8},  {0xa9fe0000, 16},
      {0xac100000, 12}, {0xc0000000, 24}, {0xc0000200, 24}, {0xc0a80000, 16}, {0xc6120000, 15},
      {0xc6336400, 24}, {0xcb007100, 24}, {0xe0000000, 3}};
  for (const auto& [network, prefix] : kNotPublic) {
    if (within(network, prefix)) return false;
  }
  return true;
}

// Only what is allotted to the public at large; everything else, and what carries an IPv4 address inside, is
// not.
bool IsPublic(const net::ip::address_v6& address) {
  const auto bytes = address.to_bytes();
  if ((bytes[0] & 0xe0) != 0x20) return false;             // 2000::/3
  if (bytes[0] == 0x20 && bytes[1] == 0x02) return false;  // 6to4
  if (bytes[0] != 0x20 || bytes[1] != 0x01) return true;
  const bool is_for_documents = bytes[2] == 0x0d && bytes[3] == 0xb8;
  return bytes[2] >= 0x02 && !is_for_documents;  // below: Teredo and other protocols
}

bool IsPublic(const net::ip::address& address) {
  return address.is_v4() ? IsPublic(address.to_v4()) : IsPublic(address.to_v6());
}

http::request<http::string_body> RequestFor(const OutgoingMessage& message, const Place& place) {
  http::request<http::string_body> request(http::verb::post, place.target, 11);
  request.set(http::field::host, place.host);
  request.set(http::field::connection, "close");
  for (const auto& [name, value] : message.headers) request.set(name, value);
  request.body() = message.body;
  request.prepare_payload();
  return request;
}

template <typename Stream>
net::awaitable<int> Exchange(Stream& stream, http::request<http::string_body> request) {
  co_await http::async_write(stream, request, net::use_awaitable);
  beast::flat_buffer buffer;
  http::response_parser<http::string_body> answer;
  answer.body_limit(kMaxAnswerBytes);
  co_await http::async_read_header(stream, buffer, answer, net::use_awaitable);
  co_return answer.get().result_int();
}

net::awaitable<int> Send(net::io_context& io, const OutgoingMessage& message, const Place& place) {
  Tcp::resolver resolver(io);
  const auto found = co_await resolver.async_resolve(place.host, place.port, net::use_awaitable);
  for (const auto& entry : found) {
    if (!message.may_go_private && !IsPublic(entry.endpoint().address())) {
      throw std::invalid_argument(entry.endpoint().address().to_string());
    }
  }
  const Tcp::endpoint endpoint = found.begin()->endpoint();
  if (!place.is_tls) {
    beast::tcp_stream stream(io);
    stream.expires_after(kPatience);
    co_await stream.async_connect(endpoint, net::use_awaitable);
    co_return co_await Exchange(stream, RequestFor(message, place));
  }
  net::ssl::context tls(net::ssl::context::tls_client);
  tls.set_default_verify_paths();
  tls.set_verify_mode(net::ssl::verify_peer);
  beast::ssl_stream<beast::tcp_stream> stream(io, tls);
  stream.set_verify_callback(net::ssl::host_name_verification(place.host));
  SSL_set_tlsext_host_name(stream.native_handle(), place.host.c_str());
  beast::get_lowest_layer(stream).expires_after(kPatience);
  co_await beast::get_lowest_layer(stream).async_connect(endpoint, net::use_awaitable);
  co_await stream.async_handshake(net::ssl::stream_base::client, net::use_awaitable);
  co_return co_await Exchange(stream, RequestFor(message, place));
}

}  // namespace

bool IsPublicAddress(const std::string& address) {
  boost::system::error_code error;
  const net::ip::address parsed = net::ip::make_address(address, error);
  return !error && IsPublic(parsed);
}

Result<void> PostMessage(const OutgoingMessage& message) {
  SKYQUILT_TRY_ASSIGN(const Place place, PlaceOf(message.url));
  net::io_context io;
  std::optional<int> status;
  std::exception_ptr failure;
  net::co_spawn(io, Send(io, message, place), [&](std::exception_ptr thrown, int answered) {
    failure = thrown;
    if (!thrown) status = answered;
  });
  io.run_for(kPatience + std::chrono::seconds(2));
  if (failure) {
    try {
      std::rethrow_exception(failure);
    } catch (const std::invalid_argument& refused) {
      return Error{ErrorCode::kForbidden, fmt::format("{} leads to a private address.", place.host),
                   refused.what()};
    } catch (const std::exception& broken) {
      return Error{ErrorCode::kUnavailable, fmt::format("{} did not answer.", place.host), broken.what()};
    }
  }
  if (!status)
    return Error{ErrorCode::kUnavailable, fmt::format("{} did not answer in time.", place.host), ""};
  if (*status < 200 || *status > 299) {
    return Error{ErrorCode::kUnavailable, fmt::format("{} answered {}.", place.host, *status), ""};
  }
  return {};
}

}  // namespace skyquilt::server
