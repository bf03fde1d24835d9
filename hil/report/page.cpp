#include "hil/report/page.hpp"

#include "hil/report/assets.hpp"

namespace relnav::hil {
namespace {

std::string html_escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      default: out += c;
    }
  }
  return out;
}

// "</" would end the script element.
std::string script_safe(std::string json) {
  for (std::size_t at = 0; (at = json.find("</", at)) != std::string::npos; at += 3) json.replace(at, 2, "<\\/");
  return json;
}

}  // namespace

std::string page_html(const std::string& title, const std::string& json, PageKind kind) {
  std::string html = "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n";
  html += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
  html += "<title>" + html_escaped(title) + "</title>\n";
  html += std::string("<style>") + assets::uplot_css + assets::report_css +
          "</style></head>\n<body><main id=\"report\"></main>\n";
  html += "<noscript>The plots need JavaScript; the figures are in summary.json beside this file.</noscript>\n";
  html += "<script id=\"data\" type=\"application/json\">" + script_safe(json) + "</script>\n";
  html += std::string("<script>") + assets::uplot_js + "</script>\n<script>" +
          (kind == PageKind::run ? assets::report_js : assets::campaign_js) + "</script>\n</body></html>\n";
  return html;
}

}  // namespace relnav::hil
