#include "api/forms/multipart.h"

#include <fmt/format.h>

#include <algorithm>

#include "api/forms/part_header.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

constexpr std::size_t kMaxPadding = 64;  // blanks that may stand between a delimiter and its line end

Error Refuse(ErrorCode code, std::string_view why) {
  return {code, fmt::format("The form cannot be read: {}.", why), ""};
}

}  // namespace

Result<std::string> MultipartBoundary(std::string_view content_type) {
  SKYQUILT_TRY_ASSIGN(const HeaderValue parsed, ParseHeaderValue(content_type));
  if (parsed.value != "multipart/form-data") {
    return Error{
        ErrorCode::kUnsupportedFormat,
        "Send files as multipart/form-data (curl -F \"photo=@PHOTO.JPG\") or one at a time by PUT (curl -T "
        "PHOTO.JPG .../files/), and JSON with its header (-H 'Content-Type: application/json').",
        ""};
  }
  for (const auto& [name, boundary] : parsed.parameters) {
    if (name != "boundary") continue;
    const bool is_good = !boundary.empty() && boundary.size() <= 70 && boundary.back() != ' ' &&
                         std::all_of(boundary.begin(), boundary.end(), [](char c) {
                           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                                  (c >= '0' && c <= '9') ||
                                  std::string_view("'()+_,-./:=? ").find(c) != std::string_view::npos;
                         });
    if (!is_good)
      return Refuse(ErrorCode::kInvalidArgument, "its boundary is not 1 to 70 permitted characters");
    return boundary;
  }
  return Refuse(ErrorCode::kInvalidArgument, "its Content-Type names no boundary");
}

// The buffer begins with a line end of ours, so that a delimiter at the very start looks like any other.
MultipartParser::MultipartParser(std::string_view boundary, PartReceiver& receiver)
    : delimiter_("\r\n--" + std::string(boundary)), receiver_(receiver), buffer_("\r\n") {}

Result<void> MultipartParser::Push(std::span<const std::uint8_t> bytes) {
  if (state_ == State::kEpilogue) return {};
  buffer_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  while (state_ != State::kEpilogue) {
    SKYQUILT_TRY_ASSIGN(const bool more, Step());
    if (!more) break;
  }
  if (state_ == State::kEpilogue) buffer_.clear();
  return {};
}

Result<void> MultipartParser::Finish() {
  if (state_ != State::kEpilogue) return Refuse(ErrorCode::kInvalidArgument, "it is cut off before its end");
  return {};
}

Result<bool> MultipartParser::Step() { return state_ == State::kHeader ? StepHeader() : StepBody(); }

MultipartParser::Delimiter MultipartParser::Classify(std::size_t at, std::size_t* end) const {
  const std::string_view tail = std::string_view(buffer_).substr(at + delimiter_.size());
  if (tail.size() < 2) {
    // One byte more decides, unless this one already does.
    return tail.empty() || std::string_view("-\r \t").find(tail[0]) != std::string_view::npos
               ? Delimiter::kUndecided
               : Delimiter::kNone;
  }
  if (tail.starts_with("--")) return Delimiter::kEnd;
  const std::size_t padding = std::min(tail.find_first_not_of(" \t"), tail.size());
  if (padding > kMaxPadding) return Delimiter::kNone;
  const std::string_view line_end = tail.substr(padding, 2);
  if (line_end == "\r\n") {
    *end = at + delimiter_.size() + padding;  // the line end itself stays: the header begins with it
    return Delimiter::kPart;
  }
  return line_end.empty() || line_end == "\r" ? Delimiter::kUndecided : Delimiter::kNone;
}

// Hands the first `count` bytes on (or drops them before the first part).
Result<void> MultipartParser::Emit(std::size_t count) {
  if (count > 0 && state_ == State::kBody) {
    SKYQUILT_TRY(receiver_.PartBytes({reinterpret_cast<const std::uint8_t*>(buffer_.data()), count}));
  }
  buffer_.erase(0, count);
  return {};
}

Result<bool> MultipartParser::StepBody() {
  const std::size_t at = buffer_.find(delimiter_);
  if (at == std::string::npos) {
    // All but what could be the start of a delimiter is surely content.
    const std::size_t keep = delimiter_.size() - 1;
    if (buffer_.size() > keep) {
      SKYQUILT_TRY(Emit(buffer_.size() - keep));
    }
    return false;
  }
  std::size_t end = 0;
  const Delimiter kind = Classify(at, &end);
  SKYQUILT_TRY(Emit(kind == Delimiter::kNone ? at + 2 : at));
  if (kind == Delimiter::kUndecided) return false;
  if (kind == Delimiter::kNone) return true;
  if (state_ == State::kBody) {
    SKYQUILT_TRY(receiver_.EndPart());
  }
  if (kind == Delimiter::kEnd) {
    state_ = State::kEpilogue;
    return true;
  }
  buffer_.erase(0, end - at);
  state_ = State::kHeader;
  return true;
}

Result<bool> MultipartParser::StepHeader() {
  const std::size_t end = buffer_.find("\r\n\r\n");
  if (std::min(end, buffer_.size()) > kMaxPartHeaderBytes) {
    return Refuse(ErrorCode::kTooLarge, "a part header is longer than 8 KiB");
  }
  if (end == std::string::npos) return false;
  if (++parts_ > kMaxParts) return Refuse(ErrorCode::kTooLarge, "it has more than 20,000 parts");
  const std::string_view block = end == 0 ? std::string_view() : std::string_view(buffer_).substr(2, end - 2);
  SKYQUILT_TRY_ASSIGN(const PartHeader header, ParsePartHeader(block));
  SKYQUILT_TRY(receiver_.BeginPart(header));
  buffer_.erase(0, end + 4);
  state_ = State::kBody;
  return true;
}

}  // namespace skyquilt::api
