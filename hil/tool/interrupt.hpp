#pragma once

namespace relnav::hil {

/// From now on SIGINT and SIGTERM only set a flag, so that what was done is finished and written.
void catch_interrupts();
[[nodiscard]] bool interrupted();

}  // namespace relnav::hil
