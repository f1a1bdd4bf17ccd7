#include "api/forms/multipart.h"

#include <fmt/format.h>

#include <algorithm>

#include "api/http/http_message.h"
#include "core/base/text/percent.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

// "form-data; name=\"a\"; filename=\"b\"": the value in lower case and its parameters (names in lower case).
struct HeaderValue {
  std::string value;
  std::vector<std::pair<std::string, std::string>> parameters;
};

Error Refuse(std::string_view why, ErrorCode code = ErrorCode::kInvalidArgument) {
  return {code, fmt::format("The form cannot be read: {}.", why)};
}

std::string PercentDecoded(std::string_view text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const int byte = PercentByte(text.substr(i));
    decoded.push_back(byte < 0 ? text[i] : static_cast<char>(byte));
    if (byte >= 0) i += 2;
  }
  return decoded;
}

// Browsers write a quote in a name as %22 and leave every other per cent sign alone.
std::string WithQuotes(std::string text) {
  for (std::size_t at = text.find("%22"); at != std::string::npos; at = text.find("%22", at + 1)) {
    text.replace(at, 3, "\"");
  }
  return text;
}

// A quoted string at the front of `text`, which is moved past it. Backslash escapes quotes and itself only:
// some clients send a bare backslash in a Windows path.
Result<std::string> TakeQuoted(std::string_view& text) {
  std::string value;
  for (std::size_t i = 1; i < text.size(); ++i) {
    if (text[i] == '"') {
      text.remove_prefix(i + 1);
      return value;
    }
    if (text[i] == '\\' && i + 1 < text.size() && (text[i + 1] == '"' || text[i + 1] == '\\')) ++i;
    value.push_back(text[i]);
  }
  return Refuse("a quoted string does not end");
}

const std::string* FindParameter(const HeaderValue& header, std::string_view name) {
  for (const auto& [known, value] : header.parameters) {
    if (known == name) return &value;
  }
  return nullptr;
}

Result<HeaderValue> ParseHeaderValue(std::string_view text) {
  HeaderValue header;
  const std::size_t end = text.find(';');
  header.value = LowerCase(Trim(text.substr(0, end)));
  text = end == std::string_view::npos ? std::string_view() : text.substr(end);
  while (!text.empty()) {
    if (text.front() != ';') return Refuse("a header has text where a semicolon belongs");
    text = Trim(text.substr(1));
    if (text.empty()) break;
    const std::size_t equals = text.find('=');
    if (equals == std::string_view::npos || equals == 0) return Refuse("a header parameter has no value");
    std::string name = LowerCase(Trim(text.substr(0, equals)));
    text = Trim(text.substr(equals + 1));
    std::string value;
    if (text.starts_with('"')) {
      SKYQUILT_TRY_ASSIGN(std::string quoted, TakeQuoted(text));
      value = std::move(quoted);
      text = Trim(text);
    } else {
      const std::size_t stop = std::min(text.find(';'), text.size());
      value = Trim(text.substr(0, stop));
      text.remove_prefix(stop);
    }
    if (FindParameter(header, name) != nullptr) return Refuse("a header parameter comes twice");
    header.parameters.emplace_back(std::move(name), std::move(value));
  }
  return header;
}

Result<PartHeader> FromDisposition(std::string_view text) {
  SKYQUILT_TRY_ASSIGN(const HeaderValue parsed, ParseHeaderValue(text));
  if (parsed.value != "form-data") return Refuse("a part is not form-data");
  const std::string* name = FindParameter(parsed, "name");
  if (name == nullptr) return Refuse("a part has no name");
  PartHeader header;
  header.field = WithQuotes(*name);
  // The extended one first: the other is what clients that know both write for those that know one.
  const std::string* const file_name = FindParameter(parsed, "filename");
  const std::string* const extended = FindParameter(parsed, "filename*");
  const bool is_utf8 = extended != nullptr && LowerCase(*extended).starts_with("utf-8'");
  if (file_name != nullptr && !is_utf8) {
    header.file_name = WithQuotes(*file_name);
  } else if (extended != nullptr) {
    if (!is_utf8) return Refuse("a file name is not in UTF-8");
    const std::size_t quote = extended->find('\'', 6);
    if (quote == std::string::npos) return Refuse("an extended file name is broken");
    header.file_name = PercentDecoded(std::string_view(*extended).substr(quote + 1));
  }
  return header;
}

constexpr std::size_t kMaxPadding = 64;  // blanks that may stand between a delimiter and its line end

}  // namespace

Result<PartHeader> ParsePartHeader(std::string_view block) {
  std::optional<PartHeader> header;
  while (!block.empty()) {
    const std::size_t end = block.find("\r\n");
    const std::string_view line = block.substr(0, end);
    block = end == std::string_view::npos ? std::string_view() : block.substr(end + 2);
    const bool has_control = std::any_of(line.begin(), line.end(), [](char c) {
      return (static_cast<unsigned char>(c) < 0x20 && c != '\t') || c == 0x7f;
    });
    if (has_control) return Refuse("a part header has a control character");
    if (line.starts_with(' ') || line.starts_with('\t')) return Refuse("a part header is folded");
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos || colon == 0) return Refuse("a part header has no colon");
    const std::string name = LowerCase(line.substr(0, colon));
    const std::string_view value = Trim(line.substr(colon + 1));
    if (name == "content-disposition") {
      if (header) return Refuse("a part has two dispositions");
      SKYQUILT_TRY_ASSIGN(PartHeader parsed, FromDisposition(value));
      header = std::move(parsed);
    } else if (name == "content-transfer-encoding" && LowerCase(value) != "binary" &&
               LowerCase(value) != "8bit" && LowerCase(value) != "7bit") {
      return Refuse("a part is transfer-encoded; send plain bytes");
    }
  }
  if (!header) return Refuse("a part has no Content-Disposition");
  return *std::move(header);
}

Result<std::string> MultipartBoundary(std::string_view content_type) {
  SKYQUILT_TRY_ASSIGN(const HeaderValue parsed, ParseHeaderValue(content_type));
  if (parsed.value != "multipart/form-data") {
    return Error{
        ErrorCode::kUnsupportedFormat,
        "Send files as multipart/form-data (curl -F \"photo=@PHOTO.JPG\") or one at a time by PUT (curl -T "
        "PHOTO.JPG .../files/), and JSON with its header (-H 'Content-Type: application/json')."};
  }
  for (const auto& [name, boundary] : parsed.parameters) {
    if (name != "boundary") continue;
    const bool is_good =
        !boundary.empty() && boundary.size() <= 70 && boundary.back() != ' ' &&
        std::all_of(boundary.begin(), boundary.end(), [](char c) {
          return IsLetterOrDigit(c) || std::string_view("'()+_,-./:=? ").find(c) != std::string_view::npos;
        });
    if (!is_good) return Refuse("its boundary is not 1 to 70 permitted characters");
    return boundary;
  }
  return Refuse("its Content-Type names no boundary");
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
  if (state_ != State::kEpilogue) return Refuse("it is cut off before its end");
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
  std::size_t at = buffer_.find(delimiter_), end = 0;
  Delimiter kind = Delimiter::kNone;
  // What only looks like one is content, and goes on with what follows: a body may be made of nothing else.
  for (; at != std::string::npos; at = buffer_.find(delimiter_, at + 2)) {
    kind = Classify(at, &end);
    if (kind != Delimiter::kNone) break;
  }
  if (at == std::string::npos) {
    // All but what could be the start of a delimiter is surely content.
    const std::size_t keep = delimiter_.size() - 1;
    if (buffer_.size() > keep) {
      SKYQUILT_TRY(Emit(buffer_.size() - keep));
    }
    return false;
  }
  SKYQUILT_TRY(Emit(at));
  if (kind == Delimiter::kUndecided) return false;
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
    return Refuse("a part header is longer than 8 KiB", ErrorCode::kTooLarge);
  }
  if (end == std::string::npos) return false;
  if (++parts_ > kMaxParts) return Refuse("it has more than 20,000 parts", ErrorCode::kTooLarge);
  const std::string_view block = end == 0 ? std::string_view() : std::string_view(buffer_).substr(2, end - 2);
  SKYQUILT_TRY_ASSIGN(const PartHeader header, ParsePartHeader(block));
  SKYQUILT_TRY(receiver_.BeginPart(header));
  buffer_.erase(0, end + 4);
  state_ = State::kBody;
  return true;
}

}  // namespace skyquilt::api
