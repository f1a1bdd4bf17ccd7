// AddGeoJsonRoute: a POST whose body is GeoJSON and whose answer is JSON, computed from it: a question, for
// whoever may read. Any thread.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "api/http/router.h"
#include "core/base/result.h"

namespace skyquilt::api {

// By its Content-Type.
bool IsGeoJson(const Request& request);

// From the body to the answer's text.
using GeoJsonAnswer = std::function<Result<std::string>(const std::string& body)>;

// `what`: what the body is, for who sends something else: line, polygon. `prepare` reads the request's
// parameters before the body is taken; its error is the answer.
void AddGeoJsonRoute(Router& router, std::string_view pattern, std::string what,
                     std::function<Result<GeoJsonAnswer>(const Request&)> prepare);

}  // namespace skyquilt::api
