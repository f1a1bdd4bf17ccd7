#include "api/control/control_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "api/json/json_text.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

using Value = nlohmann::ordered_json;

constexpr std::size_t kMaxSystemLength = 300;
constexpr std::size_t kMaxPointName = 100;
constexpr std::size_t kMaxPhotoName = 255;
constexpr double kMaxCoordinate = 1e9;
constexpr double kMaxPixel = 1e6;
constexpr std::string_view kNoPhoto = "-";  // in the list, of a point without marks
constexpr const char* kUsualSystem = "EPSG:4326";
// The format counts from the corner of the first pixel, the API from its middle.
constexpr double kMiddleOfPixel = 0.5;

Error RefuseControl(std::string message) { return {ErrorCode::kUnprocessable, std::move(message)}; }

bool IsPlainLine(const std::string& text, std::size_t max_length) {
  return !text.empty() && text.size() <= max_length && text.front() != ' ' && text.back() != ' ' &&
         std::none_of(text.begin(), text.end(),
                      [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; });
}

Result<double> ControlNumber(const Value& object, const char* field, double limit, const std::string& of) {
  const auto found = object.find(field);
  if (found == object.end() || !found->is_number())
    return RefuseControl(fmt::format("\"{}\" of {} must be a number.", field, of));
  const auto number = found->get<double>();
  if (!(std::abs(number) <= limit))
    return RefuseControl(fmt::format("\"{}\" of {} is out of range.", field, of));
  return number;
}

// Reads the document row by row.
class ListWriter {
 public:
  Result<void> Begin(const Value& document) {
    std::string system = kUsualSystem;
    if (const auto given = document.find("reference_system"); given != document.end()) {
      if (!given->is_string())
        return RefuseControl("\"reference_system\" must be a text such as EPSG:32611.");
      system = given->get<std::string>();
    }
    if (!IsPlainLine(system, kMaxSystemLength) || system.front() == '#')
      return RefuseControl("\"reference_system\" must be one line such as EPSG:32611 or WGS84 UTM 11N.");
    text_ = system + "\n";
    return {};
  }

  Result<void> Add(const Value& point) {
    if (!point.is_object()) return RefuseControl("Every point must be an object.");
    const auto name = point.find("name");
    if (name == point.end() || !name->is_string() ||
        !IsPlainLine(name->get_ref<const std::string&>(), kMaxPointName))
      return RefuseControl(
          fmt::format("Every point needs a \"name\": one line of at most {} bytes.", kMaxPointName));
    const auto& own = name->get_ref<const std::string&>();
    const std::string of = fmt::format("point {}", own);
    if (!names_.insert(own).second) return RefuseControl(fmt::format("There are two points called {}.", own));
    SKYQUILT_TRY_ASSIGN(const double x, ControlNumber(point, "x", kMaxCoordinate, of));
    SKYQUILT_TRY_ASSIGN(const double y, ControlNumber(point, "y", kMaxCoordinate, of));
    std::string height = "nan";
    if (const auto given = point.find("height"); given != point.end() && !given->is_null()) {
      SKYQUILT_TRY_ASSIGN(const double z, ControlNumber(point, "height", kMaxCoordinate, of));
      height = fmt::format("{}", z);
    }
    const std::string place = fmt::format("{}\t{}\t{}", x, y, height);
    const auto [same, is_new] = name_at_.emplace(place, own);
    if (!is_new)
      return RefuseControl(fmt::format("The points {} and {} have the same coordinates.", same->second, own));
    return AddMarks(point, place, own);
  }

  std::string Take() { return std::move(text_); }

 private:
  Result<void> AddMarks(const Value& point, const std::string& place, const std::string& name) {
    const std::string of = fmt::format("a mark of point {}", name);
    const auto marks = point.find("marks");
    if (marks == point.end() || marks->empty()) {
      text_ += fmt::format("{}\t0\t0\t{}\t{}\n", place, kNoPhoto, name);
      return {};
    }
    if (!marks->is_array()) return RefuseControl(fmt::format("\"marks\" of point {} must be a list.", name));
    std::set<std::string> photos;
    for (const Value& mark : *marks) {
      if (++marks_ > kMaxControlMarks)
        return RefuseControl(fmt::format("There are more than {} marks.", kMaxControlMarks));
      if (!mark.is_object()) return RefuseControl(fmt::format("{} must be an object.", of));
      const auto photo = mark.find("photo");
      if (photo == mark.end() || !photo->is_string() ||
          !IsPlainLine(photo->get_ref<const std::string&>(), kMaxPhotoName) || *photo == kNoPhoto)
        return RefuseControl(fmt::format("\"photo\" of {} must be the name of a photo.", of));
      const auto& image = photo->get_ref<const std::string&>();
      if (!photos.insert(image).second)
        return RefuseControl(fmt::format("Point {} has two marks in {}.", name, image));
      SKYQUILT_TRY_ASSIGN(const double x, ControlNumber(mark, "x", kMaxPixel, of));
      SKYQUILT_TRY_ASSIGN(const double y, ControlNumber(mark, "y", kMaxPixel, of));
      text_ += fmt::format("{}\t{:.3f}\t{:.3f}\t{}\t{}\n", place, x + kMiddleOfPixel, y + kMiddleOfPixel,
                           image, name);
    }
    return {};
  }

  std::string text_;
  std::set<std::string> names_;
  std::map<std::string, std::string> name_at_;
  std::size_t marks_ = 0;
};

}  // namespace

std::string NoControlJson() {
  return JsonText(
      Value{{"reference_system", kUsualSystem}, {"points", Value::array()}, {"warnings", Value::array()}});
}

Result<std::string> ControlListText(std::string_view json) {
  SKYQUILT_TRY(CheckJsonText(json, kMaxControlBytes));
  const Value document = ParseOrderedJson(json);
  if (document.is_discarded()) return Error{ErrorCode::kInvalidArgument, "The control points are not JSON."};
  if (!document.is_object()) return RefuseControl("The control points must be a JSON object.");
  for (const auto& [field, value] : document.items()) {
    if (field != "reference_system" && field != "points" && field != "warnings")
      return RefuseControl(
          fmt::format("The field \"{}\" is not known; known are reference_system and points.", field));
  }
  const auto points = document.find("points");
  if (points == document.end() || !points->is_array()) return RefuseControl("\"points\" must be a list.");
  if (points->size() > kMaxControlPoints)
    return RefuseControl(fmt::format("There are more than {} points.", kMaxControlPoints));
  ListWriter writer;
  SKYQUILT_TRY(writer.Begin(document));
  for (const Value& point : *points) SKYQUILT_TRY(writer.Add(point));
  if (points->empty()) return std::string();
  return writer.Take();
}

}  // namespace skyquilt::api
