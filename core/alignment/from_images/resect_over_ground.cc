#include <Eigen/Dense>
#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include "core/alignment/from_images/grow_block.h"
#include "core/base/median.h"
#include "core/base/parallel_for.h"
#include "core/geo/rigid3.h"

namespace skyquilt::alignment {
namespace {

using Eigen::Vector3d;

constexpr int kMinPointsOfGround = 12;
constexpr double kMinSteepness = 0.2;  // sine of the angle between a ray and level ground

// The ground below a block's photos, level where each of them looks: at the height of the points that it
// sees, parallel to the plane through all. For what a photo shows that is no point of the block. Keeps a
// reference to its block, which must not move meanwhile.
class BlockGround {
 public:
  explicit BlockGround(const Block& block) : block_(&block), level_(block.input().Photos(), 0.0) {
    std::vector<int> points;
    for (std::size_t t = 0; t < block.scene().size(); ++t) {
      if (!block.HasPoint(t)) continue;
      points.push_back(static_cast<int>(t));
      middle_ += block.Point(t);
    }
    if (static_cast<int>(points.size()) < kMinPointsOfGround) return;
    middle_ /= static_cast<double>(points.size());
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const int t : points) spread += (block.Point(t) - middle_) * (block.Point(t) - middle_).transpose();
    Vector3d up = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(0);
    double above = 0.0;
    for (std::size_t i = 0; i < level_.size(); ++i) {
      if (block.Has(i)) above += up.dot(block.Pose(i).TargetOriginInSource() - middle_);
    }
    if (above < 0.0) up = -up;
    ground_from_world_ = geo::RotationToZ(up);
    std::vector<std::vector<double>> seen(level_.size());
    for (const int t : points) {
      const auto& track = block.scene()[t];
      for (const int s : block.SeenBy(t)) {
        const int photo = track[s].photo;
        seen[photo].push_back(OnGround(block.Point(t)).z());
      }
    }
    for (std::size_t i = 0; i < level_.size(); ++i) {
      if (!seen[i].empty()) level_[i] = Median(std::move(seen[i]));
    }
    is_known_ = true;
  }

  // False where the block has too few points to say where the ground is.
  bool is_known() const { return is_known_; }
  // Where a pixel of a placed photo meets it, in the block's world; nothing near or beyond the horizon.
  std::optional<Vector3d> Lift(int photo, const Eigen::Vector2d& pixel_in_image) const {
    const geo::Rigid3& pose = block_->Pose(photo);
    const Vector3d ray_in_world = pose.rotation.conjugate() * block_->Lens(photo).Unproject(pixel_in_image);
    const double falls = -(ground_from_world_ * ray_in_world).z();
    const double height = HeightAbove(pose, photo);
    if (height <= 0.0 || falls < kMinSteepness * ray_in_world.norm()) return std::nullopt;
    return pose.TargetOriginInSource() + height / falls * ray_in_world;
  }
  // Of any camera above the ground below a placed photo, in units of the world.
  double HeightAbove(const geo::Rigid3& cam_from_world, int photo) const {
    return OnGround(cam_from_world.TargetOriginInSource()).z() - level_[photo];
  }

 private:
  Vector3d OnGround(const Vector3d& in_world) const { return ground_from_world_ * (in_world - middle_); }

  const Block* block_;
  std::vector<double> level_;  // by photo
  Vector3d middle_ = Vector3d::Zero();
  Eigen::Quaterniond ground_from_world_ = Eigen::Quaterniond::Identity();
  bool is_known_ = false;
};

constexpr double kGroundSigmas = 3.0;       // the ground is not quite level
constexpr int kMinOverGround = 24;          // matches that agree
constexpr int kManyOfOnePair = 30;          // matches of one pair that need no other to agree,
constexpr double kMinShareOfOnePair = 0.8;  // if they are nearly all
constexpr int kFewOfAPair = 6;
constexpr double kMinShareOverGround = 0.5;
constexpr double kMaxHeightStep = 6.0;  // a climb
constexpr int kGroundPoseSamples = 300;

// Where on the ground placed photos show what this one shows; which of them, in `partners`.
std::vector<PointObservation> ShownOnGround(const Block& block, const BlockGround& ground,
                                            const std::vector<const PhotoPair*>& pairs, int photo,
                                            std::vector<int>& partners) {
  std::vector<PointObservation> shown;
  const auto keypoint = [&](int of, int k) -> const Keypoint& {
    return block.input().features[of]->keypoints[k];
  };
  for (const PhotoPair* pair : pairs) {
    const bool leads = pair->first == photo;
    const int partner = leads ? pair->second : pair->first;
    for (const KeypointMatch& match : pair->matches) {
      const Keypoint& own = keypoint(photo, leads ? match.first : match.second);
      const Keypoint& other = keypoint(partner, leads ? match.second : match.first);
      const auto point = ground.Lift(partner, {other.x_px, other.y_px});
      if (!point) continue;
      const double sigma_px = kGroundSigmas * block.input().features[photo]->sigma_px;
      shown.push_back({{own.x_px, own.y_px}, *point, sigma_px});
      partners.push_back(partner);
    }
  }
  return shown;
}

std::optional<FoundPose> ResectOne(const Block& block, const BlockGround& ground,
                                   const std::vector<const PhotoPair*>& pairs, int photo) {
  std::vector<int> partners;
  const std::vector<PointObservation> observations = ShownOnGround(block, ground, pairs, photo, partners);
  if (static_cast<int>(observations.size()) < kMinOverGround) return std::nullopt;
  const int min_inliers = std::max(
      kMinOverGround, static_cast<int>(kMinShareOverGround * static_cast<double>(observations.size())));
  auto found = FindPose(block.Lens(photo), observations, 0x6E0DULL + static_cast<std::uint64_t>(photo),
                        {.min_inliers = min_inliers, .max_samples = kGroundPoseSamples});
  if (!found) return std::nullopt;
  std::map<int, int> of_partner;
  for (const int k : found->inliers) ++of_partner[partners[k]];
  int agreeing_partners = 0, most = 0, nearest = -1;
  for (const auto& [partner, matches] : of_partner) {
    agreeing_partners += matches >= kFewOfAPair ? 1 : 0;
    if (matches > most) most = matches, nearest = partner;
  }
  const bool is_one_enough =
      most >= kManyOfOnePair && most >= kMinShareOfOnePair * static_cast<double>(observations.size());
  if (agreeing_partners < 2 && !is_one_enough) return std::nullopt;
  const double height = ground.HeightAbove(found->cam_from_world, nearest);
  const double usual = ground.HeightAbove(block.Pose(nearest), nearest);
  if (height < usual / kMaxHeightStep || height > usual * kMaxHeightStep) return std::nullopt;
  found->photo = photo;
  return found;
}

}  // namespace

std::vector<FoundPose> ResectOverGround(const Block& block, const PhotoSet& left_out, int threads) {
  std::map<int, std::vector<const PhotoPair*>> of_photo;
  for (const PhotoPair& pair : block.input().links) {
    for (const auto& [photo, partner] :
         {std::pair(pair.first, pair.second), std::pair(pair.second, pair.first)}) {
      if (!left_out.Has(photo) && !block.Has(photo) && block.Has(partner)) of_photo[photo].push_back(&pair);
    }
  }
  if (of_photo.empty()) return {};
  const BlockGround ground(block);
  if (!ground.is_known()) return {};
  const std::vector<std::pair<int, std::vector<const PhotoPair*>>> asked(of_photo.begin(), of_photo.end());
  std::vector<FoundPose> poses = ParallelCollect(asked.size(), threads, [&](std::size_t k) {
    return ResectOne(block, ground, asked[k].second, asked[k].first);
  });
  std::stable_sort(poses.begin(), poses.end(), [](const FoundPose& a, const FoundPose& b) {
    return a.inliers.size() > b.inliers.size();
  });
  return poses;
}

}  // namespace skyquilt::alignment
