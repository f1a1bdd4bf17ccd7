#include "core/render/blocks/weigh_block.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "core/render/blocks/hide_ground.h"

namespace skyquilt::render {

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
  weighed.shares =
      WeighPhotos(flight, weighed.photos, weighed.views, weighed.geometry, cells, plan.feather_m);
  return weighed;
}

}  // namespace skyquilt::render
