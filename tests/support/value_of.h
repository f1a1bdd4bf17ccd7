// ValueOf: what a result holds, for tests that need it; where it holds an error an empty value, and a failure
// with its message.
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

}  // namespace skyquilt::test
