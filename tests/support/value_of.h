// ValueOf, ErrorOf: what a result holds, for tests that need it; a result that holds the other fails the test
// and ends it.
#pragma once

#include <stdexcept>
#include <utility>

#include "core/base/result.h"

namespace skyquilt::test {

template <typename Value>
Value ValueOf(Result<Value> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return *std::move(result);
}

template <typename Value>
Error ErrorOf(const Result<Value>& result) {
  if (result) throw std::runtime_error("a value where an error is expected");
  return result.error();
}

}  // namespace skyquilt::test
