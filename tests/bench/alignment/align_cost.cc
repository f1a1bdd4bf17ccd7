// What the alignment of many 12 megapixel photos costs, stage by stage, in processor seconds a photo:
//   alignment_cost DIR PHOTOS [threads]
// DIR is filled with a simulated flight first if it is not there: JPEGs of 4000 x 3000 pixels, drawn at half
// that size (the finest that features are looked for in) and enlarged with noise in every pixel, so that
// reading them costs what it costs with real ones. `write` as a fourth word ends there.
#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>

#include "core/alignment/align_flight.h"
#include "core/base/parallel_for.h"
#include "core/base/scoped_timer.h"
#include "core/flight/photos/photo_decoder.h"
#include "core/flight/read_flight.h"
#include "core/ground/model_ground.h"
#include "core/poses/estimate_poses.h"
#include "core/simulate/simulate_flight.h"
#include "core/simulate/world/random.h"
#include "core/simulate/writers/write_photo.h"
#include "tests/bench/alignment/cpu_seconds.h"

namespace {

using namespace skyquilt;

constexpr int kEnlarged = 2;
constexpr int kNoiseCounts = 7;  // each way: files of a quarter of a byte a pixel, much as cameras write

// Bilinear, with noise of its own in every pixel.
image::DecodedImage Enlarged(const image::DecodedImage& small, std::uint32_t seed) {
  image::DecodedImage large{kEnlarged * small.width_px, kEnlarged * small.height_px, {}};
  large.rgb.resize(static_cast<std::size_t>(large.width_px) * large.height_px * 3);
  for (int y = 0; y < large.height_px; ++y) {
    const double from_y = std::clamp((y + 0.5) / kEnlarged - 0.5, 0.0, small.height_px - 1.0);
    const int top = static_cast<int>(from_y);
    const auto down = static_cast<float>(from_y - top);
    const std::uint8_t* rows[] = {small.Row(top), small.Row(std::min(top + 1, small.height_px - 1))};
    std::uint8_t* out = large.rgb.data() + static_cast<std::size_t>(y) * large.width_px * 3;
    for (int x = 0; x < large.width_px; ++x) {
      const double from_x = std::clamp((x + 0.5) / kEnlarged - 0.5, 0.0, small.width_px - 1.0);
      const int left = static_cast<int>(from_x);
      const int right = std::min(left + 1, small.width_px - 1);
      const auto across = static_cast<float>(from_x - left);
      const std::uint32_t hash = simulate::HashCell(x, y, seed);
      for (int c = 0; c < 3; ++c) {
        const auto along = [&](const std::uint8_t* row) {
          return static_cast<float>(row[3 * left + c]) * (1.0F - across) +
                 static_cast<float>(row[3 * right + c]) * across;
        };
        const auto noise =
            static_cast<float>(static_cast<int>((hash >> (8 * c)) % (2 * kNoiseCounts + 1)) - kNoiseCounts);
        const float value = along(rows[0]) * (1.0F - down) + along(rows[1]) * down + noise;
        out[3 * x + c] = static_cast<std::uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F));
      }
    }
  }
  return large;
}

Result<void> WriteFlight(const std::filesystem::path& folder, int photos, int threads) {
  simulate::SimulateOptions options;
  options.noise = simulate::NoiseClass::kXmpTypical;
  options.intrinsics = camera::Intrinsics::Centered(4000, 3000, 3000.0);
  options.trajectory.photos = photos;
  options.vignetting = 0.1;
  options.exposure_jitter = 0.05;
  const Result<simulate::SimulatedFlight> flight = simulate::PlanSimulatedFlight(options);
  if (!flight) return flight.error();
  const camera::Intrinsics small =
      camera::Intrinsics::Centered(4000 / kEnlarged, 3000 / kEnlarged, 3000.0 / kEnlarged);
  std::filesystem::create_directories(folder);
  std::vector<Result<void>> written(flight->photos.size());
  ParallelFor(flight->photos.size(), threads, [&](std::size_t i) {
    const simulate::SimulatedPhoto& photo = flight->photos[i];
    if (std::filesystem::exists(folder / photo.photo.name)) return;
    simulate::RenderPhotoOptions render = photo.render;
    render.noise_counts = 0.0;
    render.threads = 1;
    const image::DecodedImage image =
        Enlarged(simulate::RenderPhoto(flight->world, small, photo.pose.cam_from_enu, render),
                 photo.render.noise_seed);
    written[i] =
        simulate::WriteBytes(folder / photo.photo.name, simulate::EncodePhoto(image, photo.recorded));
  });
  for (const Result<void>& one : written) {
    if (!one) return one.error();
  }
  return {};
}

// Counts what decoding costs.
class TimedSource final : public flight::PhotoSource {
 public:
  Result<image::DecodedImage> Decode(const flight::Photo& photo, int denominator) const override {
    const double before = ThreadCpuSeconds();
    Result<image::DecodedImage> image = files_.Decode(photo, denominator);
    const std::lock_guard lock(mutex_);
    cpu_s_ += ThreadCpuSeconds() - before;
    return image;
  }
  double cpu_s() const { return cpu_s_; }

 private:
  flight::FilePhotoSource files_;
  mutable std::mutex mutex_;
  mutable double cpu_s_ = 0.0;
};

// Books the processor's time on what alignment says it is doing.
class TimedStages final : public Progress {
 public:
  void BeginStage(std::string_view) override {}
  void Report(double, std::string_view doing) override {
    const std::lock_guard lock(mutex_);
    if (doing == doing_) return;
    Close();
    doing_ = doing;
  }
  bool IsCancelled() const override { return false; }
  // Ends the present one too.
  const std::map<std::string, double>& CpuS() {
    Close();
    return cpu_s_;
  }

 private:
  void Close() {
    const double now_s = static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
    cpu_s_[doing_] += now_s - since_s_;
    since_s_ = now_s;
  }
  std::mutex mutex_;
  std::string doing_ = "finding features";
  double since_s_ = static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
  std::map<std::string, double> cpu_s_;
};

int Fail(const Error& error) {
  fmt::print(stderr, "{}\n", error.message);
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    fmt::print(stderr, "usage: {} DIR PHOTOS [threads [write]]\n", argv[0]);
    return 2;
  }
  const int photos = std::atoi(argv[2]);
  const int threads = argc > 3 ? std::atoi(argv[3]) : 0;
  if (const Result<void> written = WriteFlight(argv[1], photos, threads); !written)
    return Fail(written.error());
  if (argc > 4) return 0;

  SilentProgress silent;
  const Result<std::vector<flight::InputFile>> files = flight::ListInputFiles({argv[1]});
  if (!files) return Fail(files.error());
  const Result<flight::Flight> read = flight::ReadFlight(*files, 0, silent);
  if (!read) return Fail(read.error());
  const Result<poses::PosedFlight> posed = poses::EstimatePoses(*read, {});
  if (!posed) return Fail(posed.error());
  alignment::AlignOptions options;
  options.threads = threads;
  alignment::AlignReport report;
  const TimedSource source;
  TimedStages stages;
  double wall_s = 0.0, ground_s = 0.0;
  Result<alignment::AlignedFlight> aligned = Error{ErrorCode::kInternal, "not yet", ""};
  {
    const ScopedTimer timer(wall_s);
    aligned = alignment::AlignFlight(*posed, source, options, report, stages);
  }
  if (!aligned) return Fail(aligned.error());
  const std::map<std::string, double> cpu_s = stages.CpuS();
  {
    const ScopedCpuTimer timer(ground_s);
    ground::ModelGroundReport ground_report;
    ground::ModelGround(*aligned, ground_report);
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto of = [&](const char* doing) {
    const auto found = cpu_s.find(doing);
    return found == cpu_s.end() ? 0.0 : found->second;
  };
  const double matching_s = of("comparing photos") + of("comparing photos once more");
  const double features_s = of("finding features") - source.cpu_s();
  double all_s = ground_s;
  for (const auto& [doing, seconds] : cpu_s) all_s += seconds;
  const double n = report.photos;
  fmt::print("{:>6} {:>7} {:>7} {:>8} {:>8} {:>10} {:>7} {:>7} {:>8} {:>9}\n", "photos", "aligned", "decode",
             "features", "matching", "adjustment", "ground", "all", "wall s", "peak GiB");
  fmt::print("{:>6} {:>7} {:>7.3f} {:>8.3f} {:>8.3f} {:>10.3f} {:>7.3f} {:>7.3f} {:>8.1f} {:>9.2f}\n",
             report.photos, report.aligned, source.cpu_s() / n, features_s / n, matching_s / n,
             of("adjusting") / n, ground_s / n, all_s / n, wall_s,
             static_cast<double>(usage.ru_maxrss) / (1024.0 * 1024.0));
  return 0;
}
