#include "core/flight/photo.h"

#include <array>
#include <cstddef>
#include <string_view>

#include "core/flight/bytes/text_fields.h"

namespace skyquilt::flight {

std::string MakeAndModel(const Photo& photo) {
  return photo.model.starts_with(photo.make) ? photo.model : photo.make + " " + photo.model;
}

namespace {

// The number that begins at `at`, without zeros before it; `at` is then behind it.
std::string_view NumberFrom(std::string_view name, std::size_t& at) {
  while (at < name.size() && name[at] == '0') ++at;
  const std::size_t begin = at;
  while (at < name.size() && IsDigit(name[at])) ++at;
  return name.substr(begin, at - begin);
}

// "frame_9" before "frame_10": numbers count as such, with zeros before them or without.
bool IsNamedBefore(std::string_view a, std::string_view b) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (!IsDigit(a[i]) || !IsDigit(b[j])) {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
      continue;
    }
    const std::string_view one = NumberFrom(a, i), other = NumberFrom(b, j);
    if (one.size() != other.size()) return one.size() < other.size();
    if (one != other) return one < other;
  }
  const bool a_ends = i == a.size(), b_ends = j == b.size();
  return a_ends != b_ends ? a_ends : a < b;
}

}  // namespace

bool ComesBefore(const Photo& a, const Photo& b) {
  if (a.captured_at.has_value() != b.captured_at.has_value()) return a.captured_at.has_value();
  if (a.captured_at != b.captured_at) return a.captured_at < b.captured_at;
  return IsNamedBefore(a.name, b.name);
}

const char* FocalSourceName(FocalSource source) {
  constexpr std::array kNames = {
      "dewarp_data",  "calibrated_focal_length", "xmp_camera", "focal_plane_resolution",
      "sensor_table", "35mm_equivalent",         "doubtful",   "assumed"};
  static_assert(kNames.size() == static_cast<std::size_t>(FocalSource::kAssumed) + 1);
  return kNames[static_cast<std::size_t>(source)];
}

}  // namespace skyquilt::flight
