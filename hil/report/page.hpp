#pragma once
#include <cstdint>
#include <string>

namespace relnav::hil {

enum class PageKind : std::uint8_t { run, campaign };

/// A page that needs no network: `json` is what its script draws.
[[nodiscard]] std::string page_html(const std::string& title, const std::string& json, PageKind kind);

}  // namespace relnav::hil
