// LinkTo: an address of this server as a document says it: with the token that the document was asked for
// with in its query, so that whoever may read the document may follow it. A token in a header is never
// written down. Pure; any thread.
#pragma once

#include <string>
#include <string_view>

#include "api/http/http_message.h"

namespace skyquilt::api {

// "token=..." of the request's query, where it is one that we may have made: nothing from outside gets into
// our documents unchecked. Empty otherwise.
std::string TokenInQuery(const Request& request);

// `path` behind `base_url`, with such a token; placeholders ("{z}") are kept as they are.
std::string WithToken(std::string_view base_url, std::string_view path, std::string_view token);
std::string LinkTo(const Request& request, std::string_view path);

// A text as it stands in an address, behind a '=' or as a segment.
std::string EncodedForQuery(std::string_view text);

}  // namespace skyquilt::api
