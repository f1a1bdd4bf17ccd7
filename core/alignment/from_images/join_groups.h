// JoinGroups: each smaller group into the first larger one that takes it, again and again. Two that do not
// fit are not asked again until one of them has grown, so that a flight in many groups costs as many
// questions as it has pairs of groups, not that times the groups. One thread; the same for the same groups.
#pragma once

#include <algorithm>
#include <cstddef>
#include <set>
#include <utility>
#include <vector>

namespace skyquilt::alignment {

// Group: has a size(). take(smaller, larger): whether the larger one took the smaller one's members; by no
// more than these two. The largest comes out first.
template <typename Group, typename Take>
void JoinGroups(const Take& take, std::vector<Group>& groups) {
  struct Numbered {
    Group group;
    std::size_t number;  // another one when it has grown
  };
  std::vector<Numbered> left;
  for (Group& group : groups) left.push_back({std::move(group), left.size()});
  std::size_t next_number = left.size();
  std::set<std::pair<std::size_t, std::size_t>> do_not_fit;
  for (bool is_joined = true; is_joined;) {
    is_joined = false;
    std::stable_sort(left.begin(), left.end(),
                     [](const Numbered& a, const Numbered& b) { return a.group.size() > b.group.size(); });
    for (std::size_t large = 0; large < left.size() && !is_joined; ++large) {
      for (std::size_t small = large + 1; small < left.size() && !is_joined; ++small) {
        const std::pair pair(left[large].number, left[small].number);
        if (do_not_fit.contains(pair)) continue;
        if (!take(left[small].group, left[large].group)) {
          do_not_fit.insert(pair);
          continue;
        }
        left[large].number = next_number++;
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(small));
        is_joined = true;
      }
    }
  }
  groups.clear();
  for (Numbered& one : left) groups.push_back(std::move(one.group));
}

}  // namespace skyquilt::alignment
