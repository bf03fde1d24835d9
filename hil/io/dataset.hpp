#pragma once
#include <string>
#include <vector>

#include "hil/io/image_entry.hpp"

namespace relnav::hil {

/// Where the images and the calibration of one camera are.
struct CameraFiles {
  std::string images;       ///< a folder with data.csv and data/, or a raw container
  std::string calibration;  ///< need not exist
};

/// A data set is one of: a folder in the EuRoC layout (mav0/camN/{data.csv,data/,sensor.yaml}); a folder with raw containers
/// camN.rnc and their camN.yaml; one raw container FILE.rnc with FILE.yaml, which is camera 0.
/// Throws InputError: nothing of the kind there, or no such camera in it.
[[nodiscard]] CameraFiles find_camera(const std::string& dataset, int number);

/// Where target.yaml and truth.tum of a data set would be: the folder, or the one that the file lies in.
[[nodiscard]] std::string folder_of_dataset(const std::string& dataset);

/// CameraFiles::images, in file order. Of a raw container, frames that are damaged or were marked by their recorder are left
/// out; a line of `notes` says so of each, and of a recording that was cut off. Throws InputError: cannot be read, or no image.
[[nodiscard]] std::vector<ImageEntry> read_images(const std::string& images, std::vector<std::string>& notes);

/// FILE.rnc -> FILE.yaml.
[[nodiscard]] std::string calibration_beside(const std::string& container);

}  // namespace relnav::hil
