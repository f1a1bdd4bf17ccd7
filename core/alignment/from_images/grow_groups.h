// GrowGroups: groups of photos one after the other, each of photos that no earlier one holds. One that keeps
// no photo when it has grown ends nothing: the photos that it began with begin none any more, but others may
// take them in. One thread; the same for the same groups.
#pragma once

#include <cstddef>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/alignment/scene/photo_set.h"

namespace skyquilt::alignment {

// Each costs the time of a group; photos that hold together as badly as that are left out.
inline constexpr int kMaxFallenApart = 100;

// begin(used, spent): the next group, as an optional, with at least one photo that is not spent; nothing:
// there is none. grow(used, group). Group: has Has(photo) and size().
template <typename Begin, typename Grow>
auto GrowGroups(std::size_t photos, const Begin& begin, const Grow& grow) {
  using Group = typename std::invoke_result_t<const Begin&, const PhotoSet&, const PhotoSet&>::value_type;
  const auto add_photos = [photos](const Group& group, PhotoSet& to) {
    for (std::size_t i = 0; i < photos; ++i) {
      if (group.Has(i)) to.Add(i);
    }
  };
  std::vector<Group> groups;
  PhotoSet used(photos), spent(photos);
  for (int fallen_apart = 0; fallen_apart < kMaxFallenApart;) {
    std::optional<Group> begun = begin(std::as_const(used), std::as_const(spent));
    if (!begun) break;
    PhotoSet spent_with_these = spent;
    add_photos(*begun, spent_with_these);
    grow(std::as_const(used), *begun);
    if (begun->size() > 0) {
      add_photos(*begun, used);
      groups.push_back(*std::move(begun));
      continue;
    }
    if (spent_with_these.Count() == spent.Count()) break;  // the same would begin again and again
    spent = std::move(spent_with_these);
    ++fallen_apart;
  }
  return groups;
}

}  // namespace skyquilt::alignment
