#include "hil/replay/output_file.hpp"

#include <cerrno>
#include <cstring>

#include "platform/files/input_error.hpp"

namespace relnav::hil {

OutputFile::OutputFile(std::string path) : path_(std::move(path)), file_(std::fopen(path_.c_str(), "wb")) {
  if (!file_)
    throw InputError(path_, 0, std::string("cannot be created: ") + std::strerror(errno), "a writable output folder");
}

void OutputFile::write(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), file_.get()) != text.size() || std::fflush(file_.get()) != 0) {
    throw InputError(path_, 0, std::string("cannot be written: ") + std::strerror(errno),
                     "room and permission to write");
  }
}

}  // namespace relnav::hil
