#pragma once
#include <string>
#include <vector>

namespace relnav::hil {

/// On stderr, a line each; of very many the first ones, and how many more there are.
void print_notes(const std::vector<std::string>& notes);

}  // namespace relnav::hil
