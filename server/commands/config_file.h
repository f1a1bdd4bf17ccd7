// ExpandConfig: options of `serve` out of a file: every "name = value" of it becomes "--name=value" before
// the options of the command line, which therefore count more; so does a variable of the environment. Lines
// that begin with # are comments; values may stand in quotes. Names that the command does not know are
// refused like any unknown option. Errors: kNotFound, kInvalidArgument (a line that is none of this).
#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::server {

// `words`: the command line without the program's name. Unchanged when it is not "serve" with "--config
// FILE".
Result<std::vector<std::string>> ExpandConfig(std::vector<std::string> words);

// The variable of the environment that stands for an option: "public-url" is SKYQUILT_SERVE_PUBLIC_URL.
std::string VariableOf(std::string_view option);

}  // namespace skyquilt::server
