#include "core/surface/views/match_tile.h"

namespace skyquilt::surface {
namespace {

// Photos whose census differs in more bits than this show something else; unlike pictures differ in 24.
constexpr std::uint8_t kMaxAgreeingBits = 15;
constexpr int kSeenSquare = 4;  // cells that are asked for together whether a photo shows them
constexpr std::uint8_t kUnknownCost = BetterHalf::kMaxCost / 2;

}  // namespace

const GrayPyramid* BlockPhotos::Pyramid(std::size_t camera) {
  const auto [found, is_new] = held_.try_emplace(camera);
  if (is_new) {
    const SurfaceCamera& wanted = cameras_[camera];
    found->second = photos_.Get(wanted.photo, flight_.photos[wanted.photo].photo,
                                GrayDenominator(wanted.CellInPhotoPx(finest_cell_m_)));
  }
  return found->second.get();
}

bool TileMatcher::Lay(const MatchedTile& tile, const std::vector<float>& low_m, double raised_m,
                      double span_m, int heights) {
  if (tile.cameras.size() < 2) return false;
  laid_.cell_m = frame_.cell_m;
  laid_.columns = tile.columns + 2 * kCensusRadius;
  laid_.rows = tile.rows + 2 * kCensusRadius;
  laid_.first_in_enu = frame_.first_in_enu +
                       frame_.cell_m * Eigen::Vector2d(tile.column - kCensusRadius, tile.row - kCensusRadius);
  shape_ = {tile.columns, tile.rows};
  plane_size_ = shape_.PlaneSize();
  low_m_.resize(laid_.Count());
  std::size_t to = 0;
  for (int row = -kCensusRadius; row < tile.rows + kCensusRadius; ++row) {
    const int from_row = std::clamp(tile.row + row, 0, frame_.rows - 1);
    for (int column = -kCensusRadius; column < tile.columns + kCensusRadius; ++column, ++to) {
      const int from_column = std::clamp(tile.column + column, 0, frame_.columns - 1);
      low_m_[to] = low_m[frame_.IndexOf(from_column, from_row)] + static_cast<float>(raised_m);
    }
  }
  used_ = 0;
  patches_.resize(std::max(patches_.size(), tile.cameras.size()));
  for (const std::size_t camera : tile.cameras) {
    const GrayPyramid* pyramid = photos_.Pyramid(camera);
    if (pyramid != nullptr &&
        patches_[used_].Prepare(photos_.Camera(camera), *pyramid, laid_, low_m_, span_m, heights)) {
      ++used_;
    }
  }
  if (used_ < 2) return false;
  shown_.resize(std::max(shown_.size(), used_));
  census_.resize(std::max(census_.size(), used_));
  views_.clear();
  for (std::size_t view = 0; view < used_; ++view) {
    shown_[view].resize(laid_.Count());
    census_[view].resize(kCensusPlanes * plane_size_);
    views_.push_back({census_[view].data(), patches_[view].Unseen().data()});
  }
  return true;
}

void TileMatcher::SampleAll(int height) {
  for (std::size_t view = 0; view < used_; ++view) {
    patches_[view].Sample(height, shown_[view].data());
    FillCensus(shown_[view].data(), shown_[view].data(), shape_, census_[view].data());
  }
}

void TileMatcher::TakeGray(const MatchedTile& tile, std::vector<std::uint8_t>& gray) const {
  for (int row = 0; row < tile.rows; ++row) {
    for (int column = 0; column < tile.columns; ++column) {
      const std::size_t cell = shape_.IndexOf(column, row);
      const std::size_t laid =
          static_cast<std::size_t>(row + kCensusRadius) * laid_.columns + column + kCensusRadius;
      std::size_t view = 0;
      while (view + 1 < used_ && views_[view].unseen[cell] != 0) ++view;
      gray[frame_.IndexOf(tile.column + column, tile.row + row)] = shown_[view][laid];
    }
  }
}

void TileMatcher::FillPlanes(const MatchedTile& tile, const std::vector<float>& low_m, double raised_m,
                             double step_m, int shown_height, std::vector<std::uint8_t>* gray) {
  const bool is_seen = Lay(tile, low_m, raised_m, (kSheetHeights - 1) * step_m, kSheetHeights);
  shape_ = {tile.columns, tile.rows};
  plane_size_ = shape_.PlaneSize();
  planes_.resize(kSheetHeights * plane_size_);
  if (!is_seen) {
    std::fill(planes_.begin(), planes_.end(), kUnknownCost);
    return;
  }
  const BetterHalf better_half(static_cast<int>(used_));
  for (int height = 0; height < kSheetHeights; ++height) {
    SampleAll(height);
    better_half.Fill(views_, plane_size_, planes_.data() + static_cast<std::size_t>(height) * plane_size_);
    if (gray != nullptr && height == shown_height) TakeGray(tile, *gray);
  }
}

void TileMatcher::FillCosts(const MatchedTile& tile, const HeightSheets& sheets, SheetCosts& costs,
                            std::vector<std::uint8_t>& gray) {
  const double step_m = sheets.step_m;
  for (int first = 0; first < sheets.heights; first += kSheetHeights) {
    FillPlanes(tile, sheets.low_m, first * step_m, step_m, sheets.expected_at - first, &gray);
    for (int row = 0; row < tile.rows; ++row) {
      const std::uint8_t* from = planes_.data() + shape_.IndexOf(0, row);
      std::uint8_t* to = costs.first.data() + frame_.IndexOf(tile.column, tile.row + row) * sheets.heights +
                         static_cast<std::size_t>(first);
      for (int column = 0; column < tile.columns; ++column, ++from, to += sheets.heights) {
        for (std::size_t height = 0; height < kSheetHeights; ++height)
          to[height] = from[height * plane_size_];
      }
    }
  }
  const std::int32_t* seconds = sheets.second.data();
  const MatchedTile part = PartWith(
      tile, [&](int column, int row) { return seconds[frame_.IndexOf(column, row)] != HeightSheets::kNone; });
  if (part.columns == 0) return;
  FillPlanes(part, sheets.second_low_m, 0.0, step_m, -1, nullptr);
  for (int row = 0; row < part.rows; ++row) {
    for (int column = 0; column < part.columns; ++column) {
      const std::int32_t second = sheets.second[frame_.IndexOf(part.column + column, part.row + row)];
      if (second == HeightSheets::kNone) continue;
      const std::uint8_t* from = planes_.data() + shape_.IndexOf(column, row);
      std::uint8_t* to = costs.second.data() + static_cast<std::size_t>(second) * kSheetHeights;
      for (std::size_t height = 0; height < kSheetHeights; ++height) to[height] = from[height * plane_size_];
    }
  }
}

void TileMatcher::FillAgreeing(const MatchedTile& tile, const std::vector<float>& heights_m,
                               std::vector<std::uint8_t>& agreeing, std::vector<std::uint8_t>& gray) {
  if (!Lay(tile, heights_m, 0.0, 0.0, 1)) return;
  SampleAll(0);
  TakeGray(tile, gray);
  counted_.resize(plane_size_);
  CountAgreeing(views_, plane_size_, kMaxAgreeingBits, counted_.data());
  for (int row = 0; row < tile.rows; ++row) {
    std::copy_n(counted_.data() + shape_.IndexOf(0, row), tile.columns,
                agreeing.data() + frame_.IndexOf(tile.column, tile.row + row));
  }
}

void TileMatcher::FillSeen(const MatchedTile& tile, const std::vector<std::size_t>& cameras,
                           const std::vector<float>& heights_m, std::vector<std::uint8_t>& seen) const {
  for (int low = 0; low < tile.rows; low += kSeenSquare) {
    const int high = std::min(tile.rows, low + kSeenSquare);
    for (int left = 0; left < tile.columns; left += kSeenSquare) {
      const int right = std::min(tile.columns, left + kSeenSquare);
      const int column = tile.column + (left + right) / 2, row = tile.row + (low + high) / 2;
      const Eigen::Vector2d place = frame_.first_in_enu + frame_.cell_m * Eigen::Vector2d(column, row);
      const Eigen::Vector3d point(place.x(), place.y(), heights_m[frame_.IndexOf(column, row)]);
      const bool is_seen = std::any_of(cameras.begin(), cameras.end(), [&](std::size_t camera) {
        return photos_.Camera(camera).Sees(point);
      });
      for (int y = low; y < high; ++y) {
        const auto from = static_cast<std::ptrdiff_t>(frame_.IndexOf(tile.column + left, tile.row + y));
        std::fill_n(seen.begin() + from, right - left, static_cast<std::uint8_t>(is_seen ? 1 : 0));
      }
    }
  }
}

void TileMatcher::CompareOthers(const MatchedTile& tile, const std::vector<float>& heights_m,
                                const std::vector<float>& others_m, std::vector<std::int16_t>& worse) {
  if (!Lay(tile, heights_m, 0.0, 0.0, 1)) return;
  SampleAll(0);
  planes_.resize(2 * plane_size_);
  // The best pair alone: at the foot of a wall there may be no more that see it.
  const BetterHalf better_half(2);
  better_half.Fill(views_, plane_size_, planes_.data());
  around_.resize(std::max(around_.size(), used_));
  for (std::size_t view = 0; view < used_; ++view) around_[view] = shown_[view];
  const std::size_t seen_by = used_;
  if (!Lay(tile, others_m, 0.0, 0.0, 1) || used_ != seen_by) return;
  for (std::size_t view = 0; view < used_; ++view) {
    patches_[view].Sample(0, shown_[view].data());
    FillCensus(shown_[view].data(), around_[view].data(), shape_, census_[view].data());
  }
  better_half.Fill(views_, plane_size_, planes_.data() + plane_size_);
  for (int row = 0; row < tile.rows; ++row) {
    const std::uint8_t* here = planes_.data() + shape_.IndexOf(0, row);
    std::int16_t* to = worse.data() + frame_.IndexOf(tile.column, tile.row + row);
    for (int column = 0; column < tile.columns; ++column) {
      to[column] =
          static_cast<std::int16_t>(here[plane_size_ + static_cast<std::size_t>(column)] - here[column]);
    }
  }
}

}  // namespace skyquilt::surface
