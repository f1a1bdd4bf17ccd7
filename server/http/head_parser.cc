#include "server/http/head_parser.h"

#include <boost/beast/http/buffer_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <cstdint>
#include <string>
#include <utility>

namespace skyquilt::server {
namespace {

namespace http = boost::beast::http;

constexpr std::string_view kEndOfHead = "\r\n\r\n";
constexpr const char* kTooLong = "The request head is longer than the server reads.";

}  // namespace

HeadParser::HeadParser(const HttpSettings& settings) : settings_(settings) {}
HeadParser::~HeadParser() = default;

std::unique_ptr<RequestParser> HeadParser::TakeParser() { return std::move(parser_); }

HeadState HeadParser::Examine(std::string_view bytes) {
  const std::size_t end = bytes.find(kEndOfHead, searched_);
  if (end != std::string_view::npos) return Parse(bytes.substr(0, end + kEndOfHead.size()));
  if (const auto refusal = CheckRawHead(bytes)) return Refuse(*refusal);
  if (bytes.size() >= settings_.max_header_bytes) return Refuse({431, kTooLong});
  searched_ = bytes.size() < kEndOfHead.size() ? 0 : bytes.size() - kEndOfHead.size() + 1;
  return HeadState::kNeedsMore;
}

HeadState HeadParser::Parse(std::string_view head_with_end) {
  const std::string_view raw = head_with_end.substr(0, head_with_end.size() - kEndOfHead.size());
  if (raw.size() > settings_.max_header_bytes) return Refuse({431, kTooLong});
  if (const auto refusal = CheckRawHead(raw)) return Refuse(*refusal);
  parser_ = std::make_unique<RequestParser>();
  parser_->header_limit(static_cast<std::uint32_t>(settings_.max_header_bytes + kEndOfHead.size()));
  parser_->body_limit(settings_.max_body_bytes);
  boost::system::error_code error;
  size_ = parser_->put(boost::asio::buffer(head_with_end.data(), head_with_end.size()), error);
  if (error == http::error::body_limit) return Refuse({413, "The body is larger than the server takes."});
  if (error == http::error::bad_version) return Refuse({505, "Only HTTP/1.0 and HTTP/1.1 are spoken here."});
  if (error) return Refuse({400, "The request head is not HTTP: " + error.message() + "."});
  const auto& message = parser_->get();
  head_.method = std::string(message.method_string());
  head_.target = std::string(message.target());
  head_.version = static_cast<int>(message.version());
  for (const auto& field : message) {
    head_.headers.Add(std::string(field.name_string()), std::string(field.value()));
  }
  if (const auto refusal = CheckFields(head_)) return Refuse(*refusal);
  return HeadState::kWhole;
}

HeadState HeadParser::Refuse(Refusal refusal) {
  refusal_ = std::move(refusal);
  return HeadState::kRefused;
}

}  // namespace skyquilt::server
