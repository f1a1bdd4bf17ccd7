// MapLayer: what a map can show beside its picture, as a tileset of its own: which photo every pixel came
// from, how far off it may lie, how high the ground is. Colours are exact (no averaging, no JPEG), so that a
// tool reads the value back. Values and pure functions; any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace skyquilt::render {

enum class MapLayer { kPhoto, kError, kHeight };

inline constexpr std::array kMapLayers{MapLayer::kPhoto, MapLayer::kError, MapLayer::kHeight};

inline constexpr int kLayerTilePx = 256;

using Rgb = std::array<std::uint8_t, 3>;

// "photo", "error", "height": as options, files and addresses name them.
const char* NameOf(MapLayer layer);
std::optional<MapLayer> MapLayerNamed(std::string_view name);
// Of its tileset, in the map's folder.
std::string LayerFileName(MapLayer layer);

// Distinct colours, neighbours in the list far apart. At most 2^24.
std::vector<Rgb> PhotoColours(std::size_t count);

// On a logarithmic scale of stops from 1 cm (dark blue) to 10 m (yellow); beyond, and where it is not
// known (NaN), the last colour.
Rgb ErrorColour(double error_radius_m);

// "Terrarium" coding of heights, which MapLibre, Mapbox and QGIS read: metres = R * 256 + G + B / 256 -
// 32768. https://github.com/tilezen/joerd/blob/master/docs/formats.md
Rgb HeightColour(double height_m);

// What the ground's heights lie between.
struct HeightRange {
  double min_m = 0.0;
  double max_m = 0.0;
};

// What the colours of these layers mean, and which tileset holds each: the text of layers.json. Photos as in
// the flight.
std::string LayersJson(const std::vector<MapLayer>& layers, const std::vector<std::string>& photo_names,
                       const HeightRange& heights);

}  // namespace skyquilt::render
