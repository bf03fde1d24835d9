#pragma once

namespace relnav::platform::mps2 {

/// From here on whoever asks for heap memory ends in the safe state. First thing of a flight image's main(); until then there is
/// none: the C++ library asks for a reserve for exceptions when it starts, and does without.
void forbid_heap();

}  // namespace relnav::platform::mps2
