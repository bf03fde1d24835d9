#pragma once
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "hil/serve/frame_sink.hpp"

typedef struct _ArvBuffer ArvBuffer;
typedef struct _ArvFakeCamera ArvFakeCamera;
typedef struct _ArvGvFakeCamera ArvGvFakeCamera;

namespace relnav::hil {

/// A GigE Vision camera on the network, played by Aravis' fake camera: original stamps in the leaders, frame numbers from 1 and
/// after 65535 from 1 again. Size is that of the frames; Mono8 and Bayer..8 give 8 bits (of 16 the upper), Mono16 gives 16 (of
/// 8 as the upper). At most one camera an address.
class GigeServer final : public FrameSink {
 public:
  struct Place {
    std::string address;          ///< IPv4, of this machine
    std::string serial = "RN01";  ///< number that it answers with
  };
  /// "ADDRESS[,SERIAL]". Throws InputError.
  [[nodiscard]] static Place parse_place(const std::string& text);

  /// `lock_step`: frames only for software triggers. `log` is told, one line each, what a client wants and cannot have.
  GigeServer(Place place, bool lock_step, std::function<void(const std::string&)> log);
  GigeServer(const GigeServer&) = delete;
  GigeServer& operator=(const GigeServer&) = delete;
  ~GigeServer() override { unplug(); }

  /// Throws InputError when the address is not one of this machine, or somebody has its port 3956.
  void plug(const FrameShape& shape) override;
  void unplug() override;
  bool write(const ServedFrame& frame, Duration wait) override;
  /// What clients have set; frames do not change by it.
  [[nodiscard]] unsigned exposure_us() const;
  [[nodiscard]] unsigned raw_gain() const;

 private:
  static void on_fill(ArvBuffer* buffer, void* server, unsigned exposure_us, unsigned gain, unsigned pixel_format);
  void fill(ArvBuffer* buffer, unsigned pixel_format);
  [[nodiscard]] bool can_serve(unsigned pixel_format);
  void copy_pixels(const Image& image, ArvBuffer* buffer, unsigned pixel_format) const;
  void lose_packets(double ratio);
  void say_once(const std::string& line);

  Place place_;
  bool lock_step_;
  std::function<void(const std::string&)> log_;
  ArvGvFakeCamera* server_ = nullptr;
  ArvFakeCamera* camera_ = nullptr;
  FrameShape shape_;
  std::string said_;
  std::mutex mutex_;  ///< of what follows; Aravis fills frames in a thread of its own
  std::condition_variable changed_;
  const ServedFrame* offered_ = nullptr;
  bool taken_ = false;
  bool leaving_ = false;
};

}  // namespace relnav::hil
