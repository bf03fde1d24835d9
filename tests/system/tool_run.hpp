#pragma once
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/support/scratch.hpp"

namespace relnav::test {

/// What a run of the relnav tool said.
struct ToolRun {
  int exit_status = -1;
  std::string out;
  std::string err;
};

inline ToolRun relnav_tool(const Scratch& scratch, const std::string& arguments) {
  const std::string command = std::string("'") + RELNAV_TOOL + "' " + arguments + " >" + scratch.path("stdout") +
                              " 2>" + scratch.path("stderr") + " </dev/null";
  const int status = std::system(command.c_str());
  const auto text_of = [](const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  };
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128, text_of(scratch.path("stdout")),
          text_of(scratch.path("stderr"))};
}

}  // namespace relnav::test
