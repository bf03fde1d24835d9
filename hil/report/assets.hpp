#pragma once

/// Text of the files in hil/report/assets, put in at build time.
namespace relnav::hil::assets {

extern const char* const uplot_js;
extern const char* const uplot_css;
extern const char* const report_js;
extern const char* const campaign_js;
extern const char* const report_css;

}  // namespace relnav::hil::assets
