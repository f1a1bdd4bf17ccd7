// AcceptedQuality: how much a client wants a media type, by its Accept header (RFC 9110 12.5.1), in
// thousandths; 0: it does not take it. The closest range counts; without a header everything is welcome.
// NamesType: whether it stands there itself, not within a range: many who send "*/*" mean what they have
// known for long; of codings (Accept-Encoding) as well. Pure.
#pragma once

#include <string_view>

namespace skyquilt::api {

int AcceptedQuality(std::string_view accept, std::string_view type);
bool NamesType(std::string_view accept, std::string_view type);

}  // namespace skyquilt::api
