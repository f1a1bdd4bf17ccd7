#include "api/http/accept.h"

#include <charconv>
#include <cmath>

#include "api/http/http_message.h"
#include "core/base/text/plain_text.h"

namespace skyquilt::api {
namespace {

constexpr int kFull = 1000;

// What stands before the separator, which goes with it.
std::string_view TakeUntil(char separator, std::string_view& rest) {
  const std::size_t end = rest.find(separator);
  const std::string_view taken = rest.substr(0, end);
  rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  return Trim(taken);
}

// 3: the type itself, 2: all of its kind, 1: all there are, 0: another.
int Closeness(std::string_view range, std::string_view type) {
  if (EqualsIgnoringCase(range, type)) return 3;
  if (range == "*/*" || range == "*") return 1;
  const std::size_t slash = type.find('/');
  return range.ends_with("/*") && EqualsIgnoringCase(range.substr(0, range.size() - 2), type.substr(0, slash))
             ? 2
             : 0;
}

// Of "q=0.5" among a range's parameters; what is no number is as good as none.
int QualityIn(std::string_view parameters) {
  while (!parameters.empty()) {
    std::string_view value = TakeUntil(';', parameters);
    if (!EqualsIgnoringCase(TakeUntil('=', value), "q")) continue;
    value = Trim(value);
    double quality = 1.0;
    const auto parsed = std::from_chars(value.data(), value.data() + value.size(), quality);
    if (parsed.ec != std::errc() || !(quality >= 0.0 && quality <= 1.0)) return kFull;
    return static_cast<int>(std::lround(quality * kFull));
  }
  return kFull;
}

}  // namespace

bool NamesType(std::string_view accept, std::string_view type) {
  while (!accept.empty()) {
    std::string_view parameters = TakeUntil(',', accept);
    if (EqualsIgnoringCase(TakeUntil(';', parameters), type)) return QualityIn(parameters) > 0;
  }
  return false;
}

int AcceptedQuality(std::string_view accept, std::string_view type) {
  if (Trim(accept).empty()) return kFull;
  int closest = 0;
  int quality = 0;
  while (!accept.empty()) {
    std::string_view parameters = TakeUntil(',', accept);
    const int closeness = Closeness(TakeUntil(';', parameters), type);
    if (closeness <= closest) continue;
    closest = closeness;
    quality = QualityIn(parameters);
  }
  return quality;
}

}  // namespace skyquilt::api
