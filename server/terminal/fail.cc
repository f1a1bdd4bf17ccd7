#include "server/terminal/fail.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "server/terminal/tell.h"

namespace skyquilt::server {

void Fail(const char* program, const Error& error) {
  Tell(fmt::format("{}: {}\n", program, error.message));
  throw CLI::RuntimeError(error.code == ErrorCode::kCancelled ? 130 : 1);
}

void Refuse(const char* program, std::string why) {
  Fail(program, {ErrorCode::kInvalidArgument, std::move(why)});
}

}  // namespace skyquilt::server
