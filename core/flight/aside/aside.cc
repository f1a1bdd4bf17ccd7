#include "core/flight/aside/aside.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "core/flight/remarks/because.h"
#include "core/flight/remarks/remark_words.h"

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

Remark ReasonOf(Aside why, std::string_view of, std::string_view instead) {
  const std::string its_own(of), other(instead);
  switch (why) {
    case Aside::kSameBytes:
      return {RemarkCode::kLeftSameBytes, {{"other", its_own}}};
    case Aside::kPanorama:
      return {RemarkCode::kLeftPanorama, {{"evidence_words", its_own}}};
    case Aside::kRawPicture:
      return {RemarkCode::kLeftRawPicture, {{"format", its_own}}};
    case Aside::kThumbnailFirst:
      return RemarkCode::kLeftThumbnailFirst;
    case Aside::kCopy:
      return {RemarkCode::kLeftCopy, {{"other", its_own}}};
    case Aside::kOlderMetadata:
      return {RemarkCode::kLeftOlderMetadata, {{"other", its_own}}};
    case Aside::kOtherCamera:
      return {RemarkCode::kLeftOtherCamera, {{"camera", its_own}, {"instead", other}}};
    case Aside::kThermal:
      return {RemarkCode::kLeftThermal, {{"camera", its_own}, {"instead", other}}};
    case Aside::kVisible:
      break;
  }
  return {RemarkCode::kLeftVisible, {{"camera", its_own}, {"instead", other}}};
}

struct SomeLines {
  std::vector<Remark> lines;
  std::size_t more = 0;  // pictures of which none speaks
};

SomeLines FirstLines(const std::vector<LeftOutPhoto>& left_out, std::size_t most) {
  constexpr std::size_t kMaxNamedApart = 3;
  std::map<std::string, std::size_t> all, seen;
  for (const LeftOutPhoto& photo : left_out) ++all[InWords(photo.reason)];
  SomeLines some;
  std::size_t told = 0;
  for (const LeftOutPhoto& photo : left_out) {
    const std::string reason = InWords(photo.reason);
    const std::size_t count = all[reason];
    const bool is_named_apart = count <= kMaxNamedApart;
    if (some.lines.size() == most || (seen[reason]++ > 0 && !is_named_apart)) continue;
    some.lines.push_back(is_named_apart
                             ? Remark(RemarkCode::kOfPhoto, {{"photo", photo.name}, {"said", photo.reason}})
                             : Remark(RemarkCode::kPhotoAndMore,
                                      {{"photo", photo.name}, {"more", count - 1}, {"said", photo.reason}}));
    told += is_named_apart ? 1 : count;
  }
  some.more = left_out.size() - told;
  return some;
}

}  // namespace

Error AsideError(Aside why, std::string_view of, std::string_view instead) {
  return Because(CodeOf(why), ReasonOf(why, of, instead));
}

LeftOutPhoto LeftAside(const std::string& name, Aside why, std::string_view of, std::string_view instead) {
  return {name, CodeOf(why), ReasonOf(why, of, instead)};
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

std::vector<std::string> LeftOutInLines(const std::vector<LeftOutPhoto>& left_out) {
  constexpr std::size_t kMaxLines = 20;
  const SomeLines some = FirstLines(left_out, kMaxLines);
  std::vector<std::string> lines = InWords(some.lines);
  if (some.more > 0)
    lines.push_back(fmt::format("and {} more picture{}", some.more, some.more == 1 ? "" : "s"));
  return lines;
}

Remark FirstLeftOut(const std::vector<LeftOutPhoto>& left_out) {
  constexpr std::size_t kMaxSentences = 3;
  SomeLines some = FirstLines(left_out, kMaxSentences);
  if (some.more > 0) some.lines.push_back({RemarkCode::kAndMorePictures, {{"pictures", some.more}}});
  return InARow(std::move(some.lines));
}

}  // namespace skyquilt::flight
