// ValueOf, ErrorOf: what a result holds, for tests that need it; where it holds the other, an empty one and a
// failure.
#pragma once

#include <gtest/gtest.h>

#include <utility>

#include "core/base/result.h"

namespace skyquilt::test {

template <typename Value>
Value ValueOf(Result<Value> result) {
  EXPECT_TRUE(result.ok()) << (result ? "" : result.error().message);
  return result ? *std::move(result) : Value();
}

template <typename Value>
Error ErrorOf(const Result<Value>& result) {
  EXPECT_FALSE(result.ok());
  return result ? Error() : result.error();
}

}  // namespace skyquilt::test
