#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"

namespace relnav::hal {

/// Way in for telecommand packets. What comes is anybody's: nothing is checked here. Contract
/// (tests/contract/command_source_contract.hpp):
/// CMD-1  receive() never blocks: with nothing to give it returns no_data.
/// CMD-2  On ok the first `bytes` bytes of `buffer` are one whole packet as it arrived, 1 <= bytes <= buffer.size().
/// CMD-3  Packets come in the order of their arrival, each one once, not merged or split.
/// CMD-4  A packet that is longer than `buffer` is not given in part: it is gone, and the answer is no_capacity.
/// CMD-5  On any status but ok `bytes` is unchanged (`buffer` need not be); the next call stands on its own.
class CommandSource {
 public:
  virtual Status receive(std::span<std::uint8_t> buffer, std::size_t& bytes) = 0;

 protected:
  CommandSource() = default;
  CommandSource(const CommandSource&) = default;
  CommandSource& operator=(const CommandSource&) = default;
  ~CommandSource() = default;
};

}  // namespace relnav::hal
