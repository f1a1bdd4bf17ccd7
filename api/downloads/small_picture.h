// SmallPicture: the whole map as a WebP of a few kilobytes, for lists: made from the map's thumbnail when it
// is asked for, kept with the tiles that were made (storage::MadeTiles). `?size=` is its longer side, one of
// few, so that no client fills that memory with sizes; the largest, of about a hundred kilobytes, is drawn
// from the tiles. Any thread.
// Errors: kInvalidArgument (a size there is not), kNotFound (a map without thumbnail, or one that was
// replaced), kCorrupt, kIo.
#pragma once

#include <string>

#include "api/common/find_flight.h"
#include "api/http/http_message.h"
#include "api/service.h"

namespace skyquilt::api {

Result<Response> SmallPicture(Service& service, const Request& request, const std::string& flight_id,
                              const ShownMap& map);

}  // namespace skyquilt::api
