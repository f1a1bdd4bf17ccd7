// The options of a job: what a client may choose, from JSON to MosaicOptions. The API checks them when a job
// is queued; the worker reads the same text again. Pure. Errors: kInvalidArgument (not JSON), kUnprocessable
// (unknown field, wrong kind, outside its range).
#pragma once

#include <string_view>

#include "core/base/result.h"
#include "core/pipeline/mosaic_options.h"

namespace skyquilt::api {

Result<pipeline::MosaicOptions> ParseJobOptions(std::string_view json);

}  // namespace skyquilt::api
