#include "core/image/huffman_code.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <queue>
#include <utility>

#include "core/base/check.h"

namespace skyquilt::image {
namespace {

constexpr int kLongest = 15;

// Of the optimal code; by symbol.
std::vector<int> Lengths(const std::vector<std::uint32_t>& counts) {
  using Tree = std::pair<std::uint64_t, std::size_t>;  // count, node
  std::priority_queue<Tree, std::vector<Tree>, std::greater<>> trees;
  for (std::size_t symbol = 0; symbol < counts.size(); ++symbol) {
    if (counts[symbol] > 0) trees.emplace(counts[symbol], symbol);
  }
  SKYQUILT_CHECK(trees.size() >= 2, "a Huffman code needs two symbols");
  std::vector<std::size_t> parent(2 * counts.size(), 0);
  std::size_t node = counts.size();
  while (trees.size() > 1) {
    const Tree a = trees.top();
    trees.pop();
    const Tree b = trees.top();
    trees.pop();
    parent[a.second] = parent[b.second] = node;
    trees.emplace(a.first + b.first, node++);
  }
  std::vector<int> depth(node, 0);
  // Parents come after their children.
  for (std::size_t i = node - 1; i-- > 0;) {
    if (i >= counts.size() || counts[i] > 0) depth[i] = depth[parent[i]] + 1;
  }
  depth.resize(counts.size());
  return depth;
}

}  // namespace

HuffmanCode HuffmanCode::Of(std::vector<std::uint32_t> counts) {
  std::vector<int> lengths = Lengths(counts);
  // Evening the counts out shortens the longest words.
  while (*std::max_element(lengths.begin(), lengths.end()) > kLongest) {
    for (std::uint32_t& count : counts) count = count == 0 ? 0 : count / 2 + 1;
    lengths = Lengths(counts);
  }
  std::array<std::uint32_t, kLongest + 2> next{};
  for (const int length : lengths) {
    if (length > 0) ++next[static_cast<std::size_t>(length) + 1];
  }
  for (std::size_t length = 1; length < next.size(); ++length)
    next[length] = (next[length] + next[length - 1]) << 1;
  // next[n] was the count of words of n - 1 bits; now it is the first word of n bits.
  HuffmanCode code;
  code.words.resize(counts.size());
  for (std::size_t symbol = 0; symbol < counts.size(); ++symbol) {
    const int length = lengths[symbol];
    if (length == 0) continue;
    const std::uint32_t word = next[static_cast<std::size_t>(length)]++;
    Word& written = code.words[symbol];
    written.length = static_cast<std::uint8_t>(length);
    for (int bit = 0; bit < length; ++bit)
      written.bits = static_cast<std::uint16_t>(written.bits | ((word >> bit & 1U) << (length - 1 - bit)));
  }
  return code;
}

}  // namespace skyquilt::image
