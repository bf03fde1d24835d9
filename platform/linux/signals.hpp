#pragma once

namespace relnav::platform::linux {

/// From now on SIGTERM and SIGINT are noted; waits in the kernel end early. A second one of the same kind ends the program as
/// usual. SIGPIPE is ignored: a reader that went away is an error of the call.
void note_stop_signals();
/// One of them came.
[[nodiscard]] bool stop_requested();

}  // namespace relnav::platform::linux
