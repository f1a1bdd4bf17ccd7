// How a command of the program ends when it cannot go on.
#pragma once

#include <string>
#include <type_traits>
#include <utility>

#include "core/base/result.h"

namespace skyquilt::server {

// Prints "program: message" to standard error and leaves the command (CLI::RuntimeError): with exit code 130
// where it was cancelled, as a shell has it for Ctrl-C, else with 1.
[[noreturn]] void Fail(const char* program, const Error& error);
// So where what was given cannot be used (kInvalidArgument).
[[noreturn]] void Refuse(const char* program, std::string why);
// The value, or Fail.
template <typename T>
T OrFail(const char* program, Result<T> result) {
  if (!result) Fail(program, result.error());
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}

}  // namespace skyquilt::server
