// film_of_photos FOLDER FILM.MP4 FRAMES_PER_S: a film (MPEG-4 part 2) whose frames are the folder's photos in
// the order of their names, for tests of the whole program.
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <vector>

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << "usage: film_of_photos FOLDER FILM.MP4 FRAMES_PER_S\n";
    return 2;
  }
  std::vector<std::string> photos;
  for (const auto& entry : std::filesystem::directory_iterator(argv[1])) photos.push_back(entry.path());
  std::sort(photos.begin(), photos.end());
  cv::VideoWriter writer;
  for (const std::string& photo : photos) {
    const cv::Mat frame = cv::imread(photo, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
    if (frame.empty()) {
      std::cerr << photo << " cannot be read.\n";
      return 1;
    }
    if (!writer.isOpened()) {
      writer.open(argv[2], cv::VideoWriter::fourcc('m', 'p', '4', 'v'), std::stod(argv[3]), frame.size());
      if (!writer.isOpened()) {
        std::cerr << "This machine has no encoder for " << argv[2] << ".\n";
        return 1;
      }
    }
    writer.write(frame);
  }
  return 0;
}
