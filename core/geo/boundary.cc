#include "core/geo/boundary.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/geo/geodesic.h"
#include "core/geo/web_mercator.h"

namespace skyquilt::geo {

void MaskRings(const std::vector<RingEdge>& edges, const MaskWindow& window,
               std::vector<std::uint8_t>& inside) {
  constexpr std::size_t kRowsAtOnce = 256;
  // The first row or column whose middle lies at or beyond a place, counted from the window's corner.
  const auto first_from = [](double place, std::size_t low, std::size_t high) {
    return static_cast<std::size_t>(
        std::clamp(std::ceil(place - 0.5), static_cast<double>(low), static_cast<double>(high)));
  };
  std::vector<std::vector<double>> crossings(std::min(kRowsAtOnce, window.rows));
  for (std::size_t low = 0; low < window.rows; low += kRowsAtOnce) {
    const std::size_t high = std::min(window.rows, low + kRowsAtOnce);
    for (const RingEdge& edge : edges) {
      const std::size_t end = first_from(std::max(edge.y0, edge.y1) - window.top, low, high);
      for (std::size_t row = first_from(std::min(edge.y0, edge.y1) - window.top, low, high); row < end;
           ++row) {
        const double y = window.top + static_cast<double>(row) + 0.5;
        crossings[row - low].push_back(edge.x0 + (y - edge.y0) / (edge.y1 - edge.y0) * (edge.x1 - edge.x0));
      }
    }
    for (std::size_t row = low; row < high; ++row) {
      std::vector<double>& of_row = crossings[row - low];
      std::sort(of_row.begin(), of_row.end());
      const auto begin = inside.begin() + static_cast<std::ptrdiff_t>(row * window.columns);
      for (std::size_t i = 0; i + 1 < of_row.size(); i += 2) {
        const std::size_t first = first_from(of_row[i] - window.left, 0, window.columns),
                          last = first_from(of_row[i + 1] - window.left, 0, window.columns);
        std::fill(begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(last),
                  std::uint8_t{1});
      }
      of_row.clear();
    }
  }
}

namespace {

// Longitudes along a ring as the numbers go on across the antimeridian; all the way around is no step across.
class LonAlong {
 public:
  explicit LonAlong(double first_deg) : last_deg_(first_deg) {}
  double At(double lon_deg) {
    const double step_deg = lon_deg - last_deg_;
    if (std::abs(step_deg) < 360.0) turn_deg_ += std::remainder(step_deg, 360.0) - step_deg;
    last_deg_ = lon_deg;
    return lon_deg + turn_deg_;
  }

 private:
  double last_deg_, turn_deg_ = 0.0;
};

}  // namespace

LatLonBounds Boundary::Bounds() const {
  const LatLon first = polygons.front().front().front();
  LatLonBounds bounds{first.lon_deg, first.lat_deg, first.lon_deg, first.lat_deg};
  for (const Polygon& polygon : polygons) {
    LonAlong along(polygon.front().front().lon_deg);
    for (const LatLon& corner : polygon.front()) {
      const double lon_deg = along.At(corner.lon_deg);
      bounds.Include({lon_deg, corner.lat_deg, lon_deg, corner.lat_deg});
    }
  }
  return bounds.OnEarth();
}

double AreaM2(const Boundary& boundary) {
  double area_m2 = 0.0;
  for (const Boundary::Polygon& polygon : boundary.polygons) {
    for (std::size_t ring = 0; ring < polygon.size(); ++ring)
      area_m2 += (ring == 0 ? 1.0 : -1.0) * GeodesicAreaM2(polygon[ring]);
  }
  return std::max(area_m2, 0.0);
}

namespace {

// Beyond 0 on the one side of the edge, below it on the other.
double SideOf(const RingEdge& edge, double x, double y) {
  return (edge.x1 - edge.x0) * (y - edge.y0) - (edge.y1 - edge.y0) * (x - edge.x0);
}

bool DoCross(const RingEdge& a, const RingEdge& b) {
  for (const auto& [x, y] : {std::pair{b.x0, b.y0}, std::pair{b.x1, b.y1}}) {
    if ((x == a.x0 && y == a.y0) || (x == a.x1 && y == a.y1)) return false;
  }
  return SideOf(a, b.x0, b.y0) * SideOf(a, b.x1, b.y1) < 0.0 &&
         SideOf(b, a.x0, a.y0) * SideOf(b, a.x1, a.y1) < 0.0;
}

// The edges of a ring in Web Mercator, each from west to east; across the antimeridian the numbers go on.
std::vector<RingEdge> EdgesInMerc(const Boundary::Ring& ring) {
  std::vector<RingEdge> edges;
  LonAlong along(ring.front().lon_deg);
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i <= ring.size(); ++i) {
    const LatLon& corner = ring[i % ring.size()];
    const Eigen::Vector2d to =
        MercFromLatLon({std::clamp(corner.lat_deg, -85.06, 85.06), along.At(corner.lon_deg)});
    if (i > 0 && from.x() < to.x()) edges.push_back({from.x(), from.y(), to.x(), to.y()});
    if (i > 0 && from.x() >= to.x()) edges.push_back({to.x(), to.y(), from.x(), from.y()});
    from = to;
  }
  return edges;
}

}  // namespace

bool CrossesItself(const Boundary& boundary) {
  std::size_t looks_left = 50'000'000;  // all pairs of ten thousand edges
  for (const Boundary::Polygon& polygon : boundary.polygons) {
    for (const Boundary::Ring& ring : polygon) {
      std::vector<RingEdge> edges = EdgesInMerc(ring);
      std::sort(edges.begin(), edges.end(), [](const RingEdge& a, const RingEdge& b) { return a.x0 < b.x0; });
      for (std::size_t i = 0; i < edges.size(); ++i) {
        for (std::size_t k = i + 1; k < edges.size() && edges[k].x0 < edges[i].x1; ++k) {
          if (looks_left == 0) return false;
          --looks_left;
          if (DoCross(edges[i], edges[k])) return true;
        }
      }
    }
  }
  return false;
}

namespace {

// Of a ring what lies on one side of a meridian or parallel (Sutherland and Hodgman 1974): where `of` is not
// below `line` (sign 1) or not above it (sign -1).
Boundary::Ring CutAtLine(const Boundary::Ring& ring, double LatLon::*of, double sign, double line) {
  Boundary::Ring cut;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const LatLon &from = ring[i], &to = ring[(i + 1) % ring.size()];
    const double a = sign * (from.*of - line), b = sign * (to.*of - line);
    if (a >= 0.0) cut.push_back(from);
    if ((a >= 0.0) == (b >= 0.0)) continue;
    const double share = a / (a - b);
    LatLon at{from.lat_deg + share * (to.lat_deg - from.lat_deg),
              from.lon_deg + share * (to.lon_deg - from.lon_deg)};
    at.*of = line;
    cut.push_back(at);
  }
  return cut;
}

}  // namespace

Boundary CutTo(const Boundary& boundary, const LatLonBounds& bounds) {
  Boundary all;
  for (const Boundary::Polygon& polygon : boundary.polygons) {
    Boundary::Polygon part;
    for (const Boundary::Ring& ring : polygon) {
      Boundary::Ring cut = CutAtLine(ring, &LatLon::lon_deg, 1.0, bounds.west_deg);
      cut = CutAtLine(cut, &LatLon::lon_deg, -1.0, bounds.east_deg);
      cut = CutAtLine(cut, &LatLon::lat_deg, 1.0, bounds.south_deg);
      cut = CutAtLine(cut, &LatLon::lat_deg, -1.0, bounds.north_deg);
      if (cut.size() >= 3) part.push_back(std::move(cut));
    }
    if (!part.empty()) all.polygons.push_back(std::move(part));
  }
  return all;
}

BoundaryOnZoom::BoundaryOnZoom(const Boundary& boundary, int zoom, int tile_size_px)
    : tile_size_px_(tile_size_px) {
  const double pixel_merc_m = PixelSizeInMercM(zoom, tile_size_px);
  const double world_px = 2.0 * kMercHalfWidthM / pixel_merc_m;
  for (const Boundary::Polygon& polygon : boundary.polygons) {
    std::vector<RingEdge> edges;
    double west_px = world_px, east_px = 0.0;
    for (const Boundary::Ring& ring : polygon) {
      LonAlong along(polygon.front().front().lon_deg);
      Eigen::Vector2d from = Eigen::Vector2d::Zero();
      for (std::size_t i = 0; i <= ring.size(); ++i) {
        // Beyond the square of the tiles there are none: clamped, a pole is not infinitely far.
        LatLon corner = ring[i % ring.size()];
        corner.lat_deg = std::clamp(corner.lat_deg, -85.06, 85.06);
        corner.lon_deg = along.At(corner.lon_deg);
        const Eigen::Vector2d merc = MercFromLatLon(corner);
        const Eigen::Vector2d to((merc.x() + kMercHalfWidthM) / pixel_merc_m,
                                 (kMercHalfWidthM - merc.y()) / pixel_merc_m);
        if (i > 0) edges.push_back({from.x(), from.y(), to.x(), to.y()});
        west_px = std::min(west_px, to.x()), east_px = std::max(east_px, to.x());
        from = to;
      }
    }
    // What lies beyond the square of the tiles is on its other side.
    for (const double turn_px :
         {west_px < -0.5 ? world_px : 0.0, east_px > world_px + 0.5 ? -world_px : 0.0}) {
      if (turn_px == 0.0) continue;
      std::vector<RingEdge>& turned = polygons_.emplace_back(edges);
      for (RingEdge& edge : turned) edge.x0 += turn_px, edge.x1 += turn_px;
    }
    polygons_.push_back(std::move(edges));
  }
}

Cover BoundaryOnZoom::Mask(const TileId& tile, std::vector<std::uint8_t>& inside) const {
  const auto side = static_cast<std::size_t>(tile_size_px_);
  const double left = static_cast<double>(tile.x()) * tile_size_px_,
               top = static_cast<double>(tile.y()) * tile_size_px_;
  inside.assign(side * side, 0);
  for (const std::vector<RingEdge>& edges : polygons_) MaskRings(edges, {left, top, side, side}, inside);
  const auto count = static_cast<std::size_t>(std::count(inside.begin(), inside.end(), std::uint8_t{1}));
  return count == 0 ? Cover::kNone : count == inside.size() ? Cover::kAll : Cover::kPart;
}

Cover BoundaryOnZoom::CoverOf(const TileId& tile) const {
  const double left = static_cast<double>(tile.x()) * tile_size_px_,
               top = static_cast<double>(tile.y()) * tile_size_px_;
  const double right = left + tile_size_px_, bottom = top + tile_size_px_;
  bool is_covered = false;
  for (const std::vector<RingEdge>& edges : polygons_) {
    bool is_inside = false;  // the tile's first row, by how many edges lie west of it
    for (const RingEdge& edge : edges) {
      const double north = std::min(edge.y0, edge.y1), south = std::max(edge.y0, edge.y1);
      if (north > bottom || south < top || std::min(edge.x0, edge.x1) > right) continue;
      if (std::max(edge.x0, edge.x1) >= left) {
        std::vector<std::uint8_t> inside;
        return Mask(tile, inside);
      }
      if ((edge.y0 <= top + 0.5) != (edge.y1 <= top + 0.5)) is_inside = !is_inside;
    }
    is_covered |= is_inside;
  }
  return is_covered ? Cover::kAll : Cover::kNone;
}

}  // namespace skyquilt::geo
