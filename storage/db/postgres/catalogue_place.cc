#include "storage/db/postgres/catalogue_place.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <string_view>

#include "core/base/text/percent.h"
#include "core/base/try.h"

namespace skyquilt::storage {
namespace {

constexpr std::size_t kMaxSchemaName = 48;
constexpr std::size_t kMaxPassword = 4096;

// "%40" -> "@". Absent: a percent sign without two digits behind it.
std::optional<std::string> Unescaped(std::string_view text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const int byte = PercentByte(text.substr(i));
    if (byte < 0 && text[i] == '%') return std::nullopt;
    plain.push_back(byte < 0 ? text[i] : static_cast<char>(byte));
    if (byte >= 0) i += 2;
  }
  return plain;
}

bool IsSchemaName(std::string_view name) {
  const auto is_word = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
  return !name.empty() && name.size() <= kMaxSchemaName && !(name[0] >= '0' && name[0] <= '9') &&
         !name.starts_with("pg_") && std::all_of(name.begin(), name.end(), is_word);
}

Result<std::string> PasswordIn(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  if (!file.is_open()) {
    return Error{ErrorCode::kNotFound,
                 fmt::format("The password file {} cannot be read. Is it there, and this user's?", path), ""};
  }
  std::getline(file, line);
  if (!line.empty() && line.back() == '\r') line.pop_back();
  if (line.empty() || line.size() > kMaxPassword) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("The first line of {} is not a password: it is empty or too long.", path), ""};
  }
  return line;
}

}  // namespace

Result<CataloguePlace> CataloguePlaceFrom(const std::string& url, const std::string& password_file) {
  // The URL itself is not repeated: a mistake may have put the password anywhere.
  const Error bad{
      ErrorCode::kInvalidArgument,
      "--catalogue: give it as postgresql://USER@HOST:PORT/DATABASE, or leave it out for a catalogue in the data folder.",
      ""};
  CataloguePlace place;
  if (url.empty()) {
    if (password_file.empty()) return place;
    return Error{ErrorCode::kInvalidArgument, "--catalogue-password-file goes with --catalogue.", ""};
  }
  if (url.find('\0') != std::string::npos) return bad;
  const std::size_t scheme_end = url.find("://");
  if (scheme_end == std::string::npos) return bad;
  const std::string scheme = url.substr(0, scheme_end);
  if (scheme != "postgresql" && scheme != "postgres") return bad;
  const std::size_t query_at = std::min(url.find('?'), url.size());
  std::string_view rest = std::string_view(url).substr(scheme_end + 3, query_at - scheme_end - 3);
  place.url = "postgresql://";
  const std::string_view authority = rest.substr(0, rest.find('/'));
  if (const std::size_t at = authority.rfind('@'); at != std::string_view::npos) {
    const std::string_view user = authority.substr(0, std::min(authority.find(':'), at));
    if (user.size() < at) {
      const std::optional<std::string> password =
          Unescaped(authority.substr(user.size() + 1, at - user.size() - 1));
      if (!password) return bad;
      place.password = *password;
    }
    place.url += std::string(user) + "@";
    rest.remove_prefix(at + 1);
  }
  place.url += rest;
  char separator = '?';
  for (std::size_t begin = query_at + 1; begin < url.size();) {
    const std::size_t end = std::min(url.find('&', begin), url.size());
    const std::string word = url.substr(begin, end - begin);
    begin = end + 1;
    const std::optional<std::string> value =
        Unescaped(std::string_view(word).substr(std::min(word.find('=') + 1, word.size())));
    if (!value) return bad;
    if (word.starts_with("schema=")) {
      if (!IsSchemaName(*value)) {
        return Error{
            ErrorCode::kInvalidArgument,
            "--catalogue: schema= takes a name of lower-case letters, digits and underscores, which does "
            "not begin with a digit or pg_.",
            ""};
      }
      place.schema = *value;
    } else if (word.starts_with("password=")) {
      place.password = *value;
    } else {
      place.url += separator + word;
      separator = '&';
    }
  }
  if (!password_file.empty()) {
    SKYQUILT_TRY_ASSIGN(place.password, PasswordIn(password_file));
  }
  return place;
}

}  // namespace skyquilt::storage
