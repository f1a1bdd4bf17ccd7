#include "api/forms/part_header.h"

#include <fmt/format.h>

#include <algorithm>

#include "api/http/header_text.h"
#include "api/http/http_message.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

Error Refuse(std::string_view why) {
  return {ErrorCode::kInvalidArgument, fmt::format("The form cannot be read: {}.", why), ""};
}

std::string Lower(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  return lower;
}

std::string PercentDecoded(std::string_view text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const int high = text[i] == '%' && i + 2 < text.size() ? HexDigit(text[i + 1]) : -1;
    const int low = high >= 0 ? HexDigit(text[i + 2]) : -1;
    if (low >= 0) {
      decoded.push_back(static_cast<char>(high * 16 + low));
      i += 2;
    } else {
      decoded.push_back(text[i]);
    }
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

Result<PartHeader> FromDisposition(std::string_view text) {
  SKYQUILT_TRY_ASSIGN(const HeaderValue parsed, ParseHeaderValue(text));
  if (parsed.value != "form-data") return Refuse("a part is not form-data");
  const std::string* name = FindParameter(parsed, "name");
  if (name == nullptr) return Refuse("a part has no name");
  PartHeader header;
  header.field = WithQuotes(*name);
  if (const std::string* file_name = FindParameter(parsed, "filename")) {
    header.file_name = WithQuotes(*file_name);
  } else if (const std::string* extended = FindParameter(parsed, "filename*")) {
    if (!Lower(*extended).starts_with("utf-8'")) return Refuse("a file name is not in UTF-8");
    const std::size_t quote = extended->find('\'', 6);
    if (quote == std::string::npos) return Refuse("an extended file name is broken");
    header.file_name = PercentDecoded(std::string_view(*extended).substr(quote + 1));
  }
  return header;
}

}  // namespace

Result<HeaderValue> ParseHeaderValue(std::string_view text) {
  HeaderValue header;
  const std::size_t end = text.find(';');
  header.value = Lower(Trim(text.substr(0, end)));
  text = end == std::string_view::npos ? std::string_view() : text.substr(end);
  while (!text.empty()) {
    if (text.front() != ';') return Refuse("a header has text where a semicolon belongs");
    text = Trim(text.substr(1));
    if (text.empty()) break;
    const std::size_t equals = text.find('=');
    if (equals == std::string_view::npos || equals == 0) return Refuse("a header parameter has no value");
    std::string name = Lower(Trim(text.substr(0, equals)));
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
    const std::string name = Lower(line.substr(0, colon));
    const std::string_view value = Trim(line.substr(colon + 1));
    if (name == "content-disposition") {
      if (header) return Refuse("a part has two dispositions");
      SKYQUILT_TRY_ASSIGN(PartHeader parsed, FromDisposition(value));
      header = std::move(parsed);
    } else if (name == "content-transfer-encoding" && Lower(value) != "binary" && Lower(value) != "8bit" &&
               Lower(value) != "7bit") {
      return Refuse("a part is transfer-encoded; send plain bytes");
    }
  }
  if (!header) return Refuse("a part has no Content-Disposition");
  return *std::move(header);
}

}  // namespace skyquilt::api
