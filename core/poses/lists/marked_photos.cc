#include "core/poses/lists/marked_photos.h"

#include <string>
#include <string_view>
#include <utility>

namespace skyquilt::poses {
namespace {

using flight::GcpSighting;
using flight::RemarkCode;

// One mark may be mistyped; of larger pictures' pixels, or lines taken for columns, a share lies outside.
constexpr std::size_t kFewestOutside = 2;
constexpr std::size_t kOutsideOneIn = 10;

struct LeftOut {
  std::size_t marks = 0;
  std::string first;

  void Add(const std::string& name) {
    if (marks++ == 0) first = name;
  }
};

// An unknown size of a photo is not held against a mark. The list counts from the first pixel's corner.
bool IsOutside(const GcpSighting& mark, const flight::Photo& photo) {
  const camera::Intrinsics& lens = photo.intrinsics;
  return lens.width_px > 0 && lens.height_px > 0 && !lens.IsInImage({mark.pixel_x - 0.5, mark.pixel_y - 0.5});
}

}  // namespace

bool MarkedPhotosFound::AreOfOtherPictures() const {
  return outside >= kFewestOutside && kOutsideOneIn * outside >= marks;
}

MarkedPhotosFound FindMarkedPhotos(const std::vector<flight::Photo>& photos, const NamedPhotos& named,
                                   flight::GcpList& list) {
  MarkedPhotosFound found;
  LeftOut nobody, open, outside;
  std::vector<std::string_view> names;
  for (const GcpSighting& mark : list.sightings) names.emplace_back(mark.image_name);
  const std::vector<NamedPhotos::Found> called_by_mark = named.FindAll(list.file_name, names);
  std::vector<GcpSighting> kept;
  for (std::size_t k = 0; k < called_by_mark.size(); ++k) {
    GcpSighting& mark = list.sightings[k];
    const NamedPhotos::Found& called = called_by_mark[k];
    if (called.photos.empty()) {
      (called.is_open ? open : nobody).Add(mark.image_name);
      continue;
    }
    const std::size_t number = called.photos.front();
    const flight::Photo& photo = photos[number];
    ++found.marks;
    if (IsOutside(mark, photo)) {
      outside.Add(mark.image_name);
      continue;
    }
    mark.image_name = photo.name;
    kept.push_back(std::move(mark));
    found.photos.push_back(number);
  }
  list.sightings = std::move(kept);
  found.outside = outside.marks;
  const auto tell = [&](RemarkCode code, const char* counted, const LeftOut& left) {
    if (left.marks > 0)
      found.remarks.push_back(
          {code, {{"file", list.file_name}, {counted, left.marks}, {"first", left.first}}});
  };
  const bool is_of_others = found.marks == 0 && open.marks == 0;
  tell(is_of_others ? RemarkCode::kListNamesNoPhoto : RemarkCode::kMarksNameNoPhoto,
       is_of_others ? "rows" : "marks", nobody);
  tell(RemarkCode::kListRowsOfSeveralPhotos, "rows", open);
  if (!found.AreOfOtherPictures()) tell(RemarkCode::kMarksOutsidePhotos, "marks", outside);
  return found;
}

}  // namespace skyquilt::poses
