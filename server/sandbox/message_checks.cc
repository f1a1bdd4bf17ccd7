#include "server/sandbox/message_checks.h"

#include <algorithm>
#include <utility>

namespace skyquilt::server {
namespace {

constexpr int kMaxZoom = 30;

}  // namespace

Error Untrue(std::string detail) {
  return {ErrorCode::kUnprocessable, "The process that works on the photos said what makes no sense.",
          std::move(detail)};
}

bool IsWithin(double value, double least, double most) { return value >= least && value <= most; }

int CountOf(double value) { return IsWithin(value, 0, kMaxPhotos) ? static_cast<int>(value) : -1; }

bool AreBounds(const geo::LatLonBounds& bounds) {
  const auto& [west, south, east, north] = bounds;
  return IsWithin(west, -180, 180) && IsWithin(east, west, west + 360) && IsWithin(south, -90, 90) &&
         IsWithin(north, south, 90);
}

bool AreZooms(int min_zoom, int max_zoom) {
  return IsWithin(min_zoom, 0, kMaxZoom) && IsWithin(max_zoom, min_zoom, kMaxZoom);
}

bool IsWord(const std::string& text, std::size_t most) {
  return !text.empty() && text.size() <= most && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

std::string Shortened(std::string text, std::size_t max_bytes) {
  if (text.size() <= max_bytes) return text;
  while (max_bytes > 0 && (static_cast<unsigned char>(text[max_bytes]) & 0xc0) == 0x80) --max_bytes;
  text.resize(max_bytes);
  return text;
}

}  // namespace skyquilt::server
