#include "platform/linux/gpio_backend.hpp"

namespace relnav::platform::linux {
namespace {

class NoBackend final : public GpioBackend {
 public:
  Status open(const std::string& path) override {
    problem_ = path + ": this program was built without libgpiod";
    return Status::unsupported;
  }
  void close() override {}
  std::uint32_t line_count() const override { return 0; }
  std::string line_name(std::uint32_t) override { return {}; }
  Status request_output(std::uint32_t, bool) override { return Status::unsupported; }
  Status request_input(std::uint32_t, hal::Edges) override { return Status::unsupported; }
  void release(std::uint32_t) override {}
  Status set(std::uint32_t, bool) override { return Status::unsupported; }
  Status get(std::uint32_t, bool&) override { return Status::unsupported; }
  int edge_descriptor(std::uint32_t) const override { return -1; }
  Status read_edges(std::uint32_t, std::span<KernelEdge>, std::size_t&) override { return Status::unsupported; }
  std::size_t kept_edges() const override { return 1; }
  const std::string& problem() const override { return problem_; }

 private:
  std::string problem_;
};

}  // namespace

std::unique_ptr<GpioBackend> make_gpiod_backend() { return std::make_unique<NoBackend>(); }

}  // namespace relnav::platform::linux
