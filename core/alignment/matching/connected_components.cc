#include "core/alignment/matching/connected_components.h"

#include <algorithm>

namespace skyquilt::alignment {

ConnectedComponents FindConnectedComponents(std::size_t photos, const std::vector<VerifiedPair>& pairs) {
  std::vector<int> root(photos, -1);  // negative: no verified pair so far
  const auto find = [&](int i) {
    if (root[i] < 0) root[i] = i;
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (const VerifiedPair& pair : pairs) {
    const int a = find(pair.first);
    const int b = find(pair.second);
    root[std::max(a, b)] = std::min(a, b);
  }
  ConnectedComponents components;
  components.of_photo.assign(photos, -1);
  std::vector<int> number(photos, -1);
  for (std::size_t i = 0; i < photos; ++i) {
    if (root[i] < 0) continue;
    const int r = find(static_cast<int>(i));
    if (number[r] < 0) {
      number[r] = static_cast<int>(components.members.size());
      components.members.emplace_back();
    }
    components.of_photo[i] = number[r];
    components.members[number[r]].push_back(static_cast<int>(i));
  }
  return components;
}

}  // namespace skyquilt::alignment
