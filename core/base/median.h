// Median: the middle value; of an even number the upper of the two middles, so that it is always one of the
// values. Takes its values by copy, since finding it reorders them. Precondition: non-empty; MedianIfAny
// is for values of which there may be none, MedianOf for what items have or are made into. Percentile: the
// same for any share. LeastFew: the items with the least values. Pure; any thread.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/check.h"

namespace skyquilt {

template <typename Value>
Value Median(std::vector<Value> values) {
  SKYQUILT_CHECK(!values.empty(), "Median needs at least one value");
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Times the median of what values lie off their middle, their sigma where they are distributed normally.
inline constexpr double kSigmaOfMedian = 1.4826;
// The median length of errors in a plane, in the sigmas of either axis.
inline constexpr double kMedianInPlane = 1.177;

template <typename Value>
std::optional<Value> MedianIfAny(std::vector<Value> values) {
  if (values.empty()) return std::nullopt;
  return Median(std::move(values));
}

// `of`: a member of the items, or a function of one.
template <typename Item, typename Of>
auto MedianOf(const std::vector<Item>& items, const Of& of) {
  std::vector<std::decay_t<std::invoke_result_t<const Of&, const Item&>>> values;
  for (const Item& item : items) values.push_back(std::invoke(of, item));
  return Median(std::move(values));
}

// The value below which a share (0..1) of the values lies; one of the values, 0 for none.
inline double Percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// The items with the least values, `count` at most, the least first; of equals the lesser item.
template <typename Value, typename Item>
std::vector<Item> LeastFew(std::vector<std::pair<Value, Item>> ranked, std::size_t count) {
  count = std::min(count, ranked.size());
  std::partial_sort(ranked.begin(), ranked.begin() + static_cast<std::ptrdiff_t>(count), ranked.end());
  std::vector<Item> items;
  for (std::size_t k = 0; k < count; ++k) items.push_back(ranked[k].second);
  return items;
}

// Of vectors, as Eigen has them, along each axis by itself.
template <typename Vector>
Vector MedianByAxis(const std::vector<Vector>& values) {
  Vector median;
  for (int axis = 0; axis < Vector::SizeAtCompileTime; ++axis) {
    std::vector<double> along;
    for (const Vector& value : values) along.push_back(value[axis]);
    median[axis] = Median(std::move(along));
  }
  return median;
}

}  // namespace skyquilt
