// OpenCV's Stitcher in its mode for flat scans, as a peer to compare with: stitch_scans DIR [PICTURE]
// Prints one line a photo that it placed: its name and where its middle lies in the picture, in pixels (x,
// y).
#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/stitching.hpp>
#include <string>
#include <vector>

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: {} DIR [PICTURE]\n", argv[0]);
    return 2;
  }
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(argv[1])) paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  std::vector<cv::Mat> photos;
  for (const std::filesystem::path& path : paths) {
    photos.push_back(cv::imread(path.string(), cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION));
  }
  const cv::Ptr<cv::Stitcher> stitcher = cv::Stitcher::create(cv::Stitcher::SCANS);
  if (const cv::Stitcher::Status status = stitcher->estimateTransform(photos); status != cv::Stitcher::OK) {
    fmt::print(stderr, "it gave up: {}\n",
               status == cv::Stitcher::ERR_NEED_MORE_IMGS        ? "too few photos match"
               : status == cv::Stitcher::ERR_HOMOGRAPHY_EST_FAIL ? "no transforms fit"
                                                                 : "the adjustment failed");
    return 1;
  }
  // Its cameras hold the affine map from the picture to the photo at the working scale; back it goes as its
  // own warper does.
  const std::vector<int> component = stitcher->component();
  const std::vector<cv::detail::CameraParams> cameras = stitcher->cameras();
  for (std::size_t i = 0; i < component.size(); ++i) {
    cv::Mat photo_from_picture;
    cameras[i].R.convertTo(photo_from_picture, CV_64F);
    const cv::Mat turn = photo_from_picture(cv::Rect(0, 0, 2, 2));
    const cv::Mat& photo = photos[static_cast<std::size_t>(component[i])];
    const cv::Mat middle = 0.5 * stitcher->workScale() * (cv::Mat_<double>(2, 1) << photo.cols, photo.rows);
    const cv::Mat place = turn.t() * (middle - photo_from_picture(cv::Rect(2, 0, 1, 2)));
    fmt::print("{} {:.4f} {:.4f}\n", paths[static_cast<std::size_t>(component[i])].filename().string(),
               place.at<double>(0), place.at<double>(1));
  }
  if (argc > 2) {
    cv::Mat picture;
    if (stitcher->composePanorama(picture) != cv::Stitcher::OK || !cv::imwrite(argv[2], picture)) {
      fmt::print(stderr, "it could not compose the picture\n");
      return 1;
    }
  }
  return 0;
}
