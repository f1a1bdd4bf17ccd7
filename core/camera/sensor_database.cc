#include "core/camera/sensor_database.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace skyquilt::camera {
namespace {

struct Entry {
  std::string_view model;
  SensorSize sensor;
};

struct Readout {
  std::string_view model;
  double readout_ms;
  double full_readout_ms = 0.0;  // of sensors that join four pixels to one, where they do not
};

constexpr double kJoinedMegapixels = 30.0;  // no more than that where they do

constexpr std::array kReadouts = {
    Readout{"PHANTOM VISION FC200", 74},
    Readout{"FC300C", 33},
    Readout{"FC300S", 33},
    Readout{"FC300X", 33},
    Readout{"FC330", 33},
    Readout{"FC350", 30},
    Readout{"FC220", 64},
    Readout{"FC2103", 32},
    Readout{"FC7203", 25},
    Readout{"FC3170", 27},
    Readout{"FC3411", 32},
    Readout{"FC3582", 26, 60},
    Readout{"L1D-20c", 56},
    Readout{"L2D-20c", 16.6},
    Readout{"XT705", 30},
    Readout{"Anafi", 39},
    Readout{"E90", 44},
    Readout{"FC3682", 23},
    Readout{"FC8482", 21, 58},
    Readout{"XT701", 25},
};

constexpr std::array kSensors = {
    // DJI
    Entry{"PHANTOM VISION FC200", {4384, 3288, 6.17}},
    Entry{"FC300C", {4000, 3000, 6.17}},
    Entry{"FC300S", {4000, 3000, 6.17}},
    Entry{"FC300X", {4000, 3000, 6.17}},
    Entry{"FC300XW", {4000, 3000, 6.17}},
    Entry{"FC330", {4000, 3000, 6.17}},
    Entry{"FC350", {4000, 3000, 6.17}},
    Entry{"FC350Z", {4000, 3000, 6.17}},
    Entry{"FC220", {4000, 3000, 6.17}},
    Entry{"FC230", {4056, 3040, 6.17}},
    Entry{"FC1102", {3968, 2976, 6.17}},
    Entry{"FC2103", {4056, 3040, 6.17}},
    Entry{"FC2204", {4000, 3000, 6.17}},
    Entry{"FC2403", {4056, 3040, 6.17}},
    Entry{"FC550", {4608, 3456, 17.3}},
    Entry{"FC550RAW", {4608, 3456, 17.3}},
    Entry{"FC6310", {5472, 3648, 13.2}},
    Entry{"FC6310S", {5472, 3648, 13.2}},
    Entry{"FC6310R", {5472, 3648, 13.2}},
    Entry{"FC6360", {1600, 1300, 4.87}},
    Entry{"FC6510", {5472, 3648, 13.2}},
    Entry{"FC6520", {5280, 3956, 17.3}},
    Entry{"FC6540", {6016, 4008, 23.5}},
    Entry{"FC7203", {4000, 3000, 6.17}},
    Entry{"FC7303", {4000, 3000, 6.17}},
    Entry{"FC3170", {4000, 3000, 6.4}},
    Entry{"FC3411", {5472, 3648, 13.2}},
    Entry{"FC3582", {4032, 3024, 9.7}},
    Entry{"FC3682", {4032, 3024, 9.7}},
    Entry{"FC8482", {4032, 3024, 9.7}},
    Entry{"L1D-20c", {5472, 3648, 13.2}},
    Entry{"L2D-20c", {5280, 3956, 17.3}},
    Entry{"M3E", {5280, 3956, 17.3}},
    Entry{"M3M", {5280, 3956, 17.3}},
    Entry{"ZenmuseP1", {8192, 5460, 35.9}},
    // Parrot, senseFly
    Entry{"Anafi", {5344, 4016, 5.92}},
    Entry{"S.O.D.A.", {5472, 3648, 12.75}},
    // Autel, Skydio, Yuneec
    Entry{"XT701", {8000, 6000, 6.4}},
    Entry{"XT705", {5472, 3648, 13.2}},
    Entry{"XL714", {5472, 3648, 13.2}},
    Entry{"E90", {5472, 3648, 13.2}},
    Entry{"Skydio 2", {4056, 3040, 6.17}},
    Entry{"VT300-L_93", {8192, 6144, 13.1}},
    Entry{"V100-L_93", {8192, 6144, 13.1}},
    Entry{"VT300-Z_50", {9248, 6944, 7.4}},
    Entry{"VT300-L_50", {9248, 6944, 7.4}},
    Entry{"V100-L_50", {9248, 6944, 7.4}},
    Entry{"VT300-Z_13", {8000, 6000, 6.4}},
    Entry{"VT300-Z_40", {640, 512, 7.68}},
    Entry{"VT300-L_40", {640, 512, 7.68}},
    // Cameras carried by fixed wings and home-made aircraft
    Entry{"Canon PowerShot ELPH 300 HS", {4000, 3000, 6.17}},
    Entry{"Canon PowerShot ELPH 110 HS", {4608, 3456, 6.17}},
    Entry{"Canon IXUS 220 HS", {4000, 3000, 6.17}},
    Entry{"Canon IXUS 127 HS", {4608, 3456, 6.17}},
    Entry{"Canon PowerShot S100", {4000, 3000, 7.44}},
    Entry{"Canon PowerShot S110", {4000, 3000, 7.44}},
    Entry{"Canon PowerShot SX260 HS", {4000, 3000, 6.17}},
    Entry{"DSC-WX220", {4896, 3672, 6.17}},
    Entry{"ILCE-5100", {6000, 4000, 23.5}},
    Entry{"ILCE-6000", {6000, 4000, 23.5}},
    Entry{"ILCE-6300", {6000, 4000, 23.5}},
    Entry{"ILCE-QX1", {5456, 3632, 23.2}},
    Entry{"NEX-5T", {4912, 3264, 23.4}},
    Entry{"NEX-7", {6000, 4000, 23.5}},
    Entry{"ILCE-7R", {7360, 4912, 35.9}},
    Entry{"ILCE-7RM2", {7952, 5304, 35.9}},
    Entry{"ILCE-7RM3", {7952, 5304, 35.9}},
    Entry{"ILCE-7RM4", {9504, 6336, 35.7}},
    Entry{"DSC-RX1RM2", {7952, 5304, 35.9}},
    Entry{"DSC-RX0M2", {4800, 3200, 11.6}},
    Entry{"DSC-RX100M2", {5472, 3648, 13.2}},
    Entry{"UMC-R10C", {5456, 3632, 23.2}},
    Entry{"GR II", {4928, 3264, 23.7}},
    Entry{"HERO4 Black", {4000, 3000, 6.17}},
    Entry{"HERO4 Silver", {4000, 3000, 6.17}},
    // Multispectral
    Entry{"RedEdge", {1280, 960, 4.8}},
    Entry{"RedEdge-M", {1280, 960, 4.8}},
    Entry{"RedEdge-MX", {1280, 960, 4.8}},
};

bool IsSame(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

}  // namespace

std::optional<double> FindReadoutS(std::string_view model, double megapixels) {
  const auto found = std::find_if(kReadouts.begin(), kReadouts.end(),
                                  [&](const Readout& entry) { return IsSame(entry.model, model); });
  if (found == kReadouts.end()) return std::nullopt;
  const bool is_full = megapixels > kJoinedMegapixels && found->full_readout_ms > 0.0;
  return 1e-3 * (is_full ? found->full_readout_ms : found->readout_ms);
}

std::optional<SensorSize> FindSensor(std::string_view model) {
  const auto found = std::find_if(kSensors.begin(), kSensors.end(),
                                  [&](const Entry& entry) { return IsSame(entry.model, model); });
  if (found == kSensors.end()) return std::nullopt;
  return found->sensor;
}

double ScaleFromNative(int width_px, int height_px, int native_width_px, int native_height_px) {
  const bool is_turned =
      (width_px > height_px) != (native_width_px > native_height_px) && width_px != height_px;
  if (is_turned) std::swap(width_px, height_px);
  return std::max(static_cast<double>(width_px) / native_width_px,
                  static_cast<double>(height_px) / native_height_px);
}

}  // namespace skyquilt::camera
