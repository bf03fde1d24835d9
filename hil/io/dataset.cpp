#include "hil/io/dataset.hpp"

#include <filesystem>

#include "hil/io/euroc.hpp"
#include "platform/files/input_error.hpp"

namespace relnav::hil {

namespace fs = std::filesystem;

std::string calibration_beside(const std::string& container) {
  return fs::path(container).replace_extension(".yaml").string();
}

CameraFiles find_camera(const std::string& dataset, int number) {
  const fs::path path(dataset);
  if (fs::is_regular_file(path)) {
    if (number == 0) return {dataset, calibration_beside(dataset)};
    throw InputError(dataset, 0, "holds one camera, number 0",
                     "for camera " + std::to_string(number) + " a folder with cam0.rnc, cam1.rnc, ...");
  }
  if (!fs::is_directory(path)) {
    throw InputError(dataset, 0, "is no folder",
                     "a data set in the EuRoC layout (mav0/cam0/data.csv), a folder with cam0.rnc, or a raw container");
  }
  const std::string name = "cam" + std::to_string(number);
  const fs::path container = path / (name + ".rnc");
  const fs::path folder = path / "mav0" / name;
  if (!fs::is_directory(folder) && fs::exists(container))
    return {container.string(), calibration_beside(container.string())};
  return {folder.string(), (folder / "sensor.yaml").string()};
}

std::string folder_of_dataset(const std::string& dataset) {
  return fs::is_regular_file(dataset) ? fs::path(dataset).parent_path().string() : dataset;
}

std::vector<ImageEntry> read_images(const std::string& images, std::vector<std::string>& notes) {
  if (!fs::is_regular_file(images)) return read_image_list(images);
  const auto container = std::make_shared<const RawContainerReader>(images);
  notes.insert(notes.end(), container->notes().begin(), container->notes().end());
  std::vector<ImageEntry> entries;
  for (std::size_t k = 0; k < container->frames().size(); ++k) {
    const hal::raw::FrameHeader& header = container->frames()[k].header;
    if (header.status != 0) {
      notes.push_back(container->place_text(k) + " was marked unusable by its recorder and is left out");
    } else if (header.mid_exposure_ns < 0) {
      notes.push_back(container->place_text(k) + " has a negative time stamp and is left out");
    } else if (!container->has_good_pixels(k)) {
      notes.push_back(container->place_text(k) + " has damaged pixels and is left out");
    } else {
      entries.push_back({Time{header.mid_exposure_ns}, images, 0, container, k});
    }
  }
  if (entries.empty()) throw InputError(images, 0, "holds no usable frame", "at least one");
  return entries;
}

}  // namespace relnav::hil
