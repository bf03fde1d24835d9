#include "hil/capture/export_run.hpp"

#include <filesystem>
#include <set>

#include "hil/replay/output_file.hpp"
#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"

namespace relnav::hil {
namespace {

const char* name_of(hal::ClockId clock) {
  switch (clock) {
    case hal::ClockId::monotonic: return "monotonic";
    case hal::ClockId::tai: return "tai";
    case hal::ClockId::device: return "device";
  }
  return "unknown";
}

std::string frames_row(const hal::raw::FrameHeader& h) {
  return format_text("%lld,%lu,%lld,%.9g,%lld,%lld,%s,%u", static_cast<long long>(h.mid_exposure_ns),
                     static_cast<unsigned long>(h.sequence), static_cast<long long>(h.exposure_ns), h.gain,
                     static_cast<long long>(h.first_data_ns), static_cast<long long>(h.dequeued_ns), name_of(h.clock),
                     static_cast<unsigned>(h.status));
}

/// Why a frame is left out; empty: it is good, and `image` is it.
std::string read_frame(const RawContainerReader& container, std::size_t k, Image& image) {
  const hal::raw::FrameHeader& header = container.frames()[k].header;
  if (header.status != 0)
    return container.place_text(k) +
           format_text(": marked unusable by its recorder (status %u)", static_cast<unsigned>(header.status));
  if (header.mid_exposure_ns < 0) return container.place_text(k) + ": its time stamp is negative";
  try {
    image = container.image(k);
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

}  // namespace

ExportOutcome export_frames(const RawContainerReader& container, const std::string& camera_folder,
                            const std::function<bool(std::size_t)>& go_on) {
  ExportOutcome outcome;
  const std::string data = camera_folder + "/data";
  std::error_code error;
  std::filesystem::create_directories(data, error);
  if (error) throw InputError(data, 0, "cannot be created: " + error.message(), "a writable output folder");
  OutputFile list(camera_folder + "/data.csv");
  OutputFile details(camera_folder + "/frames.csv");
  list.line("#timestamp [ns],filename");
  details.line("#timestamp [ns],sequence,exposure [ns],gain,first_data [ns],dequeued [ns],clock,status");
  std::set<std::string> names;
  for (std::size_t k = 0; k < container.frames().size() && go_on(k); ++k) {
    Image image;
    const std::string problem = read_frame(container, k, image);
    if (!problem.empty()) {
      outcome.skipped.push_back(problem);
      continue;
    }
    const hal::raw::FrameHeader& header = container.frames()[k].header;
    const std::string stamp = std::to_string(header.mid_exposure_ns);
    std::string name = stamp + ".png";
    for (int copy = 2; !names.insert(name).second; ++copy) name = stamp + "_" + std::to_string(copy) + ".png";
    write_png(data + "/" + name, image);
    list.line(stamp + "," + name);
    details.line(frames_row(header));
    ++outcome.exported;
  }
  return outcome;
}

}  // namespace relnav::hil
