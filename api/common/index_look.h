// IndexLook: which index of a map a request asks for, and how it is coloured:
//   index=ndvi, or expression=(nir-red)/(nir+red)
//   rescale=-1,1    the values of the two ends of the ramp
//   colormap=rdylgn the ramp; "_r" behind it turns it round
// A named index brings its own range and ramp; an expression goes from -1 to 1 on rdylgn. Whether a map has
// the bands is not its matter (index_values.h). A value; any thread. Errors: kInvalidArgument; the message
// teaches.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "api/http/http_message.h"
#include "core/indices/band_expression.h"
#include "core/indices/colour_ramp.h"
#include "core/indices/spectral_index.h"

namespace skyquilt::api {

struct IndexLook {
  std::string name;   // "ndvi"; empty: an expression of the user's own
  std::string title;  // "NDVI", or the expression
  std::string text;   // the expression
  indices::BandExpression expression;
  double least = -1.0, most = 1.0;
  std::string ramp_name;
  indices::ColourRamp ramp;

  // As the parameters of an address, each said: "index=ndvi&rescale=0,1&colormap=rdylgn".
  std::string Query() const;
};

// Absent: the request asks for no index.
Result<std::optional<IndexLook>> LookIn(const Request& request);
// Of a request that must name one.
Result<IndexLook> LookRequiredIn(const Request& request);
IndexLook LookOf(const indices::SpectralIndex& index);
// Of a style of WMS or WMTS: "default" and nothing at all are the map itself. Error: kInvalidArgument.
Result<std::optional<IndexLook>> LookOfStyle(std::string_view style);

}  // namespace skyquilt::api
