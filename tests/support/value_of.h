// ValueOf, ErrorOf: what a result or an optional holds, for tests that need it; one that does not hold it
// fails the test and ends it.
#pragma once

#include <optional>
#include <stdexcept>
#include <utility>

#include "core/base/result.h"

namespace skyquilt::test {

template <typename Value>
Value ValueOf(Result<Value> result) {
  if (!result) throw std::runtime_error(result.error().message + " " + result.error().detail);
  return *std::move(result);
}

template <typename Value>
Value ValueOf(std::optional<Value> found) {
  if (!found) throw std::runtime_error("nothing where a value is expected");
  return *std::move(found);
}

template <typename Value>
Error ErrorOf(const Result<Value>& result) {
  if (result) throw std::runtime_error("a value where an error is expected");
  return result.error();
}

}  // namespace skyquilt::test
