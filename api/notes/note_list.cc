#include "api/notes/note_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "api/json/json_text.h"
#include "core/base/text/json_io.h"
#include "core/base/text/plain_text.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

using Value = nlohmann::ordered_json;

constexpr std::size_t kMaxNoteId = 64;
constexpr std::size_t kMaxNoteName = 200;
constexpr std::size_t kMaxNoteWords = 4000;
constexpr double kMaxLonDeg = 180.0;
constexpr double kMaxLatDeg = 90.0;
constexpr std::size_t kMinOfLine = 2;
constexpr std::size_t kMinOfRing = 4;  // its first position is its last as well

Error RefuseNote(std::string message) { return {ErrorCode::kUnprocessable, std::move(message)}; }

Result<void> KnowsFields(const Value& object, std::initializer_list<std::string_view> known,
                         const std::string& of) {
  for (const auto& [field, value] : object.items()) {
    if (std::find(known.begin(), known.end(), field) == known.end())
      return RefuseNote(fmt::format("The field \"{}\" of {} is not known.", field, of));
  }
  return {};
}

bool IsControl(char c) {
  const auto code = static_cast<unsigned char>(c);
  return code < 0x20 || code == 0x7F;
}

bool IsLineOfText(const std::string& text, std::size_t max_bytes) {
  return text.size() <= max_bytes && std::none_of(text.begin(), text.end(), IsControl);
}

bool IsWords(const std::string& text) {
  return text.size() <= kMaxNoteWords && std::none_of(text.begin(), text.end(), [](char c) {
           return IsControl(c) && c != '\n' && c != '\t';
         });
}

bool IsNoteId(const std::string& text) {
  return !text.empty() && text.size() <= kMaxNoteId && std::all_of(text.begin(), text.end(), [](char c) {
    return IsLetterOrDigit(c) || c == '-' || c == '_';
  });
}

const std::string* TextAt(const Value& object, const char* field) {
  const auto found = object.find(field);
  return found != object.end() && found->is_string() ? &found->get_ref<const std::string&>() : nullptr;
}

Result<Value> ReadPosition(const Value& position, const std::string& of) {
  constexpr std::size_t kNumbers = 2;
  if (!position.is_array() || position.size() != kNumbers || !position[0].is_number() ||
      !position[1].is_number()) {
    return RefuseNote(fmt::format("A position of {} must be two numbers, longitude and latitude.", of));
  }
  const auto lon_deg = position[0].get<double>();
  const auto lat_deg = position[1].get<double>();
  if (!(std::abs(lon_deg) <= kMaxLonDeg) || !(std::abs(lat_deg) <= kMaxLatDeg))
    return RefuseNote(fmt::format("A position of {} is not on Earth.", of));
  return Value{lon_deg, lat_deg};
}

Result<Value> ReadPositions(const Value& positions, std::size_t least, const std::string& of) {
  if (!positions.is_array() || positions.size() < least)
    return RefuseNote(fmt::format("{} needs at least {} positions.", of, least));
  Value read = Value::array();
  for (const Value& position : positions) {
    SKYQUILT_TRY_ASSIGN(Value place, ReadPosition(position, of));
    read.push_back(std::move(place));
  }
  return read;
}

Result<Value> ReadRings(const Value& rings, const std::string& of) {
  if (!rings.is_array() || rings.size() != 1)
    return RefuseNote(fmt::format("{} must be a polygon of one ring.", of));
  SKYQUILT_TRY_ASSIGN(Value ring, ReadPositions(rings.front(), kMinOfRing, of));
  if (ring.front() != ring.back())
    return RefuseNote(fmt::format("The ring of {} must end where it begins.", of));
  Value read = Value::array();
  read.push_back(std::move(ring));
  return read;
}

Result<Value> ReadShape(const Value& feature, const std::string& of) {
  const auto geometry = feature.find("geometry");
  if (geometry == feature.end() || !geometry->is_object())
    return RefuseNote(fmt::format("{} needs a geometry.", of));
  SKYQUILT_TRY(KnowsFields(*geometry, {"type", "coordinates"}, fmt::format("the geometry of {}", of)));
  const std::string* type = TextAt(*geometry, "type");
  const auto coordinates = geometry->find("coordinates");
  if (type == nullptr || coordinates == geometry->end() ||
      (*type != "Point" && *type != "LineString" && *type != "Polygon")) {
    return RefuseNote(fmt::format("The geometry of {} must be a Point, a LineString or a Polygon.", of));
  }
  Result<Value> read = *type == "Point"        ? ReadPosition(*coordinates, of)
                       : *type == "LineString" ? ReadPositions(*coordinates, kMinOfLine, of)
                                               : ReadRings(*coordinates, of);
  if (!read) return read.error();
  return Value{{"type", *type}, {"coordinates", *std::move(read)}};
}

Result<Value> ReadProperties(const Value& feature, const std::string& of) {
  const auto properties = feature.find("properties");
  if (properties == feature.end() || !properties->is_object())
    return RefuseNote(fmt::format("{} needs properties, with its name.", of));
  SKYQUILT_TRY(KnowsFields(*properties, {"name", "text"}, of));
  const std::string* name = TextAt(*properties, "name");
  if (name == nullptr || name->empty() || !IsLineOfText(*name, kMaxNoteName))
    return RefuseNote(fmt::format("The \"name\" of {} must be one line of 1 to {} bytes.", of, kMaxNoteName));
  Value read{{"name", *name}};
  if (!properties->contains("text")) return read;
  const std::string* words = TextAt(*properties, "text");
  if (words == nullptr || !IsWords(*words))
    return RefuseNote(fmt::format("The \"text\" of {} must be text of at most {} bytes.", of, kMaxNoteWords));
  read["text"] = *words;
  return read;
}

Result<Value> ReadNote(const Value& feature, std::set<std::string>& ids) {
  const std::string* type = feature.is_object() ? TextAt(feature, "type") : nullptr;
  if (type == nullptr || *type != "Feature") return RefuseNote("Every note must be a GeoJSON Feature.");
  const std::string* id = TextAt(feature, "id");
  if (id == nullptr || !IsNoteId(*id)) {
    return RefuseNote(fmt::format(
        "Every note needs an \"id\" of 1 to {} letters, digits, hyphens or underscores.", kMaxNoteId));
  }
  if (!ids.insert(*id).second) return RefuseNote(fmt::format("There are two notes with the id {}.", *id));
  const std::string of = fmt::format("note {}", *id);
  SKYQUILT_TRY(KnowsFields(feature, {"type", "id", "geometry", "properties"}, of));
  SKYQUILT_TRY_ASSIGN(Value geometry, ReadShape(feature, of));
  SKYQUILT_TRY_ASSIGN(Value properties, ReadProperties(feature, of));
  return Value{{"type", "Feature"},
               {"id", *id},
               {"geometry", std::move(geometry)},
               {"properties", std::move(properties)}};
}

NotesText TextOfNotes(Value features) {
  NotesText text;
  text.count = features.size();
  Value document{{"type", "FeatureCollection"}};
  document["features"] = std::move(features);
  text.json = JsonText(document);
  return text;
}

}  // namespace

NotesText NoNotes() { return TextOfNotes(Value::array()); }

Result<NotesText> ReadNotes(std::string_view json) {
  SKYQUILT_TRY(CheckJsonText(json, kMaxNotesBytes));
  const Value document = ParseOrderedJson(json);
  if (document.is_discarded()) return Error{ErrorCode::kInvalidArgument, "The notes are not JSON."};
  const std::string* type = document.is_object() ? TextAt(document, "type") : nullptr;
  if (type == nullptr || *type != "FeatureCollection")
    return RefuseNote("The notes must be a GeoJSON FeatureCollection.");
  SKYQUILT_TRY(KnowsFields(document, {"type", "features"}, "the notes"));
  const auto given = document.find("features");
  if (given == document.end() || !given->is_array()) return RefuseNote("\"features\" must be a list.");
  if (given->size() > kMaxNotes) return RefuseNote(fmt::format("There are more than {} notes.", kMaxNotes));
  Value features = Value::array();
  std::set<std::string> ids;
  for (const Value& feature : *given) {
    SKYQUILT_TRY_ASSIGN(Value note, ReadNote(feature, ids));
    features.push_back(std::move(note));
  }
  NotesText text = TextOfNotes(std::move(features));
  // Numbers may be longer as they are kept than as they came.
  if (text.json.size() > kMaxNotesBytes) {
    return Error{ErrorCode::kTooLarge,
                 fmt::format("The notes are longer than {} KiB.", kMaxNotesBytes >> 10U)};
  }
  return text;
}

}  // namespace skyquilt::api
