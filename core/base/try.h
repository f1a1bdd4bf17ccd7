// Hand an error on to the caller. For functions that return a Result.
//
//   SKYQUILT_TRY(WriteHead(file));                                    // Result<void>, or a value nobody
//   needs SKYQUILT_TRY_ASSIGN(const TileId tile, TileId::Make(z, x, y));    // declares `tile`
//   SKYQUILT_TRY_ASSIGN(state->writer, MbtilesWriter::Create(path));  // assigns
//
// The expression is evaluated once; where it holds an error the function returns that error.
// SKYQUILT_TRY_ASSIGN is three statements: it cannot be the body of an `if` without braces. A declaration
// with a comma of its own
// (`std::map<K, V> m`) needs `auto`; the expression may have commas.
#pragma once

#include <utility>

#include "core/base/result.h"

#define SKYQUILT_TRY(...) SKYQUILT_TRY_AS_(SKYQUILT_TRY_NAME_(__COUNTER__), __VA_ARGS__)
#define SKYQUILT_TRY_ASSIGN(target, ...) \
  SKYQUILT_TRY_ASSIGN_AS_(SKYQUILT_TRY_NAME_(__COUNTER__), target, __VA_ARGS__)

// Names of its own for every use, so that uses in one scope, or within a lambda of the expression, do not
// meet.
#define SKYQUILT_TRY_JOIN_(a, b) a##b
#define SKYQUILT_TRY_NAME_(number) SKYQUILT_TRY_JOIN_(skyquilt_try_, number)
#define SKYQUILT_TRY_AS_(result, ...)                                      \
  do {                                                                     \
    if (const auto result = (__VA_ARGS__); !result) return result.error(); \
  } while (false)
#define SKYQUILT_TRY_ASSIGN_AS_(result, target, ...) \
  auto result = (__VA_ARGS__);                       \
  if (!result) return result.error();                \
  target = *std::move(result)
