// ExpandConfig: options of `serve` from a file: every "name = value" becomes "--name=value" before the
// options of the command line, which therefore take precedence; so does an environment variable. Lines that
// begin with # are comments; values may be quoted. Names that the command does not know are refused like any
// unknown option. Errors: kNotFound, kInvalidArgument (a line of another form).
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
