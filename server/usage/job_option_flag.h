// AddJobOption: an option of a command that makes maps, as the table of job options has it
// (core/pipeline/mosaic_options.h). Ranges are checked by MosaicOptions::Validate. One thread.
#pragma once

#include <string_view>

#include "core/pipeline/mosaic_options.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace skyquilt::server {

// `name` as in the table; `options` outlives the command line.
CLI::Option* AddJobOption(CLI::App& command, std::string_view name, pipeline::MosaicOptions& options);

}  // namespace skyquilt::server
