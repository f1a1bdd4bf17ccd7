#include "core/flight/aside/aside.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

namespace skyquilt::flight {
namespace {

ErrorCode CodeOf(Aside why) {
  switch (why) {
    case Aside::kSameBytes:
    case Aside::kCopy:
    case Aside::kOlderMetadata:
      return ErrorCode::kConflict;
    case Aside::kRawPicture:
    case Aside::kThumbnailFirst:
      return ErrorCode::kUnsupportedFormat;
    case Aside::kPanorama:
    case Aside::kOtherCamera:
    case Aside::kThermal:
    case Aside::kVisible:
      break;
  }
  return ErrorCode::kUnprocessable;
}

std::string ReasonInWords(Aside why, std::string_view of, std::string_view instead) {
  switch (why) {
    case Aside::kSameBytes:
      return fmt::format("The same bytes as {}; one copy is enough.", of);
    case Aside::kPanorama:
      return fmt::format("This is a panorama ({}): a map is made of single photos. Give those instead.", of);
    case Aside::kRawPicture:
      return fmt::format(
          "This is a raw picture ({}). Give the JPEG that the camera wrote beside it, or export it as JPEG or "
          "TIFF, keeping the metadata.",
          of);
    case Aside::kThumbnailFirst:
      return "The first picture in this TIFF is a thumbnail of a larger one behind it, as in raw pictures. Give "
             "the JPEG that the camera wrote, or export it as JPEG or TIFF, keeping the metadata.";
    case Aside::kCopy:
      return fmt::format("A copy of {}, which is used: it is nearer to what the camera wrote.", of);
    case Aside::kOlderMetadata:
      return fmt::format(
          "The file as it was before its metadata were changed; {}, which has the new ones, is used.", of);
    case Aside::kOtherCamera:
      return fmt::format(
          "Taken by another camera ({}) at the same moments as the map's ({}). For a map of it give its "
          "pictures alone.",
          of, instead);
    case Aside::kThermal:
      return fmt::format(
          "A thermal picture ({}); the map is made of the visible ones ({}). For a thermal map give the thermal "
          "pictures alone.",
          of, instead);
    case Aside::kVisible:
      return fmt::format(
          "A visible picture ({}); the map is made of the thermal ones ({}), of which there are more. For a map "
          "of the visible ones give them alone.",
          of, instead);
  }
  return "";
}

struct SomeLines {
  std::vector<std::string> lines;
  std::size_t more = 0;  // pictures of which none speaks
};

SomeLines FirstLines(const std::vector<LeftOutPhoto>& left_out, std::size_t most) {
  constexpr std::size_t kMaxNamedApart = 3;
  std::map<std::string_view, std::size_t> all, seen;
  for (const LeftOutPhoto& photo : left_out) ++all[photo.reason];
  SomeLines some;
  std::size_t told = 0;
  for (const LeftOutPhoto& photo : left_out) {
    const std::size_t count = all[photo.reason];
    const bool is_named_apart = count <= kMaxNamedApart;
    if (some.lines.size() == most || (seen[photo.reason]++ > 0 && !is_named_apart)) continue;
    some.lines.push_back(is_named_apart
                             ? photo.name + ": " + photo.reason
                             : fmt::format("{} and {} more: {}", photo.name, count - 1, photo.reason));
    told += is_named_apart ? 1 : count;
  }
  some.more = left_out.size() - told;
  return some;
}

std::string MorePictures(std::size_t count) {
  return fmt::format("{} more picture{}", count, count == 1 ? "" : "s");
}

}  // namespace

Error AsideError(Aside why, std::string_view of, std::string_view instead) {
  return {CodeOf(why), ReasonInWords(why, of, instead), ""};
}

LeftOutPhoto LeftAside(const std::string& name, Aside why, std::string_view of, std::string_view instead) {
  return {name, CodeOf(why), ReasonInWords(why, of, instead)};
}

std::string CameraInWords(const Photo& photo, Lens lens) {
  // Many makers repeat themselves in the model's name.
  std::string words = photo.model.starts_with(photo.make) ? photo.model : photo.make + " " + photo.model;
  if (words.find_first_not_of(' ') == std::string::npos) words = "unnamed";
  if (lens == Lens::kWide) words += ", wide";
  if (lens == Lens::kZoom) words += ", zoom";
  if (lens == Lens::kThermal) words += ", thermal";
  const auto [shorter, longer] = std::minmax(photo.intrinsics.width_px, photo.intrinsics.height_px);
  return fmt::format("{}, {} x {} px", words, longer, shorter);
}

std::string OneCameraInWords(Aside why, std::size_t pictures, std::string_view of, std::string_view instead) {
  const std::string_view reason = why == Aside::kOtherCamera ? "both saw the same moments"
                                  : why == Aside::kThermal   ? "thermal and visible pictures do not mix"
                                                             : "there are more thermal than visible pictures";
  return fmt::format("The map is made of one camera ({}); {} picture{} of another ({}) lie{} aside: {}.",
                     instead, pictures, pictures == 1 ? "" : "s", of, pictures == 1 ? "s" : "", reason);
}

std::vector<std::string> LeftOutInLines(const std::vector<LeftOutPhoto>& left_out) {
  constexpr std::size_t kMaxLines = 20;
  SomeLines some = FirstLines(left_out, kMaxLines);
  if (some.more > 0) some.lines.push_back("and " + MorePictures(some.more));
  return std::move(some.lines);
}

std::string LeftOutInWords(const std::vector<LeftOutPhoto>& left_out) {
  constexpr std::size_t kMaxSentences = 3;
  const SomeLines some = FirstLines(left_out, kMaxSentences);
  std::string words = fmt::format("{}", fmt::join(some.lines, " "));
  if (some.more > 0) words += fmt::format(" And {}.", MorePictures(some.more));
  return words;
}

}  // namespace skyquilt::flight
