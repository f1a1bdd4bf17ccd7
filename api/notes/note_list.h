// ReadNotes: the notes and measurements of a flight as they are kept, from the GeoJSON that a client sends or
// that lies among the flight's files: a FeatureCollection of points with words (notes), lines (distances) and
// polygons of one ring (areas), in degrees of WGS84, longitude first. Strict: what is not known is refused,
// so that nothing a client sends is lost without a word. What comes out is read again as it is. Pure; any
// thread. Errors, whole sentences for the user: kTooLarge, kInvalidArgument (no JSON), kUnprocessable (a
// field that breaks its rule).
#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"

namespace skyquilt::api {

inline constexpr std::size_t kMaxNotesBytes = std::size_t{1} << 20;
inline constexpr std::size_t kMaxNotes = 2000;

struct NotesText {
  std::string json;
  std::size_t count = 0;
};

NotesText NoNotes();
Result<NotesText> ReadNotes(std::string_view json);

}  // namespace skyquilt::api
