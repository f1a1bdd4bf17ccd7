#include "core/render/blocks/weigh_block.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/camera/rolling_shutter.h"
#include "core/geo/web_mercator.h"

namespace skyquilt::render {

std::vector<bool> HideGround(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                             const std::vector<std::uint32_t>& photos, const BlockGeometry& block,
                             const std::vector<std::uint8_t>& asked, std::vector<PhotoView>& views) {
  std::vector<bool> from_all;
  if (!ground.HasSteps()) return from_all;
  std::vector<Eigen::Vector3d> centers;
  centers.reserve(photos.size());
  for (const std::uint32_t photo : photos)
    centers.push_back(flight.photos[photo].cam_from_enu.TargetOriginInSource());
  std::vector<std::size_t> hiding;
  for (std::size_t node = 0; node < block.ground_in_enu.size(); ++node) {
    if (asked[node] == 0) continue;
    hiding.clear();
    bool is_seen = false;
    for (std::size_t i = 0; i < views.size(); ++i) {
      if (!views[i].sees_block) continue;
      const camera::Intrinsics& lens = flight.photos[photos[i]].intrinsics;
      const Eigen::Vector2f& pixel = views[i].pixel_in_image[node];
      const bool is_inside = pixel.x() >= 0.0f && pixel.y() >= 0.0f &&
                             pixel.x() < static_cast<float>(lens.width_px) &&
                             pixel.y() < static_cast<float>(lens.height_px);
      if (!is_inside) continue;
      if (ground::IsOccluded(ground, block.ground_in_enu[node], centers[i])) {
        hiding.push_back(i);
      } else {
        is_seen = true;
      }
    }
    if (!is_seen) {
      if (hiding.empty()) continue;
      if (from_all.empty()) from_all.resize(block.ground_in_enu.size());
      from_all[node] = true;
      continue;
    }
    for (const std::size_t i : hiding) {
      if (views[i].is_hidden.empty()) views[i].is_hidden.resize(block.ground_in_enu.size());
      views[i].is_hidden[node] = true;
    }
  }
  return from_all;
}

namespace {

// Over steps nodes are many, so that a photo is asked about those alone where it may show something: where
// the seam map has it; and in cells of which these photos do not show everything, as at the map's edge, every
// photo is.
class ViewsOverSteps {
 public:
  ViewsOverSteps(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                 const BlockCells& cells, const BlockGeometry& geometry,
                 const std::vector<std::uint32_t>& photos)
      : flight_(flight),
        ground_(ground),
        cells_(cells),
        geometry_(geometry),
        photos_(photos),
        nodes_per_cell_(cells.seams.grid.cell_px / geometry.node_step_px),
        views_(photos.size()),
        wanted_(photos.size()) {}

  std::vector<PhotoView> View() && {
    std::vector<Eigen::Vector2i> partly;
    std::vector<std::uint8_t> asked(Nodes(), 0);
    for (int row = 0; row < cells_.side; ++row) {
      for (int column = 0; column < cells_.side; ++column) {
        const Eigen::Vector2i cell(column, row);
        for (const std::size_t place : PlacesAround(cell)) {
          if (wanted_[place].empty()) wanted_[place].resize(Nodes(), 0);
          Mark(cell, wanted_[place]);
        }
        if (cells_.IsWhole(column, row)) continue;
        partly.push_back(cell);
        Mark(cell, asked);
      }
    }
    for (std::size_t i = 0; i < photos_.size(); ++i) {
      if (!wanted_[i].empty()) Look(i, wanted_[i]);
    }
    hidden_from_all_ = HideGround(flight_, ground_, photos_, geometry_, asked, views_);
    std::vector<std::uint8_t> open;  // to all photos
    for (const Eigen::Vector2i& cell : partly) {
      if (IsShown(cell)) continue;
      open.resize(Nodes(), 0);
      Mark(cell, open);
    }
    if (open.empty()) return std::move(views_);
    for (std::size_t i = 0; i < photos_.size(); ++i) Look(i, open);
    HideGround(flight_, ground_, photos_, geometry_, open, views_);
    return std::move(views_);
  }

 private:
  std::size_t Nodes() const { return geometry_.ground_in_enu.size(); }
  std::size_t FirstNode(const Eigen::Vector2i& cell) const {
    return static_cast<std::size_t>(cell.y() * nodes_per_cell_) * geometry_.nodes_per_side +
           static_cast<std::size_t>(cell.x() * nodes_per_cell_);
  }
  void Mark(const Eigen::Vector2i& cell, std::vector<std::uint8_t>& flags) const {
    for (int y = 0; y <= nodes_per_cell_; ++y) {
      const auto first = flags.begin() + static_cast<std::ptrdiff_t>(FirstNode(cell)) +
                         static_cast<std::ptrdiff_t>(y) * geometry_.nodes_per_side;
      std::fill(first, first + nodes_per_cell_ + 1, std::uint8_t{1});
    }
  }

  // Of the photos that the seam map has at a cell and around it.
  std::vector<std::size_t> PlacesAround(const Eigen::Vector2i& cell) const {
    std::vector<std::size_t> places;
    for (const std::uint32_t photo : cells_.PhotosAround(cell.x(), cell.y())) {
      const auto at = std::lower_bound(photos_.begin(), photos_.end(), photo);
      if (at != photos_.end() && *at == photo)
        places.push_back(static_cast<std::size_t>(at - photos_.begin()));
    }
    return places;
  }

  void Look(std::size_t place, const std::vector<std::uint8_t>& wanted) {
    ViewNodes(flight_.photos[photos_[place]], geometry_, wanted, views_[place]);
  }

  bool Shows(std::size_t place, std::size_t node) const {
    const PhotoView& view = views_[place];
    if (!view.is_hidden.empty() && view.is_hidden[node]) return false;
    const camera::Intrinsics& lens = flight_.photos[photos_[place]].intrinsics;
    const Eigen::Vector2f& pixel = view.pixel_in_image[node];
    return pixel.x() >= -0.5f && pixel.y() >= -0.5f &&
           pixel.x() <= static_cast<float>(lens.width_px) - 0.5f &&
           pixel.y() <= static_cast<float>(lens.height_px) - 0.5f;
  }

  // Whether one of the photos around shows each square between four nodes, past all that stands there.
  bool IsShown(const Eigen::Vector2i& cell) const {
    const std::vector<std::size_t> places = PlacesAround(cell);
    const auto below = static_cast<std::size_t>(geometry_.nodes_per_side);
    for (int y = 0; y < nodes_per_cell_; ++y) {
      for (int x = 0; x < nodes_per_cell_; ++x) {
        const std::size_t node =
            FirstNode(cell) + static_cast<std::size_t>(y) * below + static_cast<std::size_t>(x);
        if (!hidden_from_all_.empty() &&
            (hidden_from_all_[node] || hidden_from_all_[node + 1] || hidden_from_all_[node + below] ||
             hidden_from_all_[node + below + 1]))
          return false;
        const bool is_shown = std::any_of(places.begin(), places.end(), [&](std::size_t place) {
          return views_[place].sees_block && Shows(place, node) && Shows(place, node + 1) &&
                 Shows(place, node + below) && Shows(place, node + below + 1);
        });
        if (!is_shown) return false;
      }
    }
    return true;
  }

  const alignment::AlignedFlight& flight_;
  const ground::GroundSurface& ground_;
  const BlockCells& cells_;
  const BlockGeometry& geometry_;
  const std::vector<std::uint32_t>& photos_;
  const int nodes_per_cell_;
  std::vector<PhotoView> views_;                   // by photos_, as the next
  std::vector<std::vector<std::uint8_t>> wanted_;  // by node; empty: nowhere
  std::vector<bool> hidden_from_all_;              // of those that the seam map has, by node
};

}  // namespace

WeighedBlock WeighBlock(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                        const SeamMap& seams, const MosaicPlan& plan, const RenderBlock& block,
                        BlockGeometry geometry) {
  const BlockCells cells(seams, block.tile, plan.block_levels);
  WeighedBlock weighed{cells, std::move(geometry), cells.PhotosOf(block), {}, {}};
  if (ground.HasSteps()) {
    weighed.views = ViewsOverSteps(flight, ground, cells, weighed.geometry, weighed.photos).View();
  } else {
    weighed.views.reserve(weighed.photos.size());
    for (const std::uint32_t photo : weighed.photos)
      weighed.views.push_back(ViewBlock(flight.photos[photo], weighed.geometry));
  }
  weighed.shares = WeighPhotos(flight, weighed.photos, weighed.views, weighed.geometry, cells);
  return weighed;
}

namespace {

using image::PixelBox;

// What a cell's centre is not told of: its own half, the cell and a half that it blends into.
constexpr double kCellsAround = 2.5;
// Where the map ends, pixels beyond the last cell are shown by whoever still sees them.
constexpr double kCellsAroundAtEnd = 6.0;

PixelBox Around(const Eigen::Vector2d& pixel_in_image) {
  constexpr double kBeyondPhotoPx = 1e6;  // beyond any photo, well within whole numbers
  const auto whole = [&](double at) {
    return static_cast<int>(std::floor(std::clamp(at, -kBeyondPhotoPx, kBeyondPhotoPx)));
  };
  const int x = whole(pixel_in_image.x()), y = whole(pixel_in_image.y());
  return {x, y, x + 2, y + 2};
}

}  // namespace

std::vector<PixelBox> ShownRegions(const alignment::AlignedFlight& flight,
                                   const ground::GroundSurface& ground, const SeamMap& seams) {
  std::vector<PixelBox> regions(flight.photos.size());
  const auto include = [&](std::int32_t photo_index, int column, int row) {
    const auto is_nothing = [&](int dx, int dy) {
      return seams.labels.At(column + dx, row + dy) == kNoPhoto;
    };
    const bool is_end = is_nothing(-1, 0) || is_nothing(1, 0) || is_nothing(0, -1) || is_nothing(0, 1);
    const alignment::AlignedPhoto& photo = flight.photos[static_cast<std::size_t>(photo_index)];
    const geo::Vertical vertical =
        flight.frame.VerticalAt(geo::LatLonFromMerc(seams.grid.CellInMerc(column, row)));
    Eigen::Vector3d point = vertical.AtHeight(ground.MeanHeight());
    if (!ground.IsPlane()) point = vertical.AtHeight(ground.HeightAt(point.head<2>()));
    const auto pixel =
        camera::ProjectRolling(photo.intrinsics, photo.cam_from_enu, photo.readout_motion, point);
    if (!pixel) return;
    const double cell_px =
        seams.cell_m * photo.intrinsics.MeanFocalPx() / std::max(1.0, photo.height_above_ground_m);
    PixelBox& region = regions[static_cast<std::size_t>(photo_index)];
    region = region.With(
        Around(*pixel).Grown(static_cast<int>((is_end ? kCellsAroundAtEnd : kCellsAround) * cell_px) + 1));
  };
  // A photo's cells side by side are seen side by side: the outer ones are enough.
  const int columns = seams.labels.columns();
  for (int row = 0; row < seams.labels.rows(); ++row) {
    std::int32_t last = kNoPhoto;
    for (int column = 0, alike = 1; column <= columns; column += alike) {
      alike = column < columns ? seams.labels.AlikeFrom(column, row) : 1;
      const std::int32_t label = seams.labels.At(column, row);  // none beyond the last
      if (label == last) continue;
      if (last != kNoPhoto) include(last, column - 1, row);
      if (label != kNoPhoto) include(label, column, row);
      last = label;
    }
  }
  return regions;
}

PixelBox ShownBy(const PhotoShare& share, int square_px, const PhotoView& view,
                 const BlockGeometry& geometry) {
  Eigen::Vector2f low = Eigen::Vector2f::Constant(INFINITY), high = -low;
  const int cells = std::max(1, square_px / geometry.node_step_px);  // of nodes, along a square
  for (const SquareShare& square : share.squares) {
    const Eigen::Vector2f* nodes =
        view.pixel_in_image.data() +
        static_cast<std::ptrdiff_t>(square.y / geometry.node_step_px) * geometry.nodes_per_side +
        square.x / geometry.node_step_px;
    for (int row = 0; row <= cells; ++row, nodes += geometry.nodes_per_side) {
      for (int column = 0; column <= cells; ++column) {
        if (std::isnan(nodes[column].x())) continue;
        low = low.cwiseMin(nodes[column]);
        high = high.cwiseMax(nodes[column]);
      }
    }
  }
  if (!(low.x() <= high.x())) return {};
  return Around(low.cast<double>()).With(Around(high.cast<double>()));
}

}  // namespace skyquilt::render
