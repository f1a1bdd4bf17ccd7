#include "core/render/map_layer.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>

#include "core/base/text/json_io.h"

namespace skyquilt::render {
namespace {

struct ErrorStop {
  double error_radius_m;
  Rgb colour;
};
// Viridis at equal steps: even to the eye, and readable without telling red from green.
constexpr ErrorStop kErrorStops[] = {{0.01, {68, 1, 84}},     {0.0316, {65, 68, 135}}, {0.1, {42, 120, 142}},
                                     {0.316, {34, 168, 132}}, {1.0, {122, 209, 81}},   {3.16, {189, 222, 38}},
                                     {10.0, {253, 231, 37}}};

Rgb FromHsv(double hue, double saturation, double value) {
  Rgb rgb{};
  for (int c = 0; c < 3; ++c) {
    const double k = std::fmod(std::array{5.0, 3.0, 1.0}[static_cast<std::size_t>(c)] + 6.0 * hue, 6.0);
    const double part = value * (1.0 - saturation * std::clamp(std::min(k, 4.0 - k), 0.0, 1.0));
    rgb[static_cast<std::size_t>(c)] = static_cast<std::uint8_t>(std::lround(255.0 * part));
  }
  return rgb;
}

std::string Hex(const Rgb& colour) {
  return fmt::format("#{:02x}{:02x}{:02x}", colour[0], colour[1], colour[2]);
}

}  // namespace

const char* NameOf(MapLayer layer) {
  switch (layer) {
    case MapLayer::kPhoto:
      return "photo";
    case MapLayer::kError:
      return "error";
    case MapLayer::kHeight:
      return "height";
  }
  return "";
}

std::optional<MapLayer> MapLayerNamed(std::string_view name) {
  for (const MapLayer layer : kMapLayers) {
    if (name == NameOf(layer)) return layer;
  }
  return std::nullopt;
}

std::string LayerFileName(MapLayer layer) { return fmt::format("layer_{}.mbtiles", NameOf(layer)); }

std::vector<Rgb> PhotoColours(std::size_t count) {
  constexpr double kGoldenRatio = 0.6180339887498949;
  std::vector<Rgb> colours;
  colours.reserve(count);
  std::set<Rgb> taken;
  for (std::size_t i = 0; i < count; ++i) {
    const auto n = static_cast<double>(i);
    Rgb colour = FromHsv(std::fmod(n * kGoldenRatio, 1.0), 0.55 + 0.2 * static_cast<double>(i % 3),
                         1.0 - 0.2 * static_cast<double>(i % 2));
    // Thousands of photos: the next colour that is free.
    while (!taken.insert(colour).second) {
      for (std::uint8_t& part : colour) {
        if (++part != 0) break;
      }
    }
    colours.push_back(colour);
  }
  return colours;
}

Rgb ErrorColour(double error_radius_m) {
  if (error_radius_m <= kErrorStops[0].error_radius_m) return kErrorStops[0].colour;
  for (std::size_t i = 1; i < std::size(kErrorStops); ++i) {
    const auto& [from_m, from] = kErrorStops[i - 1];
    const auto& [to_m, to] = kErrorStops[i];
    if (!(error_radius_m <= to_m)) continue;
    const double share = std::log(error_radius_m / from_m) / std::log(to_m / from_m);
    Rgb colour{};
    for (std::size_t c = 0; c < 3; ++c) {
      colour[c] = static_cast<std::uint8_t>(std::lround(from[c] + share * (to[c] - from[c])));
    }
    return colour;
  }
  return std::end(kErrorStops)[-1].colour;
}

Rgb HeightColour(double height_m) {
  const double above = std::clamp(height_m + 32768.0, 0.0, 65535.0 + 255.0 / 256.0);
  const auto parts = static_cast<std::uint32_t>(std::min(std::lround(above * 256.0), 0xffffffL));
  return {static_cast<std::uint8_t>(parts >> 16), static_cast<std::uint8_t>(parts >> 8),
          static_cast<std::uint8_t>(parts)};
}

std::string LayersJson(const std::vector<MapLayer>& layers, const std::vector<std::string>& photo_names,
                       const HeightRange& heights) {
  nlohmann::ordered_json document = nlohmann::ordered_json::object();
  for (const MapLayer layer : layers) {
    nlohmann::ordered_json& entry = document[NameOf(layer)];
    entry["file"] = LayerFileName(layer);
    switch (layer) {
      case MapLayer::kPhoto: {
        entry["shows"] = "the photo that a pixel came from; of two that mix at a seam, the stronger";
        const std::vector<Rgb> colours = PhotoColours(photo_names.size());
        for (std::size_t i = 0; i < colours.size(); ++i) {
          entry["colours"].push_back({{"photo", photo_names[i]}, {"colour", Hex(colours[i])}});
        }
        break;
      }
      case MapLayer::kError:
        entry["shows"] =
            "the error radius of the photo that a pixel came from (1 sigma, horizontal), in metres";
        for (const ErrorStop& stop : kErrorStops) {
          entry["stops"].push_back({{"error_radius_m", stop.error_radius_m}, {"colour", Hex(stop.colour)}});
        }
        break;
      case MapLayer::kHeight:
        entry["shows"] =
            "the height of the ground in metres, counted as the surveyed points' are that place the map; "
            "without such, from the zero that the flight's heights have";
        entry["encoding"] = "terrarium";
        entry["range_m"] = {heights.min_m, heights.max_m};
        entry["metres"] = "R * 256 + G + B / 256 - 32768";
        break;
    }
  }
  return JsonText(document, 2);
}

}  // namespace skyquilt::render
